/* Inside src/time/ida*.c; the only header that knows IDA's types. */
#ifndef SDR_TIME_IDA_INTERNAL_H
#define SDR_TIME_IDA_INTERNAL_H

#include "time/mean_solver.h"
#include "time/sun_run.h"
#include "time/tolerances.h"

#include <ida/ida.h>

/* Sums over time: what a motion asks for, and viscous work. */
enum { SDR_IDA_SUMS = SDR_MOTION_RATES + 1, SDR_IDA_VISCOUS = SDR_MOTION_RATES };

typedef struct {
  sdr_system *system;
  sdr_motion *motion;
  sdr_reduced_solver *reduced;
  sdr_mean_solver *solver;
  sdr_tolerances tolerances;
  double longest;  /* s */
  int has_mass;    /* 1: every point has one */
  double *viscous; /* an unknown: C, N s/m; NULL: none */

  SUNContext context;
  void *memory;
  N_Vector y, slope, kind, left;
  N_Vector middle, middle_slope; /* of a step */
  SUNMatrix matrix;
  SUNLinearSolver linear;
  int32_t free, size; /* entries of q; of x */
  int32_t *entry;     /* the supports' entry of prescribed ones, x[free + k] */
  double *g, *diagonal, *right, *scale, *full;
  double rates[SDR_IDA_SUMS]; /* of the sums, at the system's time */
  double made_factor;         /* c of the matrix */
  sdr_method_record before;
  sdr_sun_complaint complaint;
  sdr_status failure;
} sdr_ida_work;

/* ida_rows.c: what IDA calls. F(t, y, y'); error weights; Newton's matrix; its solution. */
int sdr_ida_residual(realtype t, N_Vector y, N_Vector slope, N_Vector left, void *context);
int sdr_ida_weigh(N_Vector y, N_Vector weight, void *context);
int sdr_ida_make_matrix(realtype t, realtype factor, N_Vector y, N_Vector slope, N_Vector left,
                        SUNMatrix matrix, void *context, N_Vector a, N_Vector b, N_Vector c);
int sdr_ida_solve(void *context, double *x, const double *b, const double *weight,
                  double tolerance);

/* Rates of the sums at a state. */
sdr_status sdr_ida_rates(sdr_ida_work *work, double t, const double *y, const double *slope,
                         double rates[SDR_IDA_SUMS]);

/* C of entry k of q; the body at x, prescribed components where x has them. */
double sdr_ida_viscous_of(const sdr_ida_work *work, int32_t k);
sdr_status sdr_ida_place(sdr_ida_work *work, double t, const double *x);

#endif
