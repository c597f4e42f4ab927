#include "time/integrator.h"

#include <string.h>

static const sdr_integrator *const integrators[] = {
    &sdr_leapfrog, &sdr_static, &sdr_static_linear, &sdr_energy_momentum, &sdr_cvode, &sdr_ida};

const sdr_integrator *sdr_integrator_find(const char *name)
{
  for (size_t k = 0; k < sizeof integrators / sizeof *integrators; ++k)
    if (strcmp(integrators[k]->name, name) == 0) return integrators[k];
  return NULL;
}
