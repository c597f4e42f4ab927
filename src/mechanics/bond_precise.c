/* Forces of bodies with histories in double: none of these commits. */
#include "base/parallel.h"
#include "mechanics/bond_internal.h"

#include <string.h>

typedef struct {
  const sdr_bond_model *model;
  sdr_run_force run;
  sdr_loose_force loose;
  double *const *u, *const *f;
} precise_call;

static void force_of_stripe(void *context, int s)
{
  const precise_call *call = context;
  const sdr_bonds *bonds = call->model->bonds;
  call->run(&call->model->body, bonds->stripe_run[s], bonds->stripe_run[s + 1], call->u, call->f);
}

/* After the runs' stripes: chunks add to their own points only. */
static void force_of_loose_stripe(void *context, int s)
{
  const precise_call *call = context;
  int64_t first, end;
  sdr_stripe_chunks(&call->model->body, s, &first, &end);
  call->loose(&call->model->body, first, end, call->u, call->f);
}

void sdr_bond_precise_force(sdr_bond_model *model, double *const u[3], double *const f[3])
{
  const sdr_points *points = model->head.points;
  const int n = points->components, each = model->body.stiffness_at != NULL;
  const precise_call call = {.model = model,
                             .run = model->precise->run_force[model->body.law][n - 1][each],
                             .loose = model->precise->loose_force[model->body.law][n - 1][each],
                             .u = u,
                             .f = f};
  for (int a = 0; a < n; ++a) memset(f[a], 0, sdr_points_padded(points) * sizeof(double));
  sdr_each_stripe(points, force_of_stripe, (void *)&call);
  if (model->bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, points->stripe_count, 1, force_of_loose_stripe, (void *)&call);
}
