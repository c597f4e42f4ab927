/* What `check` says of the body as points: how large and heavy, and what holds and moves it. */
#ifndef SDR_APP_CHECK_BODY_H
#define SDR_APP_CHECK_BODY_H

#include "app/build.h"

#include <stdio.h>

void sdr_check_body(const sdr_built *built, FILE *out);

#endif
