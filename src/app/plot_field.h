/* The field of a frame that a picture shows: a component or the magnitude, with its name, unit and
   colour scale. */
#ifndef SDR_APP_PLOT_FIELD_H
#define SDR_APP_PLOT_FIELD_H

#include "app/plot_palette.h"
#include "app/rundata.h"

typedef struct {
  char label[320];            /* "damage", "stress xy", "displacement magnitude" */
  const char *unit;           /* "Pa"; "": none */
  float *value;               /* a point, SI */
  int pieces;                 /* 1: whole numbers that name pieces, materials or levels */
  double low, high;           /* of the colour scale */
  int flat;                   /* 1: all values are one, the scale has room beside it */
  double least, most;         /* of the values; a few may lie beyond the colour scale */
  const sdr_palette *palette; /* unused for pieces */
} sdr_plot_field;

/* name: FIELD (of several components: the magnitude; of a tensor its Frobenius norm) or
   FIELD.COMPONENT: x, y, z or xx, yy, zz, yz, xz, xy. What is not in the frame is SDR_BAD_INPUT and
   the message lists what is. The caller clears *out. */
sdr_status sdr_plot_field_read(const sdr_rundata *run, int frame, const char *name,
                               sdr_plot_field *out);
void sdr_plot_field_clear(sdr_plot_field *field);

/* Give both fields the colour scale that covers both. */
void sdr_plot_field_share(sdr_plot_field *a, sdr_plot_field *b);

/* Colour of a value. */
void sdr_plot_field_colour(const sdr_plot_field *field, double value, unsigned char rgb[3]);

#endif
