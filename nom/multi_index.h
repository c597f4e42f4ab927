/* Multi-indices: the derivatives that operators of an order give, by name. */
#ifndef SDR_NOM_MULTI_INDEX_H
#define SDR_NOM_MULTI_INDEX_H

#include "base/status.h"

enum {
  SDR_MOST_ORDER = 6,
  SDR_MOST_TERMS = 83, /* in 3-D: (6 + 3)! / (6! 3!) - 1 */
  SDR_VALUE = -1       /* the field itself, where a derivative is asked for */
};

/* All a with 1 <= |a| <= order, by rising |a|, then by falling powers of x, then of y:
   x y xx xy yy xxx ... in 2-D. */
typedef struct {
  int components, order, count;
  int power[SDR_MOST_TERMS][3];
  int degree[SDR_MOST_TERMS];                    /* |a| */
  double factorial[SDR_MOST_TERMS];              /* a! = a_x! a_y! a_z! */
  char name[SDR_MOST_TERMS][SDR_MOST_ORDER + 1]; /* "xxy" */
} sdr_multi_indices;

/* SDR_BAD_INPUT unless components is 1..3 and order 1..SDR_MOST_ORDER. */
sdr_status sdr_multi_indices_of(int components, int order, sdr_multi_indices *out);

/* Index of a derivative by name, its letters in any order ("yx" is "xy"); SDR_VALUE for "1".
   SDR_BAD_INPUT with the names that exist. */
sdr_status sdr_multi_index_find(const sdr_multi_indices *set, const char *name, int *out);

/* All monomials (r/h)^a, `count` values. */
void sdr_monomials(const sdr_multi_indices *set, const double r[3], double h, double *p);

#endif
