/* Colour scales that keep their order in grey print. */
#ifndef SDR_APP_PLOT_PALETTE_H
#define SDR_APP_PLOT_PALETTE_H

typedef struct {
  double at; /* 0..1, rising */
  unsigned char red, green, blue;
} sdr_colour_stop;

typedef struct {
  int count;
  const sdr_colour_stop *stop;
} sdr_palette;

extern const sdr_palette sdr_palette_damage;     /* light body, dark cracks */
extern const sdr_palette sdr_palette_sequential; /* light to dark: one sign */
extern const sdr_palette sdr_palette_reversed;   /* dark to light: negative values */
extern const sdr_palette sdr_palette_diverging;  /* blue, light grey, red: both signs */

/* Colour at t in [0, 1] (clamped) into rgb[3]. */
void sdr_palette_colour(const sdr_palette *palette, double t, unsigned char rgb[3]);

/* Colour of piece number `k`: 0 a light body, others from a few that differ well. */
void sdr_palette_piece(int k, unsigned char rgb[3]);

#endif
