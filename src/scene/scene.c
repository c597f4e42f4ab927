#include "scene/scene.h"

#include "base/memory.h"
#include "scene/hash.h"
#include "scene/sections.h"
#include "scene/yaml.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *sdr_origin_text(sdr_origin origin)
{
  static _Thread_local char texts[4][640];
  static _Thread_local int turn;
  char *text = texts[turn++ & 3];
  const char *file = origin.file ? origin.file : "?";
  if (origin.line > 0) {
    snprintf(text, sizeof texts[0], "%s:%d:%d", file, origin.line, origin.column);
  } else if (origin.column > 0) {
    snprintf(text, sizeof texts[0], "%s:%d", file, origin.column);
  } else {
    snprintf(text, sizeof texts[0], "%s", file);
  }
  return text;
}

void *sdr_reading_room(sdr_reading *reading, const sdr_node *list, size_t size)
{
  void *room = sdr_store_alloc(reading->reader->store, list ? (size_t)list->count : 1, size);
  if (!room) sdr_read_fatal(reading->reader, SDR_RUN_FAILED);
  return room;
}

/* What is asked for; the same for the scene itself and for the check of its variants. */
typedef struct {
  const char *path, *variant;
  int set_count;
  const char *const *sets;
  const char *text; /* instead of the file's; NULL: read the file */
} request;

/* ---- names ----------------------------------------------------------------------------------- */

/* "problems/notch/scene.yaml" is notch, "tests/bar.yaml" is bar. */
static void name_scene(sdr_scene *scene, const char *path)
{
  char full[PATH_MAX];
  if (!realpath(path, full)) snprintf(full, sizeof full, "%s", path);
  char *slash = strrchr(full, '/');
  if (slash && strcmp(slash, "/scene.yaml") == 0 && slash != full) {
    *slash = '\0';
    slash = strrchr(full, '/');
  } else {
    char *dot = strrchr(full, '.');
    if (dot && (strcmp(dot, ".yaml") == 0 || strcmp(dot, ".yml") == 0)) *dot = '\0';
  }
  snprintf(scene->name, sizeof scene->name, "%.60s", slash ? slash + 1 : full);
}

/* ---- --set ----------------------------------------------------------------------------------- */

/* What --set brings has no line. */
static void clear_lines(sdr_node *node)
{
  node->origin.line = node->origin.column = 0;
  node->key_origin = node->origin;
  for (sdr_node *child = node->first; child; child = child->next) {
    child->text_column = 0;
    clear_lines(child);
  }
}

/* The latest message without the place "FILE:LINE:COLUMN: " that it may begin with. */
static const char *message_after(const char *file)
{
  const char *message = sdr_error_message();
  if (strncmp(message, file, strlen(file)) != 0) return message;
  const char *text = strstr(message + strlen(file), ": ");
  return text ? text + 2 : message;
}

static void set_failed(sdr_reader *reader, sdr_status status, sdr_origin origin)
{
  if (status == SDR_BAD_INPUT) {
    sdr_read_error(reader, origin, "%s", message_after(origin.file));
  } else {
    sdr_read_fatal(reader, status);
  }
}

static void apply_set(sdr_reader *reader, sdr_node *root, const char *set)
{
  const char *equals = strchr(set, '=');
  const int length = equals ? (int)(equals - set) : (int)strlen(set);
  sdr_origin origin = {sdr_store_format(reader->store, "--set %.*s", length, set), 0, 0};
  char *path = sdr_store_copy(reader->store, set, (size_t)length);
  if (!origin.file || !path) {
    sdr_read_fatal(reader, SDR_RUN_FAILED);
    return;
  }
  if (!equals || length == 0) {
    sdr_read_error(reader, origin, "write it as PATH=VALUE, like --set time.end=\"1 us\"");
    return;
  }
  if (strcmp(path, "variants") == 0 || strncmp(path, "variants.", 9) == 0) {
    sdr_read_error(
        reader, origin,
        "overrides change the scene that runs, not its variants; give --variant NAME and "
        "override the key itself, like --set points.spacing=\"1 mm\"");
    return;
  }
  sdr_node *value = NULL;
  sdr_status status =
      sdr_yaml_parse(reader->store, equals + 1, strlen(equals + 1), origin.file, &value);
  if (status == SDR_OK && !value) {
    sdr_read_error(reader, origin, "no value after '='; give one");
    return;
  }
  if (status == SDR_OK) {
    clear_lines(value);
    status = sdr_node_set(reader->store, root, path, value);
  }
  if (status != SDR_OK) set_failed(reader, status, origin);
}

/* ---- variants -------------------------------------------------------------------------------- */

/* Their names, ", " between; "" if memory ran out, which is noted. */
static const char *variant_names(sdr_reader *reader, const sdr_node *variants)
{
  const char *names = "";
  if (!variants || variants->kind != SDR_MAPPING) return names;
  for (const sdr_node *v = variants->first; v; v = v->next) {
    names = sdr_store_format(reader->store, "%s%s%s", names, *names ? ", " : "", v->key);
    if (names) continue;
    sdr_read_fatal(reader, SDR_RUN_FAILED);
    return "";
  }
  return names;
}

static void unknown_variant(sdr_reader *reader, const sdr_node *variants, const char *variant)
{
  const char *names = variant_names(reader, variants);
  sdr_read_error(reader, (sdr_origin){reader->file, 0, 0}, "unknown variant '%.60s'; %s%.400s",
                 variant, *names ? "variants of this scene: " : "this scene has no variants",
                 names);
}

/* Merge the variant that is asked for, then drop `variants`; 0 on error. */
static int apply_variant(sdr_reader *reader, sdr_node *root, const char *variant)
{
  sdr_node *variants = sdr_node_find(root, "variants");
  if (variants && variants->kind != SDR_MAPPING) variants = NULL;
  const sdr_node *over = sdr_node_find(variants, variant);
  if (*variant && !over) {
    unknown_variant(reader, variants, variant);
    return 0;
  }
  variants = sdr_node_find(root, "variants");
  if (variants) sdr_node_remove(variants);
  if (over && over->kind == SDR_MAPPING &&
      sdr_node_merge(reader->store, root, over, sdr_is_shape_word) != SDR_OK) {
    sdr_read_fatal(reader, SDR_RUN_FAILED);
  }
  return 1;
}

/* The block itself: names, and that each is a mapping of known keys is found by reading it. */
static void check_variants_block(sdr_reader *reader, const sdr_node *root)
{
  const sdr_node *variants = sdr_node_find(root, "variants");
  if (!variants || sdr_node_is_null(variants)) return;
  if (!sdr_read_is(reader, variants, SDR_MAPPING, "a mapping, NAME: {overrides}")) return;
  for (const sdr_node *v = variants->first; v; v = v->next) {
    sdr_read_is_name(reader, v->key, v->key_origin, "a variant");
    if (!sdr_read_is(reader, v, SDR_MAPPING, "overrides, {key: value}")) continue;
    const sdr_node *nested = sdr_node_find(v, "variants");
    if (nested) sdr_read_error(reader, nested->key_origin, "a variant cannot hold variants");
  }
}

/* ---- one scene ------------------------------------------------------------------------------- */

static void read_top(sdr_reading *rd)
{
  static const char *const precisions[] = {"double", "mixed", NULL};
  sdr_reader *r = rd->reader;
  int64_t threads = 0;
  sdr_read_text(r, rd->root, "title", rd->scene->name, rd->scene->title, sizeof rd->scene->title);
  const sdr_node *node = sdr_node_find(rd->root, "threads");
  if (node && node->kind == SDR_SCALAR && strcmp(node->text, "all") == 0) {
    sdr_read_allow(r, rd->root, "threads");
  } else if (sdr_read_integer(r, rd->root, "threads", 0, 256, "0", &threads)) {
    rd->scene->threads = (int)threads;
  }
  sdr_read_word(r, rd->root, "precision", precisions, NULL, "double", &rd->scene->mixed);
}

/* Regions need the dimension, places the regions and the body, output the time. */
static void read_sections(sdr_reading *rd)
{
  static const char *const dimensions[] = {"1d", "plane_stress", "plane_strain", "3d", NULL};
  static const char *const of_equations[] = {"1d", "plane_stress", "plane_strain",
                                             "3d", "2d",           NULL};
  static const char *const keys[] = {
      "title",  "dimension", "points",   "horizon", "family",    "material", "materials",
      "damage", "regions",   "cracks",   "initial", "loads",     "supports", "time",
      "output", "figures",   "variants", "threads", "precision", "equation", "contact"};
  int dimension;
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) {
    sdr_read_allow(rd->reader, rd->root, keys[k]);
  }
  sdr_read_done(rd->reader, rd->root);
  const int is_equation = sdr_node_find(rd->root, "equation") != NULL;
  if (!sdr_read_word(rd->reader, rd->root, "dimension", is_equation ? of_equations : dimensions,
                     NULL, NULL, &dimension))
    return;
  rd->scene->stateless = dimension == 4; /* in the plane, whatever its state */
  if (dimension == 4) dimension = SDR_PLANE_STRESS;
  rd->reader->dimension = rd->scene->dimension = (sdr_dimension)dimension;
  read_top(rd);
  sdr_read_import(rd);
  sdr_read_regions(rd);
  if (is_equation) {
    sdr_read_points(rd);
    sdr_read_equation(rd);
    sdr_read_figures(rd);
    return;
  }
  sdr_read_model(rd);
  sdr_read_points(rd);
  sdr_read_family(rd);
  sdr_read_damage(rd);
  sdr_read_materials(rd);
  sdr_read_cracks(rd);
  sdr_read_initial(rd);
  sdr_read_loads(rd);
  sdr_read_supports(rd);
  sdr_read_time(rd);
  sdr_read_contact(rd);
  sdr_check_adapt(rd);
  sdr_read_output(rd);
  sdr_read_figures(rd);
  sdr_find_idle(rd);
}

/* Make the tree what it is with the variant and the overrides, and read it into the scene. */
static void read_tree(sdr_reader *reader, const request *asked, sdr_node *root, sdr_scene *scene)
{
  snprintf(scene->path, sizeof scene->path, "%s", asked->path);
  snprintf(scene->variant, sizeof scene->variant, "%s", asked->variant);
  name_scene(scene, asked->path);
  if (!apply_variant(reader, root, asked->variant)) return;
  const int before = reader->error_count;
  for (int k = 0; k < asked->set_count; ++k) apply_set(reader, root, asked->sets[k]);
  if (reader->error_count > before || reader->fatal != SDR_OK) return;
  sdr_reading reading = {.reader = reader, .scene = scene, .root = root};
  read_sections(&reading);
}

/* Read each variant that is not asked for, and report what is wrong with it. */
static void check_variant(sdr_reader *main_reader, const request *asked, const sdr_node *root,
                          const sdr_node *variant)
{
  sdr_store *store = sdr_store_create();
  sdr_node *copy = store ? sdr_node_copy(store, root) : NULL;
  sdr_scene *scene = store ? sdr_store_alloc(store, 1, sizeof *scene) : NULL;
  sdr_reader reader = {
      .store = store, .file = main_reader->file, .imported = main_reader->imported};
  memcpy(reader.imported_how, main_reader->imported_how, sizeof reader.imported_how);
  if (copy && scene) {
    request other = *asked;
    other.variant = variant->key;
    read_tree(&reader, &other, copy, scene);
    if (reader.fatal != SDR_OK) sdr_read_fatal(main_reader, reader.fatal);
  } else {
    sdr_read_fatal(main_reader, SDR_RUN_FAILED);
  }
  const int kept =
      reader.error_count < SDR_READER_KEPT_ERRORS ? reader.error_count : SDR_READER_KEPT_ERRORS;
  /* Another build, with what reads its file, will check it. */
  for (int k = 0; k < kept && !reader.unreadable; ++k) {
    /* An override may not fit a variant that it was not meant for. */
    if (reader.error[k].origin.file != reader.file) continue;
    sdr_read_error(main_reader, reader.error[k].origin, "in the variant '%s': %s", variant->key,
                   reader.error[k].text);
  }
  sdr_store_destroy(&store);
}

static void check_other_variants(sdr_reader *reader, const request *asked, const sdr_node *root)
{
  const sdr_node *variants = sdr_node_find(root, "variants");
  if (!variants || variants->kind != SDR_MAPPING) return;
  for (const sdr_node *v = variants->first; v; v = v->next) {
    if (reader->error_count > 0 || reader->fatal != SDR_OK) return;
    if (strcmp(v->key, asked->variant) != 0) check_variant(reader, asked, root, v);
  }
}

/* ---- loading --------------------------------------------------------------------------------- */

static sdr_status parse_file(sdr_store *store, const char *path, const char *file, sdr_node **root)
{
  char *text;
  size_t length;
  SDR_TRY(sdr_yaml_read_file(path, &text, &length));
  const sdr_status status = sdr_yaml_parse(store, text, length, file, root);
  sdr_free(text);
  return status;
}

static sdr_status parse(sdr_store *store, const request *asked, const char *file, sdr_node **root)
{
  *root = NULL;
  if (asked->text)
    SDR_TRY(sdr_yaml_parse(store, asked->text, strlen(asked->text), file, root));
  else
    SDR_TRY(parse_file(store, asked->path, file, root));
  if (!*root || sdr_node_is_null(*root)) {
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: the file is empty; a scene needs at least dimension, "
                    "points, material and time",
                    file);
  }
  if ((*root)->kind != SDR_MAPPING) {
    return sdr_fail(SDR_BAD_INPUT, "%s: the scene is %s; wanted lines of key: value",
                    sdr_origin_text((*root)->origin), sdr_node_kind_name((*root)->kind));
  }
  return SDR_OK;
}

static sdr_status read_scene(const request *asked, sdr_reader *reader, sdr_scene *scene)
{
  sdr_node *root, *copy;
  SDR_TRY(parse(scene->store, asked, reader->file, &root));
  copy = sdr_node_copy(scene->store, root);
  if (!copy) return SDR_RUN_FAILED;
  check_variants_block(reader, root);
  scene->variants = variant_names(reader, sdr_node_find(root, "variants"));
  read_tree(reader, asked, copy, scene);
  check_other_variants(reader, asked, root);
  SDR_TRY(sdr_read_finish(reader));
  scene->defaults = reader->defaults;
  scene->default_count = reader->default_count;
  scene->idle = reader->idle;
  scene->idle_count = reader->idle_count;
  scene->hash = sdr_scene_tree_hash(copy);
  scene->used_yaml = sdr_yaml_write(copy);
  return scene->used_yaml ? SDR_OK : SDR_RUN_FAILED;
}

static sdr_status load(const request *asked, sdr_scene **out)
{
  if (strlen(asked->path) >= sizeof(*out)->path) {
    return sdr_fail(SDR_BAD_INPUT, "the path of the scene is longer than 511 bytes");
  }
  if (strlen(asked->variant) >= SDR_NAME_MAX) {
    return sdr_fail(SDR_BAD_INPUT, "%s: the name of the variant is longer than 63 bytes",
                    asked->path);
  }
  sdr_status status = SDR_RUN_FAILED;
  sdr_reader *reader = NULL;
  sdr_scene *scene = sdr_alloc(1, sizeof *scene);
  if (!scene) goto done;
  scene->store = sdr_store_create();
  if (!scene->store) goto done;
  reader = sdr_alloc(1, sizeof *reader);
  if (!reader) goto done;
  reader->store = scene->store;
  reader->file = sdr_store_copy(scene->store, asked->path, strlen(asked->path));
  if (reader->file) status = read_scene(asked, reader, scene);
done:
  sdr_free(reader);
  if (status == SDR_OK) {
    *out = scene;
  } else {
    sdr_scene_destroy(&scene);
  }
  return status;
}

sdr_status sdr_scene_load(const char *path, const char *variant, int set_count,
                          const char *const *sets, sdr_scene **out)
{
  const request asked = {path, variant ? variant : "", set_count, sets, NULL};
  return load(&asked, out);
}

sdr_status sdr_scene_parse(const char *text, const char *name, sdr_scene **out)
{
  const request asked = {.path = name, .variant = "", .text = text};
  return load(&asked, out);
}

void sdr_scene_destroy(sdr_scene **scene)
{
  if (!scene || !*scene) return;
  sdr_free((*scene)->used_yaml);
  sdr_store_destroy(&(*scene)->store);
  sdr_free(*scene);
  *scene = NULL;
}
