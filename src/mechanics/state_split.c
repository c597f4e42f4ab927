#include "mechanics/state_split.h"

#include "base/memory.h"
#include "nom/stencil.h"

#include <math.h>

/* What cuts in all directions cost. */
typedef struct {
  int count;
  double normal[SDR_CUT_DIRECTIONS][3], cost[SDR_CUT_DIRECTIONS];
  sdr_split_cost cost_of;
  const void *context;
} cuts;

/* The axes come first, the others cover directions evenly: every so many of them do too. */
static void choose_directions(const sdr_points *points, int most, cuts *all)
{
  double normal[SDR_CUT_DIRECTIONS][3];
  const int count = sdr_cut_directions(points, normal), axes = points->components;
  const int stride = most < count ? (count - axes + most - axes - 1) / (most - axes) : 1;
  for (int k = 0; k < count; k += k < axes ? 1 : stride) {
    for (int a = 0; a < 3; ++a) all->normal[all->count][a] = normal[k][a];
    all->cost[all->count++] = 0.0;
  }
}

static void add_costs(const sdr_full_family *family, cuts *all)
{
  for (int k = 0; k < all->count; ++k)
    all->cost[k] += all->cost_of(all->context, family, all->normal[k]);
}

static double middle(const cuts *all)
{
  double least = INFINITY, most = 0.0;
  for (int k = 0; k < all->count; ++k) {
    least = fmin(least, all->cost[k]);
    most = fmax(most, all->cost[k]);
  }
  return 0.5 * (least + most);
}

/* ---- full families --------------------------------------------------------------------------- */

static sdr_status family_alloc(sdr_full_family *f, size_t most)
{
  f->xi = sdr_alloc(3 * most, sizeof *f->xi);
  f->weight = sdr_alloc(most, sizeof *f->weight);
  f->space = sdr_alloc(SDR_SPLIT_SPACE * most, sizeof *f->space);
  return f->xi && f->weight && f->space ? SDR_OK : SDR_RUN_FAILED;
}

static void family_free(sdr_full_family *f)
{
  sdr_free(f->xi);
  sdr_free(f->weight);
  sdr_free(f->space);
}

static void add_bond(sdr_full_family *f, const double xi[3], double sign, double weight)
{
  if (!(weight > 0.0)) return;
  for (int a = 0; a < 3; ++a) f->xi[3 * (size_t)f->count + (size_t)a] = sign * xi[a];
  f->weight[f->count++] = weight;
}

static void start_family(const sdr_points *points, int32_t i, sdr_full_family *f)
{
  f->components = points->components;
  f->count = 0;
  f->horizon = points->horizon[i];
  f->thickness = points->volume[i] / pow(points->spacing[i], points->components);
}

/* On a lattice the classes are half of it. */
static sdr_status family_of_classes(const sdr_points *points, const sdr_bonds *bonds,
                                    sdr_full_family *f)
{
  SDR_TRY(family_alloc(f, 2 * (size_t)bonds->class_count));
  start_family(points, 0, f);
  for (int c = 0; c < bonds->class_count; ++c) {
    const sdr_bond_class *class = &bonds->classes[c];
    add_bond(f, class->xi, 1.0, class->weight_ij / points->volume[0]);
    add_bond(f, class->xi, -1.0, class->weight_ji / points->volume[0]);
  }
  return SDR_OK;
}

/* The stencil of point i with influence 1: where no family is complete. */
static sdr_status family_of_stencil(const sdr_points *points, int32_t i, sdr_full_family *f)
{
  const double spacing = points->spacing[i];
  sdr_stencil stencil;
  SDR_TRY(sdr_stencil_create(points->components, spacing, points->horizon[i], &stencil));
  const sdr_status status = family_alloc(f, (size_t)stencil.count);
  start_family(points, i, f);
  for (int k = 0; k < stencil.count && status == SDR_OK; ++k) {
    const int32_t *step = stencil.step + 3 * (size_t)k;
    const double xi[3] = {spacing * step[0], spacing * step[1], spacing * step[2]};
    add_bond(f, xi, 1.0, points->volume[i]);
  }
  sdr_stencil_destroy(&stencil);
  return status;
}

typedef struct {
  const sdr_points *points;
  sdr_full_family *family;
} gather_call;

static void gather_slot(void *context, const sdr_pair *pair)
{
  const gather_call *call = context;
  add_bond(call->family, pair->xi, 1.0, pair->weight_ij / call->points->volume[pair->i]);
}

static size_t widest(const sdr_bonds *bonds)
{
  int64_t most = 1;
  for (int32_t c = 0; c < bonds->loose.chunk_count; ++c) {
    const int64_t width = (bonds->loose.chunk_slot[c + 1] - bonds->loose.chunk_slot[c]) / SDR_LANES;
    if (width > most) most = width;
  }
  return (size_t)most;
}

/* A few complete families, evenly from all points; *met: how many. */
static sdr_status cuts_of_loose(const sdr_points *points, const sdr_bonds *bonds, cuts *all,
                                int *met)
{
  sdr_full_family f = {.one_of_many = 1};
  gather_call call = {points, &f};
  int seen = 0;
  const sdr_status status = family_alloc(&f, widest(bonds));
  for (int k = 0; k < SDR_CUT_TRIED && k < points->count && seen < SDR_CUT_ENOUGH; ++k) {
    const int32_t i = sdr_cut_sample(points, k);
    if (status != SDR_OK || !sdr_cut_complete(points, bonds, i)) continue;
    start_family(points, i, &f);
    sdr_bonds_visit_loose_point(bonds, i, gather_slot, &call);
    add_costs(&f, all);
    seen += f.count;
    ++*met;
  }
  family_free(&f);
  return status;
}

static sdr_status cuts_of_one(const sdr_points *points, const sdr_bonds *bonds, cuts *all)
{
  sdr_full_family f = {0};
  const sdr_status status = bonds->class_count > 0
                                ? family_of_classes(points, bonds, &f)
                                : family_of_stencil(points, points->count / 2, &f);
  if (status == SDR_OK) add_costs(&f, all);
  family_free(&f);
  return status;
}

sdr_status sdr_split_middle(const sdr_points *points, const sdr_bonds *bonds, int directions,
                            sdr_split_cost cost, const void *context, double *out)
{
  int met = 0;
  cuts *all = sdr_alloc(1, sizeof *all);
  if (!all) return SDR_RUN_FAILED;
  all->cost_of = cost;
  all->context = context;
  choose_directions(points, directions, all);
  sdr_status status = SDR_OK;
  if (bonds->class_count == 0) status = cuts_of_loose(points, bonds, all, &met);
  if (status == SDR_OK && met == 0) status = cuts_of_one(points, bonds, all);
  if (status == SDR_OK) *out = middle(all) / (met > 0 ? met : 1);
  sdr_free(all);
  return status;
}
