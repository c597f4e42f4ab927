/* Poisson's equation with the operator library alone: -u_xx - u_yy = f on the unit square, u = 0 on
   its boundary, f = 2 pi^2 u for u = sin(pi x) sin(pi y). Prints the relative error. */
#include "linalg/solver.h"
#include "nom/assembly.h"
#include <math.h>
#include <stdio.h>

enum { CELLS = 80, SIDE = CELLS + 1, COUNT = SIDE * SIDE };
static double x[COUNT], y[COUNT], exact[COUNT], f[COUNT], u[COUNT];
static sdr_support support; /* each point's 32 nearest */
static sdr_shape_tensors shape;
static sdr_operator op; /* all derivatives up to order 4 */
static sdr_csr_builder *builder;
static sdr_csr matrix;
static sdr_solver *solver;

static sdr_status solve(void)
{
  const double pi = 3.14159265358979323846;
  for (int i = 0; i < COUNT; ++i) {
    x[i] = (double)(i % SIDE) / CELLS;
    y[i] = (double)(i / SIDE) / CELLS;
    exact[i] = sin(pi * x[i]) * sin(pi * y[i]);
  }
  const sdr_cloud cloud = {.components = 2, .count = COUNT, .x = {x, y}};
  const sdr_shape_how how = {.order = 4, .influence = SDR_INFLUENCE_GAUSSIAN};
  SDR_TRY(sdr_support_by_count(&cloud, 32, &support));
  SDR_TRY(sdr_shape_tensors_create(&support, &how, &shape));
  SDR_TRY(sdr_operator_create(&shape, &op));
  int xx, yy;
  SDR_TRY(sdr_operator_find(&op, "xx", &xx));
  SDR_TRY(sdr_operator_find(&op, "yy", &yy));
  SDR_TRY(sdr_csr_builder_create(COUNT, COUNT, &builder));
  const sdr_term equation[] = {{xx, 0, -1.0}, {yy, 0, -1.0}}, value = {SDR_VALUE, 0, 1.0};
  for (int i = 0; i < COUNT; ++i) {
    const int edge = i % SIDE % CELLS == 0 || i / SIDE % CELLS == 0;
    f[i] = edge ? 0.0 : 2.0 * pi * pi * exact[i];
    SDR_TRY(sdr_collocate(&op, i, edge ? 1 : 2, edge ? &value : equation, i, builder));
  }
  SDR_TRY(sdr_csr_builder_finish(builder, &matrix));
  SDR_TRY(sdr_solver_create("auto", SDR_MATRIX_GENERAL, &solver));
  SDR_TRY(sdr_solver_factor(solver, &matrix));
  return sdr_solver_solve(solver, f, u);
}

int main(void) /* all memory ends with the program; every create has a destroy */
{
  double wrong = 0.0, all = 0.0;
  if (solve() != SDR_OK) {
    fprintf(stderr, "%s\n", sdr_error_message());
    return 1;
  }
  for (int i = 0; i < COUNT; ++i) {
    wrong += (u[i] - exact[i]) * (u[i] - exact[i]);
    all += exact[i] * exact[i];
  }
  printf("relative error %.1e\n", sqrt(wrong / all));
  return 0;
}
