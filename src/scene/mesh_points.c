/* Points and groups of a body that is given as a mesh. */
#include "base/memory.h"
#include "base/small.h"
#include "scene/mesh.h"

#include <math.h>
#include <string.h>

/* A mesh on its way to points. */
typedef struct {
  sdr_store *store;
  const char *path;
  const sdr_mesh *mesh;
  const sdr_import_how *how;
  double *x;           /* 3 a node, m */
  int32_t *point;      /* of each element, or of each node; -1: none */
  int64_t *first, *at; /* the body's elements at each node: first (node_count + 1), at */
  sdr_import *import;
} maker;

static int of_body(const maker *m, const sdr_mesh_element *element)
{
  return element->dimension == m->how->components;
}

static const char *body_elements(int components)
{
  static const char *const names[] = {"edges", "triangles or quadrilaterals",
                                      "tetrahedra or other solid elements"};
  return names[components - 1];
}

/* ---- checks ---------------------------------------------------------------------------------- */

/* Coordinates beyond the scene's must be the same everywhere. */
static sdr_status check_flat(const maker *m)
{
  double extent = 0.0;
  for (int32_t k = 0; k < m->mesh->node_count; ++k)
    for (int c = 0; c < 3; ++c)
      extent = fmax(extent, fabs(m->x[3 * (size_t)k + (size_t)c] - m->x[c]));
  for (int32_t k = 0; k < m->mesh->node_count; ++k)
    for (int c = m->how->components; c < 3; ++c)
      if (fabs(m->x[3 * (size_t)k + (size_t)c] - m->x[c]) > 1e-9 * extent)
        return sdr_fail(SDR_BAD_INPUT,
                        "%s: the mesh does not lie %s: %c is %g m at one node and %g m at another; "
                        "choose another dimension or mesh",
                        m->path, m->how->components == 2 ? "in the x-y plane" : "along x", "xyz"[c],
                        m -> x[c], m -> x[3 * (size_t)k + (size_t)c]);
  return SDR_OK;
}

static sdr_status count_elements(const maker *m, int64_t *count)
{
  *count = 0;
  for (int64_t e = 0; e < m->mesh->element_count; ++e) *count += of_body(m, &m->mesh->element[e]);
  if (*count == 0)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: the mesh holds no %s, of which a body in %d dimensions is made; mesh it "
                    "in that dimension",
                    m->path, body_elements(m->how->components), m->how->components);
  if (*count <= INT32_MAX - 8) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s: %lld elements; at most %d are possible", m->path,
                  (long long)*count, INT32_MAX - 8);
}

/* ---- points ---------------------------------------------------------------------------------- */

static sdr_status allocate_points(maker *m, int32_t count)
{
  sdr_import *import = m->import = sdr_store_alloc(m->store, 1, sizeof *import);
  if (!import) return SDR_RUN_FAILED;
  import->components = m->how->components;
  import->count = count;
  for (int c = 0; c < 3; ++c) {
    import->x[c] = sdr_store_alloc(m->store, (size_t)count, sizeof(double));
    if (!import->x[c]) return SDR_RUN_FAILED;
  }
  import->measure = sdr_store_alloc(m->store, (size_t)count, sizeof(double));
  return import->measure ? SDR_OK : SDR_RUN_FAILED;
}

static void set_place(const maker *m, int32_t point, const double x[3])
{
  for (int c = 0; c < m->how->components; ++c) m->import->x[c][point] = x[c];
}

/* The element's measure; SDR_BAD_INPUT if it has none. */
static sdr_status measure_of(const maker *m, const sdr_mesh_element *element, double centroid[3],
                             double *measure)
{
  *measure = sdr_mesh_measure(m->x, element, centroid);
  if (*measure > 0.0 && isfinite(*measure)) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s: the element at (%g, %g, %g) m has no volume; mend the mesh",
                  m->path, centroid[0], centroid[1], centroid[2]);
}

static sdr_status points_at_centroids(maker *m, int64_t count)
{
  m->point = sdr_alloc((size_t)m->mesh->element_count, sizeof *m->point);
  if (!m->point) return SDR_RUN_FAILED;
  SDR_TRY(allocate_points(m, (int32_t)count));
  int32_t next = 0;
  for (int64_t e = 0; e < m->mesh->element_count; ++e) {
    double centroid[3];
    m->point[e] = -1;
    if (!of_body(m, &m->mesh->element[e])) continue;
    SDR_TRY(measure_of(m, &m->mesh->element[e], centroid, &m->import->measure[next]));
    set_place(m, next, centroid);
    m->point[e] = next++;
  }
  return SDR_OK;
}

/* The nodes that the body's elements have as corners, in the file's order. */
static sdr_status points_at_nodes(maker *m)
{
  const sdr_mesh *mesh = m->mesh;
  int32_t count = 0;
  m->point = sdr_alloc((size_t)mesh->node_count, sizeof *m->point);
  if (!m->point) return SDR_RUN_FAILED;
  for (int32_t k = 0; k < mesh->node_count; ++k)
    m->point[k] = m->first[k + 1] > m->first[k] ? count++ : -1;
  SDR_TRY(allocate_points(m, count));
  for (int32_t k = 0; k < mesh->node_count; ++k)
    if (m->point[k] >= 0) set_place(m, m->point[k], m->x + 3 * (size_t)k);
  for (int64_t e = 0; e < mesh->element_count; ++e) {
    const sdr_mesh_element *element = &mesh->element[e];
    double centroid[3], measure;
    if (!of_body(m, element)) continue;
    SDR_TRY(measure_of(m, element, centroid, &measure));
    for (int k = 0; k < element->corners; ++k)
      m->import->measure[m->point[element->corner[k]]] += measure / element->corners;
  }
  return SDR_OK;
}

/* ---- groups ---------------------------------------------------------------------------------- */

static void put_element(const maker *m, int64_t e, sdr_import_group *group)
{
  const sdr_mesh_element *element = &m->mesh->element[e];
  if (!m->how->nodes) {
    sdr_import_put(group, m->point[e]);
    return;
  }
  for (int k = 0; k < element->corners; ++k) sdr_import_put(group, m->point[element->corner[k]]);
}

/* Which of the body's elements each node is a corner of. */
static sdr_status list_elements(maker *m)
{
  const sdr_mesh *mesh = m->mesh;
  m->first = sdr_alloc((size_t)mesh->node_count + 1, sizeof *m->first);
  if (!m->first) return SDR_RUN_FAILED;
  for (int64_t e = 0; e < mesh->element_count; ++e)
    for (int k = 0; of_body(m, &mesh->element[e]) && k < mesh->element[e].corners; ++k)
      ++m->first[mesh->element[e].corner[k]];
  for (int32_t k = 0; k < mesh->node_count; ++k) m->first[k + 1] += m->first[k];
  m->at = sdr_alloc((size_t)m->first[mesh->node_count], sizeof *m->at);
  if (!m->at) return SDR_RUN_FAILED;
  for (int64_t e = mesh->element_count - 1; e >= 0; --e)
    for (int k = 0; of_body(m, &mesh->element[e]) && k < mesh->element[e].corners; ++k)
      m->at[--m->first[mesh->element[e].corner[k]]] = e;
  return SDR_OK;
}

static int has_corner(const sdr_mesh_element *element, int32_t node)
{
  for (int k = 0; k < element->corners; ++k)
    if (element->corner[k] == node) return 1;
  return 0;
}

/* The element of the body that the face is a side of; NULL: none. */
static const sdr_mesh_element *behind(const maker *m, const sdr_mesh_element *face)
{
  const int32_t node = face->corner[0];
  for (int64_t n = m->first[node]; n < m->first[node + 1]; ++n) {
    const sdr_mesh_element *element = &m->mesh->element[m->at[n]];
    int k = 0;
    while (k < face->corners && has_corner(element, face->corner[k])) ++k;
    if (k == face->corners) return element;
  }
  return NULL;
}

/* Edges or triangles on their way to a tree. */
typedef struct {
  int32_t count;
  double *piece, *normal;
} facets;

/* Add the edge or triangle between these corners, its normal away from `inside`. */
static void add_facet(const maker *m, const int32_t *corner, const double inside[3], facets *f)
{
  const int corners = m->how->components;
  double *piece = f->piece + (size_t)(3 * corners) * (size_t)f->count;
  double *normal = f->normal + 3 * (size_t)f->count++, away = 0.0;
  for (int k = 0; k < corners; ++k)
    memcpy(piece + 3 * k, m->x + 3 * (size_t)corner[k], 3 * sizeof *piece);
  for (int k = 0; k < corners; ++k)
    for (int c = m->how->components; c < 3; ++c) piece[3 * k + c] = 0.0;
  const double e[3] = {piece[3 % (3 * corners)] - piece[0], piece[4 % (3 * corners)] - piece[1],
                       piece[5 % (3 * corners)] - piece[2]};
  if (corners == 1) normal[0] = 1.0;
  if (corners == 2) {
    normal[0] = e[1];
    normal[1] = -e[0];
  }
  if (corners == 3) {
    const double g[3] = {piece[6] - piece[0], piece[7] - piece[1], piece[8] - piece[2]};
    sdr_cross3(e, g, normal);
  }
  for (int c = 0; c < 3; ++c) away += normal[c] * (piece[c] - inside[c]);
  const double length = (away < 0.0 ? -1.0 : 1.0) * sdr_norm3(normal);
  for (int c = 0; c < 3 && length != 0.0; ++c) normal[c] /= length;
}

static sdr_status add_face(const maker *m, const sdr_mesh_group *group, int64_t e, facets *f)
{
  const sdr_mesh_element *face = &m->mesh->element[e], *element = behind(m, face);
  double inside[3];
  if (!element) {
    const double *x = m->x + 3 * (size_t)face->corner[0];
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: the group '%s' holds a face at (%g, %g, %g) m that belongs to no element "
                    "of the body; mend the mesh",
                    m->path, group->name, x[0], x[1], x[2]);
  }
  sdr_mesh_measure(m->x, element, inside);
  for (int c = m->how->components; c < 3; ++c) inside[c] = 0.0;
  add_facet(m, face->corner, inside, f);
  if (face->corners < 4) return SDR_OK;
  const int32_t rest[3] = {face->corner[0], face->corner[2], face->corner[3]};
  add_facet(m, rest, inside, f);
  return SDR_OK;
}

static sdr_status make_face(const maker *m, const sdr_mesh_group *from, sdr_import_group *group)
{
  const int corners = m->how->components;
  int64_t count = 0;
  sdr_status status = SDR_OK;
  for (int k = 0; k < from->entity_count; ++k) {
    const sdr_mesh_entity *entity = &m->mesh->entity[from->entity[k]];
    count += 2 * (entity->last - entity->first);
  }
  facets f = {0, sdr_alloc((size_t)count, (size_t)(3 * corners) * sizeof *f.piece),
              sdr_alloc((size_t)count, 3 * sizeof *f.normal)};
  if (!f.piece || !f.normal) status = SDR_RUN_FAILED;
  for (int k = 0; k < from->entity_count; ++k) {
    const sdr_mesh_entity *entity = &m->mesh->entity[from->entity[k]];
    for (int64_t e = entity->first; e < entity->last && status == SDR_OK; ++e)
      status = add_face(m, from, e, &f);
  }
  group->holds = NULL;
  if (status == SDR_OK)
    status = sdr_tree_create(m->store, corners, f.count, f.piece, f.normal, &group->facets);
  sdr_free(f.piece);
  sdr_free(f.normal);
  return status;
}

static sdr_status make_group(const maker *m, const sdr_mesh_group *from)
{
  const int is_face = from->dimension < m->how->components;
  int64_t count = 0;
  for (int k = 0; k < from->entity_count; ++k)
    count += m->mesh->entity[from->entity[k]].last - m->mesh->entity[from->entity[k]].first;
  if (count == 0) return SDR_OK; /* of a geometry that was not meshed */
  if (sdr_import_find(m->import, from->name))
    return sdr_fail(SDR_BAD_INPUT, "%s: two physical groups are called '%s'; rename one", m->path,
                    from->name);
  sdr_import_group *group = sdr_import_add_group(m->store, m->import, from->name);
  if (!group)
    return m->import->group_count == SDR_GROUPS_MAX
               ? sdr_fail(SDR_BAD_INPUT, "%s: more than %d physical groups", m->path,
                          SDR_GROUPS_MAX)
               : SDR_RUN_FAILED;
  if (is_face) return make_face(m, from, group);
  for (int k = 0; k < from->entity_count; ++k) {
    const sdr_mesh_entity *entity = &m->mesh->entity[from->entity[k]];
    for (int64_t e = entity->first; e < entity->last; ++e) put_element(m, e, group);
  }
  return SDR_OK;
}

/* ---- all of it ------------------------------------------------------------------------------- */

static sdr_status make(maker *m)
{
  const sdr_mesh *mesh = m->mesh;
  int64_t count;
  m->x = sdr_alloc((size_t)mesh->node_count, 3 * sizeof *m->x);
  if (!m->x) return SDR_RUN_FAILED;
  for (size_t k = 0; k < 3 * (size_t)mesh->node_count; ++k) m->x[k] = mesh->x[k] * m->how->unit;
  SDR_TRY(count_elements(m, &count));
  SDR_TRY(check_flat(m));
  SDR_TRY(list_elements(m));
  if (m->how->nodes)
    SDR_TRY(points_at_nodes(m));
  else
    SDR_TRY(points_at_centroids(m, count));
  for (int k = 0; k < mesh->group_count; ++k) SDR_TRY(make_group(m, &mesh->group[k]));
  return SDR_OK;
}

sdr_status sdr_mesh_points(sdr_store *store, const char *path, const sdr_mesh *mesh,
                           const sdr_import_how *how, sdr_import **out)
{
  maker m = {.store = store, .path = path, .mesh = mesh, .how = how};
  const sdr_status status = make(&m);
  sdr_free(m.x);
  sdr_free(m.point);
  sdr_free(m.first);
  sdr_free(m.at);
  if (status == SDR_OK) *out = m.import;
  return status;
}
