/* Meshes of Gmsh, through its C library. It is loaded when a mesh is read, not before: it brings
   dozens of other libraries, and loading them takes longer than many a run. */
#include "scene/mesh.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the file must hold, whatever reads it. */
static sdr_status check_text(const char *path, const char *text, size_t length)
{
  static const char *const parts[] = {"$EndMeshFormat", "$EndNodes", "$EndElements"};
  if (length < 12 || memcmp(text, "$MeshFormat", 11) != 0)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s:1: the file does not begin with $MeshFormat: it is no mesh of Gmsh; save "
                    "it by `gmsh -2 PART.geo -o PART.msh`",
                    path);
  for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k)
    if (!memmem(text, length, parts[k], strlen(parts[k])))
      return sdr_fail(SDR_BAD_INPUT,
                      "%s: there is no %s: the file is cut off or holds no mesh; "
                      "save it again",
                      path, parts[k]);
  return SDR_OK;
}

#ifdef SDR_GMSH_LIBRARY

#include <dlfcn.h>
#include <gmshc.h>

/* The functions that are used, by name. */
#define GMSH_FUNCTIONS(use)                                                                        \
  use(Initialize) use(Finalize) use(Free) use(OptionSetNumber) use(Merge) use(LoggerGetLastError)  \
      use(ModelGetEntities) use(ModelGetPhysicalGroups) use(ModelGetEntitiesForPhysicalGroup)      \
          use(ModelGetPhysicalName) use(ModelMeshGetNodes) use(ModelMeshGetElements)               \
              use(ModelMeshGetElementProperties)

#define GMSH_MEMBER(name) __typeof__(gmsh##name) *(name);
typedef struct {
  GMSH_FUNCTIONS(GMSH_MEMBER)
} gmsh_library;

/* POSIX promises that a function's address fits in what dlsym returns; C does not. */
#define GMSH_LOAD(name)                                                                            \
  {                                                                                                \
    void *found = dlsym(handle, "gmsh" #name);                                                     \
    if (!found) return 0;                                                                          \
    memcpy(&gmsh->name, &found, sizeof found);                                                     \
  }

/* Stays loaded: unloading it is not safe. */
static int load(gmsh_library *gmsh)
{
  void *handle = dlopen(SDR_GMSH_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  if (!handle) return 0;
  GMSH_FUNCTIONS(GMSH_LOAD)
  return 1;
}

int sdr_import_has_gmsh(void)
{
  gmsh_library gmsh;
  return load(&gmsh);
}

/* A mesh being read. */
typedef struct {
  gmsh_library gmsh;
  const char *path;
  const sdr_import_how *how;
  sdr_mesh *mesh;
  size_t *tag;     /* of each node */
  int32_t *by_tag; /* nodes by rising tag */
  int *entity_tag;
} reader;

static sdr_status failed(const reader *r, const char *what)
{
  char *error = NULL;
  int ierr = 0;
  r->gmsh.LoggerGetLastError(&error, &ierr);
  const sdr_status status =
      sdr_fail(SDR_BAD_INPUT, "%s: Gmsh cannot read %s%s%.300s; save the mesh again", r->path, what,
               error && *error ? ": " : "", error ? error : "");
  r->gmsh.Free(error);
  return status;
}

/* ---- nodes ----------------------------------------------------------------------------------- */

static int by_tag(const void *left, const void *right, void *tags)
{
  const size_t *tag = tags, a = tag[*(const int32_t *)left], b = tag[*(const int32_t *)right];
  return a < b ? -1 : a > b;
}

static sdr_status keep_nodes(reader *r, const size_t *tags, size_t count, const double *x,
                             size_t x_count)
{
  sdr_mesh *mesh = r->mesh;
  if (count < 1 || count > INT32_MAX - 8 || x_count != 3 * count)
    return sdr_fail(SDR_BAD_INPUT, "%s: %zu nodes; allowed: 1 to %d", r->path, count,
                    INT32_MAX - 8);
  mesh->x = sdr_alloc(3 * count, sizeof *mesh->x);
  r->tag = sdr_alloc(count, sizeof *r->tag);
  r->by_tag = sdr_alloc(count, sizeof *r->by_tag);
  if (!mesh->x || !r->tag || !r->by_tag) return SDR_RUN_FAILED;
  mesh->node_count = (int32_t)count;
  memcpy(mesh->x, x, 3 * count * sizeof *x);
  memcpy(r->tag, tags, count * sizeof *tags);
  for (int32_t k = 0; k < mesh->node_count; ++k) r->by_tag[k] = k;
  qsort_r(r->by_tag, count, sizeof *r->by_tag, by_tag, r->tag);
  for (size_t k = 0; k < 3 * count; ++k)
    if (!isfinite(x[k])) return sdr_fail(SDR_BAD_INPUT, "%s: a node is not finite", r->path);
  return SDR_OK;
}

static sdr_status read_nodes(reader *r)
{
  size_t *tags = NULL, tag_count = 0, x_count = 0, other_count = 0;
  double *x = NULL, *other = NULL;
  int ierr = 0;
  r->gmsh.ModelMeshGetNodes(&tags, &tag_count, &x, &x_count, &other, &other_count, -1, -1, 0, 0,
                            &ierr);
  const sdr_status status =
      ierr ? failed(r, "the nodes") : keep_nodes(r, tags, tag_count, x, x_count);
  r->gmsh.Free(tags);
  r->gmsh.Free(x);
  r->gmsh.Free(other);
  return status;
}

/* The node with this tag; -1: none. */
static int32_t node_of(const reader *r, size_t tag)
{
  int32_t first = 0, last = r->mesh->node_count;
  while (first < last) {
    const int32_t middle = first + (last - first) / 2;
    const size_t here = r->tag[r->by_tag[middle]];
    if (here == tag) return r->by_tag[middle];
    if (here < tag)
      first = middle + 1;
    else
      last = middle;
  }
  return -1;
}

/* ---- elements -------------------------------------------------------------------------------- */

static sdr_status make_room(sdr_mesh *mesh, size_t more)
{
  const size_t count = (size_t)mesh->element_count + more;
  sdr_mesh_element *grown = sdr_realloc(mesh->element, count, sizeof *grown);
  if (!grown) return SDR_RUN_FAILED;
  mesh->element = grown;
  return SDR_OK;
}

/* All elements of one type in one entity; `nodes` has `node_count` tags for `count` elements. */
static sdr_status keep_elements(reader *r, int type, size_t count, const size_t *nodes,
                                size_t node_count)
{
  char *name = NULL;
  double *local = NULL;
  size_t local_count = 0;
  int dimension = 0, order, each = 0, corners = 0, ierr = 0;
  r->gmsh.ModelMeshGetElementProperties(type, &name, &dimension, &order, &each, &local,
                                        &local_count, &corners, &ierr);
  r->gmsh.Free(local);
  r->gmsh.Free(name);
  if (ierr || corners < 1 || corners > 8 || each < corners || node_count != count * (size_t)each)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: elements of Gmsh's type %d are not known here; mesh with "
                    "triangles, quadrilaterals, tetrahedra, pyramids, prisms or hexahedra",
                    r->path, type);
  SDR_TRY(make_room(r->mesh, count));
  for (size_t e = 0; e < count; ++e) {
    sdr_mesh_element *element = &r->mesh->element[r->mesh->element_count++];
    *element = (sdr_mesh_element){.dimension = dimension, .corners = corners};
    for (int k = 0; k < corners; ++k) {
      const size_t tag = nodes[e * (size_t)each + (size_t)k];
      element->corner[k] = node_of(r, tag);
      if (element->corner[k] < 0)
        return sdr_fail(SDR_BAD_INPUT, "%s: an element names node %zu, which the file lacks",
                        r->path, tag);
    }
  }
  return SDR_OK;
}

static sdr_status read_entity(reader *r, int dimension, int tag, sdr_mesh_entity *entity)
{
  int *types = NULL, ierr = 0;
  size_t type_count = 0, **tags = NULL, *tag_counts = NULL, tag_lists = 0;
  size_t **nodes = NULL, *node_counts = NULL, node_lists = 0;
  *entity = (sdr_mesh_entity){.dimension = dimension, .first = r->mesh->element_count};
  r->gmsh.ModelMeshGetElements(&types, &type_count, &tags, &tag_counts, &tag_lists, &nodes,
                               &node_counts, &node_lists, dimension, tag, &ierr);
  sdr_status status = ierr ? failed(r, "the elements") : SDR_OK;
  for (size_t k = 0; k < type_count && status == SDR_OK; ++k)
    status = keep_elements(r, types[k], tag_counts[k], nodes[k], node_counts[k]);
  for (size_t k = 0; k < tag_lists; ++k) r->gmsh.Free(tags[k]);
  for (size_t k = 0; k < node_lists; ++k) r->gmsh.Free(nodes[k]);
  r->gmsh.Free(types);
  r->gmsh.Free(tags);
  r->gmsh.Free(tag_counts);
  r->gmsh.Free(nodes);
  r->gmsh.Free(node_counts);
  if (status == SDR_OK) status = sdr_mesh_drop_doubles(r->mesh, entity->first);
  entity->last = r->mesh->element_count;
  return status;
}

static int is_read(const reader *r, int dimension)
{
  return dimension == r->how->components || dimension == r->how->components - 1;
}

static sdr_status read_entities(reader *r)
{
  int *list = NULL, ierr = 0;
  size_t count = 0;
  sdr_status status = SDR_OK;
  r->gmsh.ModelGetEntities(&list, &count, -1, &ierr);
  if (ierr) status = failed(r, "the geometry");
  r->mesh->entity = sdr_alloc(count / 2, sizeof *r->mesh->entity);
  r->entity_tag = sdr_alloc(count / 2, sizeof *r->entity_tag);
  if (status == SDR_OK && (!r->mesh->entity || !r->entity_tag)) status = SDR_RUN_FAILED;
  for (size_t k = 0; k + 1 < count && status == SDR_OK; k += 2) {
    if (!is_read(r, list[k])) continue;
    const int entity = r->mesh->entity_count++;
    r->entity_tag[entity] = list[k + 1];
    status = read_entity(r, list[k], list[k + 1], &r->mesh->entity[entity]);
  }
  r->gmsh.Free(list);
  return status;
}

/* ---- groups ---------------------------------------------------------------------------------- */

static int entity_index(const reader *r, int dimension, int tag)
{
  for (int k = 0; k < r->mesh->entity_count; ++k)
    if (r->mesh->entity[k].dimension == dimension && r->entity_tag[k] == tag) return k;
  return -1;
}

/* A group without a name is called after its dimension and tag: surface3. */
static sdr_status name_group(const reader *r, int dimension, int tag, sdr_mesh_group *group)
{
  static const char *const words[] = {"point", "line", "surface", "volume"};
  char *name = NULL;
  int ierr = 0;
  r->gmsh.ModelGetPhysicalName(dimension, tag, &name, &ierr);
  const size_t length = !ierr && name ? strlen(name) : 0;
  if (length > 0)
    snprintf(group->name, sizeof group->name, "%s", name);
  else
    snprintf(group->name, sizeof group->name, "%s%d", words[dimension], tag);
  r->gmsh.Free(name);
  if (length < sizeof group->name && !strchr(group->name, '.') &&
      strcmp(group->name, "body") != 0 && strcmp(group->name, "all") != 0)
    return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: a scene cannot name the physical group '%s': allowed are up to %d letters "
                  "without a dot, but not body or all; rename it in the mesh",
                  r->path, group->name, SDR_NAME_MAX - 1);
}

static sdr_status read_group(reader *r, int dimension, int tag, sdr_mesh_group *group)
{
  int *tags = NULL, ierr = 0;
  size_t count = 0;
  group->dimension = dimension;
  SDR_TRY(name_group(r, dimension, tag, group));
  r->gmsh.ModelGetEntitiesForPhysicalGroup(dimension, tag, &tags, &count, &ierr);
  sdr_status status = ierr ? failed(r, "the physical groups") : SDR_OK;
  group->entity = sdr_alloc(count, sizeof *group->entity);
  if (status == SDR_OK && !group->entity) status = SDR_RUN_FAILED;
  for (size_t k = 0; k < count && status == SDR_OK; ++k) {
    const int entity = entity_index(r, dimension, tags[k]);
    if (entity >= 0) group->entity[group->entity_count++] = entity;
  }
  r->gmsh.Free(tags);
  return status;
}

static sdr_status read_groups(reader *r)
{
  int *list = NULL, ierr = 0;
  size_t count = 0;
  sdr_status status = SDR_OK;
  r->gmsh.ModelGetPhysicalGroups(&list, &count, -1, &ierr);
  if (ierr) status = failed(r, "the physical groups");
  r->mesh->group = sdr_alloc(count / 2, sizeof *r->mesh->group);
  if (status == SDR_OK && !r->mesh->group) status = SDR_RUN_FAILED;
  for (size_t k = 0; k + 1 < count && status == SDR_OK; k += 2)
    if (is_read(r, list[k]))
      status = read_group(r, list[k], list[k + 1], &r->mesh->group[r->mesh->group_count++]);
  r->gmsh.Free(list);
  return status;
}

/* ---- all of it ------------------------------------------------------------------------------- */

static sdr_status read_model(reader *r)
{
  int ierr = 0;
  r->gmsh.OptionSetNumber("General.Terminal", 0.0, &ierr);
  r->gmsh.OptionSetNumber("General.AbortOnError", 2.0, &ierr); /* say so, by ierr */
  r->gmsh.Merge(r->path, &ierr);
  if (ierr) return failed(r, "the file");
  SDR_TRY(read_nodes(r));
  SDR_TRY(read_entities(r));
  return read_groups(r);
}

static void initialize(const gmsh_library *gmsh, int *ierr)
{
  char name[] = "sunder", quiet[] = "-v", none[] = "0", *arguments[] = {name, quiet, none, NULL};
#if GMSH_API_VERSION_MAJOR == 4 && GMSH_API_VERSION_MINOR < 10
  gmsh->Initialize(3, arguments, 0, ierr);
#else
  gmsh->Initialize(3, arguments, 0, 0, ierr);
#endif
}

sdr_status sdr_mesh_read(const char *path, const char *text, size_t length,
                         const sdr_import_how *how, sdr_mesh *mesh)
{
  reader r = {.path = path, .how = how, .mesh = mesh};
  int ierr = 0;
  SDR_TRY(check_text(path, text, length));
  if (!load(&r.gmsh))
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: Gmsh's library %s cannot be loaded; install it (Debian: libgmsh-dev)",
                    path, SDR_GMSH_LIBRARY);
  const int threads = sdr_threads();
  initialize(&r.gmsh, &ierr);
  if (ierr) return sdr_fail(SDR_RUN_FAILED, "%s: Gmsh's library does not start", path);
  const sdr_status status = read_model(&r);
  r.gmsh.Finalize(&ierr);
  sdr_set_threads(threads); /* it sets its own */
  sdr_free(r.tag);
  sdr_free(r.by_tag);
  sdr_free(r.entity_tag);
  return status;
}

#else

int sdr_import_has_gmsh(void)
{
  return 0;
}

sdr_status sdr_mesh_read(const char *path, const char *text, size_t length,
                         const sdr_import_how *how, sdr_mesh *mesh)
{
  (void)how;
  (void)mesh;
  SDR_TRY(check_text(path, text, length));
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: this build of Sunder cannot read meshes: Gmsh's library was missing; "
                  "install it (Debian: apt-get install libgmsh-dev), remove the build folder and "
                  "build again",
                  path);
}

#endif
