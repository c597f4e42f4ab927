/* Horizon sets H_i as a directed table in compressed rows (theory sec. 1). */
#ifndef SDR_NOM_NEIGHBOURHOOD_H
#define SDR_NOM_NEIGHBOURHOOD_H

#include "nom/lattice_groups.h"

typedef struct {
  int64_t *row;    /* count + 1 */
  int32_t *column; /* H_i = column[row[i]] .. column[row[i + 1] - 1], ascending, without i */
} sdr_neighbourhood;

/* Find every H_i by a cell search, threaded; linear in the number of bonds. Owner: the caller. */
sdr_status sdr_neighbourhood_create(const sdr_points *points, sdr_neighbourhood *out);
/* The same without the pairs that runs hold. Where all around a point are of its group nothing is
   compared, so this is linear in what is found, and in the points. */
sdr_status sdr_neighbourhood_beside(const sdr_points *points, const sdr_lattice_groups *held,
                                    sdr_neighbourhood *out);
void sdr_neighbourhood_destroy(sdr_neighbourhood *neighbourhood);

/* |X_j - X_i|^2 (m^2); the same bits for (i, j) and (j, i). */
static inline double sdr_distance_squared(const sdr_points *points, int32_t i, int32_t j)
{
  double square = 0.0;
  for (int a = 0; a < points->components; ++a) {
    const double d = points->x[a][j] - points->x[a][i];
    square += d * d;
  }
  return square;
}

/* 1 if a neighbour at that squared distance lies in H_i; ties count as inside. Points without a
   family have no neighbour. */
static inline int sdr_in_horizon(const sdr_points *points, int32_t i, double distance_squared)
{
  return sdr_has_family(points, i) &&
         distance_squared <= points->horizon[i] * points->horizon[i] * (1.0 + 1e-9);
}

#endif
