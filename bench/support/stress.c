#include "support/stress.h"

#include <math.h>

/* ---- a plate in motion ----------------------------------------------------------------------- */

static const char *const laws[] = {"none", "variational", "critical_stretch", "at1"};

/* 20 mm x 20 mm of something like steel: waves go at about 5.5 mm/us. */
static void plate(FILE *out, const char *model, const char *law, const char *points)
{
  fprintf(out,
          "dimension: plane_stress\n"
          "points: {shape: {box: {size: [20 mm, 20 mm]}}, spacing: 1 mm, align: cell%s}\n"
          "material: {%s, young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2}\n"
          "damage: {law: %s}\noutput: {snapshots: 0}\n",
          points, model, law);
}

/* The limit of this plate's step is 0.370 us (sunder check). */
static void step_over_limit(FILE *out, int variant, double level)
{
  plate(out, "model: bond_based", laws[variant], "");
  fprintf(out,
          "initial: {velocity: [\"5 m/s * sin(x*y/(20 mm^2))\", \"3 m/s * cos(7*x/(1 mm))\"]}\n"
          "time: {step: %.17g us, allow_unstable: true, end: 200 us}\n",
          0.36985 * level);
}

/* A plate that is stretched and bent by how it starts. */
static void moving_plate(FILE *out, const char *law)
{
  plate(out, "model: bond_based", law, "");
  fprintf(out, "initial: {velocity: [\"20 m/s * sin(x/(8 mm))\", \"15 m/s * y/(10 mm)\"]}\n");
}

static void long_steps(FILE *out, int variant, double level)
{
  static const char *const how[] = {"integrator: energy_momentum", "integrator: energy_momentum",
                                    "integrator: leapfrog, allow_unstable: true"};
  moving_plate(out, laws[variant == 1]);
  fprintf(out, "time: {%s, step: %.6g us, end: 100 us}\n", how[variant], 0.2 * level);
}

static void tolerances(FILE *out, int variant, double level)
{
  static const char *const how[] = {"cvode", "cvode, method: adams", "ida"};
  moving_plate(out, "variational");
  fprintf(out, "time: {integrator: %s, tolerance: %g, end: 20 us}\n", how[variant], level);
}

static const char *const strained[] = {"model: bond_based",
                                       "model: bond_based",
                                       "model: bond_based",
                                       "model: ordinary, poisson: 0.3",
                                       "model: nonordinary, poisson: 0.3",
                                       "model: nonordinary, elasticity: neo_hookean, poisson: 0.3"};

/* At -1 the two ends of every bond along x lie in one place; below, bonds are turned round. */
static void strains(FILE *out, int variant, double level)
{
  plate(out, strained[variant], laws[variant < 3 ? variant : 0], "");
  fprintf(out,
          "initial: {displacement: [\"%.17g * x\", 0]}\n"
          "time: {step: auto, safety: 0.3, end: 5 us}\n",
          level);
}

/* ---- patches at rest ------------------------------------------------------------------------- */

/* A plate whose frame is moved by a uniform strain: the inside should follow. */
static void patch(FILE *out, const char *points, const char *rest)
{
  fprintf(out,
          "dimension: plane_stress\n"
          "regions: {plate: {box: {size: [40 mm, 40 mm]}}, frame: {difference: [plate, {box: "
          "{size: [26 mm, 26 mm]}}]}}\n"
          "points: {shape: plate, align: cell, %s}\n"
          "supports: [{on: frame, displacement: [\"1e-4*x\", \"-3e-5*y + 5e-5*x\"]}]\n"
          "time: {integrator: static}\n%s"
          "output: {snapshots: 0, measures: {err: {kind: l2_error, field: displacement, "
          "component: x, exact: \"1e-4*x\"}}}\n",
          points, rest);
}

static const char *const patched[] = {
    "material: {young: 210 GPa, density: 7850 kg/m^3}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3}\nfamily: {weight: surface_iso}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3, model: ordinary, poisson: 0.3}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3, model: nonordinary, poisson: 0.3}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3}\nfamily: {dual: false}\n"};

static void jitter(FILE *out, int variant, double level)
{
  char points[100];
  snprintf(points, sizeof points, "spacing: 1 mm, jitter: {share: %g, seed: 3}", level);
  patch(out, points, patched[variant]);
}

static void jumps(FILE *out, int variant, double level)
{
  static const int material[] = {0, 1, 3, 4};
  char points[200];
  snprintf(points, sizeof points,
           "spacing: 2 mm, refine: [{where: {box: {size: [6 mm, 6 mm]}}, spacing: %.17g mm}]",
           2.0 / level);
  patch(out, level > 1.0 ? points : "spacing: 2 mm", patched[material[variant]]);
}

static void horizons(FILE *out, int variant, double level)
{
  char rest[300];
  snprintf(rest, sizeof rest, "%shorizon: %g spacing\n", patched[variant], level);
  patch(out, "spacing: 1 mm", rest);
}

/* A few rows of points: with one, no family of a plane body tells strain across. */
static void rows(FILE *out, int variant, double level)
{
  if (variant < 3) {
    fprintf(out,
            "dimension: plane_stress\n"
            "points: {shape: {box: {from: [-20 mm, 0], to: [20 mm, %g mm]}}, spacing: 1 mm, align: "
            "cell}\n%s"
            "supports: [{on: left, depth: 3 spacing, displacement: [0, null]}, {on: {box: {from: "
            "[-21 mm, 0], to: [-17 mm, 1 mm]}}, displacement: [null, 0]}]\n"
            "loads: [{traction: {on: right, value: [1 MPa, 0], spread: layer}}]\n"
            "time: {integrator: static}\n"
            "output: {snapshots: 0, measures: {err: {kind: l2_error, field: displacement, "
            "component: x, on: {box: {from: [-10 mm, -20 mm], to: [10 mm, 20 mm]}}, "
            "exact: \"1e6/210e9*(x + 20 mm - 2.5 mm)\"}}}\n",
            level, patched[variant + 1]);
    return;
  }
  fprintf(out,
          "dimension: 2d\n"
          "regions: {strip: {box: {from: [0, 0], to: [20 mm, %g mm]}}, edge: {difference: [strip, "
          "{box: {from: [1 mm, 0.9 mm], to: [19 mm, %g mm]}}]}}\n"
          "points: {shape: strip, spacing: 1 mm, align: cell}\n"
          "equation: {kind: poisson, form: collocation, order: 2, support: {neighbours: 14},\n"
          "  source: 0, exact: x/(1 mm), boundary: [{on: edge, value: "
          "x/(1 mm)}]}\n",
          level, fmax(level - 0.9, 1.0));
}

/* ---- a bar of two halves --------------------------------------------------------------------- */

static void contrast_at_rest(FILE *out, int variant, double level)
{
  static const char *const solvers[] = {"cholmod", "umfpack", "pcg"};
  fprintf(
      out,
      "dimension: 1d\n"
      "points: {shape: {interval: {from: 0, to: 1 m}}, spacing: 1 cm, align: cell}\n"
      "materials:\n  - {young: 1 GPa, density: 1000 kg/m^3}\n"
      "  - {name: hard, where: {interval: {from: 0.5 m, to: 1 m}}, young: %.17g GPa, "
      "density: 1000 kg/m^3}\n"
      "supports: [{on: left, depth: 3 spacing, displacement: [0]}]\n"
      "loads: [{traction: {on: right, value: [1 kPa], spread: layer}}]\n"
      "time: {integrator: static, solver: %s}\n"
      "output: {snapshots: 0, measures: {err: {kind: l2_error, field: displacement, "
      "component: x, on: {interval: {from: 0.1 m, to: 0.4 m}}, exact: \"1e-6*(x - 25 mm)\"}}}\n",
      level, solvers[variant]);
}

/* 2000 steps of the half that is faster. */
static void contrast_in_motion(FILE *out, int variant, double level)
{
  const double stiff = variant == 0 ? level : 1.0, heavy = variant == 1 ? level : 1.0;
  const double fastest = sqrt(fmax(1.0, stiff)) * 1000.0;
  fprintf(out,
          "dimension: 1d\n"
          "points: {shape: {interval: {from: 0, to: 1 m}}, spacing: 1 cm, align: cell}\n"
          "materials:\n  - {young: 1 GPa, density: 1000 kg/m^3}\n"
          "  - {name: other, where: {interval: {from: 0.5 m, to: 1 m}}, young: %.17g GPa, "
          "density: %.17g kg/m^3}\n"
          "initial: {velocity: [\"1 m/s * exp(-((x - 0.3 m)/(0.1 m))^2)\"]}\n"
          "time: {end: %.17g s}\noutput: {snapshots: 0}\n",
          stiff, 1000.0 * heavy, 2000.0 * 0.01 / fastest);
}

/* ---- the cylinder ---------------------------------------------------------------------------- */

/* lengths, times and masses in other units; its centre at `away` (of the length). */
typedef struct {
  double length, time, mass, away, pressure, toughness;
  const char *law, *ell;
} ring;

static const ring as_is = {1.0, 1.0, 1.0, 0.0, 1.0, 1.0, "variational", "1 horizon"};

static void put_ring(FILE *out, const ring *r)
{
  const double stress = r->mass / (r->length * r->time * r->time), l = r->length;
  fprintf(out,
          "dimension: plane_stress\n"
          "points: {shape: {annulus: {inner: %.17g, outer: %.17g, centre: [%.17g, 0]}}, spacing: "
          "%.17g, origin: [%.17g, 0], thickness: %.17g}\n",
          0.081 * l, 0.149 * l, r->away * l, 0.006 * l, r->away * l, l);
  fprintf(out,
          "material: {young: %.17g, density: %.17g, toughness: %.17g}\n"
          "damage: {law: %s%s%s}\n"
          "loads: [{pressure: {on: inner, value: \"%.17g Pa*exp(-t/(%.17g s))\", ramp: %.17g}}]\n"
          "time: {step: %.17g, end: %.17g}\noutput: {snapshots: 0}\n",
          210e9 * stress, 7850.0 * r->mass / (l * l * l),
          2e4 * r->toughness * r->mass / (r->time * r->time), r->law,
          r->ell && *r->ell ? ", ell: " : "", r->ell ? r->ell : "", 4e8 * r->pressure * stress,
          1e-4 * r->time, 1e-5 * r->time, 0.8e-6 * r->time, 80e-6 * r->time);
}

/* With ell for the laws that have one: variational and at1. */
static ring ring_of(int law)
{
  ring r = as_is;
  r.law = laws[law];
  if (law % 2 == 0) r.ell = "";
  return r;
}

static void pressures(FILE *out, int variant, double level)
{
  ring r = ring_of(variant);
  r.pressure = level;
  put_ring(out, &r);
}

static void toughnesses(FILE *out, int variant, double level)
{
  ring r = ring_of(variant + 1);
  r.toughness = level;
  put_ring(out, &r);
}

static void lengths(FILE *out, int variant, double level)
{
  char ell[40];
  ring r = as_is;
  snprintf(ell, sizeof ell, "%g horizon", level);
  r.law = variant == 0 ? "variational" : "at1";
  r.ell = ell;
  put_ring(out, &r);
}

static void units(FILE *out, int variant, double level)
{
  ring r = as_is;
  *(variant == 0 ? &r.length : variant == 1 ? &r.time : &r.mass) = level;
  put_ring(out, &r);
}

static void offsets(FILE *out, int variant, double level)
{
  ring r = ring_of(variant);
  r.away = level;
  put_ring(out, &r);
}

/* ---- long runs ------------------------------------------------------------------------------- */

/* A disc of 49 points, spinning 1000 steps a turn. */
static void turns(FILE *out, int variant, double level)
{
  const double spin = 2.0 * acos(-1.0) * 1e-3 / 0.1e-6;
  (void)variant;
  fprintf(out,
          "dimension: plane_stress\n"
          "points: {shape: {disc: {radius: 4 mm}}, spacing: 1 mm}\n"
          "material: {young: 210 GPa, density: 7850 kg/m^3}\n"
          "initial: {velocity: [\"%.17g/s*(-y)\", \"%.17g/s*x\"]}\n"
          "time: {step: 0.1 us, end: %.17g s}\noutput: {snapshots: 0}\n",
          spin, spin, level * 1e-4);
}

static void vibration(FILE *out, int variant, double level)
{
  static const char *const precision[] = {"double", "mixed"};
  fprintf(out,
          "dimension: 1d\n"
          "points: {shape: {interval: {from: 0, to: 1 m}}, spacing: 2.5 cm, align: cell}\n"
          "material: {young: 1 GPa, density: 1000 kg/m^3}\nprecision: %s\n"
          "initial: {displacement: [\"1 mm * sin(pi*(x/(1 m) - 0.5))\"]}\n"
          "time: {step: 10 us, end: %.17g s}\noutput: {snapshots: 0}\n",
          precision[variant], level * 1e-5);
}

/* Nothing but numbers too small for their exponent, from some size on. */
static void denormals(FILE *out, int variant, double level)
{
  fprintf(out,
          "dimension: plane_stress\n"
          "points: {shape: {box: {size: [100 mm, 100 mm]}}, spacing: 1 mm, align: cell}\n"
          "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2}\n"
          "damage: {law: %s}\nthreads: 1\n"
          "initial: {velocity: [\"%.17g*1 m/s * cos(x/(3 mm))\", 0]}\n"
          "time: {step: 0.1 us, end: 20 us}\noutput: {snapshots: 0}\n",
          laws[variant], level);
}

const stress_sweep stress_sweeps[] = {
    {"step",
     "step over the stability limit, leapfrog",
     "share of the limit",
     STRESS_IMBALANCE,
     0.02,
     0,
     {"elastic", "variational", "critical stretch"},
     8,
     {0.5, 0.8, 0.95, 0.99, 1.0, 1.01, 1.05, 1.2},
     step_over_limit},
    {"long_steps",
     "long steps",
     "step over 0.2 us",
     STRESS_IMBALANCE,
     1e-6,
     0,
     {"energy momentum, elastic", "energy momentum, variational", "leapfrog, elastic"},
     5,
     {0.5, 2, 8, 32, 125},
     long_steps},
    {"tolerance",
     "tolerance of methods that choose steps",
     "tolerance",
     STRESS_IMBALANCE,
     1e-3,
     0,
     {"cvode bdf", "cvode adams", "ida"},
     5,
     {1e-2, 1e-4, 1e-6, 1e-8, 1e-10},
     tolerances},
    {"strain",
     "strain at the start; -1: bonds of length zero",
     "strain",
     STRESS_IMBALANCE,
     0.02,
     0,
     {"bond-based", "variational", "critical stretch", "ordinary", "non-ordinary", "neo-Hookean"},
     8,
     {0.01, 0.1, 0.5, 1.0, -0.1, -0.5, -1.0, -1.5},
     strains},
    {"jitter",
     "points moved at random, uniform strain",
     "share of the spacing",
     STRESS_EXACT,
     0.01,
     0,
     {"bond-based", "surface_iso", "ordinary", "non-ordinary"},
     7,
     {0, 0.01, 0.05, 0.1, 0.2, 0.3, 0.45},
     jitter},
    {"jump",
     "horizons that differ, uniform strain",
     "coarse over fine",
     STRESS_EXACT,
     0.01,
     0,
     {"bond-based", "surface_iso", "non-ordinary", "without dual horizon"},
     5,
     {1, 2, 4, 8, 16},
     jumps},
    {"horizon",
     "horizon over spacing, uniform strain",
     "m",
     STRESS_EXACT,
     0.01,
     0,
     {"bond-based", "surface_iso", "ordinary", "non-ordinary"},
     7,
     {1.5, 2.015, 2.5, 3.015, 4.015, 5.015, 6},
     horizons},
    {"rows",
     "bodies a few rows thick",
     "rows",
     STRESS_EXACT,
     0.05,
     0,
     {"surface_iso", "ordinary", "non-ordinary", "Poisson, n = 2"},
     6,
     {1, 2, 3, 4, 6, 8},
     rows},
    {"contrast",
     "stiffness contrast at rest",
     "stiff over soft",
     STRESS_EXACT,
     0.02,
     0,
     {"cholmod", "umfpack", "pcg"},
     6,
     {1, 10, 1e3, 1e5, 1e7, 1e9},
     contrast_at_rest},
    {"contrast_motion",
     "contrast in motion, leapfrog",
     "ratio",
     STRESS_IMBALANCE,
     0.02,
     0,
     {"stiffness", "density"},
     6,
     {1, 10, 1e3, 1e5, 1e7, 1e9},
     contrast_in_motion},
    {"pressure",
     "cylinder, pressure times",
     "factor",
     STRESS_END,
     0.01,
     0,
     {"elastic", "variational", "critical stretch", "at1"},
     6,
     {0.1, 1, 3, 10, 30, 100},
     pressures},
    {"toughness",
     "cylinder, toughness times",
     "factor",
     STRESS_END,
     0.01,
     0,
     {"variational", "critical stretch", "at1"},
     8,
     {1e-300, 1e-20, 1e-6, 1e-2, 1, 1e2, 1e20, 1e290},
     toughnesses},
    {"ell",
     "cylinder, ell over the horizon",
     "ell/horizon",
     STRESS_END,
     0.01,
     0,
     {"variational", "at1"},
     7,
     {0.1, 0.3, 1, 3, 10, 30, 100},
     lengths},
    {"units",
     "cylinder in other units",
     "unit",
     STRESS_SAME,
     1e-10,
     2,
     {"length", "time", "mass"},
     5,
     {1e-12, 1e-6, 1, 1e6, 1e12},
     units},
    {"offset",
     "cylinder far from the origin",
     "distance, m",
     STRESS_SAME,
     1e-6,
     0,
     {"elastic", "variational", "critical stretch"},
     7,
     {0, 1, 1e2, 1e4, 1e6, 1e8, 1e12},
     offsets},
    {"turns",
     "disc that spins",
     "turns",
     STRESS_IMBALANCE,
     1e-2,
     0,
     {"leapfrog"},
     4,
     {1, 10, 100, 1000},
     turns},
    {"vibration",
     "free vibration: drift in a million steps",
     "steps",
     STRESS_DRIFT,
     1e-5,
     0,
     {"leapfrog", "leapfrog, mixed"},
     4,
     {1e3, 1e4, 1e5, 1e6},
     vibration},
    {"denormals",
     "size of the motion: cost",
     "m/s",
     STRESS_COST,
     0.25,
     0,
     {"elastic", "variational"},
     6,
     {1, 1e-100, 1e-160, 1e-290, 1e-300, 1e-307},
     denormals},
};
const int stress_sweep_count = sizeof stress_sweeps / sizeof *stress_sweeps;
