#include "nom/stencil.h"

#include "base/memory.h"

#include <math.h>
#include <stddef.h>

static int fill(int components, double ratio, int32_t *step)
{
  const int32_t reach = (int32_t)floor(ratio * (1.0 + 1e-9));
  const double square = ratio * ratio * (1.0 + 1e-9);
  const int32_t ry = components > 1 ? reach : 0, rz = components > 2 ? reach : 0;
  int count = 0;
  for (int32_t z = -rz; z <= rz; ++z)
    for (int32_t y = -ry; y <= ry; ++y)
      for (int32_t x = -reach; x <= reach; ++x) {
        const double d = (double)x * x + (double)y * y + (double)z * z;
        if (d == 0.0 || d > square) continue;
        if (step) {
          step[3 * count] = x;
          step[3 * count + 1] = y;
          step[3 * count + 2] = z;
        }
        ++count;
      }
  return count;
}

sdr_status sdr_stencil_create(int components, double spacing, double horizon, sdr_stencil *out)
{
  const double ratio = horizon / spacing;
  if (!(ratio < 100.0))
    return sdr_fail(SDR_BAD_INPUT,
                    "a horizon of %g spacings would give each point millions of "
                    "bonds; give less than 100 spacings",
                    ratio);
  const int count = fill(components, ratio, NULL);
  int32_t *step = sdr_alloc(3 * (size_t)count, sizeof *step);
  if (!step) return SDR_RUN_FAILED;
  fill(components, ratio, step);
  *out = (sdr_stencil){count, step};
  return SDR_OK;
}

void sdr_stencil_destroy(sdr_stencil *stencil)
{
  sdr_free(stencil->step);
  *stencil = (sdr_stencil){0};
}
