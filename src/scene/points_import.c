/* Key `points.import`. */
#include "scene/import.h"
#include "scene/sections.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The path of the file, from the scene's folder, for messages. The node then holds it in full, so
   that the copy of the scene in the run's directory finds it too. 0: error. */
static int find_file(sdr_reading *rd, sdr_node *node, char path[PATH_MAX])
{
  char full[PATH_MAX];
  const char *scene = rd->scene->path, *slash = strrchr(scene, '/');
  const int folder = slash && node->text[0] != '/' ? (int)(slash - scene) + 1 : 0;
  const int length = snprintf(path, PATH_MAX, "%.*s%s", folder, scene, node->text);
  if (length >= PATH_MAX || !realpath(path, full)) {
    sdr_read_error(rd->reader, node->origin,
                   "the file '%.300s' cannot be found; give its path from the scene's folder",
                   path);
    return 0;
  }
  node->text = sdr_store_copy(rd->reader->store, full, strlen(full));
  if (!node->text) sdr_read_fatal(rd->reader, SDR_RUN_FAILED);
  return node->text != NULL;
}

/* The columns that are left out. */
static void read_ignored(sdr_reading *rd, sdr_node *map, sdr_import_how *how)
{
  sdr_node *list = sdr_read_list(rd->reader, map, "ignore", "[]");
  if (!list || list->count == 0) return;
  const char **names = sdr_reading_room(rd, list, sizeof *names);
  if (!names) return;
  for (const sdr_node *item = list->first; item; item = item->next)
    if (sdr_read_is(rd->reader, item, SDR_SCALAR, "the name of a column"))
      names[how->ignored_count++] = item->text;
  how->ignored = names;
}

/* The name of the file, or a mapping that says more. NULL: in error. */
static sdr_node *read_how(sdr_reading *rd, sdr_node *node, sdr_import_how *how)
{
  static const char *const sites[] = {"centroids", "nodes", NULL};
  sdr_reader *r = rd->reader;
  if (node->kind == SDR_SCALAR) return node;
  if (!sdr_read_is(r, node, SDR_MAPPING, "a file, or {file: FILE, unit: 1 mm}")) return NULL;
  sdr_node *file = sdr_read_value(r, node, "file", NULL, "a .csv or .msh file");
  int good = file && sdr_read_is(r, file, SDR_SCALAR, "a .csv or .msh file");
  good = sdr_read_number(r, node, "unit", SDR_ABOVE_ZERO(SDR_LENGTH), "1 m", &how->unit) && good;
  good = sdr_read_word(r, node, "sites", sites, NULL, "centroids", &how->nodes) && good;
  read_ignored(rd, node, how);
  sdr_read_done(r, node);
  return good ? file : NULL;
}

static int is_mesh(const char *path)
{
  const size_t length = strlen(path);
  return length > 4 && strcmp(path + length - 4, ".msh") == 0;
}

/* What decides on what is read, as text. */
static void write_how(const sdr_import_how *how, const char *full, char text[600])
{
  int used =
      snprintf(text, 600, "%d %.17g %d %.400s", how->components, how->unit, how->nodes, full);
  for (int k = 0; k < how->ignored_count && used < 600; ++k)
    used += snprintf(text + used, (size_t)(600 - used), ",%s", how->ignored[k]);
  if (used >= 600) text[0] = '\0'; /* too long to compare: read again */
}

static void load(sdr_reading *rd, sdr_node *file, const sdr_import_how *how, const char *path)
{
  sdr_reader *r = rd->reader;
  char text[600];
  sdr_import *import = NULL;
  write_how(how, file->text, text);
  if (r->imported && text[0] && strcmp(text, r->imported_how) == 0) {
    rd->scene->points.imported = r->imported;
    return;
  }
  const sdr_status status = sdr_import_load(r->store, path, how, &import);
  if (status == SDR_BAD_INPUT) {
    r->unreadable = is_mesh(path) && !sdr_import_has_gmsh();
    sdr_read_error(r, file->origin, "%s", sdr_error_message());
  } else if (status != SDR_OK) {
    sdr_read_fatal(r, status);
  } else {
    rd->scene->points.imported = r->imported = import;
    memcpy(r->imported_how, text, sizeof text);
  }
}

void sdr_read_import(sdr_reading *rd)
{
  sdr_node *points = sdr_node_find(rd->root, "points");
  sdr_node *node = points && points->kind == SDR_MAPPING ? sdr_node_find(points, "import") : NULL;
  sdr_import_how how = {.components = sdr_components(rd->reader->dimension), .unit = 1.0};
  char path[PATH_MAX];
  if (!node || sdr_node_is_null(node)) return;
  if (sdr_node_find(rd->root, "equation")) {
    sdr_read_error(rd->reader, node->key_origin,
                   "equations are solved on points of a shape; give points.shape and spacing");
    return;
  }
  sdr_node *file = read_how(rd, node, &how);
  if (!file || !find_file(rd, file, path)) return;
  load(rd, file, &how, path);
  /* The state depends on what the file holds, wherever it lies. */
  if (!rd->scene->points.imported) return;
  file->canonical = sdr_store_format(rd->reader->store, "%016llx",
                                     (unsigned long long)rd->scene->points.imported->hash);
  if (!file->canonical) sdr_read_fatal(rd->reader, SDR_RUN_FAILED);
}

sdr_shape *sdr_imported_shape(const sdr_reading *rd, const char *name)
{
  sdr_import_group *group = sdr_import_find(rd->scene->points.imported, name);
  return group ? &group->shape : NULL;
}
