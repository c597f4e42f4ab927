/* Which instruction set's kernels run: each file NAME_kernels.c is compiled once for each, ends in
   a const table, and the model takes the table of the best level. */
#ifndef SDR_MECHANICS_ISA_H
#define SDR_MECHANICS_ISA_H

/* 0 baseline, 1 avx2, 2 avx512: the best that this processor has and sdr_isa_limit allows. */
int sdr_isa_level(void);

#endif
