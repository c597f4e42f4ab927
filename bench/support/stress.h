/* Sweeps that push bodies to where methods fail: what varies, and the scene of each case. */
#ifndef SDR_BENCH_STRESS_H
#define SDR_BENCH_STRESS_H

#include <stdio.h>

enum { STRESS_VARIANTS = 6, STRESS_LEVELS = 8 };

/* What is judged of a run. */
typedef enum {
  STRESS_IMBALANCE, /* largest imbalance of energy over the largest energy */
  STRESS_END,   /* imbalance at the end alone: while a load grows from nothing it tells nothing */
  STRESS_EXACT, /* the scene's measure `err` */
  STRESS_SAME,  /* shares of energy and mean damage against the sweep's level `base` */
  STRESS_DRIFT, /* slope of the imbalance over the energy, in a million steps */
  STRESS_COST   /* cost of a bond and step over that at the level `base`, less 1 */
} stress_kind;

typedef struct {
  const char *name, *title, *what; /* `what`: the level's meaning */
  stress_kind kind;
  double accurate; /* a smaller error counts as accurate */
  int base;        /* index of the level that others are compared with */
  const char *variant[STRESS_VARIANTS];
  int level_count;
  double level[STRESS_LEVELS];
  void (*scene)(FILE *out, int variant, double level);
} stress_sweep;

extern const stress_sweep stress_sweeps[];
extern const int stress_sweep_count;

#endif
