#include "app/plot_palette.h"

#include <math.h>

/* Spread-out damage below a third stays light, so that cracks stand out of it. */
static const sdr_colour_stop damage_stops[] = {{0.00, 227, 230, 234}, {0.12, 231, 217, 186},
                                               {0.32, 240, 172, 86},  {0.55, 201, 67, 56},
                                               {0.78, 112, 26, 78},   {1.00, 24, 6, 36}};
static const sdr_colour_stop sequential_stops[] = {{0.00, 234, 240, 243},
                                                   {0.25, 166, 206, 214},
                                                   {0.50, 84, 156, 184},
                                                   {0.75, 36, 98, 146},
                                                   {1.00, 14, 36, 84}};
static const sdr_colour_stop reversed_stops[] = {{0.00, 14, 36, 84},
                                                 {0.25, 36, 98, 146},
                                                 {0.50, 84, 156, 184},
                                                 {0.75, 166, 206, 214},
                                                 {1.00, 234, 240, 243}};
static const sdr_colour_stop diverging_stops[] = {
    {0.00, 22, 52, 116},   {0.22, 62, 122, 184}, {0.40, 166, 202, 224}, {0.50, 238, 238, 236},
    {0.60, 242, 190, 164}, {0.78, 212, 92, 74},  {1.00, 122, 16, 36}};

#define PALETTE(stops)                                                                             \
  {                                                                                                \
    (int)(sizeof(stops) / sizeof((stops)[0])), stops                                               \
  }

const sdr_palette sdr_palette_damage = PALETTE(damage_stops);
const sdr_palette sdr_palette_sequential = PALETTE(sequential_stops);
const sdr_palette sdr_palette_reversed = PALETTE(reversed_stops);
const sdr_palette sdr_palette_diverging = PALETTE(diverging_stops);

static unsigned char between(unsigned char a, unsigned char b, double share)
{
  return (unsigned char)lround(a + share * (b - a));
}

void sdr_palette_colour(const sdr_palette *palette, double t, unsigned char rgb[3])
{
  const double at = fmin(fmax(t, 0.0), 1.0);
  int k = 1;
  while (k < palette->count - 1 && palette->stop[k].at < at) ++k;
  const sdr_colour_stop *low = &palette->stop[k - 1], *high = &palette->stop[k];
  const double share = fmin(fmax((at - low->at) / (high->at - low->at), 0.0), 1.0);
  rgb[0] = between(low->red, high->red, share);
  rgb[1] = between(low->green, high->green, share);
  rgb[2] = between(low->blue, high->blue, share);
}

void sdr_palette_piece(int k, unsigned char rgb[3])
{
  static const unsigned char colours[][3] = {
      {216, 220, 226}, {0, 114, 178},  {230, 159, 0},  {0, 158, 115},  {204, 102, 142},
      {86, 180, 233},  {213, 94, 0},   {240, 214, 66}, {110, 84, 160}, {140, 108, 70},
      {60, 70, 84},    {150, 200, 90}, {190, 160, 210}};
  const int others = (int)(sizeof colours / sizeof colours[0]) - 1;
  const int pick = k <= 0 ? 0 : 1 + (k - 1) % others;
  for (int c = 0; c < 3; ++c) rgb[c] = colours[pick][c];
}
