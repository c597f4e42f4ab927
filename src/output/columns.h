/* The further columns of history.csv: probes (fields at points) and reactions of supports. */
#ifndef SDR_OUTPUT_COLUMNS_H
#define SDR_OUTPUT_COLUMNS_H

#include "mechanics/system.h"
#include "scene/scene.h"

typedef struct sdr_columns sdr_columns;

/* PROBE.field[.x|.y|.z|.xx...] for each probe and field, then SUPPORT.reaction.x ... for each
   prescribed component, in the scene's order. A field that probes cannot show is SDR_BAD_INPUT with
   the probe's origin. Borrows the scene. Owner: the caller. */
sdr_status sdr_columns_create(const sdr_scene *scene, const sdr_points *points, sdr_columns **out);
void sdr_columns_destroy(sdr_columns **columns); /* NULL-safe */

int sdr_columns_count(const sdr_columns *columns);
const char *sdr_columns_name(const sdr_columns *columns, int k);

/* Present values, one a column, SI. Each field is made once, however many columns show it. */
sdr_status sdr_columns_values(sdr_columns *columns, sdr_system *system, double *values);

#endif
