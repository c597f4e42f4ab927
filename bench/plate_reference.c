/* Tables for problems/tension_plate and problems/plate_vibration from the finite-element solver in
   tests/support/q4.h:

     bench_plate_reference DIRECTORY [ELEMENTS]

   writes DIRECTORY/tension_plate/{u,v}.csv and DIRECTORY/plate_vibration/history.csv. ELEMENTS a
   side: 200 by default. The plate of paper 004 sec. 5: 1 m square about the origin, clamped on the
   left; nu = 1/3. */
#include "base/status.h"
#include "tests/support/q4.h"

#include <stdio.h>
#include <stdlib.h>

static q4_plate plate_of(int elements)
{
  return (q4_plate){.nx = elements,
                    .ny = elements,
                    .low = {-0.5, -0.5},
                    .size = {1.0, 1.0},
                    .young = 200e9,
                    .poisson = 1.0 / 3.0,
                    .density = 7850.0,
                    .thickness = 0.01};
}

static char *clamp_left(const q4_plate *plate)
{
  char *fixed = sdr_alloc((size_t)q4_unknowns(plate), 1);
  for (int j = 0; fixed && j <= plate->ny; ++j)
    fixed[2 * q4_node(plate, 0, j)] = fixed[2 * q4_node(plate, 0, j) + 1] = 1;
  return fixed;
}

static FILE *open_table(const char *directory, const char *name)
{
  char path[600];
  snprintf(path, sizeof path, "%s/%s", directory, name);
  FILE *file = fopen(path, "w");
  if (!file) fprintf(stderr, "cannot write %s\n", path);
  return file;
}

/* Component c along an axis, at the rows (columns) of points beside it: `off` from it before 0 and
   `off_after` beyond. */
static int write_axis(const q4_plate *plate, const double *u, int c, const double off[2],
                      const char *directory, const char *name)
{
  FILE *file = open_table(directory, name);
  if (!file) return 0;
  fprintf(file, "# %d x %d four-node elements, made by bench/plate_reference.c\n%s\n", plate->nx,
          plate->ny, c == 0 ? "x,u" : "y,fine,coarse");
  for (int k = 0; k <= 200; ++k) {
    const double along = -0.5 + 0.005 * k;
    if (c == 0) {
      const double x[2] = {along, along < 0.0 ? off[0] : off[1]};
      fprintf(file, "%.4g,%.9g\n", along, q4_value(plate, u, x, c));
      continue;
    }
    const double left[2] = {off[0], along}, right[2] = {off[1], along};
    fprintf(file, "%.4g,%.9g,%.9g\n", along, q4_value(plate, u, left, c),
            q4_value(plate, u, right, c));
  }
  return fclose(file) == 0;
}

static int make_tension(const q4_plate *plate, const char *fixed, const char *directory)
{
  const size_t n = (size_t)q4_unknowns(plate);
  double *u = sdr_alloc(n, sizeof *u), *load = sdr_alloc(n, sizeof *load);
  int good = u && load;
  if (good) {
    q4_pull_side(plate, plate->nx, (double[2]){200e6, 0.0}, load);
    good = q4_solve(plate, fixed, load, u) == SDR_OK;
  }
  if (good) {
    printf("tension: u(0.5, 0) = %.5f mm\n", 1e3 * q4_value(plate, u, (double[2]){0.5, 0.0}, 0));
    good = write_axis(plate, u, 0, (double[2]){0.0025, 0.005}, directory, "tension_plate/u.csv") &&
           write_axis(plate, u, 1, (double[2]){-0.0025, 0.005}, directory, "tension_plate/v.csv");
  }
  sdr_free(u);
  sdr_free(load);
  return good;
}

/* Time of the vibration and of a row of its table, s. */
static const double vibration_end = 1.5e-3, vibration_row = 2e-6;

static int make_vibration(const q4_plate *plate, const char *fixed, const char *directory)
{
  static const double at[2] = {0.255, 0.255};
  const int each = (plate->nx + 49) / 50;
  const double dt = vibration_row / each;
  double *u = sdr_alloc((size_t)q4_unknowns(plate), sizeof *u);
  q4_motion motion = {0};
  if (!u) return 0;
  for (int j = 0; j <= plate->ny; ++j)
    for (int i = 0; i <= plate->nx; ++i) u[2 * q4_node(plate, i, j)] = 1e-3 * i / plate->nx;
  FILE *file = open_table(directory, "plate_vibration/history.csv");
  int good = file && q4_motion_start(plate, fixed, u, dt, &motion) == SDR_OK;
  if (good)
    fprintf(file, "# %d x %d four-node elements, made by bench/plate_reference.c\nt,u,v\n",
            plate->nx, plate->ny);
  const long rows = good ? lround(vibration_end / vibration_row) : -1;
  for (long row = 0; row <= rows; ++row) {
    fprintf(file, "%.7g,%.8g,%.8g\n", (double)row * vibration_row, q4_value(plate, u, at, 0),
            q4_value(plate, u, at, 1));
    for (int step = 0; step < each; ++step) q4_motion_step(&motion);
  }
  if (file) good = fclose(file) == 0 && good;
  q4_motion_end(&motion);
  sdr_free(u);
  return good;
}

int main(int argc, char **argv)
{
  const int elements = argc > 2 ? atoi(argv[2]) : 200;
  if (argc < 2 || elements < 2 || elements > 2000) {
    fprintf(stderr, "usage: bench_plate_reference DIRECTORY [ELEMENTS]\n");
    return 1;
  }
  const q4_plate plate = plate_of(elements);
  char *fixed = clamp_left(&plate);
  const int good =
      fixed && make_tension(&plate, fixed, argv[1]) && make_vibration(&plate, fixed, argv[1]);
  sdr_free(fixed);
  if (good) return 0;
  fprintf(stderr, "bench_plate_reference: %s\n", sdr_error_message());
  return 2;
}
