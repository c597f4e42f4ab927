#include "scene/equation.h"

#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const forms[] = {"collocation", "variational", NULL};

/* ---- keys of bodies in motion ---------------------------------------------------------------- */

static void refuse_other_sections(sdr_reading *rd)
{
  static const char *const keys[] = {"horizon",  "family", "material", "materials",
                                     "damage",   "cracks", "initial",  "loads",
                                     "supports", "time",   "contact"};
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) {
    const sdr_node *node = sdr_node_find(rd->root, keys[k]);
    if (!node) continue;
    sdr_read_error(rd->reader, node->key_origin,
                   "'%s' does not go with 'equation', which is solved by nonlocal operators "
                   "instead of moving a body; leave one of them out",
                   keys[k]);
  }
}

/* `precision` has its default there. */
static void refuse_mixed(sdr_reading *rd)
{
  if (rd->scene->mixed)
    sdr_read_error(rd->reader, sdr_node_find(rd->root, "precision")->origin,
                   "precision 'mixed' is for bodies in motion; an equation is solved in double");
}

/* What makes points asks for a horizon and a material. */
static void stand_in(sdr_reading *rd)
{
  sdr_scene *scene = rd->scene;
  sdr_node node = {.kind = SDR_SCALAR, .text = "1 spacing", .key = "horizon", .parent = rd->root};
  scene->horizon_origin = scene->equation->origin;
  sdr_read_relative_node(rd->reader, &node, SDR_LENGTH, "spacing", 0, &scene->horizon_relative,
                         &scene->horizon);
  scene->material = sdr_reading_room(rd, NULL, sizeof *scene->material);
  if (scene->material) scene->material_count = 1;
}

/* ---- operators ------------------------------------------------------------------------------- */

/* Neighbours that serve well: half as many again as there are derivatives, and more. */
static int neighbours_for(int components, int order)
{
  static const int line[] = {2, 4, 6, 6, 8, 8}, plane[] = {8, 14, 22, 32, 44, 60};
  const int k = order < 1 ? 0 : order > 6 ? 5 : order - 1;
  return components == 1 ? line[k] : plane[k] * (components - 1);
}

static void read_support(sdr_reading *rd, sdr_node *map)
{
  sdr_reader *r = rd->reader;
  sdr_equation *e = rd->scene->equation;
  char fallback[16];
  int64_t nearest = 0;
  sdr_node *support = sdr_read_map(r, map, "support", "{}");
  if (!support) return;
  const sdr_node *radius = sdr_node_find(support, "radius");
  const sdr_node *count = sdr_node_find(support, "neighbours");
  snprintf(fallback, sizeof fallback, "%d", neighbours_for(sdr_components(r->dimension), e->order));
  if (radius && count) {
    sdr_read_error(r, count->key_origin,
                   "a support has a 'radius' or a number of 'neighbours', not both");
    sdr_read_allow(r, support, "neighbours");
  }
  if (radius) {
    sdr_read_length(r, support, "radius", "spacing", SDR_ABOVE_ZERO(SDR_LENGTH), NULL, &e->radius);
    sdr_read_allow(r, support, "neighbours");
  } else if (sdr_read_integer(r, support, "neighbours", 1, 1000, fallback, &nearest)) {
    e->nearest = (int)nearest;
    sdr_read_allow(r, support, "radius");
  }
  sdr_read_done(r, support);
}

static void read_order(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  sdr_equation *e = rd->scene->equation;
  const int least = words->least_order[e->variational];
  char fallback[16];
  int64_t order = least;
  snprintf(fallback, sizeof fallback, "%d", least);
  e->order = least;
  if (!sdr_read_integer(rd->reader, map, "order", 1, 6, fallback, &order)) return;
  e->order = (int)order;
  if (order >= least) return;
  sdr_read_error(rd->reader, sdr_node_find(map, "order")->origin,
                 "%s in the form '%s' has derivatives of order %d; operators of order %d have none",
                 words->word, forms[e->variational], least, (int)order);
}

static void read_form(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  sdr_equation *e = rd->scene->equation;
  const char *fallback = forms[words->least_order[0] == 0];
  if (!sdr_read_word(rd->reader, map, "form", forms, NULL, fallback, &e->variational)) return;
  if (words->least_order[e->variational] > 0) return;
  sdr_read_error(rd->reader, sdr_node_find(map, "form")->origin,
                 "the equation '%s' has no form '%s'; take %s", words->word, forms[e->variational],
                 forms[!e->variational]);
  e->variational = !e->variational;
}

static void read_operators(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  static const char *const weights[] = {"constant", "inverse", "inverse_square", "linear", "cubic",
                                        "gaussian", NULL};
  static const char *const singular[] = {"stop", "enlarge", NULL};
  static const char *const penalties[] = {"4/3", "8/3", "4"};
  static const char *const solvers[] = {"auto", "cholmod", "klu", "umfpack", "pcg", NULL};
  sdr_reader *r = rd->reader;
  sdr_equation *e = rd->scene->equation;
  int weight = 0, solver = 0;
  read_form(rd, map, words);
  read_order(rd, map, words);
  read_support(rd, map);
  if (sdr_read_word(r, map, "weight", weights, NULL, "gaussian", &weight))
    e->weight = (sdr_weight_function)weight;
  sdr_read_word(r, map, "singular", singular, NULL, "stop", &e->enlarge);
  if (e->variational) {
    sdr_read_number(r, map, "penalty", SDR_FROM_ZERO(SDR_PLAIN),
                    penalties[sdr_components(r->dimension) - 1], &e->penalty);
  } else if (sdr_read_has(r, map, "penalty")) {
    sdr_read_error(r, sdr_node_find(map, "penalty")->key_origin,
                   "'penalty' belongs to the form variational: collocation has no energy");
  }
  if (!sdr_read_word(r, map, "solver", solvers, NULL, "auto", &solver)) return;
  snprintf(e->solver, sizeof e->solver, "%s", solvers[solver]);
  if (!e->variational && (solver == 1 || solver == 4))
    sdr_read_error(r, sdr_node_find(map, "solver")->origin,
                   "'%s' is for symmetric matrices; collocation takes auto, klu or umfpack",
                   solvers[solver]);
}

/* ---- the equation and its conditions --------------------------------------------------------- */

/* One formula, or those of the components. How many were given. */
static int read_values(sdr_reading *rd, sdr_node *node, const sdr_equation_words *words,
                       sdr_unit unit, sdr_expression *out[3])
{
  if (words->is_vector) return sdr_read_components(rd->reader, node, unit, SDR_USES_SPACE, out);
  return sdr_read_formula_node(rd->reader, node, unit, SDR_USES_SPACE, &out[0]);
}

static void read_source(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  const char *what = words->is_vector ? "components, as [x, y]" : "a formula";
  sdr_node *node = sdr_read_value(rd->reader, map, "source", SDR_OPTIONAL, what);
  if (node) read_values(rd, node, words, words->source_unit, rd->scene->equation->source);
}

static void read_exact_stress(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  static const char *const names[] = {"[xx]", "[xx, yy, xy]", "[xx, yy, zz, yz, xz, xy]"};
  const int components = sdr_components(rd->reader->dimension);
  const int width = components * (components + 1) / 2;
  if (!words->has_stress || !sdr_read_has(rd->reader, map, "exact_stress")) return;
  sdr_node *list = sdr_read_list(rd->reader, map, "exact_stress", NULL);
  if (!list) return;
  if (list->count != width) {
    sdr_read_error(rd->reader, list->origin, "equation.exact_stress has %d components, wanted %s",
                   list->count, names[components - 1]);
    return;
  }
  int k = 0;
  for (sdr_node *child = list->first; child; child = child->next, ++k)
    sdr_read_formula_node(rd->reader, child, SDR_STRESS, SDR_USES_SPACE,
                          &rd->scene->equation->exact_stress[k]);
}

static void read_exact(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  const char *what = words->is_vector ? "components, as [x, y]" : "a formula";
  sdr_expression **exact = rd->scene->equation->exact;
  sdr_node *node = sdr_read_value(rd->reader, map, "exact", SDR_OPTIONAL, what);
  read_exact_stress(rd, map, words);
  if (!node) return;
  const int before = rd->reader->error_count;
  const int given = read_values(rd, node, words, words->unit, exact);
  const int wanted = words->is_vector ? sdr_components(rd->reader->dimension) : 1;
  if (given == wanted || rd->reader->error_count > before) return;
  sdr_read_error(rd->reader, node->origin, "the exact solution lacks components; give all %d",
                 wanted);
}

static void read_places(sdr_reading *rd, sdr_node *item, sdr_boundary *boundary)
{
  sdr_node *node = sdr_read_value(rd->reader, item, "on", NULL, "a place or a list of places");
  if (!node) return;
  if (node->kind != SDR_SEQUENCE) {
    boundary->place_count = sdr_read_place_node(rd, node, SDR_ANY_PLACE, &boundary->on[0]);
    return;
  }
  if (node->count == 0 || node->count > SDR_EQUATION_PLACES) {
    sdr_read_error(rd->reader, node->origin, "%d places; give 1 to %d", node->count,
                   (int)SDR_EQUATION_PLACES);
    return;
  }
  for (sdr_node *child = node->first; child; child = child->next)
    boundary->place_count +=
        sdr_read_place_node(rd, child, SDR_ANY_PLACE, &boundary->on[boundary->place_count]);
}

/* A condition that has no direction of its own needs faces. */
static void check_faces(sdr_reading *rd, const sdr_node *node, const sdr_boundary *boundary)
{
  for (int k = 0; k < boundary->place_count; ++k)
    if (!boundary->on[k].face[0])
      sdr_read_error(rd->reader, node->key_origin, "'%s' acts across a face; '%s' is a volume",
                     node->key, boundary->on[k].text);
}

static void read_condition(sdr_reading *rd, sdr_node *node, const sdr_equation_words *words,
                           sdr_boundary *boundary)
{
  const sdr_equation_condition *condition = &words->condition[boundary->condition];
  const sdr_equation *e = rd->scene->equation;
  const int before = rd->reader->error_count;
  if (condition->is_natural) check_faces(rd, node, boundary);
  boundary->origin = node->key_origin;
  boundary->is_exact = node->kind == SDR_SCALAR && strcmp(node->text, "exact") == 0;
  if (!boundary->is_exact) {
    if (read_values(rd, node, words, condition->unit, boundary->value) > 0) return;
    if (rd->reader->error_count == before)
      sdr_read_error(rd->reader, node->origin, "'%s' has no component; give at least one",
                     node->key);
  } else if (!condition->is_solution) {
    sdr_read_error(rd->reader, node->origin,
                   "'exact' is the solution itself; give the values of '%s'", node->key);
  } else if (!e->exact[0]) {
    sdr_read_error(rd->reader, node->origin, "there is no 'equation.exact' that '%s' could take",
                   node->key);
  }
}

/* An entry may prescribe several things on its places; each becomes one of the scene's. */
static void read_entry(sdr_reading *rd, sdr_node *item, const sdr_equation_words *words)
{
  sdr_equation *e = rd->scene->equation;
  sdr_boundary places = {0};
  char names[120] = "";
  int given = 0;
  if (!sdr_read_is(rd->reader, item, SDR_MAPPING, "a condition, {on: PLACE, ...}")) return;
  read_places(rd, item, &places);
  for (int k = 0; k < SDR_EQUATION_CONDITIONS && words->condition[k].word; ++k) {
    const char *word = words->condition[k].word;
    const size_t used = strlen(names);
    snprintf(names + used, sizeof names - used, "%s%s", k ? " or " : "", word);
    sdr_node *node = sdr_read_value(rd->reader, item, word, SDR_OPTIONAL, "a value");
    if (!node) continue;
    ++given;
    places.condition = k;
    e->boundary[e->boundary_count] = places;
    read_condition(rd, node, words, &e->boundary[e->boundary_count++]);
  }
  if (given == 0)
    sdr_read_error(rd->reader, item->origin, "the entry prescribes nothing; give %s", names);
  sdr_read_done(rd->reader, item);
}

static void read_boundary(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  sdr_equation *e = rd->scene->equation;
  sdr_node *list = sdr_read_list(rd->reader, map, "boundary", NULL);
  if (!list) return;
  e->boundary = sdr_reading_room(rd, list, SDR_EQUATION_CONDITIONS * sizeof *e->boundary);
  if (!e->boundary) return;
  for (sdr_node *item = list->first; item; item = item->next) read_entry(rd, item, words);
}

static void read_coarser(sdr_reading *rd, sdr_node *map)
{
  sdr_equation *e = rd->scene->equation;
  sdr_node *list = sdr_read_list(rd->reader, map, "coarser", "[]");
  if (!list) return;
  for (sdr_node *child = list->first; child; child = child->next) {
    double spacing = 0.0;
    const double before = e->coarser_count ? e->coarser[e->coarser_count - 1] : (double)INFINITY;
    if (e->coarser_count == SDR_EQUATION_COARSER) {
      sdr_read_error(rd->reader, child->origin, "more than %d coarser spacings",
                     (int)SDR_EQUATION_COARSER);
      return;
    }
    if (!sdr_read_number_node(rd->reader, child, SDR_ABOVE_ZERO(SDR_LENGTH), &spacing)) continue;
    if (!(spacing < before && spacing > rd->scene->points.spacing))
      sdr_read_error(rd->reader, child->origin,
                     "coarser spacings fall towards points.spacing, %g m; %s does not",
                     rd->scene->points.spacing, child->text);
    e->coarser[e->coarser_count++] = spacing;
  }
}

static void read_numbers(sdr_reading *rd, sdr_node *map, const sdr_equation_words *words)
{
  for (int k = 0; k < SDR_EQUATION_NUMBERS && words->number[k].word; ++k) {
    const sdr_equation_number *number = &words->number[k];
    if (sdr_components(rd->reader->dimension) < number->least_components) continue;
    const sdr_quantity quantity = {number->unit, number->low, number->high, number->above_low, 1};
    sdr_read_number(rd->reader, map, number->word, quantity, number->fallback,
                    &rd->scene->equation->number[k]);
  }
}

static int read_kind(sdr_reading *rd, sdr_node *map, const sdr_equation_words **out)
{
  enum { MOST_KINDS = 32 };
  const char *names[MOST_KINDS + 1] = {NULL};
  int kind = 0;
  for (int k = 0; k < MOST_KINDS && sdr_equations[k].word; ++k) names[k] = sdr_equations[k].word;
  if (!sdr_read_word(rd->reader, map, "kind", names, NULL, NULL, &kind)) return 0;
  *out = &sdr_equations[kind];
  rd->scene->equation->kind = (sdr_equation_kind)kind;
  if ((*out)->is_vector && rd->scene->stateless)
    sdr_read_error(rd->reader, sdr_node_find(rd->root, "dimension")->origin,
                   "'%s' in the plane has a state; give plane_stress or plane_strain", names[kind]);
  if (!(*out)->in_plane || sdr_components(rd->reader->dimension) == 2) return 1;
  sdr_read_error(rd->reader, sdr_node_find(map, "kind")->origin,
                 "the equation '%s' is one of two dimensions; give dimension: 2d", names[kind]);
  return 0;
}

/* ---- output ---------------------------------------------------------------------------------- */

static void read_output(sdr_reading *rd)
{
  sdr_output_scene *output = &rd->scene->output;
  char directory[2 * SDR_NAME_MAX + 8];
  int64_t snapshots = 1;
  sdr_node *map = sdr_read_map(rd->reader, rd->root, "output", "{}");
  if (!map) return;
  snprintf(directory, sizeof directory, "out/%s%s%s", rd->scene->name,
           rd->scene->variant[0] ? "-" : "", rd->scene->variant);
  sdr_read_text(rd->reader, map, "directory", directory, output->directory,
                sizeof output->directory);
  sdr_read_integer(rd->reader, map, "snapshots", 0, 1, "1", &snapshots);
  output->snapshots = (int)snapshots;
  sdr_read_done(rd->reader, map);
}

void sdr_read_equation(sdr_reading *rd)
{
  const sdr_equation_words *words = NULL;
  refuse_other_sections(rd);
  refuse_mixed(rd);
  sdr_node *map = sdr_read_map(rd->reader, rd->root, "equation", NULL);
  if (!map) return;
  rd->scene->equation = sdr_reading_room(rd, NULL, sizeof *rd->scene->equation);
  if (!rd->scene->equation) return;
  rd->scene->equation->origin = map->key_origin;
  stand_in(rd);
  if (!read_kind(rd, map, &words)) return;
  read_operators(rd, map, words);
  read_numbers(rd, map, words);
  read_source(rd, map, words);
  read_exact(rd, map, words);
  read_boundary(rd, map, words);
  read_coarser(rd, map);
  sdr_read_done(rd->reader, map);
  if (rd->scene->points.refine_count > 0)
    sdr_read_error(rd->reader, rd->scene->points.refine[0].where.origin,
                   "points.refine does not go with 'equation'");
  read_output(rd);
}
