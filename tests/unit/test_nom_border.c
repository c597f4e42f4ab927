/* nom: weights near the border of two spacings leave uniform strain in equilibrium. */
#include "base/memory.h"
#include "nom/bonds.h"
#include "nom/family.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <string.h>

typedef struct {
  int components;
  int32_t size[3];
  double angle;
  sdr_correction correction;
  int (*fine)(const int32_t cell[3]);
} plate;

static void put(sdr_points *points, const plate *p, const int32_t cell[3], int level)
{
  const int32_t i = points->count++;
  const double h = ldexp(1.0, -level);
  for (int a = 0; a < p->components; ++a) {
    points->x[a][i] = 0.0;
    for (int b = 0; b < p->components; ++b)
      points->x[a][i] += points->axes[b][a] * (cell[b] + 0.5) * h;
  }
  points->spacing[i] = h;
  points->volume[i] = pow(h, p->components);
  points->horizon[i] = 3.015 * h;
  points->level[i] = (uint8_t)level;
  memcpy(points->cell + 3 * (size_t)i, cell, 3 * sizeof *cell);
}

static sdr_points *make_points(const plate *p)
{
  sdr_points *points;
  const int32_t cells = p->size[0] * p->size[1] * p->size[2];
  assert_int_equal(sdr_points_create(cells << p->components, p->components, 1, &points), SDR_OK);
  points->level = sdr_alloc(sdr_points_padded(points), 1);
  points->lattice_spacing = 1.0;
  points->axes[0][0] = points->axes[1][1] = cos(p->angle);
  points->axes[0][1] = sin(p->angle);
  points->axes[1][0] = -sin(p->angle);
  points->count = 0;
  for (int32_t k = 0; k < cells; ++k) {
    const int32_t cell[3] = {k % p->size[0], k / p->size[0] % p->size[1],
                             k / p->size[0] / p->size[1]};
    if (!p->fine(cell)) {
      put(points, p, cell, 0);
      continue;
    }
    for (int child = 0; child < 1 << p->components; ++child) {
      int32_t c[3] = {0};
      for (int a = 0; a < p->components; ++a) c[a] = 2 * cell[a] + (child >> a & 1);
      put(points, p, c, 1);
    }
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  return points;
}

static int inner_block(const int32_t cell[3])
{
  return cell[0] >= 9 && cell[0] < 15 && cell[1] >= 8 && cell[1] < 15;
}

static int right_half(const int32_t cell[3])
{
  return cell[0] >= 12;
}

static int inner_line(const int32_t cell[3])
{
  return cell[0] >= 12 && cell[0] < 30;
}

/* Forces of a body with one modulus, (C_i b_ij + C_j b_ji) V V s, under a uniform strain: over
   volume and spacing times the strain (times E). */
typedef struct {
  const sdr_families *families;
  double strain[3][3], *force[3], energy;
} pull_call;

static void pull(void *context, const sdr_pair *pair)
{
  pull_call *call = context;
  double stretch = 0.0;
  if (!pair->primary) return;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) stretch += call->strain[a][b] * pair->xi[a] * pair->xi[b];
  stretch /= pair->length * pair->length;
  const double c = pair->weight_ij / sdr_family_of(call->families, pair->i)->first +
                   pair->weight_ji / sdr_family_of(call->families, pair->j)->first;
  for (int a = 0; a < 3; ++a) {
    call->force[a][pair->i] += c * stretch * pair->xi[a] / pair->length;
    call->force[a][pair->j] -= c * stretch * pair->xi[a] / pair->length;
  }
  call->energy += 0.5 * c * pair->length * stretch * stretch;
}

/* At least `away` from the body's surface. */
static int is_inside(const plate *p, const sdr_points *points, int32_t i, double away)
{
  for (int a = 0; a < p->components; ++a) {
    double q = 0.0;
    for (int b = 0; b < p->components; ++b) q += points->axes[a][b] * points->x[b][i];
    if (q < away || q > p->size[a] - away) return 0;
  }
  return 1;
}

typedef struct {
  double most, energy; /* the largest force inside; the energy */
  double total[3];     /* sum of all forces */
} pulled;

static pulled pull_plate(const plate *p, int balance)
{
  sdr_points *points = make_points(p);
  const sdr_families_how how = {.correction = p->correction, .balance = balance};
  sdr_families *families;
  sdr_bonds *bonds;
  assert_int_equal(sdr_families_create(points, &how, &families), SDR_OK);
  const sdr_bonds_how bonds_how = {
      .levels = 1, .weight = sdr_families_weight, .context = families, .border = families->border};
  assert_int_equal(sdr_bonds_create(points, &bonds_how, &bonds), SDR_OK);
  assert_true(bonds->run_count > 0);
  pull_call call = {.families = families,
                    .strain = {{1.0, 0.3, 0.0}, {0.3, -0.5, 0.2}, {0.0, 0.2, 0.4}}};
  for (int a = 0; a < 3; ++a) call.force[a] = sdr_alloc((size_t)points->count, sizeof(double));
  sdr_bonds_visit(bonds, points, pull, &call);
  pulled out = {.energy = call.energy};
  for (int32_t i = 0; i < points->count; ++i)
    for (int a = 0; a < 3; ++a) {
      const double force = call.force[a][i] * points->spacing[i] / points->volume[i];
      if (is_inside(p, points, i, 6.1)) out.most = fmax(out.most, fabs(force));
      out.total[a] += call.force[a][i];
    }
  for (int a = 0; a < 3; ++a) sdr_free(call.force[a]);
  sdr_bonds_destroy(&bonds);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
  return out;
}

static const plate plates[] = {
    {1, {42, 1, 1}, 0.0, SDR_CORRECTION_NONE, inner_line},
    {2, {24, 23, 1}, 0.0, SDR_CORRECTION_NONE, inner_block},
    {2, {24, 23, 1}, 0.4, SDR_CORRECTION_ISO, inner_block},
};
enum { PLATES = sizeof plates / sizeof *plates };

static void uniform_strain_is_in_equilibrium_about_a_finer_block(void **state)
{
  (void)state;
  for (int k = 0; k < PLATES; ++k) {
    const pulled without = pull_plate(&plates[k], 0), with = pull_plate(&plates[k], 1);
    assert_true(without.most > 0.03);
    assert_true(with.most < 6e-3 * without.most);
    for (int a = 0; a < 3; ++a) assert_true(fabs(with.total[a]) < 1e-12);
  }
}

/* Where the border ends at a surface not all can be mended, but most is. */
static void a_border_that_meets_the_surface_is_mended_inside(void **state)
{
  (void)state;
  const plate flat = {2, {24, 30, 1}, 0.0, SDR_CORRECTION_NONE, right_half};
  assert_true(pull_plate(&flat, 1).most < 0.1 * pull_plate(&flat, 0).most);
}

/* A body in equilibrium stores what its surface's forces do, so the energy is that of one spacing
   but for how the surfaces differ. */
static int nowhere(const int32_t cell[3])
{
  (void)cell;
  return 0;
}

static void the_energy_of_uniform_strain_is_that_of_one_spacing(void **state)
{
  (void)state;
  for (int k = 0; k < PLATES; ++k) {
    plate one = plates[k];
    one.fine = nowhere;
    const double exact = pull_plate(&one, 0).energy;
    const double without = pull_plate(&plates[k], 0).energy / exact - 1.0;
    const double with = pull_plate(&plates[k], 1).energy / exact - 1.0;
    assert_true(fabs(without) > 8e-4 && fabs(with) < 3e-4 && fabs(with) < 0.3 * fabs(without));
  }
}

static void bodies_of_one_spacing_have_no_border(void **state)
{
  (void)state;
  plate one = plates[1];
  one.fine = nowhere;
  sdr_points *points = make_points(&one);
  const sdr_families_how how = {.balance = 1};
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &how, &families), SDR_OK);
  assert_null(families->border);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  sdr_points *points = make_points(&plates[0]);
  const sdr_families_how how = {.balance = 1};
  const size_t before = sdr_memory_now();
  sdr_families *families = NULL;
  long fails = 0;
  for (; fails < 100; ++fails) {
    sdr_memory_fail_after(fails);
    const sdr_status status = sdr_families_create(points, &how, &families);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) break;
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(fails > 10 && fails < 100);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(uniform_strain_is_in_equilibrium_about_a_finer_block),
      cmocka_unit_test(a_border_that_meets_the_surface_is_mended_inside),
      cmocka_unit_test(the_energy_of_uniform_strain_is_that_of_one_spacing),
      cmocka_unit_test(bodies_of_one_spacing_have_no_border),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
