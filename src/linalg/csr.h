/* Sparse matrices in compressed rows. */
#ifndef SDR_LINALG_CSR_H
#define SDR_LINALG_CSR_H

#include "base/status.h"

#include <stdint.h>

typedef struct {
  int32_t rows, columns;
  int64_t *row;    /* rows + 1 */
  int32_t *column; /* ascending within a row */
  double *value;
} sdr_csr;

void sdr_csr_destroy(sdr_csr *matrix);

/* A matrix that is summed up from entries in any order: first every entry's place is named, then
   values are added. */
typedef struct sdr_csr_builder sdr_csr_builder;
sdr_status sdr_csr_builder_create(int32_t rows, int32_t columns, sdr_csr_builder **out);
void sdr_csr_builder_destroy(sdr_csr_builder **builder); /* NULL-safe */

/* Add `value` at (row, column); entries at one place are summed, in the order of the calls. */
sdr_status sdr_csr_builder_add(sdr_csr_builder *builder, int32_t row, int32_t column, double value);

/* The sum of all entries. The builder may be used no more but must be destroyed. */
sdr_status sdr_csr_builder_finish(sdr_csr_builder *builder, sdr_csr *out);

/* y = A x. */
void sdr_csr_times(const sdr_csr *matrix, const double *x, double *y);

#endif
