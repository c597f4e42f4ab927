#include "scene/import.h"

#include "base/memory.h"
#include "scene/mesh.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- groups ---------------------------------------------------------------------------------- */

sdr_import_group *sdr_import_find(const sdr_import *import, const char *name)
{
  for (int k = 0; import && k < import->group_count; ++k)
    if (strcmp(import->group[k].name, name) == 0) return &import->group[k];
  return NULL;
}

sdr_import_group *sdr_import_add_group(sdr_store *store, sdr_import *import, const char *name)
{
  if (import->group_count == SDR_GROUPS_MAX) {
    sdr_fail(SDR_BAD_INPUT, "more than %d groups", SDR_GROUPS_MAX);
    return NULL;
  }
  if (!import->group) import->group = sdr_store_alloc(store, SDR_GROUPS_MAX, sizeof *import->group);
  uint8_t *holds = sdr_store_alloc(store, (size_t)import->count / 8 + 1, 1);
  if (!import->group || !holds) return NULL;
  sdr_import_group *group = &import->group[import->group_count++];
  snprintf(group->name, sizeof group->name, "%s", name);
  group->holds = holds;
  return group;
}

void sdr_import_put(sdr_import_group *group, int32_t point)
{
  group->holds[point / 8] |= (uint8_t)(1u << (point % 8));
}

int sdr_import_holds(const sdr_import_group *group, const double x[3])
{
  int32_t nearest;
  sdr_tree_nearest(group->points, x, &nearest);
  if (nearest < 0) return 0;
  const int32_t point = group->points->label[nearest];
  return group->holds[point / 8] >> (point % 8) & 1;
}

/* ---- points ---------------------------------------------------------------------------------- */

double sdr_import_spacing(const sdr_import *import, int32_t i, double across)
{
  if (import->spacing) return import->spacing[i];
  const double measure = import->measure ? import->measure[i] : import->volume[i] / across;
  return import->components == 1   ? measure
         : import->components == 2 ? sqrt(measure)
                                   : cbrt(measure);
}

double sdr_import_volume(const sdr_import *import, int32_t i, double across)
{
  if (import->volume) return import->volume[i];
  const double measure =
      import->measure ? import->measure[i] : pow(import->spacing[i], import->components);
  return measure * across;
}

static int by_place(const void *left, const void *right, void *context)
{
  const int32_t i = *(const int32_t *)left, j = *(const int32_t *)right;
  const sdr_import *import = context;
  for (int c = 0; c < 3; ++c)
    if (import->x[c][i] != import->x[c][j]) return import->x[c][i] < import->x[c][j] ? -1 : 1;
  return i < j ? -1 : i > j;
}

static sdr_status same_place(const sdr_import *import, const char *path, int32_t i, int32_t j)
{
  const double x = import->x[0][i], y = import->x[1][i], z = import->x[2][i];
  if (import->line)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s:%d: the point lies where that of line %d does, at (%g, %g, %g) m; remove "
                    "one of them",
                    path, import->line[j], import->line[i], x, y, z);
  return sdr_fail(SDR_BAD_INPUT, "%s: two points of the mesh lie at (%g, %g, %g) m; mend the mesh",
                  path, x, y, z);
}

static sdr_status refuse_doubles(const sdr_import *import, const char *path)
{
  int32_t *order = sdr_alloc((size_t)import->count, sizeof *order);
  if (!order) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < import->count; ++i) order[i] = i;
  qsort_r(order, (size_t)import->count, sizeof *order, by_place, (void *)(uintptr_t)import);
  sdr_status status = SDR_OK;
  for (int32_t k = 1; k < import->count && status == SDR_OK; ++k) {
    const int32_t i = order[k - 1], j = order[k];
    int same = 1;
    for (int c = 0; c < 3; ++c) same = same && import->x[c][i] == import->x[c][j];
    if (same) status = same_place(import, path, i, j);
  }
  sdr_free(order);
  return status;
}

static sdr_status sort_points(sdr_store *store, sdr_import *import)
{
  double *x = sdr_alloc((size_t)import->count, 3 * sizeof *x);
  if (!x) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < import->count; ++i)
    for (int c = 0; c < 3; ++c) x[3 * (size_t)i + (size_t)c] = import->x[c][i];
  const sdr_status status = sdr_tree_create(store, 1, import->count, x, NULL, &import->points);
  sdr_free(x);
  return status;
}

static void set_shapes(sdr_import *import)
{
  for (int k = 0; k < import->group_count; ++k) {
    sdr_import_group *group = &import->group[k];
    group->points = import->points;
    group->shape = (sdr_shape){
        .kind = group->facets ? SDR_FACETS : SDR_GROUP, .primitive_count = 1, .group = group};
  }
}

/* ---- the file -------------------------------------------------------------------------------- */

static sdr_status read_bytes(const char *path, FILE *file, char **text, size_t *length)
{
  size_t room = 0;
  *text = NULL;
  *length = 0;
  do {
    room = room ? 2 * room : 1 << 16;
    char *grown = sdr_realloc(*text, room + 1, 1);
    if (!grown) return SDR_RUN_FAILED;
    *text = grown;
    *length += fread(*text + *length, 1, room - *length, file);
  } while (*length == room);
  (*text)[*length] = '\0';
  if (!ferror(file)) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
}

static sdr_status read_file(const char *path, char **text, size_t *length)
{
  FILE *file = fopen(path, "rb");
  if (!file) return sdr_fail(SDR_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
  const sdr_status status = read_bytes(path, file, text, length);
  fclose(file);
  return status;
}

static uint64_t hash_of(const char *text, size_t length)
{
  uint64_t hash = UINT64_C(14695981039346656037);
  for (size_t k = 0; k < length; ++k)
    hash = (hash ^ (unsigned char)text[k]) * UINT64_C(1099511628211);
  return hash;
}

static int ends_with(const char *path, const char *ending)
{
  const size_t length = strlen(path), tail = strlen(ending);
  return length > tail && strcmp(path + length - tail, ending) == 0;
}

static sdr_status import_mesh(sdr_store *store, const char *path, const char *text, size_t length,
                              const sdr_import_how *how, sdr_import **out)
{
  sdr_mesh mesh = {0};
  sdr_status status = sdr_mesh_read(path, text, length, how, &mesh);
  if (status == SDR_OK) status = sdr_mesh_points(store, path, &mesh, how, out);
  sdr_mesh_clear(&mesh);
  return status;
}

static sdr_status import_bytes(sdr_store *store, const char *path, const char *text, size_t length,
                               const sdr_import_how *how, sdr_import **out)
{
  if (ends_with(path, ".msh")) return import_mesh(store, path, text, length, how, out);
  if (ends_with(path, ".csv")) return sdr_import_table(store, path, text, length, how, out);
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: what the file holds is told by the end of its name: .csv for a table of "
                  "points, .msh for a mesh of Gmsh",
                  path);
}

sdr_status sdr_import_load(sdr_store *store, const char *path, const sdr_import_how *how,
                           sdr_import **out)
{
  char *text = NULL;
  size_t length = 0;
  sdr_import *import = NULL;
  sdr_status status = read_file(path, &text, &length);
  if (status == SDR_OK) status = import_bytes(store, path, text, length, how, &import);
  if (status == SDR_OK) status = refuse_doubles(import, path);
  if (status == SDR_OK) status = sort_points(store, import);
  if (status == SDR_OK) {
    set_shapes(import);
    import->hash = hash_of(text, length);
    *out = import;
  }
  sdr_free(text);
  return status;
}
