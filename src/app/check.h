/* `sunder check`: what a scene would run, before it does. */
#ifndef SDR_APP_CHECK_H
#define SDR_APP_CHECK_H

#include "base/status.h"

#include <stdio.h>

/* Build the scene as `run` would and print points, bonds, stable step, memory, the constants that
   its moduli and toughness turn into, defaults and what is skipped. */
sdr_status sdr_check(const char *path, const char *variant, int set_count, const char *const *sets,
                     FILE *out);

#endif
