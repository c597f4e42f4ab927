/* A run's directory made up for the tests of plot and compare: a ring with radial cracks that grow,
   a bar, or a block; with the files of design sec. 5. */
#ifndef SDR_TESTS_MADE_RUN_H
#define SDR_TESTS_MADE_RUN_H

#include <hdf5.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct {
  int dimension;       /* 1: bar, 2: ring, 3: block */
  int cells;           /* across the body */
  int cracks;          /* of the ring */
  double turn, jitter; /* of the lattice: radians, share of the spacing */
  const char *law;     /* damage_law of the summary */
  int frames;          /* 0: no snapshots.h5 */
  int without_summary, without_history, without_damage;
} made_run;

typedef struct {
  int count;
  double *x; /* 3 a point */
} made_points;

static inline double made_noise(unsigned *seed)
{
  *seed = *seed * 1664525U + 1013904223U;
  return (double)(*seed >> 8) / (1 << 24) - 0.5;
}

static inline int made_inside(const made_run *run, const double x[3])
{
  const double r = hypot(x[0], x[1]);
  if (run->dimension == 2) return r >= 0.081 && r <= 0.149;
  return 1;
}

static inline made_points made_body(const made_run *run)
{
  const double size = run->dimension == 2 ? 0.298 : 0.1, h = size / run->cells;
  const int n = run->cells + (run->dimension == 2 ? run->cells / 2 : 0), half = n / 2;
  const int up = run->dimension > 1 ? n : 1, deep = run->dimension > 2 ? n / 2 : 1;
  made_points points = {0, malloc((size_t)n * (size_t)up * (size_t)deep * 3 * sizeof(double))};
  unsigned seed = 7;
  for (int k = 0; k < deep; ++k)
    for (int j = 0; j < up; ++j)
      for (int i = 0; i < n; ++i) {
        const double jitter = run->jitter * 2.0;
        const double a = (i - half + jitter * made_noise(&seed)) * h;
        const double b = run->dimension > 1 ? (j - half + jitter * made_noise(&seed)) * h : 0.0;
        double *x = points.x + 3 * (size_t)points.count;
        x[0] = a * cos(run->turn) - b * sin(run->turn);
        x[1] = a * sin(run->turn) + b * cos(run->turn);
        x[2] = k * h;
        points.count += made_inside(run, x);
      }
  return points;
}

static inline double made_damage(const made_run *run, const double x[3], double share)
{
  const double r = hypot(x[0], x[1]), angle = atan2(x[1], x[0]);
  if (run->dimension != 2)
    return 0.5 * share * exp(-pow((x[0] - 0.15 * x[1] - 0.1 * x[2]) / 0.004, 2.0));
  double damage = 0.06 * share * exp(-(r - 0.081) / 0.02);
  for (int c = 0; c < run->cracks; ++c) {
    const double reach = 0.081 + 0.068 * share * (0.55 + 0.9 * fabs(sin(2.3 * c + 0.7)));
    const double at = 6.283185307179586 * c / run->cracks + 0.08 * sin(r * 90.0 + 1.7 * c) - 3.1;
    const double off = remainder(angle - at, 6.283185307179586) * r / 0.0016;
    if (r < reach) damage = fmax(damage, 0.55 * exp(-off * off));
  }
  return damage;
}

static inline void made_set(hid_t at, const char *name, hid_t type, int rows, int columns,
                            const void *data)
{
  const hsize_t size[2] = {(hsize_t)rows, (hsize_t)columns};
  const hid_t space = H5Screate_simple(columns > 1 ? 2 : 1, size, NULL);
  const hid_t set = H5Dcreate2(at, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
  H5Dclose(set);
  H5Sclose(space);
}

static inline void made_frame(hid_t file, const made_run *run, const made_points *points, int k)
{
  char name[32];
  const double share = run->frames > 1 ? (double)k / (run->frames - 1) : 1.0, time = 1e-4 * share;
  const int n = points->count, d = run->dimension;
  float *damage = malloc((size_t)n * sizeof *damage),
        *stress = malloc(3 * (size_t)n * sizeof *stress);
  float *u = malloc((size_t)(n * d) * sizeof *u);
  for (int i = 0; i < n; ++i) {
    const double *x = points->x + 3 * (size_t)i, r = fmax(hypot(x[0], x[1]), 1e-9);
    damage[i] = (float)made_damage(run, x, share);
    for (int c = 0; c < d; ++c) u[i * d + c] = (float)(1e-4 * share * x[c] / r);
    stress[3 * i] = (float)(2e8 * x[0] / r * share);
    stress[3 * i + 1] = (float)(1e8 * share * (0.2 + r));
    stress[3 * i + 2] = (float)(-1e8 * share);
  }
  snprintf(name, sizeof name, "frame_%04d", k);
  const hid_t group = H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  if (!run->without_damage) made_set(group, "damage", H5T_NATIVE_FLOAT, n, 1, damage);
  made_set(group, "displacement", H5T_NATIVE_FLOAT, n, d, u);
  made_set(group, "stress", H5T_NATIVE_FLOAT, n, 3, stress);
  made_set(group, "time", H5T_NATIVE_DOUBLE, 1, 1, &time);
  H5Gclose(group);
  free(damage);
  free(stress);
  free(u);
}

static inline int made_snapshots(const char *directory, const made_run *run)
{
  char path[640];
  made_points points = made_body(run);
  snprintf(path, sizeof path, "%s/snapshots.h5", directory);
  const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t group = H5Gcreate2(file, "points", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  double *volume = malloc((size_t)points.count * sizeof *volume);
  for (int i = 0; i < points.count; ++i) volume[i] = 1e-6;
  made_set(group, "position", H5T_NATIVE_DOUBLE, points.count, 3, points.x);
  made_set(group, "volume", H5T_NATIVE_DOUBLE, points.count, 1, volume);
  H5Gclose(group);
  for (int k = 0; k < run->frames; ++k) made_frame(file, run, &points, k);
  H5Fclose(file);
  free(volume);
  free(points.x);
  return points.count;
}

static inline void made_history(const char *directory, const made_run *run)
{
  char path[640];
  snprintf(path, sizeof path, "%s/history.csv", directory);
  FILE *file = fopen(path, "w");
  fputs("time,kinetic,stored,dissipated,viscous,contact,refinement,external_work,imbalance,"
        "max_damage,broken_bonds\n",
        file);
  for (int k = 0; k <= 200; ++k) {
    const double s = k / 200.0, work = 4.2e4 * (1.0 - exp(-3.0 * s));
    const double broken = s > 0.43 ? 1.3e4 * (1.0 - exp(-(4.0 + run->cracks) * (s - 0.43))) : 0.0;
    const double off = -9.0 * s * s - (s > 0.43 ? 3.0 * sin(60.0 * s) : 0.0);
    const double stored = 0.45 * work * pow(cos(2.0 * s), 2.0) * (s > 0.43 ? 0.8 : 1.0);
    fprintf(file, "%.17g,%.17g,%.17g,%.17g,0,0,0,%.17g,%.17g,%g,%d\n", 1e-4 * s,
            work + off - stored - broken, stored, broken, work, off, 0.9 * s, 10 * k);
  }
  fclose(file);
}

static inline void made_summary(const char *directory, const made_run *run, int points)
{
  char path[640];
  snprintf(path, sizeof path, "%s/summary.json", directory);
  FILE *file = fopen(path, "w");
  fprintf(
      file,
      "{\"program\": \"sunder\", \"scene\": \"made_ring\", \"title\": \"Thick cylinder under "
      "internal pressure\", \"dimension\": \"plane_stress\", \"model\": \"bond_based\", "
      "\"damage_law\": \"%s\", \"points\": %d, \"bonds\": %d, \"steps\": 1000, \"step\": 1e-7, "
      "\"time_end\": 1e-4, \"wall_seconds\": {\"setup\": 0.5, \"integrate\": 12.5, "
      "\"output\": 0.4, \"total\": 13.4}, \"ns_per_bond_step\": 2.21, "
      "\"peak_memory_bytes\": 88000000, \"energy\": {\"kinetic\": 18000.0, \"stored\": 9000.5, "
      "\"dissipated\": %d, \"external_work\": 40000, \"imbalance\": -9.25, "
      "\"imbalance_relative\": -2.2e-4, \"imbalance_largest\": 2.5e-4}, \"momentum\": "
      "{\"linear\": 1e-15, \"angular\": 2e-15}, \"damage\": {\"onset_time\": %s, \"max\": 0.55, "
      "\"mean\": 0.03125}, \"fragments\": {\"count\": %d, \"largest\": %d}, \"figures\": "
      "{\"through_cracks\": {\"value\": %d, \"low\": 5, \"high\": 20, \"paper\": null}}}\n",
      run->law, points, 28 * points, 12000 + run->cracks, run->cracks ? "4.36e-5" : "null",
      3 * run->cracks, points / 4, run->cracks);
  fclose(file);
}

/* A name for a directory of this test run, which does not exist yet. */
static inline const char *made_run_name(const char *test, char name[512])
{
  const char *base = getenv("TMPDIR");
  snprintf(name, 512, "%s/sunder-%s-%ld", base && *base ? base : P_tmpdir, test, (long)getpid());
  return name;
}

/* Write the directory (made if need be); returns the number of points. */
static inline int made_run_write(const char *directory, const made_run *run)
{
  mkdir(directory, 0777);
  const int points = run->frames > 0 ? made_snapshots(directory, run) : 1000;
  if (!run->without_history) made_history(directory, run);
  if (!run->without_summary) made_summary(directory, run, points);
  return points;
}

/* Remove the directory and what is in it. */
static inline void made_run_remove(const char *directory)
{
  static const char *const names[] = {"snapshots.h5",     "history.csv", "summary.json",
                                      "ledger.png",       "damage.png",  "stress.xy.png",
                                      "displacement.png", "compare.png", "x.png",
                                      "reactions.png",    "used.yaml",   "damage_at_50us.png"};
  char path[640];
  for (size_t k = 0; k < sizeof names / sizeof names[0]; ++k) {
    snprintf(path, sizeof path, "%s/%s", directory, names[k]);
    unlink(path);
  }
  rmdir(directory);
}

#endif
