/* A scene: everything a run needs to know, in SI, read from YAML (docs/scene.md lists each key). */
#ifndef SDR_SCENE_SCENE_H
#define SDR_SCENE_SCENE_H

#include "base/status.h"
#include "scene/expression.h"

#include <stdint.h>

enum { SDR_NAME_MAX = 64 };

typedef enum { SDR_1D, SDR_PLANE_STRESS, SDR_PLANE_STRAIN, SDR_3D } sdr_dimension;

/* Where in the scene's text something stands, for messages that appear after reading:
   "file:line:column". line 0: from the command line, `file` is "--set PATH" and a column above 0
   counts in the value given. A default has the origin of the mapping that lacks the key. */
typedef struct {
  const char *file; /* owned by the scene */
  int line, column;
} sdr_origin;

/* ---- shapes ---------------------------------------------------------------------------------- */

typedef enum {
  SDR_BOX,  /* low..high per component (1-D: an interval); faces left right bottom top back front */
  SDR_DISC, /* centre, outer; 2-D; face rim */
  SDR_ANNULUS,    /* centre, inner, outer; 2-D; faces inner outer */
  SDR_SPHERE,     /* centre, outer, inner (0: full); faces inner outer */
  SDR_CYLINDER,   /* centre, inner (0: full), outer, axis z from low[2] to high[2]; 3-D;
                     faces inner outer bottom top ends */
  SDR_HALF_SPACE, /* points with (x - centre).normal <= 0; no face */
  SDR_POLYGON,    /* 2-D, vertices in order; face rim */
  SDR_GROUP,      /* named points of an imported body; no face */
  SDR_FACETS,     /* a named face of an imported mesh; face surface */
  SDR_UNION,
  SDR_INTERSECTION,
  SDR_DIFFERENCE /* parts[0] without the others */
} sdr_shape_kind;

typedef struct sdr_shape {
  sdr_shape_kind kind;
  double centre[3], low[3], high[3], normal[3]; /* unused components 0 */
  double inner, outer;
  double angle; /* box only: turned about its centre by this, anticlockwise in x-y, radians */
  int part_count;
  struct sdr_shape *parts; /* of a combination */
  int primitive_count;     /* in all parts, at most 10000; 1 for a primitive */
  int vertex_count;
  double *vertices;                     /* polygon: x0 y0 x1 y1 ... */
  const struct sdr_import_group *group; /* SDR_GROUP, SDR_FACETS (scene/import.h) */
  sdr_origin origin;
} sdr_shape;

/* What `on:` or `where:` names: a shape, a region, or a face of one of them. */
typedef struct {
  const sdr_shape *shape;  /* NULL: the whole body */
  char face[16];           /* "" : the volume */
  char text[SDR_NAME_MAX]; /* as written, for messages ("inner", "notch.left", "box") */
  sdr_origin origin;
} sdr_place;

typedef struct {
  char name[SDR_NAME_MAX];
  sdr_shape *shape;
} sdr_region;

/* ---- body ------------------------------------------------------------------------------------ */

/* Halve the spacing `levels` times inside the shape (levels >= 1). */
typedef struct {
  sdr_place where;
  double spacing; /* of the refined part, as asked for; spacing / 2^k */
} sdr_refine;

/* A length in metres, or a multiple of the spacing or horizon of the point. */
typedef struct {
  double value;
  int relative;
} sdr_length;

/* Points that split while a run goes on, key `points.adapt` (mechanics/refine.h). */
typedef struct {
  int levels;      /* halvings of the body's spacing that a point may reach */
  int anywhere;    /* 1: points of any place may split, else those in `where` */
  sdr_place where; /* volume */
  double damage;   /* a point splits whose damage has grown by more than this; INFINITY: none */
  double energy;   /* or whose stored energy is above this, J/m^3; INFINITY: none */
  sdr_length neighbours; /* and all within this distance of it; relative: horizons of level 0 */
  sdr_length ahead;      /* beyond that, whenever some point must; likewise */
  double every;          /* s between two looks; NAN: automatic */
  sdr_origin origin;
} sdr_adapt_scene;

typedef struct {
  sdr_shape *shape;
  double spacing; /* m, of the coarsest lattice */
  double
      lattice_origin[3]; /* m: a lattice point lies here (default 0 0 0: "a point at the centre") */
  int cell_centred[3];   /* 1: `origin` is a corner of cells in that component, points sit half a
                            spacing off (scene key `align: point | cell`) */
  double angle;          /* lattice axes turned by this about the origin, anticlockwise, radians */
  double jitter; /* each coordinate moved by uniform noise of +- this share of the spacing */
  uint64_t jitter_seed;
  int jitter_inside; /* 1: points within a quarter of a spacing of the surface stay */
  double thickness;  /* m: 2-D; in 1-D the area in m^2; default 1 */
  int refine_count;
  sdr_refine *refine;
  sdr_adapt_scene *adapt;            /* NULL: points stay as they are */
  const struct sdr_import *imported; /* from a file (scene/import.h) instead of shape and spacing,
                                        which then are NULL and the largest one; NULL: a lattice */
  sdr_origin origin;
} sdr_points_scene;

typedef enum { SDR_BOND_BASED, SDR_ORDINARY, SDR_NONORDINARY } sdr_model_kind;

typedef struct {
  char name[SDR_NAME_MAX]; /* default "body" */
  sdr_place where;         /* the whole body for the first */
  double young;            /* Pa */
  double poisson;          /* as given; NAN if not */
  double density;          /* kg/m^3 */
  double toughness;        /* J/m^2; INFINITY if not given (law none) */
  double strength;         /* Pa, in uniaxial tension: law cohesive; NAN if not given */
  double scatter_young;    /* relative half width, uniform; 0: none */
  uint64_t scatter_seed;
  sdr_origin origin;
} sdr_material;

typedef enum {
  SDR_LAW_NONE,
  SDR_LAW_VARIATIONAL,
  SDR_LAW_CRITICAL_STRETCH,
  SDR_LAW_AT1,
  SDR_LAW_COHESIVE
} sdr_law;
typedef enum { SDR_CALIBRATE_FAMILY, SDR_CALIBRATE_PRINTED } sdr_calibration_kind;
/* Whether bonds at the border of two spacings get weights that balance uniform strain. */
typedef enum { SDR_BORDER_PLAIN, SDR_BORDER_BALANCED, SDR_BORDER_AUTO } sdr_border;
/* Weight of a bond in its family: a function of its length (named after the influence functions of
   nom/influence.h), times partial volumes, times a correction. */
typedef enum {
  SDR_WEIGHT_CONSTANT,
  SDR_WEIGHT_INVERSE,
  SDR_WEIGHT_INVERSE_SQUARE,
  SDR_WEIGHT_LINEAR,
  SDR_WEIGHT_CUBIC,
  SDR_WEIGHT_GAUSSIAN
} sdr_weight_function;
typedef enum {
  SDR_CORRECT_NOTHING,
  SDR_CORRECT_ISO,
  SDR_CORRECT_SURFACE_ISO,
  SDR_CORRECT_MADENCI_OTERKUS
} sdr_weight_correction;
typedef struct {
  sdr_weight_function function;
  int partial_volume;
  sdr_weight_correction correction;
} sdr_weight;

/* State-based bodies: linear is small strain, the others finite. */
typedef enum { SDR_LINEAR, SDR_SAINT_VENANT_KIRCHHOFF, SDR_NEO_HOOKEAN } sdr_elasticity;
/* Which part of the energy drives damage at a point. */
typedef enum { SDR_SPLIT_DILATATION, SDR_SPLIT_SPECTRAL } sdr_split;
/* Ordinary bodies: 000 eq. 42, or the 2-D calibration of 004. */
typedef enum { SDR_FORM_STANDARD, SDR_FORM_MADENCI_OTERKUS } sdr_ordinary_form;

typedef struct {
  sdr_law law;
  sdr_length ell; /* relative: multiples of the horizon; default 1 horizon; value 0 (default of
                     state-based bodies): the band that a cut damages */
  double onset;   /* damage of a point that counts as onset; NAN: 0.9 of the plane cut's share */
  int protect_count;
  sdr_place *protect; /* pairs with an end in one of these never break */
} sdr_damage_scene;

/* Repulsion between pieces that are not bonded, key `contact` (mechanics/contact.h). */
typedef struct {
  int on;
  double range;   /* spacings, at most 1 */
  double penalty; /* stiffness over that of the body between neighbouring layers */
} sdr_contact_scene;

typedef enum { SDR_CRACK_POLYLINE, SDR_CRACK_DISC, SDR_CRACK_RECTANGLE } sdr_crack_kind;

/* A cut present from the start: every bond that crosses or touches it is cut. */
typedef struct {
  sdr_crack_kind kind;
  int point_count;  /* polyline: >= 2 in 2-D, segments are polylines of two points; 1-D: 1 point */
  double *vertices; /* 3 a point; disc: [0] centre; rectangle: a corner and its two neighbours */
  double radius, normal[3]; /* disc */
  sdr_origin origin;
} sdr_crack;

/* ---- conditions ------------------------------------------------------------------------------ */

/* When a load or support acts, and how it sets in: value * ramp, ramp from 0 at `from` to 1 at
   from + ramp (linear), until included. */
typedef struct {
  double from, until; /* s; -INFINITY and INFINITY if not given */
  double ramp;        /* s; 0: at once */
} sdr_schedule;

/* Fictitious points outside a flat face, that follow the points inside it (004 sec. 3). */
typedef enum { SDR_NO_LAYER, SDR_MIRROR_LAYER, SDR_TRACTION_LAYER } sdr_layer_kind;

typedef enum { SDR_PRESSURE, SDR_TRACTION, SDR_BODY_FORCE, SDR_POINT_FORCE } sdr_load_kind;

typedef struct {
  sdr_load_kind kind;
  sdr_place on;             /* pressure, traction: a face; body: a volume */
  double at[3];             /* point force: its nearest point */
  sdr_expression *value[3]; /* pressure: [0] only, Pa; traction Pa; body N/m^3; point N; NULL: 0 */
  int spread_layer;         /* 1: shared equally over the points within one spacing of the piece */
  sdr_layer_kind layer;     /* SDR_TRACTION_LAYER: the value acts through fictitious points */
  sdr_length depth;         /* of the layer; relative: horizons; default 2 horizons */
  sdr_schedule schedule;
  sdr_origin origin;
} sdr_load;

typedef enum { SDR_FREE, SDR_PRESCRIBED_DISPLACEMENT, SDR_PRESCRIBED_VELOCITY } sdr_support_kind;

typedef struct {
  char name[SDR_NAME_MAX];  /* default "support0", ... : names the reaction in history.csv */
  sdr_place on;             /* volume: its points; face: the points within `depth` of it */
  sdr_length depth;         /* relative: spacings; default 1 spacing. Of a layer: horizons, 1 */
  sdr_layer_kind layer;     /* SDR_MIRROR_LAYER: held by fictitious points outside the face */
  sdr_support_kind kind[3]; /* per component */
  sdr_expression *value[3]; /* m or m/s; NULL where free */
  int mean;                 /* 1: of the place's points together, not of each */
  sdr_schedule schedule;
  sdr_origin origin;
} sdr_support_scene;

/* Start values on a place; later entries overwrite earlier ones. */
typedef struct {
  int velocity; /* 0: displacement */
  sdr_place on;
  sdr_expression *value[3]; /* m or m/s; NULL: leave */
  sdr_origin origin;
} sdr_initial;

/* ---- time and output ------------------------------------------------------------------------- */

typedef struct {
  char integrator[SDR_NAME_MAX]; /* "leapfrog", "static", "cvode", ... */
  char solver[16];               /* of linear equations, "auto", "cholmod", ...; implicit ones */
  double step;                   /* s; NAN: automatic */
  double safety;                 /* share of the stability limit an automatic step takes; 0.9 */
  double end;                    /* s */
  int allow_unstable;            /* 1: a step above the limit only warns */
  int linear;                    /* static: 1: one linear solution; 0: increments */
  int ends_at_collapse;          /* static: 1: a load that nothing carries ends the run as done */
  /* Of integrators that control their error. */
  int adams;                     /* cvode: 1 Adams, 0 BDF */
  int order;                     /* the largest that it may take; 0: the method's own */
  double tolerance;              /* relative */
  double tolerance_displacement; /* m; NAN: automatic */
  double tolerance_velocity;     /* m/s; NAN: automatic */
  double viscosity;              /* s; ida: of massless points, over their stiffness */
  sdr_origin origin, step_origin;
} sdr_time_scene;

typedef struct {
  char name[SDR_NAME_MAX]; /* column prefix in history.csv */
  double at[3];            /* nearest point is taken */
  int field_count;
  char field[8][24]; /* "displacement", "velocity", "damage", "stress", ... */
  sdr_origin origin;
} sdr_probe;

typedef enum {
  SDR_MEASURE_VALUE,
  SDR_MEASURE_MEAN,
  SDR_MEASURE_MIN,
  SDR_MEASURE_MAX,
  SDR_MEASURE_SUM,
  SDR_MEASURE_L2_ERROR, /* relative to the norm of the exact values */
  SDR_MEASURE_MAX_ERROR /* absolute */
} sdr_measure_kind;

/* What a measured field should be: a formula, a series of formulas or a table. */
typedef struct {
  sdr_expression *formula; /* SI; NULL: a table, or nothing at all if rows is 0 too */
  int is_series;           /* the formula's sum over n = first .. last */
  int64_t first, last;
  char by;             /* table: along x, y, z, r or t, linear between rows */
  int rows;            /* >= 2; 0: no table */
  double *key, *value; /* SI; keys rise */
} sdr_exact;

/* A quantity to be measured, key `output.measures`: one number from the points of a place (or one
   point, or the body as a whole) at one instant or over a time. */
typedef struct {
  char name[SDR_NAME_MAX]; /* of the figure */
  sdr_measure_kind kind;
  char field[24];    /* of points; "": none */
  int component;     /* of the field, in the order of sdr_model_field; -1: length of the vector */
  char quantity[24]; /* of the whole body; "": none */
  char support[SDR_NAME_MAX]; /* quantity reaction: which support's */
  int at_point;               /* 1: the point nearest to `point`; 0: those of `on` */
  double point[3];
  sdr_place on;
  int over_time;      /* 1: from .. until, every so many steps; 0: at one instant */
  double from, until; /* s; +-INFINITY if not given */
  int64_t every;
  sdr_length at; /* s, or steps if relative; INFINITY: the end */
  sdr_exact exact;
  sdr_origin origin;
} sdr_measurement;

/* What is told of a crack that is followed; each is a figure TIP_WORD. */
typedef enum {
  SDR_CRACK_FIRST_TIME,      /* s: first damage beyond the notch */
  SDR_CRACK_START_TIME,      /* s: the tip has moved by `moved` */
  SDR_CRACK_MEAN_SPEED,      /* m/s, from there to the end, along the arm that got farthest */
  SDR_CRACK_MAX_SPEED,       /* m/s, the largest over the window, from there on */
  SDR_CRACK_RAYLEIGH_SHARE,  /* that over the speed of Rayleigh waves */
  SDR_CRACK_ANGLE,           /* rad, of the path against `direction` */
  SDR_CRACK_TIPS,            /* how many there are at `count_at` */
  SDR_CRACK_BRANCHES,        /* at the end */
  SDR_CRACK_BRANCH_TIME,     /* s, of the first branch */
  SDR_CRACK_BRANCH_X,        /* m */
  SDR_CRACK_BRANCH_Y,        /* m */
  SDR_CRACK_BRANCH_DISTANCE, /* m, from the notch's tip along the crack */
  SDR_CRACK_BRANCH_SPEED,    /* m/s, over the window */
  SDR_CRACK_LENGTH,          /* m, of all arms */
  SDR_CRACK_AREA,            /* m^2, from damage */
  SDR_CRACK_ENERGY,          /* J, dissipated within a horizon of the crack */
  SDR_CRACK_TOUGHNESS_SHARE, /* energy over area and toughness */
  SDR_CRACK_PATH_SHARE,      /* 2-D: energy over length, thickness and toughness */
  SDR_CRACK_FIGURES
} sdr_crack_figure;
extern const char *const sdr_crack_figure_words[]; /* ended by NULL */

/* A crack that is followed from the tip of its notch. */
typedef struct {
  char name[SDR_NAME_MAX];
  double start[3];     /* m, the notch's tip */
  double direction[3]; /* of the notch, a unit vector */
  sdr_length fit[2];   /* distances between which the angle is fitted; [1] INFINITY: the end */
  char figure[SDR_CRACK_FIGURES][SDR_NAME_MAX];
  sdr_origin origin;
} sdr_crack_tip;

/* Key `output.cracks`. Relative lengths are multiples of the largest spacing. */
typedef struct {
  double threshold;    /* damage of a point that a tip has passed; NAN: automatic */
  double every;        /* s between looks; NAN: automatic */
  double count_at;     /* s, when tips are counted; INFINITY: the end */
  sdr_length moved;    /* a tip has started when it is this far */
  sdr_length window;   /* along the path, of speeds */
  sdr_length shortest; /* that an arm must be to count */
  int tip_count;       /* 0: no crack is followed */
  sdr_crack_tip *tip;
} sdr_cracks_output;

/* A figure of the problem with its accepted range; the run fills in the value by name. */
typedef struct {
  char name[SDR_NAME_MAX];
  double low, high; /* NAN: open */
  double paper;     /* NAN: none */
  sdr_origin origin;
} sdr_figure;

typedef struct {
  char directory[512]; /* "" : out/<scene>[-variant] */
  int snapshots;       /* frames after the first, evenly spaced in time; 0: none at all */
  int field_count;
  char field[24][24];      /* what a frame holds */
  int history_every;       /* steps between rows of history.csv; default chosen as end/200;
                              0: as many as make about 200 rows (the step is automatic) */
  double checkpoint_every; /* s of simulated time; INFINITY: none */
  int probe_count;
  sdr_probe *probe;
  int measure_count;
  sdr_measurement *measure;
  sdr_cracks_output cracks;
  int fragments;             /* 1: count them at the end (default with a damage law) */
  double fragment_threshold; /* pairs with damage below this hold together; 0.5 */
  int ring;                  /* 1: count through-cracks around ring_centre (an annulus scene) */
  double ring_centre[3];
} sdr_output_scene;

/* ---- equations ------------------------------------------------------------------------------- */

/* What nonlocal operators solve instead of moving a body, key `equation` (scene/equation.h). */
typedef enum { SDR_POISSON, SDR_PLATE, SDR_ELASTICITY, SDR_GRADIENT_ELASTICITY } sdr_equation_kind;
enum { SDR_EQUATION_NUMBERS = 4, SDR_EQUATION_PLACES = 6, SDR_EQUATION_COARSER = 8 };

/* A condition on some places; later ones overwrite earlier ones where they meet. */
typedef struct {
  int condition; /* which of its kind */
  int place_count;
  sdr_place on[SDR_EQUATION_PLACES];
  int is_exact;             /* the value is that of the exact solution */
  sdr_expression *value[3]; /* SI; NULL: that component is left alone */
  sdr_origin origin;
} sdr_boundary;

typedef struct {
  sdr_equation_kind kind;
  int variational;   /* 0: collocation */
  int order;         /* of the operators */
  int nearest;       /* points in a support; 0: all within `radius` */
  sdr_length radius; /* relative: spacings */
  sdr_weight_function weight;
  int enlarge;     /* 1: supports of singular points grow; 0: they stop the run */
  double penalty;  /* of the operator energy, over the equation's own constant */
  char solver[16]; /* as in sdr_time_scene */
  double number[SDR_EQUATION_NUMBERS]; /* constants of the kind, SI */
  sdr_expression *source[3];           /* NULL: 0 */
  sdr_expression *exact[3];            /* NULL: not known */
  sdr_expression *exact_stress[6];     /* likewise, in the order of sdr_model_field */
  int boundary_count;
  sdr_boundary *boundary;
  int coarser_count;
  double coarser[SDR_EQUATION_COARSER]; /* m, falling: spacings that are solved before the body's */
  sdr_origin origin;
} sdr_equation;

typedef struct sdr_scene {
  char path[512];             /* the file read */
  char name[SDR_NAME_MAX];    /* folder under problems/ or file name without .yaml */
  char variant[SDR_NAME_MAX]; /* "" : none */
  char title[256];
  sdr_dimension dimension;
  int stateless; /* 1: `2d`, an equation in the plane that minds neither stress nor strain in z */
  sdr_points_scene points;
  sdr_expression *horizon; /* of x y z; multiples of the spacing if horizon_relative, else m; NULL:
                              each imported point has its own */
  int horizon_relative;
  sdr_origin horizon_origin;
  sdr_weight weight;  /* key `family: {weight: ...}` */
  int one_sided;      /* key `family: {dual: false}`: no dual horizon */
  sdr_border balance; /* key `family: {balance: ...}`: at the border of two spacings */
  sdr_calibration_kind calibration; /* key `family: {calibration: ...}` */
  sdr_model_kind model;
  sdr_elasticity elasticity;            /* key `material.elasticity`; nonordinary only */
  sdr_split split;                      /* key `damage.split`; state-based only */
  sdr_ordinary_form form;               /* key `material.form`; ordinary only */
  double control_shear, control_normal; /* Pa, key `material.control`; NAN: automatic */
  int material_count;                   /* >= 1 */
  sdr_material *material;
  sdr_damage_scene damage;
  sdr_contact_scene contact;
  int region_count;
  sdr_region *region;
  int crack_count;
  sdr_crack *crack;
  int initial_count;
  sdr_initial *initial;
  int load_count;
  sdr_load *load;
  int support_count;
  sdr_support_scene *support;
  sdr_time_scene time;
  sdr_equation *equation; /* NULL: a body in motion; else material, loads, time, ... are unread */
  sdr_output_scene output;
  int figure_count;
  sdr_figure *figure;
  int threads;     /* 0: all */
  int mixed;       /* precision: mixed */
  uint64_t hash;   /* FNV-1a over every key that affects the state, canonically written */
  char *used_yaml; /* the scene with every default filled in, as YAML text */
  int default_count;
  char **defaults;      /* "damage.ell = 1 horizon": what was defaulted, for `check` */
  const char *variants; /* names of all, ", " between; "": none */
  int idle_count;
  char **idle;             /* "time.safety: the integrator static does not use it": what the scene
                              says without effect */
  struct sdr_store *store; /* holds all that the scene points to */
} sdr_scene;

/* Read `path` (a file), merge `variant` (NULL or "": none) and then the `set_count` overrides
   "path=value" of --set into it, and check every key. SDR_BAD_INPUT: the message holds up to 20
   lines "file:line:column: what, allowed, how to mend". SDR_IO_ERROR: the file cannot be read.
   The caller destroys *out; it is written only on success. */
sdr_status sdr_scene_load(const char *path, const char *variant, int set_count,
                          const char *const *sets, sdr_scene **out);
/* The same of text in memory; `name` stands in messages and names the scene. */
sdr_status sdr_scene_parse(const char *text, const char *name, sdr_scene **out);
void sdr_scene_destroy(sdr_scene **scene); /* NULL-safe */

/* "file:line:column" of an origin, in a static thread-local buffer (valid until the 4th next call).
 */
const char *sdr_origin_text(sdr_origin origin);

static inline int sdr_components(sdr_dimension dimension)
{
  return dimension == SDR_1D ? 1 : dimension == SDR_3D ? 3 : 2;
}

#endif
