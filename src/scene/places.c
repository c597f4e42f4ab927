#include "scene/import.h"
#include "scene/sections.h"

#include <stdio.h>
#include <string.h>

enum { FACES_MAX = 6 };

/* ---- faces ----------------------------------------------------------------------------------- */

/* Faces of one primitive; the number of them. */
static int faces_of(const sdr_shape *shape, sdr_dimension dimension, const char *faces[FACES_MAX])
{
  static const char *const box[] = {"left", "right", "bottom", "top", "back", "front"};
  int count = 0;
  switch (shape->kind) {
  case SDR_BOX:
    for (; count < 2 * sdr_components(dimension); ++count) faces[count] = box[count];
    break;
  case SDR_DISC:
  case SDR_POLYGON:
    faces[count++] = "rim";
    break;
  case SDR_FACETS:
    faces[count++] = "surface";
    break;
  case SDR_ANNULUS:
  case SDR_SPHERE:
  case SDR_CYLINDER:
    if (shape->inner > 0) faces[count++] = "inner";
    faces[count++] = "outer";
    if (shape->kind != SDR_CYLINDER) break;
    faces[count++] = "bottom";
    faces[count++] = "top";
    faces[count++] = "ends";
    break;
  default:
    break;
  }
  return count;
}

/* How many primitives of a shape have that face. */
static int count_face(const sdr_shape *shape, sdr_dimension dimension, const char *face)
{
  const char *faces[FACES_MAX];
  int found = 0;
  for (int k = 0; k < shape->part_count; ++k) {
    found += count_face(&shape->parts[k], dimension, face);
  }
  const int count = faces_of(shape, dimension, faces);
  for (int k = 0; k < count; ++k) found += strcmp(faces[k], face) == 0;
  return found;
}

/* Every face name there is, in a fixed order. */
static const char *const all_faces[] = {"inner",  "outer", "rim",  "left", "right",
                                        "bottom", "top",   "ends", "back", "front"};
enum { ALL_FACES = sizeof all_faces / sizeof *all_faces };

const char *sdr_shape_face_list(const sdr_shape *shape, sdr_dimension dimension)
{
  static _Thread_local char text[128];
  size_t used = 0;
  text[0] = '\0';
  for (int k = 0; k < ALL_FACES; ++k) {
    if (count_face(shape, dimension, all_faces[k]) != 1) continue;
    used +=
        (size_t)snprintf(text + used, sizeof text - used, "%s%s", used ? ", " : "", all_faces[k]);
  }
  return text;
}

static int is_face_word(const char *word)
{
  for (int k = 0; k < ALL_FACES; ++k) {
    if (strcmp(word, all_faces[k]) == 0) return 1;
  }
  return 0;
}

/* 1 if the shape has exactly one face of that name; else an error that says what there is. */
static int check_face(sdr_reading *rd, const sdr_node *node, const sdr_shape *shape,
                      const char *owner, const char *face)
{
  const sdr_dimension dimension = rd->reader->dimension;
  const int found = count_face(shape, dimension, face);
  if (found == 1) return 1;
  if (found > 1) {
    sdr_read_error(rd->reader, node->origin,
                   "%d parts of %s have a face '%s'; make the part a region and write REGION.%s",
                   found, owner, face, face);
    return 0;
  }
  const char *list = sdr_shape_face_list(shape, dimension);
  sdr_read_error(rd->reader, node->origin, "%s has no face '%.60s'; %s%s", owner, face,
                 *list ? "its faces: " : "it has no face with a name", list);
  return 0;
}

/* ---- regions --------------------------------------------------------------------------------- */

static int region_index(const sdr_reading *rd, const char *name)
{
  for (int k = 0; k < rd->scene->region_count; ++k) {
    if (strcmp(rd->scene->region[k].name, name) == 0) return k;
  }
  return -1;
}

/* Regions of the scene, then groups of the imported file. */
static void region_names(const sdr_reading *rd, char *text, size_t size)
{
  const sdr_import *import = rd->scene->points.imported;
  size_t used = 0;
  text[0] = '\0';
  for (int k = 0; k < rd->scene->region_count && used < size; ++k) {
    used += (size_t)snprintf(text + used, size - used, "%s%s", k ? ", " : "",
                             rd->scene->region[k].name);
  }
  for (int k = 0; import && k < import->group_count && used < size; ++k) {
    used +=
        (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", import->group[k].name);
  }
}

static void unknown_region(sdr_reading *rd, const sdr_node *node, const char *name)
{
  char names[300];
  if (sdr_is_shape_word(name)) {
    sdr_read_error(rd->reader, node->origin, "the shape '%s' needs its measures: {%s: ...}", name,
                   name);
    return;
  }
  region_names(rd, names, sizeof names);
  sdr_read_error(rd->reader, node->origin, "unknown region '%.60s'; %s%s", name,
                 *names ? "regions of this scene: " : "this scene has no regions", names);
}

/* A region is read once, when first named; a region that leads back to itself is in error. */
static void read_region(sdr_reading *rd, int index)
{
  sdr_node *node = sdr_node_item(rd->regions, index);
  rd->state[index] = SDR_REGION_OPEN;
  sdr_shape *shape = NULL;
  if (sdr_node_is_null(node)) {
    sdr_read_error(rd->reader, node->origin, "the region '%s' has no shape", node->key);
  } else {
    shape = sdr_read_shape(rd, node, NULL);
  }
  rd->scene->region[index].shape = shape;
  rd->state[index] = shape ? SDR_REGION_READ : SDR_REGION_BAD;
}

/* 1 if a file was to be imported and is in error, which has been said: names may be its groups. */
static int lacks_import(const sdr_reading *rd)
{
  const sdr_node *points = sdr_node_find(rd->root, "points");
  const sdr_node *import =
      points && points->kind == SDR_MAPPING ? sdr_node_find(points, "import") : NULL;
  return import && !sdr_node_is_null(import) && !rd->scene->points.imported;
}

/* The points of a group of the imported file; an error if there is none of that name. */
static sdr_shape *imported_volume(sdr_reading *rd, const sdr_node *node, const char *name)
{
  sdr_shape *shape = sdr_imported_shape(rd, name);
  if (!shape) {
    if (!lacks_import(rd)) unknown_region(rd, node, name);
    return NULL;
  }
  if (shape->kind == SDR_GROUP) return shape;
  sdr_read_error(rd->reader, node->origin,
                 "'%s' is a face of the imported mesh; here a region or a group of its elements is "
                 "wanted",
                 name);
  return NULL;
}

sdr_shape *sdr_read_region(sdr_reading *rd, const sdr_node *node, const char *name)
{
  const int index = region_index(rd, name);
  if (index < 0) return imported_volume(rd, node, name);
  if (rd->state[index] == SDR_REGION_OPEN) {
    sdr_read_error(rd->reader, node->origin, "the region '%s' is made of itself", name);
    return NULL;
  }
  if (rd->state[index] == SDR_REGION_UNREAD) read_region(rd, index);
  return rd->scene->region[index].shape;
}

void sdr_read_regions(sdr_reading *rd)
{
  sdr_node *regions = sdr_read_map(rd->reader, rd->root, "regions", "{}");
  if (!regions || regions->count == 0) return;
  rd->scene->region = sdr_reading_room(rd, regions, sizeof *rd->scene->region);
  rd->state = sdr_reading_room(rd, regions, sizeof *rd->state);
  if (!rd->scene->region || !rd->state) return;
  rd->regions = regions;
  for (sdr_node *child = regions->first; child; child = child->next) {
    sdr_region *region = &rd->scene->region[rd->scene->region_count++];
    if (!sdr_read_is_name(rd->reader, child->key, child->key_origin, "a region")) continue;
    snprintf(region->name, sizeof region->name, "%s", child->key);
    if (strcmp(child->key, "body") == 0 || strcmp(child->key, "all") == 0) {
      sdr_read_error(rd->reader, child->key_origin,
                     "'%s' always names the whole body; give the region another name", child->key);
    } else if (sdr_imported_shape(rd, child->key)) {
      sdr_read_error(rd->reader, child->key_origin,
                     "'%s' is a group of the imported file too; give the region another name",
                     child->key);
    }
  }
  for (int k = 0; k < rd->scene->region_count; ++k) {
    if (rd->state[k] == SDR_REGION_UNREAD) read_region(rd, k);
  }
}

/* ---- holes -----------------------------------------------------------------------------------

   The rim of a hole looks into the hole, out of the body, so that a pressure on it pushes into the
   body. A region that the body has taken away is therefore named as what is left of space without
   it: geometry turns the normals of what a difference takes away. */

static int is_same_shape(const sdr_shape *a, const sdr_shape *b)
{
  return a->kind == b->kind && memcmp(a->centre, b->centre, sizeof a->centre) == 0 &&
         memcmp(a->low, b->low, sizeof a->low) == 0 &&
         memcmp(a->high, b->high, sizeof a->high) == 0 &&
         memcmp(a->normal, b->normal, sizeof a->normal) == 0 &&
         memcmp(&a->inner, &b->inner, sizeof a->inner) == 0 &&
         memcmp(&a->outer, &b->outer, sizeof a->outer) == 0 &&
         memcmp(&a->angle, &b->angle, sizeof a->angle) == 0 && a->parts == b->parts &&
         a->vertices == b->vertices && a->group == b->group;
}

/* 1 if `body` takes `part` away (an odd number of times on the way to it). */
static int takes_away(const sdr_shape *body, const sdr_shape *part, int away)
{
  if (away && is_same_shape(body, part)) return 1;
  for (int k = 0; k < body->part_count; ++k) {
    const int turned = body->kind == SDR_DIFFERENCE && k > 0;
    if (takes_away(&body->parts[k], part, turned ? !away : away)) return 1;
  }
  return 0;
}

static sdr_shape *shape_room(sdr_reading *rd, size_t count)
{
  sdr_shape *shapes = sdr_store_alloc(rd->reader->store, count, sizeof *shapes);
  if (!shapes) sdr_read_fatal(rd->reader, SDR_RUN_FAILED);
  return shapes;
}

/* All of space (two half spaces, which have no faces) without `hole`; NULL: memory. */
static sdr_shape *space_without(sdr_reading *rd, const sdr_shape *hole)
{
  sdr_shape *whole = shape_room(rd, 1), *parts = shape_room(rd, 2), *halves = shape_room(rd, 2);
  if (!whole || !parts || !halves) return NULL;
  for (int k = 0; k < 2; ++k) {
    halves[k].kind = SDR_HALF_SPACE;
    halves[k].normal[0] = k ? -1 : 1;
    halves[k].primitive_count = 1;
    halves[k].origin = hole->origin;
  }
  parts[0] = (sdr_shape){.kind = SDR_UNION,
                         .part_count = 2,
                         .parts = halves,
                         .primitive_count = 2,
                         .origin = hole->origin};
  parts[1] = *hole;
  *whole = (sdr_shape){.kind = SDR_DIFFERENCE,
                       .part_count = 2,
                       .parts = parts,
                       .primitive_count = 2 + hole->primitive_count,
                       .origin = hole->origin};
  return whole;
}

/* ---- places ---------------------------------------------------------------------------------- */

static int named_place(sdr_reading *rd, const sdr_node *node, sdr_place *out)
{
  const char *text = node->text, *dot = strchr(text, '.');
  char owner[SDR_NAME_MAX + 16];
  if (strcmp(text, "body") == 0 || strcmp(text, "all") == 0) return 1;
  if (dot) {
    snprintf(owner, sizeof owner, "%.*s", (int)(dot - text < 60 ? dot - text : 60), text);
    if (strcmp(owner, "body") == 0 && rd->scene->points.imported) {
      sdr_read_error(rd->reader, node->origin,
                     "'%.60s': an imported body has the faces that its file names only", text);
      return 0;
    }
    out->shape =
        strcmp(owner, "body") == 0 ? rd->scene->points.shape : sdr_read_region(rd, node, owner);
    if (!out->shape || !check_face(rd, node, out->shape, owner, dot + 1)) return 0;
    if (rd->scene->points.shape && takes_away(rd->scene->points.shape, out->shape, 0)) {
      out->shape = space_without(rd, out->shape);
      if (!out->shape) return 0;
    }
    snprintf(out->face, sizeof out->face, "%s", dot + 1);
    return 1;
  }
  if (region_index(rd, text) >= 0) {
    out->shape = sdr_read_region(rd, node, text);
    return out->shape != NULL;
  }
  if (sdr_imported_shape(rd, text)) {
    out->shape = sdr_imported_shape(rd, text);
    if (out->shape->kind == SDR_FACETS) snprintf(out->face, sizeof out->face, "surface");
    return 1;
  }
  if (is_face_word(text) && !rd->scene->points.imported) {
    out->shape = rd->scene->points.shape;
    if (!out->shape || !check_face(rd, node, out->shape, "the body", text)) return 0;
    snprintf(out->face, sizeof out->face, "%s", text);
    return 1;
  }
  if (lacks_import(rd)) return 0;
  char names[300] = "";
  region_names(rd, names, sizeof names);
  const char *faces = rd->scene->points.shape
                          ? sdr_shape_face_list(rd->scene->points.shape, rd->reader->dimension)
                          : "";
  sdr_read_error(rd->reader, node->origin, "unknown place '%.60s'; allowed: body, a shape%s%s%s%s",
                 text, *faces ? ", a face of the body: " : "", faces, *names ? ", a region: " : "",
                 names);
  return 0;
}

static int inline_place(sdr_reading *rd, sdr_node *node, sdr_place *out)
{
  sdr_node *face = sdr_node_find(node, "face");
  out->shape = sdr_read_shape(rd, node, "face");
  if (!out->shape) return 0;
  for (const sdr_node *child = node->first; child; child = child->next) {
    if (child != face) snprintf(out->text, sizeof out->text, "%s", child->key);
  }
  if (!face) return 1;
  if (!sdr_read_is(rd->reader, face, SDR_SCALAR, "the name of a face")) return 0;
  if (!check_face(rd, face, out->shape, "the shape", face->text)) return 0;
  snprintf(out->face, sizeof out->face, "%s", face->text);
  return 1;
}

static int check_kind(sdr_reading *rd, const sdr_node *node, sdr_place_kind kind,
                      const sdr_place *place)
{
  char path[256];
  sdr_node_path(node, path, sizeof path);
  if (kind == SDR_FACE_PLACE && place->face[0] == '\0') {
    const sdr_shape *shape = place->shape ? place->shape : rd->scene->points.shape;
    const char *faces = shape ? sdr_shape_face_list(shape, rd->reader->dimension) : "";
    sdr_read_error(rd->reader, node->origin, "%s: '%s' is a volume, a face is wanted%s%s", path,
                   place->text, *faces ? "; it has: " : "; it has none with a name", faces);
    return 0;
  }
  if (kind == SDR_VOLUME_PLACE && place->face[0] != '\0') {
    sdr_read_error(rd->reader, node->origin,
                   "%s: '%s' is a face, a volume is wanted: a region, a shape or body", path,
                   place->text);
    return 0;
  }
  return 1;
}

int sdr_read_place_node(sdr_reading *rd, sdr_node *node, sdr_place_kind kind, sdr_place *out)
{
  sdr_place place = {.origin = node->origin};
  if (node->kind == SDR_SCALAR) {
    snprintf(place.text, sizeof place.text, "%s", node->text);
    if (!named_place(rd, node, &place)) return 0;
  } else if (!inline_place(rd, node, &place)) {
    return 0;
  }
  if (!check_kind(rd, node, kind, &place)) return 0;
  *out = place;
  return 1;
}

int sdr_read_place(sdr_reading *rd, sdr_node *map, const char *key, sdr_place_kind kind,
                   const char *fallback, sdr_place *out)
{
  sdr_node *node = sdr_read_value(rd->reader, map, key, fallback,
                                  kind == SDR_FACE_PLACE ? "a face, like inner or REGION.left"
                                                         : "a place: body, a region or a shape");
  return node && sdr_read_place_node(rd, node, kind, out);
}
