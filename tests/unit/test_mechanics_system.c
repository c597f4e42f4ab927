/* mechanics: what integrators see: masses, energies, momenta, fields. */
#include "support/still_body.h"

static const body_how plate = {
    .dimension = SDR_PLANE_STRESS, .cells = {20, 12}, .two_materials = 1, .scatter = 0.2};

static void mass_is_density_times_volume(void **state)
{
  (void)state;
  still_body s;
  still_create(&plate, &s);
  for (int32_t i = 0; i < s.system->count; ++i) {
    const double density = s.body.points->x[0][i] > 0.0 ? 4000.0 : 2500.0;
    assert_near(s.system->mass[i], density * body_spacing * body_spacing, 1e-18);
  }
  still_destroy(&s);
}

static void energies_and_momenta_are_plain_sums(void **state)
{
  (void)state;
  static const body_how shapes[] = {
      {.dimension = SDR_1D, .cells = {30}},
      {.dimension = SDR_PLANE_STRESS, .cells = {9, 30}, .two_materials = 1},
      {.dimension = SDR_3D, .cells = {6, 7, 5}, .ratio = 2.01}};
  for (int k = 0; k < 3; ++k) {
    still_body s;
    still_create(&shapes[k], &s);
    sdr_system *system = s.system;
    const sdr_points *points = s.body.points;
    vector_noise(points, 1e-6, 3, system->u);
    vector_noise(points, 10.0, 4, system->v);
    vector_noise(points, 5.0, 5, system->f);
    system->velocity_offset = -3e-8; /* v is of that much before: now it is v + 3e-8 f/m */
    double kinetic = 0.0, p[3] = {0.0}, l[3] = {0.0}, linear = 0.0, angular = 0.0;
    for (int32_t i = 0; i < system->count; ++i) {
      double v[3] = {0.0}, x[3] = {0.0};
      for (int a = 0; a < system->components; ++a) {
        v[a] = system->v[a][i] + 3e-8 * system->f[a][i] / system->mass[i];
        x[a] = points->x[a][i] + system->u[a][i];
        p[a] += system->mass[i] * v[a];
      }
      l[0] += system->mass[i] * (x[1] * v[2] - x[2] * v[1]);
      l[1] += system->mass[i] * (x[2] * v[0] - x[0] * v[2]);
      l[2] += system->mass[i] * (x[0] * v[1] - x[1] * v[0]);
      const double vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
      const double xx = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
      kinetic += 0.5 * system->mass[i] * vv;
      linear += system->mass[i] * sqrt(vv);
      angular += system->mass[i] * sqrt(vv) * sqrt(xx);
    }
    sdr_balance balance;
    sdr_system_balance(system, &balance);
    assert_near(balance.kinetic, kinetic, 1e-13 * kinetic);
    assert_near(balance.momentum_scale, linear, 1e-13 * linear);
    assert_near(balance.angular_scale, angular, 1e-13 * angular);
    for (int a = 0; a < 3; ++a) {
      assert_near(balance.momentum[a], p[a], 1e-13 * linear);
      assert_near(balance.angular[a], l[a], 1e-13 * angular);
    }
    still_destroy(&s);
  }
}

static void fields_have_their_components(void **state)
{
  (void)state;
  static const struct {
    const char *name;
    int in[3]; /* components in 1-D, 2-D, 3-D */
  } fields[] = {{"displacement", {1, 2, 3}}, {"velocity", {1, 2, 3}}, {"acceleration", {1, 2, 3}},
                {"force", {1, 2, 3}},        {"reaction", {1, 2, 3}}, {"stress", {1, 3, 6}},
                {"strain", {1, 3, 6}},       {"damage", {1, 1, 1}},   {"energy_density", {1, 1, 1}},
                {"dissipated", {1, 1, 1}},   {"material", {1, 1, 1}}, {"horizon", {1, 1, 1}},
                {"spacing", {1, 1, 1}},      {"level", {1, 1, 1}},    {"dilatation", {1, 1, 1}},
                {"fragment", {0, 0, 0}},     {"colour", {0, 0, 0}},   {"", {0, 0, 0}}};
  for (size_t k = 0; k < sizeof fields / sizeof *fields; ++k)
    for (int n = 1; n <= 3; ++n)
      assert_int_equal(sdr_field_components(fields[k].name, n), fields[k].in[n - 1]);
}

static void fields_of_the_system_are_its_arrays(void **state)
{
  (void)state;
  still_body s;
  still_create(&plate, &s);
  sdr_system *system = s.system;
  const size_t n = (size_t)system->count;
  vector_noise(s.body.points, 1.0, 3, system->u);
  vector_noise(s.body.points, 1.0, 4, system->v);
  vector_noise(s.body.points, 1.0, 5, system->f);
  system->velocity_offset = -0.25;
  static const char *const names[] = {"displacement", "velocity", "acceleration", "force"};
  double *out = sdr_alloc(3 * n, sizeof *out);
  for (int k = 0; k < 4; ++k) {
    assert_int_equal(sdr_system_field(system, names[k], out), SDR_OK);
    for (size_t i = 0; i < n; ++i)
      for (size_t a = 0; a < 2; ++a) {
        const double u = system->u[a][i], v = system->v[a][i], f = system->f[a][i];
        const double acceleration = f / system->mass[i];
        const double expected[4] = {u, v + 0.25 * acceleration, acceleration, f};
        assert_near(out[a * n + i], expected[k], 1e-13 * fabs(expected[k]));
      }
  }
  assert_int_equal(sdr_system_field(system, "material", out), SDR_OK);
  for (size_t i = 0; i < n; ++i) assert_true(out[i] == (s.body.points->x[0][i] > 0.0));
  assert_int_equal(sdr_system_field(system, "horizon", out), SDR_OK);
  assert_near(out[7], 3.015 * body_spacing, 1e-18);
  assert_int_equal(sdr_system_field(system, "spacing", out), SDR_OK);
  assert_near(out[7], body_spacing, 0.0);
  assert_int_equal(sdr_system_field(system, "level", out), SDR_OK);
  assert_near(out[7], 0.0, 0.0);
  assert_int_equal(sdr_system_field(system, "reaction", out), SDR_OK);
  assert_near(out[7], 0.0, 0.0);
  sdr_free(out);
  still_destroy(&s);
}

static void an_unknown_field_is_refused(void **state)
{
  (void)state;
  still_body s;
  double out[1];
  still_create(&plate, &s);
  assert_int_equal(sdr_system_field(s.system, "temperature", out), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "there is no field 'temperature'");
  still_destroy(&s);
}

static void an_unknown_instruction_set_is_refused(void **state)
{
  (void)state;
  assert_int_equal(sdr_isa_limit("sse9"), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "instruction set 'sse9' is unknown; known are avx512, "
                                           "avx2, baseline");
}

/* The state of a checkpoint is all of the history: copied into another body it acts the same. */
static void the_state_blocks_hold_the_whole_history(void **state)
{
  (void)state;
  for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law)
    for (int loose = 0; loose < 2; ++loose) {
      body_how how = plate;
      how.law = (sdr_law)law;
      how.force_loose = loose;
      body one = body_create(&how), other = body_create(&how);
      double *u[3], *f[3], *g[3];
      vector_create(one.points, u);
      vector_create(one.points, f);
      vector_create(one.points, g);
      vector_noise(one.points, 0.02 * body_spacing, 4, u);
      one.model->ops->commit(one.model, u);
      sdr_state_block from[SDR_STATE_BLOCKS], to[SDR_STATE_BLOCKS];
      int count, again;
      one.model->ops->state(one.model, from, &count);
      other.model->ops->state(other.model, to, &again);
      assert_int_equal(count, again);
      assert_true(count <= SDR_STATE_BLOCKS);
      for (int k = 0; k < count; ++k) {
        assert_string_equal(from[k].name, to[k].name);
        assert_int_equal(from[k].bytes, to[k].bytes);
        memcpy(to[k].data, from[k].data, from[k].bytes);
      }
      for (uint64_t seed = 5; seed < 7; ++seed) {
        vector_noise(one.points, 0.01 * body_spacing, seed, u);
        sdr_energies first, second;
        one.model->ops->force(one.model, u, f);
        other.model->ops->force(other.model, u, g);
        one.model->ops->energies(one.model, u, &first);
        other.model->ops->energies(other.model, u, &second);
        assert_near(vector_difference(one.points, f, g), 0.0, 0.0);
        assert_memory_equal(&first, &second, sizeof first);
        assert_true(law == SDR_LAW_NONE || first.dissipated > 0.0);
      }
      vector_destroy(u);
      vector_destroy(f);
      vector_destroy(g);
      body_destroy(&one);
      body_destroy(&other);
    }
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  still_body s;
  still_create(&plate, &s);
  const size_t before = sdr_memory_now();
  long fails = 0;
  for (; fails < 50; ++fails) {
    sdr_system *system = NULL;
    sdr_memory_fail_after(fails);
    const sdr_status status =
        sdr_system_create(s.body.model, still_density, s.loads, s.supports, &system);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) {
      sdr_system_destroy(&system);
      break;
    }
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_null(system);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(fails > 8 && fails < 50);
  still_destroy(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(mass_is_density_times_volume),
      cmocka_unit_test(energies_and_momenta_are_plain_sums),
      cmocka_unit_test(fields_have_their_components),
      cmocka_unit_test(fields_of_the_system_are_its_arrays),
      cmocka_unit_test(an_unknown_field_is_refused),
      cmocka_unit_test(an_unknown_instruction_set_is_refused),
      cmocka_unit_test(the_state_blocks_hold_the_whole_history),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
