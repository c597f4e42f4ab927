/* The pieces that a body has come apart into, one by one. */
#ifndef SDR_OUTPUT_PIECES_H
#define SDR_OUTPUT_PIECES_H

#include "output/fragments.h"

/* A piece at the present time, in the order of sdr_fragments_find. */
typedef struct {
  int32_t points;
  double mass;        /* kg */
  double centre[3];   /* m: of mass, where it is now */
  double velocity[3]; /* m/s: of that centre */
} sdr_piece;

/* All pieces; *out also as by sdr_fragments_find, with its `effective` number. Caller: sdr_free. */
sdr_status sdr_pieces_find(sdr_system *system, double threshold, sdr_piece **pieces,
                           sdr_fragments *out);

/* The same as fragments.csv in the directory: piece,points,mass,x,y,z,vx,vy,vz; 17 digits, SI. */
sdr_status sdr_pieces_write(const char *directory, sdr_system *system, double threshold,
                            sdr_fragments *out);

#endif
