/* All kernels compute the same thing: runs and loose pairs, every instruction set and any number of
   threads, and what all pairs of points give by the plain equations. */
#include "mechanics/bond_internal.h"
#include "support/reference.h"

static const double tolerance = 1e-13; /* of the largest force */

static int in_a_patch(const int32_t cell[3])
{
  return cell[0] % 9 > 2 && cell[1] % 5 > 1;
}

static const body_how shapes[] = {
    {.dimension = SDR_PLANE_STRESS, .cells = {12, 11}, .refined = in_a_patch},
    {.dimension = SDR_3D, .cells = {9, 4, 3}, .ratio = 2.01, .refined = in_a_patch},
    {.dimension = SDR_1D, .cells = {90}},
    {.dimension = SDR_PLANE_STRESS, .cells = {37, 9}},
    {.dimension = SDR_PLANE_STRAIN,
     .cells = {9, 40},
     .angle = 0.3,
     .weight = {.correction = SDR_CORRECTION_ISO}},
    {.dimension = SDR_PLANE_STRESS,
     .cells = {15, 16},
     .jitter = 0.3,
     .horizon_spread = 0.3,
     .weight = {.partial_volume = 1}},
    {.dimension = SDR_3D, .cells = {7, 6, 8}, .ratio = 2.01},
    {.dimension = SDR_3D, .cells = {6, 6, 7}, .ratio = 2.2, .jitter = 0.2, .horizon_spread = 0.2},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

/* Forces and energies of a body in a state with history, against the reference. */
static void compare_with_reference(const body_how *how, double amplitude, int marked)
{
  body b = body_create(how);
  reference r = reference_create(&b);
  double *u[3], *f[3], *expected[3];
  vector_create(b.points, u);
  vector_create(b.points, f);
  vector_create(b.points, expected);
  if (marked) reference_mark(&r, body_cut_and_protect);
  vector_noise(b.points, amplitude * body_spacing, 5, u);
  b.model->ops->commit(b.model, u);
  reference_commit(&r, u);
  vector_noise(b.points, amplitude * body_spacing, 6, u);
  /* critical stretch: the reference breaks in commit only, the force also at once */
  if (how->law == SDR_LAW_CRITICAL_STRETCH) {
    b.model->ops->commit(b.model, u);
    reference_commit(&r, u);
  }
  sdr_energies energies, right;
  reference_force(&r, u, expected, &right);
  b.model->ops->force(b.model, u, f);
  b.model->ops->energies(b.model, u, &energies);
  const double largest = vector_largest(b.points, expected);
  assert_true(largest > 0.0);
  assert_at_most(vector_difference(b.points, f, expected) / largest, tolerance);
  b.model->ops->force_commit(b.model, u, u, 0.0, f); /* dt = 0: the velocity does not count */
  assert_at_most(vector_difference(b.points, f, expected) / largest, tolerance);
  assert_near(energies.stored, right.stored, tolerance * right.stored);
  assert_near(energies.dissipated, right.dissipated, tolerance * right.dissipated);
  vector_destroy(u);
  vector_destroy(f);
  vector_destroy(expected);
  reference_destroy(&r);
  body_destroy(&b);
}

static void every_case(double amplitude, double stretch)
{
  for (int k = 0; k < SHAPES; ++k)
    for (int law = 0; law < SDR_LAW_COUNT; ++law)
      for (int loose = 0; loose < 2; ++loose)
        for (int scatter = 0; scatter < 2; ++scatter) {
          if (loose && shapes[k].jitter > 0.0) continue;
          body_how how = shapes[k];
          how.law = (sdr_law)law;
          how.force_loose = loose;
          how.scatter = 0.3 * scatter;
          how.stretch = stretch;
          how.ell = 1.7;
          for (int marked = 0; marked < 2; ++marked)
            if (amplitude > 1e-3 || marked == (k + law + loose + scatter) % 2)
              compare_with_reference(&how, amplitude, marked);
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

static void at_a_stretch_of_1e_6(void **state)
{
  (void)state;
  every_case(1e-6, 1e-6);
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

/* ---- instruction sets and threads ------------------------------------------------------------ */

/* Run a body through commits with force_commit, and give the last force and energies. */
static void play(const body_how *how, double *f[3], sdr_energies *energies, char isa[16])
{
  body b = body_create(how);
  double *u[3], *v[3];
  vector_create(b.points, u);
  vector_create(b.points, v);
  vector_create(b.points, f);
  snprintf(isa, 16, "%s", body_traits(b.model).isa);
  for (uint64_t step = 1; step < 4; ++step) {
    vector_noise(b.points, 0.02 * body_spacing, step, u);
    vector_noise(b.points, 1.0, step + 10, v);
    b.model->ops->force_commit(b.model, u, v, 1e-8, f);
  }
  b.model->ops->energies(b.model, u, energies);
  vector_destroy(u);
  vector_destroy(v);
  body_destroy(&b);
}

static double force_scale(double *const f[3], int32_t count)
{
  double most = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int32_t i = 0; f[a] && i < count; ++i) most = fmax(most, fabs(f[a][i]));
  return most;
}

static double force_change(double *const f[3], double *const g[3], int32_t count)
{
  double most = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int32_t i = 0; f[a] && i < count; ++i) most = fmax(most, fabs(f[a][i] - g[a][i]));
  return most;
}

static int32_t count_of(const body_how *how)
{
  int32_t count = 1;
  for (int a = 0; a < sdr_components(how->dimension); ++a) count *= how->cells[a];
  return count;
}

static void compare_with_baseline(const body_how *how, const char *isa)
{
  double *f[3], *g[3];
  sdr_energies first, second;
  char name[16];
  assert_int_equal(sdr_isa_limit("baseline"), SDR_OK);
  play(how, f, &first, name);
  assert_string_equal(name, "baseline");
  assert_int_equal(sdr_isa_limit(isa), SDR_OK);
  play(how, g, &second, name);
  assert_string_equal(name, isa);
  const int32_t count = count_of(how);
  assert_at_most(force_change(f, g, count), tolerance * force_scale(f, count));
  assert_near(second.stored, first.stored, tolerance * first.stored);
  assert_near(second.dissipated, first.dissipated, tolerance * first.dissipated);
  assert_int_equal(second.broken, first.broken);
  vector_destroy(f);
  vector_destroy(g);
}

static int has_isa(const char *isa)
{
  return sdr_isa_limit(isa) == SDR_OK;
}

static void every_instruction_set_gives_the_same(void **state)
{
  (void)state;
  static const char *const names[] = {"avx2", "avx512"};
  for (int n = 0; n < 2; ++n) {
    if (!has_isa(names[n])) {
      print_message("this processor has no %s: not compared\n", names[n]);
      continue;
    }
    for (int k = 0; k < SHAPES; ++k)
      for (int law = 0; law < SDR_LAW_COUNT; ++law)
        for (int scatter = 0; scatter < 2; ++scatter) {
          body_how how = shapes[k];
          how.law = (sdr_law)law;
          how.scatter = 0.3 * scatter;
          compare_with_baseline(&how, names[n]);
        }
  }
}

/* A ring: rows of many lengths and beginnings, longer than the blocks of kernels. */
static int in_ring(const int32_t cell[3])
{
  const double r = hypot(cell[0] - 298, cell[1] - 298);
  return r >= 162.0 && r <= 298.0;
}

typedef struct {
  const sdr_bond_body *body;
  double *const *u;
} history_check;

static void check_pair(void *context, const sdr_pair *pair)
{
  const history_check *check = context;
  const double s = sdr_pair_stretch(pair, 2, check->u);
  assert_near(check->body->stretch[pair->slot], s > 0.0 ? s : 0.0, 1e-7 * fabs(s) + 1e-18);
}

/* Kernels compute whole vectors: what lies beyond a run's end must not reach its neighbour's. */
static void long_rows_keep_to_their_own_history(void **state)
{
  (void)state;
  const body_how how = {
      .dimension = SDR_PLANE_STRESS, .cells = {597, 597}, .law = SDR_LAW_VARIATIONAL};
  body b = body_create_kept(&how, in_ring);
  double *u[3], *f[3];
  vector_create(b.points, u);
  vector_create(b.points, f);
  vector_noise(b.points, 1e-3 * body_spacing, 3, u);
  b.model->ops->force_commit(b.model, u, u, 0.0, f);
  history_check check = {&((const sdr_bond_model *)b.model)->body, u};
  assert_int_equal(b.bonds->loose_pairs, 0);
  sdr_bonds_visit(b.bonds, b.points, check_pair, &check);
  vector_destroy(u);
  vector_destroy(f);
  body_destroy(&b);
}

/* What is lost by the plain rule, pair by pair; `flags` by slot. */
typedef struct {
  const sdr_bond_body *body;
  double *const *u;
  sdr_flags *flags;
  int components, lost, kept;
} plain_rule;

static void break_plainly(void *context, const sdr_pair *pair)
{
  plain_rule *rule = context;
  const double s = sdr_pair_stretch(pair, rule->components, rule->u);
  sdr_flags *flags = &rule->flags[pair->slot];
  const sdr_flags i = s > 0.0 && s * s > sdr_body_threshold(rule->body, pair->i) ? SDR_LOST_I : 0;
  const sdr_flags j = s > 0.0 && s * s > sdr_body_threshold(rule->body, pair->j) ? SDR_LOST_J : 0;
  if (!(*flags & SDR_PROTECTED)) *flags |= i | j;
  assert_int_equal(rule->body->flags[pair->slot], *flags);
  rule->lost += (*flags & (SDR_LOST_I | SDR_LOST_J)) != 0;
  rule->kept += (*flags & (SDR_LOST_I | SDR_LOST_J)) == 0;
}

/* The plain rule after every step of a body of which a growing part, beginning at its low end, is
   strained so far that bonds break; kernels look at flags only where some may be set. */
static void break_step_by_step(const body_how *how, int marked)
{
  body b = body_create(how);
  const sdr_bond_body *bonds = &((const sdr_bond_model *)b.model)->body;
  double *u[3], *v[3], *f[3];
  int64_t cut = 0, flagged = 0;
  vector_create(b.points, u);
  vector_create(b.points, v);
  vector_create(b.points, f);
  if (marked) b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut);
  plain_rule rule = {.body = bonds, .u = u, .components = b.points->components};
  rule.flags = sdr_alloc((size_t)b.bonds->run_slots, sizeof *rule.flags);
  assert_non_null(rule.flags);
  memcpy(rule.flags, bonds->flags, (size_t)b.bonds->run_slots * sizeof *rule.flags);
  for (int step = 0; step < 6; ++step) {
    vector_noise(b.points, (0.002 + 0.002 * step) * body_spacing, (uint64_t)step + 1, u);
    for (int a = 0; a < b.points->components; ++a)
      for (int32_t i = b.points->count * (step + 1) / 9; i < b.points->count; ++i) u[a][i] *= 0.1;
    b.model->ops->force_commit(b.model, u, v, 1e-8, f);
    rule.lost = rule.kept = 0;
    sdr_bonds_visit(b.bonds, b.points, break_plainly, &rule);
  }
  for (int64_t r = 0; r < b.bonds->run_count; ++r) flagged += bonds->run_flagged[r];
  assert_true(rule.lost > 5 && rule.kept > rule.lost);
  assert_true(flagged > 0 && (marked || flagged < b.bonds->run_count));
  sdr_free(rule.flags);
  vector_destroy(u);
  vector_destroy(v);
  vector_destroy(f);
  body_destroy(&b);
}

static void critical_stretch_breaks_what_the_plain_rule_breaks(void **state)
{
  (void)state;
  static const body_how each[] = {{.dimension = SDR_1D, .cells = {700}},
                                  {.dimension = SDR_PLANE_STRESS, .cells = {70, 90}},
                                  {.dimension = SDR_3D, .cells = {9, 8, 21}, .ratio = 2.01}};
  for (int k = 0; k < 3; ++k)
    for (int scatter = 0; scatter < 3; ++scatter)
      for (int marked = 0; marked < 2; ++marked) {
        body_how how = each[k];
        how.law = SDR_LAW_CRITICAL_STRETCH;
        how.scatter = 0.3 * (scatter == 1);
        how.two_materials = scatter == 2;
        break_step_by_step(&how, marked);
      }
}

static void any_number_of_threads_gives_the_same_bits(void **state)
{
  (void)state;
  static const body_how many[] = {
      {.dimension = SDR_PLANE_STRESS, .cells = {70, 300}},
      {.dimension = SDR_PLANE_STRESS, .cells = {1300, 5}},
      {.dimension = SDR_PLANE_STRESS, .cells = {61, 70}, .jitter = 0.3, .horizon_spread = 0.3},
      {.dimension = SDR_3D, .cells = {12, 13, 40}, .ratio = 2.01},
  };
  const char *best = has_isa("avx512") ? "avx512" : has_isa("avx2") ? "avx2" : "baseline";
  for (int k = 0; k < 4; ++k)
    for (int law = 0; law < SDR_LAW_COUNT; ++law)
      for (int threads = 2; threads <= 3; ++threads) {
        body_how how = many[k];
        how.law = (sdr_law)law;
        how.scatter = 0.3;
        double *f[3], *g[3];
        sdr_energies first, second;
        char name[16];
        assert_int_equal(sdr_isa_limit(best), SDR_OK);
        sdr_set_threads(1);
        play(&how, f, &first, name);
        sdr_set_threads(threads);
        play(&how, g, &second, name);
        const size_t bytes = (size_t)count_of(&how) * sizeof(double);
        for (int a = 0; a < 3; ++a)
          if (f[a]) assert_memory_equal(f[a], g[a], bytes);
        assert_memory_equal(&first, &second, sizeof first);
        vector_destroy(f);
        vector_destroy(g);
      }
  sdr_set_threads(1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(runs_and_loose_pairs_give_what_all_pairs_give),
      cmocka_unit_test(at_a_stretch_of_1e_3),
      cmocka_unit_test(at_a_stretch_of_1e_6),
      cmocka_unit_test(at_a_stretch_of_1e_9),
      cmocka_unit_test(at_large_stretches_and_rotations),
      cmocka_unit_test(every_instruction_set_gives_the_same),
      cmocka_unit_test(long_rows_keep_to_their_own_history),
      cmocka_unit_test(critical_stretch_breaks_what_the_plain_rule_breaks),
      cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
  };
  sdr_set_threads(1); /* small bodies: threads would only wait for each other */
  return cmocka_run_group_tests(tests, NULL, NULL);
}
