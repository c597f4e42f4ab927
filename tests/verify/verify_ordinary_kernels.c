/* The kernels of ordinary bodies all compute the same thing: runs and loose pairs, every
   instruction set and any number of threads, with or without stripes at rest, and what all pairs
   of points give by the plain equations. */
#include "mechanics/bond_internal.h"
#include "support/ordinary.h"

static const double tolerance = 1e-13; /* of the largest force */

static const ordinary_how shapes[] = {
    {.body = {.dimension = SDR_1D, .cells = {90}}},
    {.body = {.dimension = SDR_PLANE_STRESS, .cells = {37, 9}}, .poisson = 0.2},
    {.body = {.dimension = SDR_PLANE_STRAIN,
              .cells = {9, 20},
              .angle = 0.3,
              .weight = {.correction = SDR_CORRECTION_ISO}},
     .poisson = 0.45},
    {.body = {.dimension = SDR_PLANE_STRESS, .cells = {17, 9}}, .form = SDR_FORM_MADENCI_OTERKUS},
    {.body = {.dimension = SDR_PLANE_STRESS,
              .cells = {12, 14},
              .jitter = 0.3,
              .horizon_spread = 0.3,
              .weight = {.partial_volume = 1}}},
    {.body =
         {.dimension = SDR_PLANE_STRAIN, .cells = {11, 12}, .jitter = 0.3, .horizon_spread = 0.3},
     .form = SDR_FORM_MADENCI_OTERKUS},
    {.body = {.dimension = SDR_3D, .cells = {5, 6, 8}, .ratio = 2.01}},
    {.body = {.dimension = SDR_3D,
              .cells = {6, 5, 6},
              .ratio = 2.2,
              .jitter = 0.2,
              .horizon_spread = 0.2}},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static const sdr_law laws[] = {SDR_LAW_NONE, SDR_LAW_VARIATIONAL, SDR_LAW_CRITICAL_STRETCH};

/* Forces and energies of a body in a state with history, against the plain equations. */
static void compare(const ordinary_how *how, double amplitude, int marked)
{
  body b = ordinary_create(how);
  plain r = plain_create(&b, how);
  double *u[3], *f[3], *expected[3];
  long double right[2];
  vector_create(b.points, u);
  vector_create(b.points, f);
  vector_create(b.points, expected);
  if (marked) plain_mark(&r, body_cut_and_protect);
  for (int i = 0; i < b.points->count; ++i) {
    double x[3] = {0.0};
    for (int a = 0; a < b.points->components; ++a) x[a] = b.points->x[a][i];
    if (marked)
      r.mark[(size_t)i * (size_t)b.points->count + (size_t)i] =
          (char)body_cut_and_protect(NULL, x, x);
  }
  vector_noise(b.points, amplitude * body_spacing, 5, u);
  b.model->ops->commit(b.model, u);
  plain_commit(&r, u);
  vector_noise(b.points, amplitude * body_spacing, 6, u);
  plain_force(&r, u, expected, right);
  b.model->ops->force(b.model, u, f);
  const double largest = vector_largest(b.points, expected);
  assert_true(largest > 0.0);
  assert_at_most(vector_difference(b.points, f, expected) / largest, tolerance);
  /* critical stretch: what breaks at u is gone from the force that commits it */
  if (how->body.law == SDR_LAW_CRITICAL_STRETCH) {
    plain_commit(&r, u);
    plain_force(&r, u, expected, right);
  }
  b.model->ops->force_commit(b.model, u, u, 0.0, f); /* dt = 0: the velocity does not count */
  assert_at_most(vector_difference(b.points, f, expected) / largest, tolerance);
  sdr_energies energies;
  b.model->ops->energies(b.model, u, &energies);
  assert_near(energies.stored, (double)right[0], tolerance * (double)right[0]);
  if (how->body.law == SDR_LAW_VARIATIONAL)
    assert_near(energies.dissipated, (double)right[1], tolerance * (double)right[1]);
  vector_destroy(u);
  vector_destroy(f);
  vector_destroy(expected);
  plain_destroy(&r);
  body_destroy(&b);
}

static void every_case(double amplitude, double stretch)
{
  for (int k = 0; k < SHAPES; ++k)
    for (int law = 0; law < 3; ++law)
      for (int loose = 0; loose < 2; ++loose) {
        if (loose && shapes[k].body.jitter > 0.0) continue;
        ordinary_how how = shapes[k];
        how.body.law = laws[law];
        how.body.force_loose = loose;
        how.body.scatter = 0.3 * loose;
        how.body.two_materials = loose;
        how.body.stretch = stretch;
        compare(&how, amplitude, (k + law + loose) % 2);
        if (amplitude > 1e-3 && amplitude < 0.1)
          compare(&how, amplitude, (k + law + loose + 1) % 2);
      }
}

static void runs_and_loose_pairs_give_what_all_pairs_give(void **state)
{
  (void)state;
  every_case(0.02, 0.01);
}

static void at_a_stretch_of_1e_3(void **state)
{
  (void)state;
  every_case(1e-3, 1e-3);
}

static void at_a_stretch_of_1e_9(void **state)
{
  (void)state;
  every_case(1e-9, 1e-9);
}

static void at_large_stretches_and_rotations(void **state)
{
  (void)state;
  every_case(0.4, 0.2);
}

/* Families below a tenth of their moment among them. */
static void with_most_bonds_lost(void **state)
{
  (void)state;
  every_case(0.05, 1e-3);
}

/* ---- instruction sets and threads ------------------------------------------------------------ */

typedef struct {
  double *f[3];
  sdr_energies energies;
  int32_t count;
  char isa[16];
} played;

/* Run a body through commits with force_commit, and give the last force and energies. */
static played play(const ordinary_how *how, int keep_resting)
{
  body b = ordinary_create(how);
  double *u[3], *v[3];
  played p = {.count = b.points->count};
  vector_create(b.points, u);
  vector_create(b.points, v);
  vector_create(b.points, p.f);
  b.model->ops->skip_rest(b.model, !keep_resting);
  snprintf(p.isa, sizeof p.isa, "%s", body_traits(b.model).isa);
  for (uint64_t step = 1; step < 4; ++step) {
    vector_noise(b.points, 0.02 * body_spacing, step, u);
    vector_noise(b.points, 1.0, step + 10, v);
    for (int a = 0; keep_resting >= 0 && a < b.points->components; ++a)
      for (int32_t i = 0; i < b.points->count; ++i)
        if (b.points->x[b.points->components - 1][i] > 0.0) u[a][i] = v[a][i] = 0.0;
    b.model->ops->force_commit(b.model, u, v, 1e-8, p.f);
  }
  b.model->ops->energies(b.model, u, &p.energies);
  if (keep_resting == 0 && b.points->stripe_count > 3)
    assert_true(body_traits(b.model).moved < 1.0);
  vector_destroy(u);
  vector_destroy(v);
  body_destroy(&b);
  return p;
}

static void same_bits(played *p, played *q)
{
  for (int a = 0; a < 3; ++a)
    if (p->f[a])
      for (int32_t i = 0; i < p->count; ++i)
        if (p->f[a][i] != q->f[a][i]) fail_msg("force %d of point %d differs", a, (int)i);
  assert_memory_equal(&p->energies, &q->energies, sizeof p->energies);
  vector_destroy(q->f);
}

/* Bodies with several stripes. */
static ordinary_how long_body(int k, int law)
{
  static const ordinary_how bodies[] = {
      {.body = {.dimension = SDR_PLANE_STRESS, .cells = {40, 70}}},
      {.body = {.dimension = SDR_PLANE_STRESS, .cells = {40, 70}, .force_loose = 1}},
      {.body = {.dimension = SDR_PLANE_STRAIN,
                .cells = {20, 40},
                .jitter = 0.2,
                .horizon_spread = 0.3}},
      {.body = {.dimension = SDR_3D, .cells = {6, 7, 30}, .ratio = 2.01}},
  };
  ordinary_how how = bodies[k];
  how.body.law = laws[law];
  how.body.scatter = 0.1;
  return how;
}

static void one_thread_and_three_give_the_same_bits(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k)
    for (int law = 0; law < 3; ++law) {
      const ordinary_how how = long_body(k, law);
      played one = play(&how, -1);
      sdr_set_threads(3);
      played three = play(&how, -1);
      sdr_set_threads(1);
      same_bits(&one, &three);
      vector_destroy(one.f);
    }
}

/* The half of the body with the last coordinate above zero stays where it is. */
static void skipping_what_rests_changes_no_bit(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k)
    for (int law = 0; law < 3; ++law) {
      const ordinary_how how = long_body(k, law);
      played skipping = play(&how, 0), all = play(&how, 1);
      same_bits(&skipping, &all);
      vector_destroy(skipping.f);
    }
}

static void every_instruction_set_gives_the_same_forces(void **state)
{
  (void)state;
  static const char *const names[] = {"baseline", "avx2", "avx512"};
  for (int k = 0; k < 4; ++k)
    for (int law = 0; law < 3; ++law) {
      const ordinary_how how = long_body(k, law);
      assert_int_equal(sdr_isa_limit("baseline"), SDR_OK);
      played base = play(&how, -1);
      assert_string_equal(base.isa, "baseline");
      for (int isa = 1; isa < 3 && sdr_isa_limit(names[isa]) == SDR_OK; ++isa) {
        played other = play(&how, -1);
        double most = 0.0, change = 0.0;
        assert_string_equal(other.isa, names[isa]);
        for (int a = 0; a < 3; ++a)
          for (int32_t i = 0; base.f[a] && i < base.count; ++i) {
            most = fmax(most, fabs(base.f[a][i]));
            change = fmax(change, fabs(base.f[a][i] - other.f[a][i]));
          }
        assert_at_most(change, tolerance * most);
        assert_near(base.energies.stored, other.energies.stored, 1e-13 * base.energies.stored);
        assert_int_equal(base.energies.broken, other.energies.broken);
        vector_destroy(other.f);
      }
      vector_destroy(base.f);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(runs_and_loose_pairs_give_what_all_pairs_give),
      cmocka_unit_test(at_a_stretch_of_1e_3),
      cmocka_unit_test(at_a_stretch_of_1e_9),
      cmocka_unit_test(at_large_stretches_and_rotations),
      cmocka_unit_test(with_most_bonds_lost),
      cmocka_unit_test(one_thread_and_three_give_the_same_bits),
      cmocka_unit_test(skipping_what_rests_changes_no_bit),
      cmocka_unit_test(every_instruction_set_gives_the_same_forces),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
