/* What `check` says of weights and materials: the constants that the model takes from them. */
#ifndef SDR_APP_CHECK_MATERIAL_H
#define SDR_APP_CHECK_MATERIAL_H

#include "app/build.h"

#include <stdio.h>

sdr_status sdr_check_materials(const sdr_built *built, FILE *out);

#endif
