#include "scene/import.h"
#include "scene/sections.h"

#include <math.h>

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
  /* Conditions of equations are met at points on the boundary. */
  const char *inside = sdr_node_find(rd->root, "equation") ? "true" : SDR_OPTIONAL;
  sdr_read_flag(rd->reader, jitter, "inside", inside, &points->jitter_inside);
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

static void read_across(sdr_reading *rd, sdr_node *map)
{
  sdr_reader *r = rd->reader;
  double *across = &rd->scene->points.thickness;
  if (r->dimension == SDR_1D) {
    sdr_read_number(r, map, "area", SDR_ABOVE_ZERO(SDR_AREA), "1 m^2", across);
  } else if (r->dimension != SDR_3D) {
    sdr_read_number(r, map, "thickness", SDR_ABOVE_ZERO(SDR_LENGTH), "1 m", across);
  }
}

/* Points from a file lie where they lie. */
static void read_imported(sdr_reading *rd, sdr_node *map)
{
  static const char *const lattice[] = {"shape", "spacing", "origin", "align",
                                        "angle", "jitter",  "refine", "adapt"};
  sdr_points_scene *points = &rd->scene->points;
  sdr_read_allow(rd->reader, map, "import");
  for (size_t k = 0; k < sizeof lattice / sizeof *lattice; ++k) {
    const sdr_node *node = sdr_node_find(map, lattice[k]);
    sdr_read_allow(rd->reader, map, lattice[k]);
    if (!node || sdr_node_is_null(node)) continue;
    sdr_read_error(rd->reader, node->key_origin,
                   "points.%s is for lattices, and these points are imported; remove one of the "
                   "two keys (in a variant: %s: null)",
                   lattice[k], lattice[k]);
  }
  read_across(rd, map);
  sdr_read_done(rd->reader, map);
  for (int32_t i = 0; i < points->imported->count; ++i)
    points->spacing =
        fmax(points->spacing, sdr_import_spacing(points->imported, i, points->thickness));
}

void sdr_read_points(sdr_reading *rd)
{
  sdr_reader *r = rd->reader;
  sdr_points_scene *points = &rd->scene->points;
  sdr_node *map = sdr_read_map(r, rd->root, "points", NULL);
  points->thickness = 1;
  if (!map) return;
  points->origin = map->key_origin;
  if (points->imported) {
    read_imported(rd, map);
    return;
  }
  if (sdr_read_has(r, map, "import") && !sdr_node_is_null(sdr_node_find(map, "import"))) return;
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
  sdr_read_adapt(rd, map);
  read_across(rd, map);
  sdr_read_done(r, map);
}
