/* output: fragments, and through-cracks of a ring. */
#include "output_body.h"

#include "output/fragments.h"

/* ---- a chain of points ----------------------------------------------------------------------- */

static void chain(body *b, int32_t count)
{
  body_create(b, count, 1);
  b->model.pair_count = count - 1;
  b->model.pairs = calloc((size_t)count, sizeof *b->model.pairs);
  for (int32_t i = 0; i + 1 < count; ++i) b->model.pairs[i] = (body_pair){i + 1, i, 0.0};
}

static void a_sound_chain_is_one_piece(void **state)
{
  (void)state;
  body b;
  sdr_fragments found;
  int32_t piece[5] = {9, 9, 9, 9, 9};
  chain(&b, 5);
  assert_int_equal(sdr_fragments_find(b.system, 0.5, piece, &found), SDR_OK);
  assert_int_equal(found.count, 1);
  assert_int_equal(found.largest, 5);
  assert_int_equal(found.single, 0);
  for (int i = 0; i < 5; ++i) assert_int_equal(piece[i], 0);
  body_destroy(&b);
}

static void a_pair_at_the_threshold_holds_nothing_together(void **state)
{
  (void)state;
  body b;
  sdr_fragments found;
  chain(&b, 2);
  b.model.pairs[0].damage = 0.5;
  assert_int_equal(sdr_fragments_find(b.system, 0.5, NULL, &found), SDR_OK);
  assert_int_equal(found.count, 2);
  assert_int_equal(sdr_fragments_find(b.system, 0.5000001, NULL, &found), SDR_OK);
  assert_int_equal(found.count, 1);
  body_destroy(&b);
}

static void pieces_are_numbered_by_falling_size_then_lowest_point(void **state)
{
  (void)state;
  body b;
  sdr_fragments found;
  int32_t piece[9];
  const int32_t wanted[9] = {3, 1, 1, 4, 0, 0, 0, 2, 2};
  chain(&b, 9);
  b.model.pairs[0].damage = b.model.pairs[2].damage = 1.0; /* 0 | 1 2 | 3 | 4 5 6 | 7 8 */
  b.model.pairs[3].damage = b.model.pairs[6].damage = 1.0;
  assert_int_equal(sdr_fragments_find(b.system, 0.5, piece, &found), SDR_OK);
  assert_int_equal(found.count, 5);
  assert_int_equal(found.largest, 3);
  assert_int_equal(found.single, 2);
  assert_memory_equal(piece, wanted, sizeof wanted);
  body_destroy(&b);
}

static void a_body_without_pairs_is_all_single_points(void **state)
{
  (void)state;
  body b;
  sdr_fragments found;
  int32_t piece[3];
  body_create(&b, 3, 2);
  assert_int_equal(sdr_fragments_find(b.system, 0.5, piece, &found), SDR_OK);
  assert_int_equal(found.count, 3);
  assert_int_equal(found.single, 3);
  assert_int_equal(piece[2], 2);
  body_destroy(&b);
}

static void running_out_of_memory_is_reported_and_leaks_nothing(void **state)
{
  (void)state;
  body b;
  sdr_fragments found;
  int32_t count;
  const double centre[3] = {0};
  body_create(&b, 3, 2);
  const size_t before = sdr_memory_now();
  for (int k = 0; k < 4; ++k) {
    sdr_memory_fail_after(k);
    const sdr_status pieces = sdr_fragments_find(b.system, 0.5, NULL, &found);
    sdr_memory_fail_after(k);
    const sdr_status cracks = sdr_ring_sectors(b.system, 0.5, centre, &count);
    sdr_memory_fail_after(-1);
    assert_int_equal(pieces, SDR_RUN_FAILED);
    assert_int_equal(cracks, SDR_RUN_FAILED);
    assert_int_equal(sdr_memory_now(), before);
  }
  body_destroy(&b);
}

/* ---- rings ----------------------------------------------------------------------------------- */

/* A crack from polar point (r0, angle0) to (r1, angle1) about the ring's centre, angles in degrees:
   a spiral if angle1 > angle0 (an arc for r0 = r1), else straight. */
typedef struct {
  double r0, angle0, r1, angle1;
} slit;

static const double ring_centre[3] = {3.0, -2.0, 0.0};
enum { INNER = 10, OUTER = 20, RING_POINTS = 2000 };

static double side(const double a[2], const double b[2], const double c[2])
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static int segments_cross(const double a[2], const double b[2], const double c[2],
                          const double d[2])
{
  return side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0;
}

/* A spiral is made of chords of a degree. */
static int slit_cuts(const slit *s, const double a[2], const double b[2])
{
  const int parts = s->angle1 > s->angle0 ? (int)(s->angle1 - s->angle0) : 1;
  for (int k = 0; k < parts; ++k) {
    double end[2][2];
    for (int e = 0; e < 2; ++e) {
      const double t = (double)(k + e) / parts;
      const double r = s->r0 + t * (s->r1 - s->r0);
      const double angle = (s->angle0 + t * (s->angle1 - s->angle0)) * M_PI / 180.0;
      end[e][0] = r * cos(angle);
      end[e][1] = r * sin(angle);
    }
    if (segments_cross(a, b, end[0], end[1])) return 1;
  }
  return 0;
}

static int32_t ring_points(double x[2][RING_POINTS])
{
  int32_t count = 0;
  for (int j = -OUTER; j <= OUTER; ++j)
    for (int i = -OUTER; i <= OUTER; ++i) {
      const int r2 = i * i + j * j;
      if (r2 < INNER * INNER || r2 > OUTER * OUTER) continue;
      x[0][count] = i;
      x[1][count++] = j;
    }
  return count;
}

/* A ring of a unit lattice, 10 <= r <= 20, horizon 1.5, with slits. */
static void ring(body *b, const slit *slits, int slit_count)
{
  static double x[2][RING_POINTS];
  const int32_t count = ring_points(x);
  body_create(b, count, 2);
  b->model.pairs = calloc((size_t)count * 4, sizeof *b->model.pairs);
  for (int32_t i = 0; i < count; ++i) {
    for (int c = 0; c < 2; ++c) b->points->x[c][i] = x[c][i] + ring_centre[c];
    for (int32_t j = 0; j < i; ++j) {
      const double from[2] = {x[0][i], x[1][i]}, to[2] = {x[0][j], x[1][j]};
      if (hypot(to[0] - from[0], to[1] - from[1]) > 1.5) continue;
      body_pair *pair = &b->model.pairs[b->model.pair_count++];
      *pair = (body_pair){i, j, 0.0};
      for (int s = 0; s < slit_count; ++s)
        if (slit_cuts(&slits[s], from, to)) pair->damage = 1.0;
    }
  }
}

/* {cuts, fragments} of a ring with these slits. */
static void expect(const slit *slits, int slit_count, int cracks, int fragments)
{
  body b;
  sdr_fragments found;
  int32_t count = -1;
  ring(&b, slits, slit_count);
  assert_int_equal(sdr_fragments_find(b.system, 0.5, NULL, &found), SDR_OK);
  assert_int_equal(sdr_ring_sectors(b.system, 0.5, ring_centre, &count), SDR_OK);
  assert_int_equal(found.count, fragments);
  assert_int_equal(count, cracks);
  body_destroy(&b);
}

static void a_sound_ring_has_no_through_crack(void **state)
{
  (void)state;
  expect(NULL, 0, 0, 1);
}

static void a_crack_that_ends_inside_does_not_cut_through(void **state)
{
  (void)state;
  const slit slits[] = {{9.0, 20.3, 17.0, 20.3}, {13.0, 190.7, 21.0, 190.7}};
  expect(slits, 2, 0, 1);
}

static void one_radial_cut_leaves_one_piece_and_counts_one(void **state)
{
  (void)state;
  for (int k = 0; k < 12; ++k) { /* wherever the angle jumps */
    const slit cut = {9.0, 30.0 * k + 0.3, 21.0, 30.0 * k + 0.3};
    expect(&cut, 1, 1, 1);
  }
}

static void a_cut_with_a_kink_counts_as_one(void **state)
{
  (void)state;
  const slit slits[] = {
      {9.0, 20.3, 15.3, 20.3}, {15.3, 20.3, 15.3, 100.3}, {15.3, 100.3, 21.0, 100.3}};
  expect(slits, 3, 1, 1);
}

static void radial_cuts_count_as_many_as_sectors(void **state)
{
  (void)state;
  const slit slits[] = {{9.0, 20.3, 21.0, 20.3},
                        {9.0, 100.3, 21.0, 100.3},
                        {9.0, 170.3, 21.0, 170.3},
                        {9.0, 300.3, 21.0, 300.3}};
  expect(slits, 2, 2, 2);
  expect(slits, 3, 3, 3);
  expect(slits, 4, 4, 4);
}

static void a_branch_that_frees_a_wedge_is_no_second_crack(void **state)
{
  (void)state;
  const slit slits[] = {{9.0, 40.3, 13.5, 40.3},
                        {13.5, 40.3, 21.0, 25.3}, /* the two arms of a Y */
                        {13.5, 40.3, 21.0, 55.3},
                        {9.0, 200.3, 21.0, 200.3}};
  const slit arms[] = {{9.0, 40.3, 13.5, 40.3}, {13.5, 40.3, 21.0, 55.3}};
  expect(slits, 3, 1, 2);
  expect(slits, 4, 2, 3);
  expect(arms, 2, 1, 1);
}

static void a_crack_along_a_circle_is_no_through_crack(void **state)
{
  (void)state;
  const slit circle = {15.3, 0.0, 15.3, 360.0};
  const slit crossed[] = {{15.3, 0.0, 15.3, 360.0}, {9.0, 20.3, 21.0, 20.3}};
  expect(&circle, 1, 0, 2);
  expect(crossed, 2, 0, 2);
}

static void a_bar_has_no_through_cracks(void **state)
{
  (void)state;
  body b;
  int32_t count = -1;
  chain(&b, 4);
  assert_int_equal(sdr_ring_sectors(b.system, 0.5, ring_centre, &count), SDR_OK);
  assert_int_equal(count, 0);
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_sound_chain_is_one_piece),
      cmocka_unit_test(a_pair_at_the_threshold_holds_nothing_together),
      cmocka_unit_test(pieces_are_numbered_by_falling_size_then_lowest_point),
      cmocka_unit_test(a_body_without_pairs_is_all_single_points),
      cmocka_unit_test(running_out_of_memory_is_reported_and_leaks_nothing),
      cmocka_unit_test(a_sound_ring_has_no_through_crack),
      cmocka_unit_test(a_crack_that_ends_inside_does_not_cut_through),
      cmocka_unit_test(one_radial_cut_leaves_one_piece_and_counts_one),
      cmocka_unit_test(a_cut_with_a_kink_counts_as_one),
      cmocka_unit_test(radial_cuts_count_as_many_as_sectors),
      cmocka_unit_test(a_branch_that_frees_a_wedge_is_no_second_crack),
      cmocka_unit_test(a_crack_along_a_circle_is_no_through_crack),
      cmocka_unit_test(a_bar_has_no_through_cracks),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
