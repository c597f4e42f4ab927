/* A finite-element reference of our own: rectangles of four-node elements with 2 x 2 Gauss points,
   plane stress or plane strain, linear. Statics by a sparse factor, vibration by central
   differences with lumped mass. For tests and for the tables beside problems. */
#ifndef SDR_TESTS_Q4_H
#define SDR_TESTS_Q4_H

#include "base/memory.h"
#include "linalg/solver.h"

#include <math.h>
#include <string.h>

typedef struct {
  int nx, ny;             /* elements */
  double low[2], size[2]; /* m */
  double young, poisson, density, thickness;
  int plane_strain;
} q4_plate;

static inline int32_t q4_node(const q4_plate *plate, int i, int j)
{
  return (int32_t)(j * (plate->nx + 1) + i);
}

static inline int32_t q4_unknowns(const q4_plate *plate)
{
  return 2 * (plate->nx + 1) * (plate->ny + 1);
}

static inline void q4_place(const q4_plate *plate, int i, int j, double x[2])
{
  x[0] = plate->low[0] + plate->size[0] * i / plate->nx;
  x[1] = plate->low[1] + plate->size[1] * j / plate->ny;
}

/* Derivatives of the four shape functions by x and y at (s, t) in [-1, 1]^2; nodes anticlockwise.
 */
static inline void q4_gradients(const q4_plate *plate, double s, double t, double dx[4],
                                double dy[4])
{
  static const double sign_s[4] = {-1, 1, 1, -1}, sign_t[4] = {-1, -1, 1, 1};
  const double a = plate->size[0] / plate->nx, b = plate->size[1] / plate->ny;
  for (int k = 0; k < 4; ++k) {
    dx[k] = 0.5 * sign_s[k] * (1.0 + sign_t[k] * t) / a;
    dy[k] = 0.5 * sign_t[k] * (1.0 + sign_s[k] * s) / b;
  }
}

/* Stiffness of an element, 8 x 8 row major; unknowns u0 v0 u1 v1 ... */
static inline void q4_element(const q4_plate *plate, double k[64])
{
  const double e = plate->young, nu = plate->poisson;
  const double shear = 0.5 * e / (1.0 + nu);
  const double c11 =
      plate->plane_strain ? e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)) : e / (1.0 - nu * nu);
  const double c12 = c11 - 2.0 * shear;
  const double weight = 0.25 * plate->size[0] * plate->size[1] / plate->nx / plate->ny;
  memset(k, 0, 64 * sizeof *k);
  for (int point = 0; point < 4; ++point) {
    const double g = 1.0 / sqrt(3.0);
    double dx[4], dy[4];
    q4_gradients(plate, point % 2 ? g : -g, point / 2 ? g : -g, dx, dy);
    for (int p = 0; p < 4; ++p)
      for (int q = 0; q < 4; ++q) {
        const double w = weight * plate->thickness;
        k[(2 * p) * 8 + 2 * q] += w * (c11 * dx[p] * dx[q] + shear * dy[p] * dy[q]);
        k[(2 * p) * 8 + 2 * q + 1] += w * (c12 * dx[p] * dy[q] + shear * dy[p] * dx[q]);
        k[(2 * p + 1) * 8 + 2 * q] += w * (c12 * dy[p] * dx[q] + shear * dx[p] * dy[q]);
        k[(2 * p + 1) * 8 + 2 * q + 1] += w * (c11 * dy[p] * dy[q] + shear * dx[p] * dx[q]);
      }
  }
}

/* Add an element's stiffness. A fixed unknown (fixed[r] != 0) keeps its diagonal only; its column
   goes to `load` with the value that u holds. fixed NULL: nothing is fixed. */
static inline sdr_status q4_add_element(const int32_t unknown[8], const double k[64],
                                        const char *fixed, const double *u,
                                        sdr_csr_builder *builder, double *load)
{
  for (int p = 0; p < 8; ++p)
    for (int q = 0; q < 8; ++q) {
      const int32_t row = unknown[p], column = unknown[q];
      if (fixed && (fixed[row] || fixed[column]) && p != q) {
        if (!fixed[row]) load[row] -= k[8 * p + q] * u[column];
        continue;
      }
      SDR_TRY(sdr_csr_builder_add(builder, row, column, k[8 * p + q]));
    }
  return SDR_OK;
}

static inline sdr_status q4_assemble(const q4_plate *plate, const char *fixed, const double *u,
                                     double *load, sdr_csr *out)
{
  double k[64];
  sdr_csr_builder *builder = NULL;
  SDR_TRY(sdr_csr_builder_create(q4_unknowns(plate), q4_unknowns(plate), &builder));
  sdr_status status = SDR_OK;
  q4_element(plate, k);
  for (int j = 0; j < plate->ny; ++j)
    for (int i = 0; i < plate->nx && status == SDR_OK; ++i) {
      const int32_t node[4] = {q4_node(plate, i, j), q4_node(plate, i + 1, j),
                               q4_node(plate, i + 1, j + 1), q4_node(plate, i, j + 1)};
      int32_t unknown[8];
      for (int p = 0; p < 8; ++p) unknown[p] = 2 * node[p / 2] + p % 2;
      status = q4_add_element(unknown, k, fixed, u, builder, load);
    }
  if (status == SDR_OK) status = sdr_csr_builder_finish(builder, out);
  sdr_csr_builder_destroy(&builder);
  return status;
}

/* Static solution: u holds the values of the fixed unknowns and gets the rest; `load` (N) is
   changed. */
static inline sdr_status q4_solve(const q4_plate *plate, const char *fixed, double *load, double *u)
{
  sdr_csr matrix = {0};
  sdr_solver *solver = NULL;
  sdr_status status = q4_assemble(plate, fixed, u, load, &matrix);
  for (int32_t r = 0; r < q4_unknowns(plate) && status == SDR_OK; ++r)
    for (int64_t k = matrix.row[r]; fixed[r] && k < matrix.row[r + 1]; ++k)
      if (matrix.column[k] == r) load[r] = matrix.value[k] * u[r];
  if (status == SDR_OK) status = sdr_solver_create("cholmod", SDR_MATRIX_POSITIVE, &solver);
  if (status == SDR_OK) status = sdr_solver_factor(solver, &matrix);
  if (status == SDR_OK) status = sdr_solver_solve(solver, load, u);
  sdr_solver_destroy(&solver);
  sdr_csr_destroy(&matrix);
  return status;
}

/* Add a uniform traction (Pa) on the side x = const (i = 0 or nx). */
static inline void q4_pull_side(const q4_plate *plate, int i, const double traction[2],
                                double *load)
{
  const double half = 0.5 * plate->thickness * plate->size[1] / plate->ny;
  for (int j = 0; j < plate->ny; ++j)
    for (int c = 0; c < 2; ++c) {
      load[2 * q4_node(plate, i, j) + c] += half * traction[c];
      load[2 * q4_node(plate, i, j + 1) + c] += half * traction[c];
    }
}

/* Lumped mass of each node, kg. */
static inline void q4_masses(const q4_plate *plate, double *mass)
{
  const double quarter = 0.25 * plate->density * plate->thickness * plate->size[0] *
                         plate->size[1] / plate->nx / plate->ny;
  memset(mass, 0, (size_t)(q4_unknowns(plate) / 2) * sizeof *mass);
  for (int j = 0; j < plate->ny; ++j)
    for (int i = 0; i < plate->nx; ++i)
      for (int p = 0; p < 4; ++p) mass[q4_node(plate, i + p % 2, j + p / 2)] += quarter;
}

/* A vibration from rest: what is kept between steps. */
typedef struct {
  sdr_csr stiffness;
  double *mass, *u, *v, *force; /* v half a step ago */
  const char *fixed;            /* these stay where they are */
  int32_t unknowns;
  double dt;
} q4_motion;

static inline void q4_motion_end(q4_motion *motion)
{
  sdr_csr_destroy(&motion->stiffness);
  sdr_free(motion->mass);
  sdr_free(motion->v);
  sdr_free(motion->force);
}

/* Start from the displacements u (borrowed, moved by the steps). dt below about size/(nx c). */
static inline sdr_status q4_motion_start(const q4_plate *plate, const char *fixed, double *u,
                                         double dt, q4_motion *motion)
{
  const size_t n = (size_t)q4_unknowns(plate);
  *motion = (q4_motion){.u = u, .fixed = fixed, .unknowns = (int32_t)n, .dt = dt};
  motion->mass = sdr_alloc(n / 2, sizeof(double));
  motion->v = sdr_alloc(n, sizeof(double));
  motion->force = sdr_alloc(n, sizeof(double));
  if (!motion->mass || !motion->v || !motion->force) return SDR_RUN_FAILED;
  q4_masses(plate, motion->mass);
  SDR_TRY(q4_assemble(plate, NULL, NULL, NULL, &motion->stiffness));
  sdr_csr_times(&motion->stiffness, u, motion->force);
  for (int32_t r = 0; r < motion->unknowns; ++r)
    motion->v[r] = fixed[r] ? 0.0 : 0.5 * dt * motion->force[r] / motion->mass[r / 2];
  return SDR_OK;
}

static inline void q4_motion_step(q4_motion *motion)
{
  sdr_csr_times(&motion->stiffness, motion->u, motion->force);
  for (int32_t r = 0; r < motion->unknowns; ++r) {
    if (motion->fixed[r]) continue;
    motion->v[r] -= motion->dt * motion->force[r] / motion->mass[r / 2];
    motion->u[r] += motion->dt * motion->v[r];
  }
}

/* Component c of u at x[2], bilinear within the element. */
static inline double q4_value(const q4_plate *plate, const double *u, const double x[2], int c)
{
  const double s = (x[0] - plate->low[0]) / plate->size[0] * plate->nx;
  const double t = (x[1] - plate->low[1]) / plate->size[1] * plate->ny;
  const int i = (int)fmin(fmax(floor(s), 0.0), plate->nx - 1);
  const int j = (int)fmin(fmax(floor(t), 0.0), plate->ny - 1);
  const double a = s - i, b = t - j;
  return (1.0 - b) * ((1.0 - a) * u[2 * q4_node(plate, i, j) + c] +
                      a * u[2 * q4_node(plate, i + 1, j) + c]) +
         b * ((1.0 - a) * u[2 * q4_node(plate, i, j + 1) + c] +
              a * u[2 * q4_node(plate, i + 1, j + 1) + c]);
}

#endif
