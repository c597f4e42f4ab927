#include "nom/influence.h"

#include <string.h>

static const char *const names[SDR_INFLUENCES] = {
    [SDR_INFLUENCE_CONSTANT] = "constant",    [SDR_INFLUENCE_INVERSE] = "1/r",
    [SDR_INFLUENCE_INVERSE_SQUARE] = "1/r^2", [SDR_INFLUENCE_LINEAR] = "linear",
    [SDR_INFLUENCE_CUBIC] = "cubic",          [SDR_INFLUENCE_GAUSSIAN] = "gaussian",
};

const char *sdr_influence_name(sdr_influence influence)
{
  const unsigned index = (unsigned)influence;
  return index < SDR_INFLUENCES ? names[index] : NULL;
}

int sdr_influence_named(const char *name, sdr_influence *out)
{
  for (int k = 0; k < SDR_INFLUENCES; ++k)
    if (strcmp(name, names[k]) == 0) {
      *out = (sdr_influence)k;
      return 1;
    }
  return 0;
}
