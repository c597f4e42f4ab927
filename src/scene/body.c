#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- points ---------------------------------------------------------------------------------- */

/* One word for all components or a list of words. */
static void read_align(sdr_reading *rd, sdr_node *map)
{
  static const char *const words[] = {"point", "cell", NULL};
  int *cell = rd->scene->points.cell_centred;
  const int components = sdr_components(rd->reader->dimension);
  sdr_node *node = sdr_read_value(rd->reader, map, "align", "point", "point or cell");
  if (!node) return;
  if (node->kind == SDR_SCALAR) {
    int word = 0;
    if (!sdr_read_word_node(rd->reader, node, "align", words, NULL, &word)) return;
    for (int c = 0; c < components; ++c) cell[c] = word;
    return;
  }
  if (!sdr_read_is(rd->reader, node, SDR_SEQUENCE, "point, cell or a list of them")) return;
  if (node->count != components) {
    sdr_read_error(rd->reader, node->origin,
                   "points.align has %d words; this scene has %d "
                   "components",
                   node->count, components);
    return;
  }
  int c = 0;
  for (sdr_node *child = node->first; child; child = child->next, ++c) {
    sdr_read_word_node(rd->reader, child, "align", words, NULL, &cell[c]);
  }
}

static void read_jitter(sdr_reading *rd, sdr_node *map)
{
  sdr_points_scene *points = &rd->scene->points;
  int64_t seed = 1;
  sdr_node *jitter = sdr_read_map(rd->reader, map, "jitter", "{}");
  if (!jitter) return;
  sdr_read_number(rd->reader, jitter, "share", (sdr_quantity){SDR_PLAIN, 0, 0.5, 0, 1}, "0 %",
                  &points->jitter);
  if (sdr_read_integer(rd->reader, jitter, "seed", 0, INT64_MAX, "1", &seed)) {
    points->jitter_seed = (uint64_t)seed;
  }
  sdr_read_done(rd->reader, jitter);
}

static void read_refine_item(sdr_reading *rd, sdr_node *item, sdr_refine *refine)
{
  sdr_reader *r = rd->reader;
  if (!sdr_read_is(r, item, SDR_MAPPING, "{where: SHAPE, spacing: LENGTH}")) return;
  sdr_read_place(rd, item, "where", SDR_VOLUME_PLACE, NULL, &refine->where);
  if (sdr_read_number(r, item, "spacing", SDR_ABOVE_ZERO(SDR_LENGTH), NULL, &refine->spacing) &&
      rd->scene->points.spacing > 0) {
    const double levels = log2(rd->scene->points.spacing / refine->spacing);
    if (fabs(levels - rint(levels)) > 1e-9 || levels < 0.5 || levels > 20.5) {
      sdr_read_error(r, sdr_node_find(item, "spacing")->origin,
                     "the spacing %g m is no halving of the body's %g m; allowed: %g m, %g m, %g m "
                     "and so on",
                     refine->spacing, rd->scene->points.spacing, rd->scene->points.spacing / 2,
                     rd->scene->points.spacing / 4, rd->scene->points.spacing / 8);
    }
  }
  sdr_read_done(r, item);
}

static void read_refine(sdr_reading *rd, sdr_node *map)
{
  sdr_points_scene *points = &rd->scene->points;
  sdr_node *list = sdr_read_list(rd->reader, map, "refine", "[]");
  if (!list || list->count == 0) return;
  points->refine = sdr_reading_room(rd, list, sizeof *points->refine);
  if (!points->refine) return;
  for (sdr_node *item = list->first; item; item = item->next) {
    read_refine_item(rd, item, &points->refine[points->refine_count++]);
  }
}

void sdr_read_points(sdr_reading *rd)
{
  sdr_reader *r = rd->reader;
  sdr_points_scene *points = &rd->scene->points;
  sdr_node *map = sdr_read_map(r, rd->root, "points", NULL);
  points->thickness = 1;
  if (!map) return;
  points->origin = map->key_origin;
  const sdr_node *import = sdr_read_has(r, map, "import") ? sdr_node_find(map, "import") : NULL;
  if (import) {
    sdr_read_error(r, import->key_origin,
                   "'import' is not available in this version; give shape and spacing");
    return;
  }
  sdr_node *shape = sdr_read_value(r, map, "shape", NULL, "a shape, like {box: {...}}");
  if (shape) points->shape = sdr_read_shape(rd, shape, NULL);
  sdr_read_number(r, map, "spacing", SDR_ABOVE_ZERO(SDR_LENGTH), NULL, &points->spacing);
  sdr_read_vector(r, map, "origin", SDR_ANY_VALUE(SDR_LENGTH), "[0]", points->lattice_origin);
  read_align(rd, map);
  if (r->dimension != SDR_1D) {
    sdr_read_number(r, map, "angle", SDR_ANY_VALUE(SDR_PLAIN), "0 deg", &points->angle);
  }
  read_jitter(rd, map);
  read_refine(rd, map);
  if (r->dimension == SDR_1D) {
    sdr_read_number(r, map, "area", SDR_ABOVE_ZERO(SDR_AREA), "1 m^2", &points->thickness);
  } else if (r->dimension != SDR_3D) {
    sdr_read_number(r, map, "thickness", SDR_ABOVE_ZERO(SDR_LENGTH), "1 m", &points->thickness);
  }
  sdr_read_done(r, map);
}

/* ---- horizon and family ---------------------------------------------------------------------- */

static void read_horizon(sdr_reading *rd)
{
  sdr_scene *scene = rd->scene;
  sdr_node *node = sdr_read_value(rd->reader, rd->root, "horizon", "3.015 spacing",
                                  "a length, like 3 mm or 3.015 spacing");
  if (!node) return;
  scene->horizon_origin = node->origin;
  if (!sdr_read_relative_node(rd->reader, node, SDR_LENGTH, "spacing", SDR_USES_SPACE,
                              &scene->horizon_relative, &scene->horizon) ||
      sdr_expression_uses(scene->horizon)) {
    return;
  }
  double value;
  sdr_expression_value(scene->horizon, (double[3]){0, 0, 0}, 0, &value);
  if (!(value > 0)) {
    sdr_read_error(rd->reader, node->origin, "horizon = %s is out of range; allowed: above 0 m",
                   node->text);
  }
}

void sdr_read_family(sdr_reading *rd)
{
  static const char *const weights[] = {"constant", "partial_volume", "iso", NULL};
  static const char *const calibrations[] = {"family", "printed", NULL};
  int weight = 0, calibration = 0;
  read_horizon(rd);
  sdr_node *map = sdr_read_map(rd->reader, rd->root, "family", "{}");
  if (!map) return;
  sdr_read_word(rd->reader, map, "weight", weights, NULL, "constant", &weight);
  sdr_read_word(rd->reader, map, "calibration", calibrations, NULL, "family", &calibration);
  rd->scene->weight = (sdr_weight_kind)weight;
  rd->scene->calibration = (sdr_calibration_kind)calibration;
  sdr_read_done(rd->reader, map);
}

/* ---- materials ------------------------------------------------------------------------------- */

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

static void read_material(sdr_reading *rd, sdr_node *map, sdr_material *material)
{
  static const char *const models[] = {"bond_based", NULL};
  static const char *const later[] = {"ordinary", "nonordinary", NULL};
  sdr_reader *r = rd->reader;
  int model = 0;
  material->poisson = NAN;
  material->toughness = INFINITY;
  material->origin = map->key ? map->key_origin : map->origin;
  sdr_read_word(r, map, "model", models, later, "bond_based", &model);
  rd->scene->model = (sdr_model_kind)model;
  sdr_read_number(r, map, "young", SDR_ABOVE_ZERO(SDR_STRESS), NULL, &material->young);
  sdr_read_number(r, map, "poisson", (sdr_quantity){SDR_PLAIN, -1, 0.5, 1, 1}, SDR_OPTIONAL,
                  &material->poisson);
  sdr_read_number(r, map, "density", SDR_ABOVE_ZERO(((sdr_unit){-3, 1, 0, 0})), NULL,
                  &material->density);
  sdr_read_number(r, map, "toughness", SDR_ABOVE_ZERO(((sdr_unit){0, 1, -2, 0})),
                  rd->scene->damage.law == SDR_LAW_NONE ? SDR_OPTIONAL : NULL,
                  &material->toughness);
  read_scatter(rd, map, material);
  sdr_read_done(r, map);
}

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

void sdr_read_materials(sdr_reading *rd)
{
  sdr_reader *r = rd->reader;
  sdr_node *list = sdr_node_find(rd->root, "materials");
  sdr_node *single = sdr_node_find(rd->root, "material");
  sdr_read_allow(r, rd->root, "material");
  sdr_read_allow(r, rd->root, "materials");
  if (list && single) {
    sdr_read_error(r, list->key_origin, "'material' and 'materials' together; give one of them");
    return;
  }
  rd->scene->material_count = 1;
  if (list) {
    list = sdr_read_list(r, rd->root, "materials", NULL);
    if (!list) return;
    rd->scene->material_count = list->count;
    if (list->count == 0) {
      sdr_read_error(r, list->origin, "materials is an empty list; give at least one");
      return;
    }
  }
  rd->scene->material = sdr_reading_room(rd, list, sizeof *rd->scene->material);
  if (!rd->scene->material) return;
  if (!list) {
    read_one_material(rd);
    return;
  }
  int index = 0;
  for (sdr_node *item = list->first; item; item = item->next) read_material_item(rd, item, index++);
}

/* ---- damage ---------------------------------------------------------------------------------- */

static void read_protect(sdr_reading *rd, sdr_node *map)
{
  sdr_damage_scene *damage = &rd->scene->damage;
  sdr_node *list = sdr_read_list(rd->reader, map, "protect", "[]");
  if (!list || list->count == 0) return;
  damage->protect = sdr_reading_room(rd, list, sizeof *damage->protect);
  if (!damage->protect) return;
  for (sdr_node *item = list->first; item; item = item->next) {
    sdr_read_place_node(rd, item, SDR_VOLUME_PLACE, &damage->protect[damage->protect_count++]);
  }
}

/* Without the section there is no damage; a section must name its law. */
void sdr_read_damage(sdr_reading *rd)
{
  static const char *const laws[] = {"none", "variational", "critical_stretch", NULL};
  static const char *const later[] = {"at1", "cohesive", NULL};
  sdr_reader *r = rd->reader;
  sdr_damage_scene *damage = &rd->scene->damage;
  const int is_given = sdr_read_has(r, rd->root, "damage");
  sdr_node *map = sdr_read_map(r, rd->root, "damage", "{}");
  int law = SDR_LAW_NONE;
  damage->ell = (sdr_length){1, 1};
  damage->onset = NAN;
  if (!map) return;
  sdr_read_word(r, map, "law", laws, later, is_given ? NULL : "none", &law);
  damage->law = (sdr_law)law;
  sdr_read_length(r, map, "ell", "horizon", SDR_ABOVE_ZERO(SDR_LENGTH), "1 horizon", &damage->ell);
  sdr_read_number_or(r, map, "onset", "auto", NAN, (sdr_quantity){SDR_PLAIN, 0, 1, 1, 0}, "auto",
                     &damage->onset);
  read_protect(rd, map);
  sdr_read_done(r, map);
}
