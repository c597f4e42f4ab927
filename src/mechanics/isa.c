/* Which instruction set's kernels run. */
#include "mechanics/isa.h"

#include "mechanics/bond_body.h"
#include "mechanics/motion.h"

#include <string.h>

static int limit = 2; /* 0 baseline, 1 avx2, 2 avx512 */

static int processor_level(void)
{
#ifdef SDR_HAVE_X86_KERNELS
  __builtin_cpu_init();
  const int avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                   __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  const int avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                     __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  return avx2 && avx512 ? 2 : avx2 ? 1 : 0;
#else
  return 0;
#endif
}

int sdr_isa_level(void)
{
  const int own = processor_level();
  return own < limit ? own : limit;
}

const sdr_bond_kernels *sdr_bond_kernels_best(void)
{
#ifdef SDR_HAVE_X86_KERNELS
  const int level = sdr_isa_level();
  if (level == 2) return &sdr_bond_kernels_avx512;
  if (level == 1) return &sdr_bond_kernels_avx2;
#endif
  return &sdr_bond_kernels_baseline;
}

const sdr_precise_kernels *sdr_precise_kernels_best(void)
{
#ifdef SDR_HAVE_X86_KERNELS
  const int level = sdr_isa_level();
  if (level == 2) return &sdr_precise_kernels_avx512;
  if (level == 1) return &sdr_precise_kernels_avx2;
#endif
  return &sdr_precise_kernels_baseline;
}

const sdr_motion_kernels *sdr_motion_kernels_best(void)
{
#ifdef SDR_HAVE_X86_KERNELS
  const int level = sdr_isa_level();
  if (level == 2) return &sdr_motion_kernels_avx512;
  if (level == 1) return &sdr_motion_kernels_avx2;
#endif
  return &sdr_motion_kernels_baseline;
}

sdr_status sdr_isa_limit(const char *name)
{
  static const char *const names[3] = {"baseline", "avx2", "avx512"};
  for (int level = 0; level < 3; ++level)
    if (strcmp(name, names[level]) == 0) {
      if (level > processor_level())
        return sdr_fail(SDR_BAD_INPUT, "this processor has no %s; its best is %s", name,
                        names[processor_level()]);
      limit = level;
      return SDR_OK;
    }
  return sdr_fail(SDR_BAD_INPUT,
                  "instruction set '%s' is unknown; known are avx512, avx2, baseline", name);
}
