/* A linear problem of nonlocal operators at one spacing: points, their operators, and what a page
   of code for a kind of equation gives. A new equation is one such page (docs/nom.md, "A new
   equation"), its words in scene/equation_words.c and a line in kinds.c. */
#ifndef SDR_EQUATION_PROBLEM_H
#define SDR_EQUATION_PROBLEM_H

#include "nom/assembly.h"
#include "scene/equation.h"

enum {
  SDR_EQUATION_TERMS = 128, /* of one row, or of a functional */
  SDR_EQUATION_STRESSES = 6
};

typedef struct sdr_problem sdr_problem;

/* What a page gives. Unknowns are `fields` values a point; row p is the equation that stands, at a
   point inside, for unknown p. */
typedef struct {
  int (*fields)(int components);
  /* Which row the scene's source belongs to; that of its further components follow. */
  int source_row;
  /* Terms of row p at a point inside, whose sum is the source. How many. NULL: no collocation. */
  int (*inside)(const sdr_problem *problem, int p, sdr_term *term);
  /* Terms of a condition (the scene's words, in their order) for component c at a place with that
     outward normal, and the row that they replace. How many. */
  int (*condition)(const sdr_problem *problem, int condition, int c, const double normal[3],
                   sdr_term *term, int *row);
  /* Terms of the functional, whose work is the source's and the natural conditions'. How many.
     NULL: no variational form. */
  int (*functional)(const sdr_problem *problem, sdr_quadratic_term *term);
  /* The constant of 1/2 |grad u|^2 in the functional, times which `penalty` goes. */
  double (*stiffness)(const sdr_problem *problem);
  /* Stress from gradient[c][a], the derivative of component c along a; NULL: none. */
  void (*stress)(const sdr_problem *problem, double gradient[3][3], double *out);
} sdr_equation_ops;

extern const sdr_equation_ops sdr_equation_poisson, sdr_equation_plate, sdr_equation_elasticity,
    sdr_equation_gradient_elasticity;

const sdr_equation_ops *sdr_equation_ops_of(sdr_equation_kind kind);

struct sdr_problem {
  const sdr_scene *scene; /* borrowed, at the spacing of its points */
  const sdr_equation *equation;
  const sdr_equation_words *words;
  const sdr_equation_ops *ops;
  sdr_points *points;
  double *volume; /* of the points; in the variational form that of their cells inside the shape */
  uint8_t *held;  /* 1: prescribed as a volume, so no place to measure errors at */
  sdr_support support;
  sdr_shape_tensors shape;
  sdr_operator op;
  int components, fields;
  /* Derivatives by their letters, -1 where the order is too low. */
  int d[3], dd[3][3];
};

/* Points, supports, shape tensors and operators of the scene's equation. What is wrong with the
   points or their supports is SDR_BAD_INPUT. The scene is borrowed. Owner: the caller. */
sdr_status sdr_problem_create(const sdr_scene *scene, sdr_problem **out);
void sdr_problem_destroy(sdr_problem **problem); /* NULL-safe */

/* Mean of the shape tensors' condition numbers. */
double sdr_problem_mean_condition(const sdr_problem *problem);

/* Coordinates of point i; unused components 0. */
void sdr_problem_place(const sdr_problem *problem, int32_t i, double x[3]);

#endif
