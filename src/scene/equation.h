/* Equations that nonlocal operators solve: what a scene may say of each. The equation itself is a
   page of code in src/equation. */
#ifndef SDR_SCENE_EQUATION_H
#define SDR_SCENE_EQUATION_H

#include "scene/scene.h"

/* A constant of an equation, as `young`. */
typedef struct {
  const char *word;
  sdr_unit unit;
  double low, high;
  int above_low;        /* 1: `low` itself is excluded */
  const char *fallback; /* NULL: required */
  int least_components; /* bodies of fewer have no such constant */
} sdr_equation_number;

/* A condition on the boundary, as `traction`. */
typedef struct {
  const char *word;
  sdr_unit unit;
  int is_solution; /* 1: it prescribes the solution itself, so it may be `exact` */
  int is_natural;  /* 1: a variational form takes it as a load */
} sdr_equation_condition;

enum { SDR_EQUATION_CONDITIONS = 3 };

typedef struct {
  const char *word;
  const char *formula; /* for messages and `check` */
  const char *solution;
  sdr_unit unit;      /* of the solution */
  const char *symbol; /* of that unit, in files */
  int is_vector;      /* 1: solution, source and conditions have the body's components */
  int has_stress;
  int in_plane;       /* 1: in two dimensions only */
  int least_order[2]; /* of collocation, of the variational form; 0: has none */
  sdr_unit source_unit;
  sdr_equation_number number[SDR_EQUATION_NUMBERS];          /* word NULL: the end */
  sdr_equation_condition condition[SDR_EQUATION_CONDITIONS]; /* likewise */
} sdr_equation_words;

/* In the order of sdr_equation_kind, ended by word NULL. */
extern const sdr_equation_words sdr_equations[];

#endif
