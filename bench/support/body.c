#include "support/body.h"

#include "base/memory.h"
#include "mechanics/state_based.h"
#include "time/integrator.h"

#include <math.h>
#include <string.h>

static const double young = 210e9, toughness = 2e4, density = 7850.0;
static const double horizon_ratio = 3.015, inner = 81e-3, outer = 149e-3;

int32_t *bench_shuffle(int32_t count)
{
  int32_t *order = sdr_alloc((size_t)count, sizeof *order);
  uint64_t state = 88172645463325252u; /* xorshift */
  for (int32_t i = 0; order && i < count; ++i) order[i] = i;
  for (int32_t i = count - 1; order && i > 0; --i) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    const int32_t k = (int32_t)(state % ((uint64_t)i + 1)), kept = order[i];
    order[i] = order[k];
    order[k] = kept;
  }
  return order;
}

/* ---- points ---------------------------------------------------------------------------------- */

static int inside(const bench_how *how, const int32_t cell[3])
{
  if (how->dimension == 3) return 1;
  const double r = how->spacing * hypot(cell[0], cell[1]), slack = 1e-9 * how->spacing;
  return r >= inner - slack && r <= outer + slack;
}

/* Lattice cells of the body in row order; `points` NULL: only count them. */
static int32_t place(const bench_how *how, double spacing, sdr_points *points)
{
  const int32_t reach = (int32_t)ceil(outer / how->spacing);
  const int32_t low = how->dimension == 3 ? 0 : -reach;
  const int32_t high = how->dimension == 3 ? how->edge - 1 : reach;
  int32_t count = 0;
  for (int32_t z = how->dimension == 3 ? low : 0; z <= (how->dimension == 3 ? high : 0); ++z)
    for (int32_t y = low; y <= high; ++y)
      for (int32_t x = low; x <= high; ++x) {
        const int32_t cell[3] = {x, y, z};
        if (!inside(how, cell)) continue;
        for (int a = 0; points && a < 3; ++a) {
          points->cell[3 * (size_t)count + (size_t)a] = cell[a];
          if (a < how->dimension) points->x[a][count] = spacing * cell[a];
        }
        ++count;
      }
  return count;
}

static void shuffle_points(sdr_points *points, const int32_t *order)
{
  for (int a = 0; a < points->components; ++a) {
    double *kept = sdr_alloc((size_t)points->count, sizeof *kept);
    if (!kept) return; /* the order stays: the body is checked against the other */
    memcpy(kept, points->x[a], (size_t)points->count * sizeof *kept);
    for (int32_t i = 0; i < points->count; ++i) points->x[a][i] = kept[order[i]];
    sdr_free(kept);
  }
  sdr_free(points->cell);
  points->cell = NULL;
}

static sdr_status make_points(const bench_how *how, bench_body *body)
{
  const double spacing = how->dimension == 3 ? 1e-3 : how->spacing;
  const double depth = how->dimension == 3 ? spacing : 1e-3;
  sdr_points *points;
  SDR_TRY(
      sdr_points_create(place(how, spacing, NULL), how->layer ? 3 : how->dimension, 1, &points));
  body->points = points;
  place(how, spacing, points);
  points->lattice_spacing = spacing;
  for (int32_t i = 0; i < points->count; ++i) {
    points->spacing[i] = spacing;
    points->horizon[i] = horizon_ratio * spacing;
    points->volume[i] = spacing * spacing * depth;
  }
  int32_t *order = how->shuffled ? bench_shuffle(points->count) : NULL;
  if (how->shuffled && !order) return SDR_RUN_FAILED;
  if (order) shuffle_points(points, order);
  sdr_status status = sdr_points_arrange(points);
  if (order && status == SDR_OK) {
    body->original = sdr_alloc((size_t)points->count, sizeof *body->original);
    if (!body->original) status = SDR_RUN_FAILED;
    for (int32_t i = 0; body->original && i < points->count; ++i)
      body->original[i] = order[points->generated[i]];
  }
  sdr_free(order);
  return status;
}

/* ---- model and state ------------------------------------------------------------------------- */

/* A number in -1..1 that depends on the place alone, so that it is the same in any order. */
static double noise(const sdr_points *points, int32_t i, double phase)
{
  double argument = phase;
  for (int a = 0; a < points->components; ++a)
    argument += points->x[a][i] / points->spacing[i] * (1.7 + 0.6 * a);
  return 0.5 * (sin(argument) + sin(1.31 * argument + phase));
}

static sdr_status make_bond_based(const bench_how *how, const double *modulus, sdr_bonds *bonds,
                                  bench_body *body)
{
  const sdr_points *points = body->points;
  const sdr_bond_based_how model_how = {.dimension =
                                            points->components == 3 ? SDR_3D : SDR_PLANE_STRESS,
                                        .law = how->law,
                                        .mixed = how->mixed,
                                        .calibration = SDR_CALIBRATE_FAMILY,
                                        .ell = {.value = 1.0, .relative = 1},
                                        .young = modulus,
                                        .toughness = &toughness};
  return sdr_bond_based_create(points, bonds, body->families, &model_how, &body->model);
}

static sdr_status make_state_based(const bench_how *how, const double *modulus, sdr_bonds *bonds,
                                   bench_body *body)
{
  const double poisson = 0.25;
  const sdr_points *points = body->points;
  const sdr_state_based_how model_how = {.dimension =
                                             points->components == 3 ? SDR_3D : SDR_PLANE_STRESS,
                                         .law = how->law,
                                         .control_shear = (double)NAN,
                                         .control_normal = (double)NAN,
                                         .young = modulus,
                                         .poisson = &poisson,
                                         .toughness = &toughness};
  return how->model == SDR_ORDINARY
             ? sdr_ordinary_create(points, bonds, &model_how, &body->model)
             : sdr_nonordinary_create(points, bonds, &model_how, &body->model);
}

static sdr_status make_model(const bench_how *how, bench_body *body)
{
  const sdr_points *points = body->points;
  const sdr_bonds_how bonds_how = {.force_loose = how->loose,
                                   .in_order = how->model == SDR_NONORDINARY};
  sdr_bonds *bonds = NULL;
  double *modulus = sdr_alloc(sdr_points_padded(points), sizeof *modulus);
  sdr_status status = modulus ? SDR_OK : SDR_RUN_FAILED;
  for (int32_t i = 0; modulus && i < points->count; ++i)
    modulus[i] = young * (how->scattered ? 1.0 + 0.05 * noise(points, i, 3.0) : 1.0);
  if (status == SDR_OK)
    status = sdr_families_create(points, &(sdr_families_how){0}, &body->families);
  if (status == SDR_OK) status = sdr_bonds_create(points, &bonds_how, &bonds);
  if (status == SDR_OK)
    status = how->model == SDR_BOND_BASED ? make_bond_based(how, modulus, bonds, body)
                                          : make_state_based(how, modulus, bonds, body);
  sdr_free(modulus);
  return status;
}

sdr_status bench_body_restart(bench_body *body)
{
  sdr_system *system = body->system;
  const double strain = 0.05 * 1e-2; /* of about 1e-2 that break a bond at these spacings */
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < system->count; ++i) {
      system->u[a][i] = strain * body->points->spacing[i] * noise(body->points, i, 1.0 + a);
      system->v[a][i] = 0.0;
    }
  system->step = 0;
  system->time = 0.0;
  return sdr_leapfrog.start(system, body->step);
}

void bench_body_forget(bench_body *body)
{
  sdr_state_block blocks[SDR_STATE_BLOCKS];
  int count = 0;
  body->model->ops->state(body->model, blocks, &count);
  for (int k = 0; k < count; ++k)
    if (strstr(blocks[k].name, "stretch") || strstr(blocks[k].name, "flags"))
      memset(blocks[k].data, 0, blocks[k].bytes);
}

sdr_status bench_body_create(const bench_how *how, bench_body *out)
{
  static const sdr_scene nothing; /* no loads, no supports */
  bench_body body = {.step =
                         0.3 * (how->dimension == 3 ? 1e-3 : how->spacing) / sqrt(young / density)};
  sdr_status status = make_points(how, &body);
  if (status == SDR_OK) status = make_model(how, &body);
  if (status == SDR_OK) status = sdr_loads_create(&nothing, body.points, &body.loads);
  if (status == SDR_OK) status = sdr_supports_create(&nothing, body.points, &body.supports);
  if (status == SDR_OK)
    status = sdr_system_create(body.model, &density, body.loads, body.supports, &body.system);
  if (status == SDR_OK) status = bench_body_restart(&body);
  if (status != SDR_OK) {
    bench_body_destroy(&body);
    return status;
  }
  *out = body;
  return SDR_OK;
}

void bench_body_destroy(bench_body *body)
{
  sdr_system_destroy(&body->system);
  sdr_supports_destroy(&body->supports);
  sdr_loads_destroy(&body->loads);
  if (body->model) body->model->ops->destroy(body->model);
  sdr_families_destroy(&body->families);
  sdr_points_destroy(&body->points);
  sdr_free(body->original);
  *body = (bench_body){0};
}
