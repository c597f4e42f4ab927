#include "time/sun_run.h"

static sdr_status attach(const sdr_sun_method *method, sdr_system *system, double dt,
                         const sdr_method_record *before)
{
  void *work = NULL;
  SDR_TRY(method->create(system, dt, before, &work));
  system->work = work;
  system->end_work = method->destroy;
  system->method.name = method->name(system);
  return SDR_OK;
}

sdr_status sdr_sun_start(const sdr_sun_method *method, sdr_system *system, double dt)
{
  const sdr_method_record none = {0};
  SDR_TRY(attach(method, system, dt, &none));
  SDR_TRY(method->next_stretch(system->work, 1));
  return sdr_motion_show(method->motion(system->work));
}

sdr_status sdr_sun_restart(const sdr_sun_method *method, sdr_system *system, double dt)
{
  const sdr_method_record before = system->method;
  if (system->work) system->end_work(system->work);
  system->work = NULL;
  SDR_TRY(attach(method, system, dt, &before));
  return method->next_stretch(system->work, 0);
}

void sdr_sun_report(sdr_system *system, const sdr_reduced_solver *reduced,
                    const sdr_method_record *counts)
{
  sdr_method_record *record = &system->method;
  const char *name = record->name;
  const double residual = record->residual;
  *record = *counts;
  record->name = name;
  record->residual = residual;
  if (!reduced) return;
  const sdr_reduced_report solver = sdr_reduced_solver_report(reduced);
  record->solver = solver.name;
  record->unknowns = solver.unknowns;
  record->tangents = solver.tangents;
  record->factors = solver.factors;
  record->linear_iterations = solver.iterations;
}

sdr_status sdr_sun_complain(const char *library, sdr_sun_failure failure)
{
  const char *text = failure.complaint->text;
  if (failure.status != SDR_OK) return failure.status;
  return sdr_fail(SDR_RUN_FAILED, "%s failed: %s", library, text[0] ? text : "out of memory");
}

sdr_status sdr_sun_explain(const sdr_system *system, const char *name, sdr_sun_failure failure,
                           int flag, const sdr_sun_reason *known, size_t count)
{
  const long long step = (long long)system->step;
  if (failure.status != SDR_OK)
    return sdr_fail(failure.status, "%s stopped at t = %.6g s (step %lld): %s", name, system->time,
                    step, sdr_error_message());
  for (size_t k = 0; k < count; ++k)
    if (known[k].flag == flag)
      return sdr_fail(SDR_RUN_FAILED, "%s stopped at t = %.6g s (step %lld): %s; %s", name,
                      system->time, step, known[k].what, known[k].try);
  return sdr_fail(SDR_RUN_FAILED, "%s stopped at t = %.6g s (step %lld): %s", name, system->time,
                  step, failure.complaint->text);
}
