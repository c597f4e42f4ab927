/* how far step and lattice orientation move the thick cylinder's damage, for both damage laws */
#include "app/find_scene.h"
#include "app/plot_gnuplot.h"
#include "app/run.h"
#include "app/rundata.h"
#include "base/memory.h"
#include "support/report.h"

#include <math.h>
#include <string.h>

/* Both laws at two separation energies. At each of them a surface takes the same energy in both. */
typedef struct {
  const char *name, *variant, *colour;
  int kilojoule; /* separation energy per m^2 */
} law;

enum { LAWS = 4, STEPS = 3, RUNS = 6, OTHER_MODULI = RUNS - 1, EARLY_US = 50, SECTORS = 3 };

static const law laws[LAWS] = {
    {"variational, ell = 2 horizon", NULL, "#0072b2", 10},
    {"critical stretch, Gc/2", "critical_stretch_half", "#d55e00", 10},
    {"variational, ell = horizon", "ell_delta", "#0072b2", 20},
    {"critical stretch, Gc", "critical_stretch", "#d55e00", 20},
};

/* The runs of a law. Turning the lattice of a ring turns the whole problem and its answer, but for
   how the load's pieces fall on points; what orientation does shows within one ring, where the hoop
   stress meets the lattice at every angle. The last run has other random moduli: how far chance
   alone moves a result. */
typedef struct {
  double step;  /* us */
  double angle; /* degrees */
  int seed;
} setting;

static const setting settings[RUNS] = {{0.1, 0.0, 1},  {0.05, 0.0, 1}, {0.025, 0.0, 1},
                                       {0.1, 22.5, 1}, {0.1, 45.0, 1}, {0.1, 0.0, 2}};

/* rms, most: difference of the damage fields from the run with half the step (from the first run
   for the other seed) early and at the end; NAN where there is no such run.
   sector: dissipated energy per volume over the ring's mean where the radius lies within 0-15,
   15-30 and 30-45 degrees of a lattice axis. */
typedef struct {
  sdr_rundata *data;
  double onset, dissipated, imbalance, worst_imbalance, cracks, fragments, damage;
  double rms_early, rms, most, sector[SECTORS];
} outcome;

typedef struct {
  const char *spacing;
  char directory[BENCH_PATH];
  outcome outcome[LAWS][RUNS];
} study;

/* ---- running --------------------------------------------------------------------------------- */

static sdr_status run_scene(const study *s, const law *l, const setting *how, const char *directory)
{
  char path[SDR_SCENE_PATH], step[64], angle[64], seed[64], spacing[64];
  SDR_TRY(sdr_find_scene("thick_cylinder", path));
  snprintf(step, sizeof step, "time.step=%g us", how->step);
  snprintf(angle, sizeof angle, "points.angle=%g deg", how->angle);
  snprintf(seed, sizeof seed, "material.scatter.seed=%d", how->seed);
  snprintf(spacing, sizeof spacing, "points.spacing=%s", s->spacing);
  const char *sets[] = {
      step, angle, seed, spacing, "output.snapshots=20", "output.fields=[damage, dissipated]"};
  const sdr_run_options options = {.scene = path,
                                   .variant = l->variant,
                                   .directory = directory,
                                   .set_count = 6,
                                   .sets = sets,
                                   .quiet = 1};
  FILE *silent = fopen("/dev/null", "w");
  const sdr_status status = sdr_run(&options, silent ? silent : stderr);
  if (silent) fclose(silent);
  return status;
}

static sdr_status take(const study *s, int l, int r, outcome *out)
{
  char directory[2 * BENCH_PATH];
  snprintf(directory, sizeof directory, "%s/%s-%d", s->directory,
           laws[l].variant ? laws[l].variant : "ell_2delta", r);
  fprintf(stderr, "%-30s step %-5g us, lattice %4g deg, seed %d ... ", laws[l].name,
          settings[r].step, settings[r].angle, settings[r].seed);
  const double from = bench_clock();
  SDR_TRY(run_scene(s, &laws[l], &settings[r], directory));
  fprintf(stderr, "%.1f s\n", bench_clock() - from);
  SDR_TRY(sdr_rundata_open(directory, &out->data));
  out->onset = sdr_rundata_number(out->data, "damage.onset_time") * 1e6;
  out->dissipated = sdr_rundata_number(out->data, "energy.dissipated");
  out->imbalance = sdr_rundata_number(out->data, "energy.imbalance_relative");
  out->worst_imbalance = sdr_rundata_number(out->data, "energy.imbalance_largest");
  out->cracks = sdr_rundata_number(out->data, "figures.through_cracks.value");
  out->fragments = sdr_rundata_number(out->data, "fragments.count");
  out->damage = sdr_rundata_number(out->data, "damage.mean");
  out->rms = out->rms_early = out->most = (double)NAN;
  return SDR_OK;
}

/* Root mean square and largest difference of the damage of the same points at time t (s). */
static sdr_status difference(const sdr_rundata *a, const sdr_rundata *b, double t, double *rms,
                             double *most)
{
  float *da = NULL, *db = NULL;
  int components;
  sdr_status status = SDR_OK;
  if (a->point_count != b->point_count)
    status =
        sdr_fail(SDR_RUN_FAILED, "%s and %s differ in their points", a->directory, b->directory);
  if (status == SDR_OK)
    status = sdr_rundata_field(a, sdr_rundata_nearest(a, t), "damage", &da, &components);
  if (status == SDR_OK)
    status = sdr_rundata_field(b, sdr_rundata_nearest(b, t), "damage", &db, &components);
  double sum = 0.0, largest = 0.0;
  for (int32_t i = 0; status == SDR_OK && i < a->point_count; ++i) {
    const double d = (double)da[i] - (double)db[i];
    sum += d * d;
    largest = fmax(largest, fabs(d));
  }
  if (status == SDR_OK) {
    *rms = sqrt(sum / a->point_count);
    *most = largest;
  }
  sdr_free(da);
  sdr_free(db);
  return status;
}

/* Angle (degrees, 0..45) between the radius at x, y and the nearest axis of a lattice turned by
   `turned` degrees. */
static double to_axis(double x, double y, double turned)
{
  const double angle = fmod(atan2(y, x) * 180.0 / acos(-1.0) - turned + 720.0, 90.0);
  return angle < 45.0 ? angle : 90.0 - angle;
}

static sdr_status by_sector(const setting *how, outcome *o)
{
  const sdr_rundata *data = o->data;
  float *density = NULL;
  int components;
  SDR_TRY(sdr_rundata_field(data, data->frame_count - 1, "dissipated", &density, &components));
  double sum[SECTORS] = {0.0}, points[SECTORS] = {0.0}, mean = 0.0;
  for (int32_t i = 0; i < data->point_count; ++i) {
    const double angle = to_axis(data->position[0][i], data->position[1][i], how->angle);
    const int k = angle < 15.0 ? 0 : angle < 30.0 ? 1 : 2;
    sum[k] += (double)density[i];
    points[k] += 1.0;
    mean += (double)density[i] / data->point_count;
  }
  for (int k = 0; k < SECTORS; ++k) o->sector[k] = sum[k] / (points[k] * mean);
  sdr_free(density);
  return SDR_OK;
}

/* The run that run r is compared with point by point; -1: none. */
static int partner(int r)
{
  if (r < STEPS - 1) return r + 1;
  return r == OTHER_MODULI ? 0 : -1;
}

static sdr_status run_all(study *s)
{
  for (int l = 0; l < LAWS; ++l) {
    outcome *o = s->outcome[l];
    for (int r = 0; r < RUNS; ++r) {
      SDR_TRY(take(s, l, r, &o[r]));
      SDR_TRY(by_sector(&settings[r], &o[r]));
    }
    for (int r = 0; r < RUNS; ++r) {
      if (partner(r) < 0) continue;
      const sdr_rundata *a = o[r].data, *b = o[partner(r)].data;
      SDR_TRY(difference(a, b, EARLY_US * 1e-6, &o[r].rms_early, &o[r].most));
      SDR_TRY(difference(a, b, 1.0, &o[r].rms, &o[r].most));
    }
  }
  return SDR_OK;
}

/* ---- figures of a law ------------------------------------------------------------------------ */

/* (largest - smallest)/mean of the dissipated energy over some runs of a law. */
static double spread(const outcome *o, const int *runs, int count)
{
  double low = (double)INFINITY, high = 0.0, mean = 0.0;
  for (int k = 0; k < count; ++k) {
    low = fmin(low, o[runs[k]].dissipated);
    high = fmax(high, o[runs[k]].dissipated);
    mean += o[runs[k]].dissipated / count;
  }
  return mean > 0.0 ? (high - low) / mean : 0.0;
}

static double spread_by_step(const outcome *o)
{
  return spread(o, (const int[]){0, 1, 2}, 3);
}

/* Largest minus smallest share of a sector, over three rings whose cracks chance has placed
   differently. */
static double spread_by_sector(const outcome *o)
{
  double low = (double)INFINITY, high = 0.0;
  for (int k = 0; k < SECTORS; ++k) {
    const double share = (o[0].sector[k] + o[3].sector[k] + o[OTHER_MODULI].sector[k]) / 3.0;
    low = fmin(low, share);
    high = fmax(high, share);
  }
  return high - low;
}

static double spread_by_seed(const outcome *o)
{
  return spread(o, (const int[]){0, OTHER_MODULI}, 2);
}

/* Ratio of the differences between steps h, h/2 and h/2, h/4, as an order of convergence. */
static double order(double coarse, double fine)
{
  return coarse > 0.0 && fine > 0.0 ? log2(coarse / fine) : (double)NAN;
}

/* ---- table ----------------------------------------------------------------------------------- */

static void number(FILE *out, const char *format, int width, double value)
{
  if (isnan(value))
    fprintf(out, "%*s", width, "-");
  else
    fprintf(out, format, width, value);
}

static void print_row(FILE *out, const setting *how, const outcome *o)
{
  fprintf(out, "  %-6g %7g %5d", how->step, how->angle, how->seed);
  number(out, "%*.1f", 8, o->onset);
  number(out, "%*.0f", 11, o->dissipated);
  number(out, "%*.1e", 11, o->imbalance);
  number(out, "%*.0f", 8, o->cracks);
  number(out, "%*.0f", 8, o->fragments);
  number(out, "%*.4f", 9, o->damage);
  number(out, "%*.5f", 10, o->rms_early);
  number(out, "%*.5f", 9, o->rms);
  number(out, "%*.3f", 7, o->most);
  for (int k = 0; k < SECTORS; ++k) number(out, "%*.2f", k ? 6 : 9, o->sector[k]);
  fputc('\n', out);
}

static void print_table(const study *s, FILE *out)
{
  fprintf(
      out,
      "\nThick cylinder, spacing %s, to 100 us\n"
      "RMS, max: difference of the damage fields from the run with half the step; for seed 2\n"
      "(other random moduli) from that with seed 1. By angle: dissipated energy per volume over\n"
      "the ring's mean, where the radius lies 0-15, 15-30, 30-45 degrees off a lattice axis.\n",
      s->spacing);
  for (int l = 0; l < LAWS; ++l) {
    fprintf(out, "\n%s: a surface takes %d kJ/m^2\n", laws[l].name, laws[l].kilojoule);
    fputs("  step   lattice  seed   onset dissipated  imbalance through  pieces     mean"
          "    RMS at   RMS at    max  by angle to lattice\n"
          "  us     turned             us          J     at end  cracks           damage"
          "     50 us   100 us             0-    15-   30-45\n",
          out);
    for (int r = 0; r < RUNS; ++r) print_row(out, &settings[r], &s->outcome[l][r]);
  }
}

/* ---- conclusion ------------------------------------------------------------------------------ */

/* The law whose figure is below two thirds of the other's, if there is one. */
static const char *smaller(double variational, double critical)
{
  if (variational < 0.667 * critical) return "the variational law";
  if (critical < 0.667 * variational) return "critical stretch";
  return "neither law clearly";
}

static void conclude_pair(const study *s, int l, FILE *out)
{
  const outcome *v = s->outcome[l], *c = s->outcome[l + 1];
  fprintf(out, "At %d kJ/m^2 (variational | critical stretch):\n", laws[l].kilojoule);
  fprintf(out,
          "  step: %s depends less on it. RMS difference of damage, 0.05 to 0.025 us: %.5f | %.5f\n"
          "        at %d us, %.4f | %.4f at the end, where other moduli make %.4f | %.4f;\n",
          smaller(v[1].rms, c[1].rms), v[1].rms_early, c[1].rms_early, EARLY_US, v[1].rms, c[1].rms,
          v[OTHER_MODULI].rms, c[OTHER_MODULI].rms);
  fprintf(out,
          "        order of that difference at %d us: %.1f | %.1f; dissipated energy moves by"
          " %.2f | %.2f %%;\n        imbalance at the end: %.1e | %.1e at 0.1 us, %.1e | %.1e"
          " at 0.025 us.\n",
          EARLY_US, order(v[0].rms_early, v[1].rms_early), order(c[0].rms_early, c[1].rms_early),
          100.0 * spread_by_step(v), 100.0 * spread_by_step(c), fabs(v[0].imbalance),
          fabs(c[0].imbalance), fabs(v[2].imbalance), fabs(c[2].imbalance));
  fprintf(
      out,
      "  orientation: %s depends less on it. Dissipated energy by angle to the lattice differs\n"
      "        by %.0f | %.0f %% of its mean; with other random moduli its total moves by"
      " %.1f | %.1f %%.\n",
      smaller(spread_by_sector(v), spread_by_sector(c)), 100.0 * spread_by_sector(v),
      100.0 * spread_by_sector(c), 100.0 * spread_by_seed(v), 100.0 * spread_by_seed(c));
}

static void conclude(const study *s, FILE *out)
{
  fputs("\nConclusion\n", out);
  for (int l = 0; l < LAWS; l += 2) conclude_pair(s, l, out);
}

static sdr_status write_csv(const study *s)
{
  FILE *csv;
  SDR_TRY(bench_csv(s->directory, "step_study", &csv));
  fputs("law,separation_energy,spacing,step_us,angle,seed,onset_us,dissipated,imbalance_relative,"
        "imbalance_largest,through_cracks,fragments,mean_damage,rms_early,rms_end,max_end,"
        "sector_0,sector_15,sector_30\n",
        csv);
  for (int l = 0; l < LAWS; ++l)
    for (int r = 0; r < RUNS; ++r) {
      const outcome *o = &s->outcome[l][r];
      fprintf(csv,
              "\"%s\",%d,%s,%g,%g,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,"
              "%.5f,%.5f,%.5f\n",
              laws[l].name, laws[l].kilojoule * 1000, s->spacing, settings[r].step,
              settings[r].angle, settings[r].seed, o->onset, o->dissipated, o->imbalance,
              o->worst_imbalance, o->cracks, o->fragments, o->damage, o->rms_early, o->rms, o->most,
              o->sector[0], o->sector[1], o->sector[2]);
    }
  return fclose(csv) == 0 ? SDR_OK : sdr_fail(SDR_IO_ERROR, "%s: disk full", s->directory);
}

/* ---- picture --------------------------------------------------------------------------------- */

/* Data block $dLR: RMS difference of run r of law l from its partner over time (us). */
static sdr_status put_differences(FILE *script, const outcome *o, int l, int r)
{
  fprintf(script, "$d%d%d << E\n", l, r);
  const sdr_rundata *a = o[r].data, *b = o[partner(r)].data;
  for (int k = 0; k < a->frame_count; ++k) {
    double rms, most;
    SDR_TRY(difference(a, b, a->frame_time[k], &rms, &most));
    if (rms > 0.0) fprintf(script, "%g %g\n", a->frame_time[k] * 1e6, rms);
  }
  fputs("E\n", script);
  return SDR_OK;
}

/* Data block $eLR: dissipated energy (kJ) over time (us). */
static void put_dissipated(FILE *script, const outcome *o, int l, int r)
{
  const double *time = sdr_rundata_column(o[r].data, "time");
  const double *energy = sdr_rundata_column(o[r].data, "dissipated");
  const int rows = time && energy ? o[r].data->history.row_count : 0;
  fprintf(script, "$e%d%d << E\n0 0\n", l, r);
  for (int k = 0; k < rows; ++k) fprintf(script, "%g %g\n", time[k] * 1e6, energy[k] * 1e-3);
  fputs("E\n", script);
}

static void draw_differences(FILE *script, int pair)
{
  fprintf(script,
          "set title 'RMS difference of damage, %d kJ/m²'\nset logscale y\nset format y '%%.0e'\n"
          "set yrange [1e-7:1]\nset key bottom right\nplot ",
          laws[pair].kilojoule);
  for (int l = pair; l < pair + 2; ++l)
    fprintf(script,
            "$d%d0 w l lw 1.5 dt 2 lc '%s' t '%s: 0.1 - 0.05 µs', "
            "$d%d1 w l lw 2 lc '%s' t '0.05 - 0.025 µs', "
            "$d%d5 w l lw 1.5 dt 3 lc '%s' t 'other moduli', ",
            l, laws[l].colour, laws[l].name, l, laws[l].colour, l, laws[l].colour);
  fputs("\nunset logscale y\nset format y '%g'\n", script);
}

static void draw_dissipated(FILE *script, int pair)
{
  fprintf(script,
          "set title 'dissipated energy (kJ), %d kJ/m²'\nset yrange [0:*]\nset key top left\nplot ",
          laws[pair].kilojoule);
  for (int l = pair; l < pair + 2; ++l)
    fprintf(script,
            "$e%d0 w l lw 1.5 dt 2 lc '%s' t '%s: 0.1 µs', "
            "$e%d1 w l lw 1.5 dt 4 lc '%s' t '0.05 µs', "
            "$e%d2 w l lw 2 lc '%s' t '0.025 µs', "
            "$e%d5 w l lw 1.5 dt 3 lc '%s' t '0.1 µs, other moduli', ",
            l, laws[l].colour, laws[l].name, l, laws[l].colour, l, laws[l].colour, l,
            laws[l].colour);
  fputc('\n', script);
}

static sdr_status draw(const study *s)
{
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 1600, 1200, 20.0));
  FILE *script = picture.script;
  sdr_status status = SDR_OK;
  for (int l = 0; l < LAWS; ++l)
    for (int r = 0; r < RUNS && status == SDR_OK; ++r) {
      if (partner(r) >= 0) status = put_differences(script, s->outcome[l], l, r);
      put_dissipated(script, s->outcome[l], l, r);
    }
  if (status != SDR_OK) {
    sdr_picture_drop(&picture);
    return status;
  }
  fputs("set tics nomirror\nset xtics 20\nset ytics\nset grid lc '#e0e0e0'\nset border 3\n"
        "set xrange [0:100]\nset key samplen 2 font ',11'\nset size 0.5,0.5\n",
        script);
  for (int pair = 0; pair < LAWS; pair += 2) {
    fprintf(script, "set xlabel 'time (µs)'\nset origin %g,0.5\n", pair / 4.0);
    draw_differences(script, pair);
    fprintf(script, "set origin %g,0\n", pair / 4.0);
    draw_dissipated(script, pair);
  }
  snprintf(path, sizeof path, "%s/step_study.png", s->directory);
  return sdr_picture_end(&picture, path);
}

/* ---- main ------------------------------------------------------------------------------------ */

static sdr_status report(const study *s)
{
  print_table(s, stdout);
  conclude(s, stdout);
  SDR_TRY(write_csv(s));
  SDR_TRY(draw(s));
  printf("\n%s\n%s/step_study.csv\n%s/step_study.png\n", bench_origin(), s->directory,
         s->directory);
  return SDR_OK;
}

int main(int count, char **words)
{
  static study s = {.spacing = "1 mm"};
  if (count == 2 && strcmp(words[1], "--full") == 0)
    s.spacing = "0.5 mm";
  else if (count > 1) {
    fputs("usage: bench_step_study [--full]\n"
          "--full: spacing 0.5 mm (minutes) instead of 1 mm\n",
          stderr);
    return SDR_BAD_INPUT;
  }
  sdr_status status = bench_directory("step_study", s.directory);
  if (status == SDR_OK) status = run_all(&s);
  if (status == SDR_OK) status = report(&s);
  if (status != SDR_OK) fprintf(stderr, "step_study: %s\n", sdr_error_message());
  for (int l = 0; l < LAWS; ++l)
    for (int r = 0; r < RUNS; ++r) sdr_rundata_destroy(&s.outcome[l][r].data);
  return (int)status;
}
