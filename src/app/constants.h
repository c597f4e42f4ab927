/* The constants that a state-based model takes from a material, for `check` and the summary. */
#ifndef SDR_APP_CONSTANTS_H
#define SDR_APP_CONSTANTS_H

#include "app/build.h"
#include "output/summary.h"

/* Of the first point of material `index`; what the model or its law lacks is NAN. */
sdr_material_constants sdr_constants_of(const sdr_built *built, int index);

#endif
