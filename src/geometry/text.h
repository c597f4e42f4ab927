/* Lengths and places in messages, in a unit that reads well. */
#ifndef SDR_GEOMETRY_TEXT_H
#define SDR_GEOMETRY_TEXT_H

enum { SDR_LENGTH_TEXT = 32, SDR_PLACE_TEXT = 3 * (SDR_LENGTH_TEXT + 6) };

/* "0.5 mm" for 5e-4: m, mm, um or nm. Returns `text`. */
const char *sdr_length_text(double metres, char text[SDR_LENGTH_TEXT]);

/* "x = 1 mm, y = 2 mm" for the first `components` of x. Returns `text`. */
const char *sdr_place_text(const double *x, int components, char text[SDR_PLACE_TEXT]);

#endif
