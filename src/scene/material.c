#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void read_scatter(sdr_reading *rd, sdr_node *map, sdr_material *material)
{
  int64_t seed = 1;
  sdr_node *scatter = sdr_read_map(rd->reader, map, "scatter", "{}");
  if (!scatter) return;
  sdr_read_number(rd->reader, scatter, "young", (sdr_quantity){SDR_PLAIN, 0, 1, 0, 1}, "0 %",
                  &material->scatter_young);
  if (sdr_read_integer(rd->reader, scatter, "seed", 0, INT64_MAX, "1", &seed)) {
    material->scatter_seed = (uint64_t)seed;
  }
  sdr_read_done(rd->reader, scatter);
}

/* ---- model ----------------------------------------------------------------------------------- */

const char *const sdr_model_words[] = {"bond_based", "ordinary", "nonordinary", NULL};

void sdr_read_model(sdr_reading *rd)
{
  const sdr_node *map = sdr_node_find(rd->root, "material");
  const sdr_node *list = sdr_node_find(rd->root, "materials");
  if (!map && list && list->kind == SDR_SEQUENCE) map = list->first;
  const sdr_node *word = map && map->kind == SDR_MAPPING ? sdr_node_find(map, "model") : NULL;
  if (!word || word->kind != SDR_SCALAR) return;
  for (int k = 0; sdr_model_words[k]; ++k) {
    if (strcmp(word->text, sdr_model_words[k]) == 0) rd->scene->model = (sdr_model_kind)k;
  }
}

/* A key of one model, which stands in the first material and counts for the body. 1: read it. */
static int is_models_key(sdr_reading *rd, sdr_node *map, const char *key, sdr_model_kind model,
                         int first)
{
  const sdr_node *node = sdr_node_find(map, key);
  if (rd->scene->model == model && first) return 1;
  if (!node) return 0;
  sdr_read_allow(rd->reader, map, key);
  if (rd->scene->model != model) {
    sdr_read_error(rd->reader, node->key_origin,
                   "'%s' belongs to the model %s; the model here is %s", key,
                   sdr_model_words[model], sdr_model_words[rd->scene->model]);
  } else {
    sdr_read_error(rd->reader, node->key_origin,
                   "'%s' is the whole body's; give it in the first material only", key);
  }
  return 0;
}

static void read_form(sdr_reading *rd, sdr_node *map)
{
  static const char *const forms[] = {"standard", "madenci_oterkus", NULL};
  const int components = sdr_components(rd->scene->dimension);
  int form = 0;
  if (!sdr_read_word(rd->reader, map, "form", forms, NULL, "standard", &form)) return;
  rd->scene->form = (sdr_ordinary_form)form;
  if (form == SDR_FORM_MADENCI_OTERKUS && components != 2) {
    sdr_read_error(rd->reader, sdr_node_find(map, "form")->origin,
                   "the form 'madenci_oterkus' is for plane bodies; take standard");
  }
}

static void read_control(sdr_reading *rd, sdr_node *map)
{
  sdr_scene *scene = rd->scene;
  sdr_node *control = sdr_read_map(rd->reader, map, "control", "{}");
  if (!control) return;
  sdr_read_number_or(rd->reader, control, "shear", "auto", NAN, SDR_FROM_ZERO(SDR_STRESS), "auto",
                     &scene->control_shear);
  sdr_read_number_or(rd->reader, control, "normal", "auto", NAN, SDR_ANY_VALUE(SDR_STRESS), "auto",
                     &scene->control_normal);
  if (scene->control_shear + scene->control_normal < 0.0) {
    sdr_read_error(rd->reader, control->origin,
                   "control: shear + normal is below 0 Pa, which would feed the zero-energy modes; "
                   "raise one of them");
  }
  sdr_read_done(rd->reader, control);
}

/* Keys of one model only. */
static void read_options(sdr_reading *rd, sdr_node *map, int first)
{
  static const char *const elasticities[] = {"linear", "saint_venant_kirchhoff", "neo_hookean",
                                             NULL};
  int elasticity = 0;
  if (is_models_key(rd, map, "elasticity", SDR_NONORDINARY, first)) {
    sdr_read_word(rd->reader, map, "elasticity", elasticities, NULL, "linear", &elasticity);
    rd->scene->elasticity = (sdr_elasticity)elasticity;
  }
  if (is_models_key(rd, map, "form", SDR_ORDINARY, first)) read_form(rd, map);
  if (is_models_key(rd, map, "control", SDR_NONORDINARY, first)) read_control(rd, map);
}

/* One model a scene: later materials have the first's. */
static void read_model_word(sdr_reading *rd, sdr_node *map, int first)
{
  sdr_reader *r = rd->reader;
  const char *const common = sdr_model_words[rd->scene->model];
  int model = (int)rd->scene->model;
  if (!sdr_read_word(r, map, "model", sdr_model_words, NULL, first ? "bond_based" : common,
                     &model) ||
      model == (int)rd->scene->model) {
    return;
  }
  sdr_read_error(r, sdr_node_find(map, "model")->origin,
                 "the model '%s' beside '%s' of the first material; a scene has one model",
                 sdr_model_words[model], common);
}

/* Bond-based bodies have their own Poisson ratio, and so has a bar of any model. */
static void read_poisson(sdr_reading *rd, sdr_node *map, sdr_material *material)
{
  const sdr_scene *scene = rd->scene;
  const int is_free = scene->model == SDR_BOND_BASED || scene->dimension == SDR_1D;
  sdr_read_number(rd->reader, map, "poisson", (sdr_quantity){SDR_PLAIN, -1, 0.5, 1, 1},
                  is_free ? SDR_OPTIONAL : NULL, &material->poisson);
}

static void read_material(sdr_reading *rd, sdr_node *map, sdr_material *material)
{
  sdr_reader *r = rd->reader;
  const int first = material == rd->scene->material;
  material->poisson = NAN;
  material->toughness = INFINITY;
  material->density = NAN;
  material->strength = NAN;
  material->origin = map->key ? map->key_origin : map->origin;
  read_model_word(rd, map, first);
  read_options(rd, map, first);
  sdr_read_number(r, map, "young", SDR_ABOVE_ZERO(SDR_STRESS), NULL, &material->young);
  read_poisson(rd, map, material);
  sdr_read_number(r, map, "density", (sdr_quantity){{-3, 1, 0, 0}, 0, INFINITY, 0, 0}, NULL,
                  &material->density);
  sdr_read_number(r, map, "toughness", SDR_ABOVE_ZERO(((sdr_unit){0, 1, -2, 0})),
                  rd->scene->damage.law == SDR_LAW_NONE ? SDR_OPTIONAL : NULL,
                  &material->toughness);
  sdr_read_number(r, map, "strength", SDR_ABOVE_ZERO(SDR_STRESS),
                  rd->scene->damage.law == SDR_LAW_COHESIVE ? NULL : SDR_OPTIONAL,
                  &material->strength);
  read_scatter(rd, map, material);
  sdr_read_done(r, map);
}

/* ---- one or several -------------------------------------------------------------------------- */

static void read_material_item(sdr_reading *rd, sdr_node *item, int index)
{
  sdr_reader *r = rd->reader;
  sdr_material *material = &rd->scene->material[index];
  if (!sdr_read_is(r, item, SDR_MAPPING, "a material, {name: ..., young: ..., ...}")) return;
  const int named = sdr_read_name(r, item, "name", index == 0 ? "body" : NULL, material->name);
  for (int k = 0; named && k < index; ++k) {
    if (strcmp(material->name, rd->scene->material[k].name) != 0) continue;
    sdr_read_error(r, sdr_node_find(item, "name")->origin,
                   "the material '%s' stands twice; give each its own name", material->name);
  }
  sdr_read_place(rd, item, "where", SDR_VOLUME_PLACE, index == 0 ? "body" : NULL, &material->where);
  read_material(rd, item, material);
}

static void read_one_material(sdr_reading *rd)
{
  sdr_material *material = rd->scene->material;
  sdr_node *map = sdr_read_map(rd->reader, rd->root, "material", NULL);
  if (!map) return;
  snprintf(material->where.text, sizeof material->where.text, "body");
  material->where.origin = map->origin;
  sdr_read_name(rd->reader, map, "name", "body", material->name);
  read_material(rd, map, material);
}

/* precision: mixed is a matter of the bond-based kernels. */
static void check_precision(sdr_reading *rd)
{
  const sdr_node *node = sdr_node_find(rd->root, "precision");
  if (!rd->scene->mixed || rd->scene->model == SDR_BOND_BASED) return;
  sdr_read_error(rd->reader, node->origin,
                 "precision 'mixed' belongs to the model bond_based; the model here is %s, so take "
                 "double",
                 sdr_model_words[rd->scene->model]);
}

void sdr_read_materials(sdr_reading *rd)
{
  sdr_reader *r = rd->reader;
  check_precision(rd);
  sdr_node *list = sdr_node_find(rd->root, "materials");
  sdr_node *single = sdr_node_find(rd->root, "material");
  sdr_read_allow(r, rd->root, "material");
  sdr_read_allow(r, rd->root, "materials");
  if (list && single) {
    sdr_read_error(r, list->key_origin, "'material' and 'materials' together; give one of them");
    return;
  }
  rd->scene->control_shear = rd->scene->control_normal = NAN;
  if (list) {
    list = sdr_read_list(r, rd->root, "materials", NULL);
    if (!list) return;
    if (list->count == 0) {
      sdr_read_error(r, list->origin, "materials is an empty list; give at least one");
      return;
    }
  }
  rd->scene->material = sdr_reading_room(rd, list, sizeof *rd->scene->material);
  if (!rd->scene->material) return;
  rd->scene->material_count = list ? list->count : 1;
  if (!list) {
    read_one_material(rd);
    return;
  }
  int index = 0;
  for (sdr_node *item = list->first; item; item = item->next) read_material_item(rd, item, index++);
}
