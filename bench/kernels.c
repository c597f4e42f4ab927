/* time of a bond in a step: plain reference, loose pairs, runs, beside what the machine allows */
#include "base/memory.h"
#include "base/parallel.h"
#include "support/body.h"
#include "support/chart.h"
#include "support/floor.h"
#include "support/plain_reference.h"
#include "support/report.h"
#include "time/integrator.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Ways to hold bonds. LATTICE: points in the order of lattice rows. RANDOM: they come shuffled; the
   plain reference takes them as they are, the library sorts them along a curve. */
typedef enum {
  PLAIN_LATTICE,
  PLAIN_RANDOM,
  LOOSE_LATTICE,
  LOOSE_RANDOM,
  RUNS,
  MIXED, /* runs in float arithmetic */
  FLOOR, /* loads and stores of RUNS alone */
  FORMS
} form;

static const char *const form_name[FORMS] = {"plain, lattice", "plain, random", "loose, lattice",
                                             "loose, random",  "runs",          "runs, mixed",
                                             "floor of runs"};
static const char *const law_name[3] = {"none", "variational", "critical"};
static const char *const body_name[2] = {"plane stress", "3-D"};

enum { ISAS = 3, MOST_ROUNDS = 15, LAWS = 3 };
static const char *const isa_name[ISAS] = {"baseline", "avx2", "avx512"};

/* Median and least of the rounds, ns a directed bond and step; NAN: not measured. */
typedef struct {
  double median, least;
} timing;

/* By body, law, moduli (0 shared, 1 a point), threads - 1, instruction set, form. */
typedef struct {
  timing time[2][LAWS][2][2][ISAS][FORMS];
  double worst; /* largest difference of a force from the plain reference, over the largest force */
  double triad[2];
  int32_t points[2];
  int64_t bonds[2];
  int rounds, best_isa, threads;
} figures;

/* ---- what is compared ------------------------------------------------------------------------ */

typedef struct {
  bench_body lattice, mixed, loose, random; /* of RUNS, MIXED, LOOSE_LATTICE, LOOSE_RANDOM */
  bench_plain plain, plain_random;
} bodies;

static void destroy_bodies(bodies *all)
{
  bench_body_destroy(&all->lattice);
  bench_body_destroy(&all->mixed);
  bench_body_destroy(&all->loose);
  bench_body_destroy(&all->random);
  bench_plain_destroy(&all->plain);
  bench_plain_destroy(&all->plain_random);
}

static sdr_status create_bodies(bench_how how, bodies *all)
{
  SDR_TRY(bench_body_create(&how, &all->lattice));
  SDR_TRY(bench_plain_create(&all->lattice, 0, &all->plain));
  SDR_TRY(bench_plain_create(&all->lattice, 1, &all->plain_random));
  how.mixed = 1;
  SDR_TRY(bench_body_create(&how, &all->mixed));
  how.mixed = 0;
  how.loose = 1;
  SDR_TRY(bench_body_create(&how, &all->loose));
  how.shuffled = 1;
  return bench_body_create(&how, &all->random);
}

static bench_body *body_of(bodies *all, form which)
{
  if (which == LOOSE_LATTICE) return &all->loose;
  if (which == LOOSE_RANDOM) return &all->random;
  return which == MIXED ? &all->mixed : &all->lattice;
}

static sdr_status take_step(bodies *all, form which)
{
  bench_body *body = body_of(all, which);
  if (which == PLAIN_LATTICE) bench_plain_step(&all->plain, all->lattice.step);
  if (which == PLAIN_RANDOM) bench_plain_step(&all->plain_random, all->lattice.step);
  if (which == FLOOR) bench_floor_step(body);
  if (which < LOOSE_LATTICE || which == FLOOR) return SDR_OK;
  return sdr_leapfrog.step(body->system, body->step);
}

/* Largest difference of a body's force from the plain reference's, over the largest force. */
static double force_error(const bodies *all, const bench_body *body)
{
  double largest = 0.0, error = 0.0;
  for (int a = 0; a < body->system->components; ++a)
    for (int32_t i = 0; i < body->system->count; ++i) {
      const double right = all->plain.f[a][body->original ? body->original[i] : i];
      largest = fmax(largest, fabs(right));
      error = fmax(error, fabs(body->system->f[a][i] - right));
    }
  return error / largest;
}

/* Have the body use the kernels of an instruction set. */
static sdr_status use_isa(bench_body *body, int isa)
{
  SDR_TRY(sdr_isa_limit(isa_name[isa]));
  ((sdr_bond_model *)body->model)->kernels = sdr_bond_kernels_best();
  return SDR_OK;
}

/* All forces of the start are computed anew and compared with the plain reference. */
static sdr_status check_forces(bodies *all, figures *out)
{
  for (int isa = 0; isa <= out->best_isa; ++isa)
    for (form which = LOOSE_LATTICE; which <= RUNS; ++which) {
      bench_body *body = body_of(all, which);
      SDR_TRY(use_isa(body, isa));
      SDR_TRY(bench_body_restart(body));
      out->worst = fmax(out->worst, force_error(all, body));
    }
  return SDR_OK;
}

/* ---- measuring ------------------------------------------------------------------------------- */

typedef struct {
  form which;
  int isa, steps;
  double seconds[MOST_ROUNDS]; /* a step */
} contestant;

static int by_size(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

/* On one thread processor time, which does not count what others do on this machine. */
static double clock_for(int threads)
{
  return threads == 1 ? bench_processor_clock() : bench_clock();
}

static sdr_status time_steps(bodies *all, const contestant *c, int threads, double *seconds)
{
  if (c->which >= LOOSE_LATTICE && c->which <= MIXED)
    SDR_TRY(use_isa(body_of(all, c->which), c->isa));
  const double from = clock_for(threads);
  for (int k = 0; k < c->steps; ++k) SDR_TRY(take_step(all, c->which));
  *seconds = (clock_for(threads) - from) / c->steps;
  if (c->which != FLOOR) return SDR_OK;
  const bench_body *body = &all->lattice; /* its forces are spoiled */
  return sdr_system_force(body->system, 0.0, body->step, body->step);
}

/* On two threads only the best instruction set; forms without a choice count as the best. */
static int list_contestants(const figures *out, int threads, contestant list[ISAS * FORMS])
{
  int count = 0;
  for (form which = PLAIN_LATTICE; which < FORMS; ++which)
    for (int isa = 0; isa <= out->best_isa; ++isa) {
      const int choice = which >= LOOSE_LATTICE && which <= MIXED && threads == 1;
      if (choice || isa == out->best_isa)
        list[count++] = (contestant){.which = which, .isa = isa, .steps = 1};
    }
  return count;
}

/* Time every contestant once a round, so that what disturbs the machine disturbs all alike. */
static sdr_status measure(bodies *all, int threads, figures *out, timing result[ISAS][FORMS])
{
  contestant list[ISAS * FORMS];
  const int count = list_contestants(out, threads, list);
  const double enough = 0.02; /* s a measurement */
  sdr_set_threads(threads);
  for (int round = -1; round < out->rounds; ++round)
    for (int k = 0; k < count; ++k) {
      double seconds;
      SDR_TRY(time_steps(all, &list[k], threads, &seconds));
      if (round < 0)
        list[k].steps = (int)fmin(100.0, fmax(1.0, ceil(enough / seconds)));
      else
        list[k].seconds[round] = seconds;
    }
  const double bonds = (double)all->lattice.model->bonds;
  for (int k = 0; k < count; ++k) {
    qsort(list[k].seconds, (size_t)out->rounds, sizeof(double), by_size);
    result[list[k].isa][list[k].which] =
        (timing){list[k].seconds[out->rounds / 2] * 1e9 / bonds, list[k].seconds[0] * 1e9 / bonds};
  }
  return SDR_OK;
}

static sdr_status measure_case(const bench_how *how, figures *out)
{
  bodies all = {0};
  const int b = how->dimension - 2;
  fprintf(stderr, "%s, %s, %s moduli ...\n", body_name[b], law_name[how->law],
          how->scattered ? "scattered" : "shared");
  sdr_status status = create_bodies(*how, &all);
  if (status == SDR_OK) status = check_forces(&all, out);
  for (int threads = 1; status == SDR_OK && threads <= out->threads; ++threads)
    status = measure(&all, threads, out, out->time[b][how->law][how->scattered][threads - 1]);
  if (status == SDR_OK) {
    out->points[b] = all.lattice.points->count;
    out->bonds[b] = all.lattice.model->bonds;
  }
  destroy_bodies(&all);
  return status;
}

static sdr_status measure_all(int quick, figures *out)
{
  timing *const all = &out->time[0][0][0][0][0][0];
  for (size_t k = 0; k < sizeof out->time / sizeof(timing); ++k)
    all[k] = (timing){(double)NAN, (double)NAN};
  out->rounds = quick ? 3 : 7;
  out->threads = sdr_threads() > 1 ? 2 : 1;
  while (out->best_isa + 1 < ISAS && sdr_isa_limit(isa_name[out->best_isa + 1]) == SDR_OK)
    ++out->best_isa;
  for (int threads = 1; threads <= out->threads; ++threads) {
    sdr_set_threads(threads);
    out->triad[threads - 1] = bench_triad();
  }
  bench_how how = {.spacing = quick ? 1e-3 : 0.5e-3, .edge = quick ? 32 : 48};
  for (how.dimension = 2; how.dimension <= 3; ++how.dimension)
    for (int law = 0; law < LAWS; ++law)
      for (how.scattered = 0; how.scattered < 2; ++how.scattered) {
        how.law = (sdr_law)law;
        SDR_TRY(measure_case(&how, out));
      }
  return SDR_OK;
}

/* ---- tables ---------------------------------------------------------------------------------- */

/* What the ratios must reach: plain over loose, plain over runs (by body), runs over mixed. */
static const double loose_target = 3.0, runs_target[2] = {5.0, 4.0}, mixed_target = 1.5;

/* A ratio, with a mark where it misses its target. */
static void print_ratio(double ratio, double target, int *missed)
{
  const int short_of_it = ratio < target;
  *missed += short_of_it;
  printf("%7.2f%c", ratio, short_of_it ? '*' : ' ');
}

static void print_row(const figures *f, int b, int law, int moduli, int threads, int *missed)
{
  const timing *t = f->time[b][law][moduli][threads - 1][f->best_isa];
  double ns[FORMS];
  printf("  %-12s %-11s %-9s", body_name[b], law_name[law], moduli ? "scattered" : "shared");
  for (int k = 0; k < FORMS; ++k) printf("%8.2f", ns[k] = t[k].median);
  print_ratio(ns[PLAIN_LATTICE] / ns[LOOSE_LATTICE], loose_target, missed);
  print_ratio(ns[PLAIN_LATTICE] / ns[RUNS], runs_target[b], missed);
  print_ratio(ns[RUNS] / ns[MIXED], mixed_target, missed);
  printf("%7.1f\n", ns[RUNS] / ns[FLOOR]);
}

static void print_threads(const figures *f, int threads)
{
  int missed = 0;
  printf("\n%s, %s: ns a directed bond and step (median of %d)\n"
         "  %-12s %-11s %-9s   plain   plain   loose   loose    runs    runs   floor"
         " plain/  plain/   runs/  runs/\n"
         "  %-12s %-11s %-9s lattice  random lattice  random           mixed of runs"
         "  loose    runs   mixed  floor\n",
         threads == 1 ? "One core (processor time)" : "Two cores (wall)", isa_name[f->best_isa],
         f->rounds, "", "", "", "body", "law", "moduli");
  for (int b = 0; b < 2; ++b)
    for (int law = 0; law < LAWS; ++law)
      for (int moduli = 0; moduli < 2; ++moduli) print_row(f, b, law, moduli, threads, &missed);
  printf("  To be reached: plain/loose %.0f, plain/runs %.0f in plane stress and %.0f in 3-D, "
         "runs/mixed %.1f; %d missed%s\n",
         loose_target, runs_target[0], runs_target[1], mixed_target, missed, missed ? " (*)" : "");
}

static void print_isas(const figures *f)
{
  printf("\nOne core, scattered moduli, by instruction set: ns a directed bond and step\n  %-24s",
         "");
  for (form k = LOOSE_LATTICE; k <= RUNS; ++k) printf("  %-27s", form_name[k]);
  printf("\n  %-12s %-11s", "body", "law");
  for (int k = 0; k < 3; ++k) printf(" %9s%9s%9s ", isa_name[0], isa_name[1], isa_name[2]);
  fputc('\n', stdout);
  for (int b = 0; b < 2; ++b)
    for (int law = 0; law < LAWS; ++law) {
      printf("  %-12s %-11s", body_name[b], law_name[law]);
      for (form k = LOOSE_LATTICE; k <= RUNS; ++k) {
        fputc(' ', stdout);
        for (int isa = 0; isa < ISAS; ++isa) printf("%9.2f", f->time[b][law][1][0][isa][k].median);
        fputc(' ', stdout);
      }
      fputc('\n', stdout);
    }
}

static void print_all(const figures *f)
{
  for (int b = 0; b < 2; ++b)
    printf("%s%s: %d points, %lld directed bonds, %.1f a point\n", b ? "" : "\n", body_name[b],
           f->points[b], (long long)f->bonds[b], (double)f->bonds[b] / f->points[b]);
  for (int threads = 1; threads <= f->threads; ++threads) print_threads(f, threads);
  print_isas(f);
  printf("\nTriad bandwidth: %.1f GB/s on one core", f->triad[0] * 1e-9);
  if (f->threads > 1) printf(", %.1f GB/s on two", f->triad[1] * 1e-9);
  printf("\nForces agree with the plain reference to %.1e of the largest force\n%s\n", f->worst,
         bench_origin());
}

static sdr_status write_csv(const figures *f, const char *directory)
{
  FILE *csv;
  SDR_TRY(bench_csv(directory, "kernels", &csv));
  fprintf(csv, "# triad, bytes/s: %.4g %.4g\n", f->triad[0], f->triad[1]);
  fputs("body,points,bonds,law,moduli,threads,isa,form,median_ns,least_ns\n", csv);
  for (int b = 0; b < 2; ++b)
    for (int k = 0; k < LAWS * 2 * 2 * ISAS * FORMS; ++k) {
      const int which = k % FORMS, isa = k / FORMS % ISAS, threads = k / (FORMS * ISAS) % 2;
      const int moduli = k / (FORMS * ISAS * 2) % 2, law = k / (FORMS * ISAS * 4);
      const timing t = f->time[b][law][moduli][threads][isa][which];
      if (isnan(t.median)) continue;
      const int choice = which >= LOOSE_LATTICE && which <= MIXED;
      fprintf(csv, "%s,%d,%lld,%s,%s,%d,%s,\"%s\",%.4f,%.4f\n", body_name[b], f->points[b],
              (long long)f->bonds[b], law_name[law], moduli ? "scattered" : "shared", threads + 1,
              choice ? isa_name[isa] : "", form_name[which], t.median, t.least);
    }
  return fclose(csv) == 0 ? SDR_OK : sdr_fail(SDR_IO_ERROR, "%s: disk full", directory);
}

/* ---- picture --------------------------------------------------------------------------------- */

/* One bar of each group: a form with an instruction set. */
typedef struct {
  form which;
  int isa;
} choice;

/* Bars for the laws of one body, scattered moduli, one core. */
static void draw_panel(sdr_picture *picture, const figures *f, int b, int row, const char *what,
                       const choice *choices, const bench_bar *bars, int count)
{
  double value[LAWS * FORMS];
  char title[80];
  for (int law = 0; law < LAWS; ++law)
    for (int k = 0; k < count; ++k)
      value[law * count + k] = f->time[b][law][1][0][choices[k].isa][choices[k].which].median;
  snprintf(title, sizeof title, "%s: %s", body_name[b], what);
  const bench_chart chart = {.title = title,
                             .unit = "ns a directed bond and step, one core",
                             .groups = LAWS,
                             .bars = count,
                             .group = law_name,
                             .bar = bars,
                             .value = value,
                             .format = "%.1f",
                             .columns = (count + 1) / 2};
  bench_draw_bars(picture, &chart, (sdr_area){90 + 800 * b, 60 + 550 * row, 690, 430});
}

static sdr_status draw(const figures *f, const char *directory)
{
  static const bench_bar forms[FORMS] = {
      {"plain, lattice", "#999999"}, {"plain, random", "#cccccc"}, {"loose, lattice", "#56b4e9"},
      {"loose, random", "#0072b2"},  {"runs", "#d55e00"},          {"runs, mixed", "#f0a070"},
      {"floor of runs", "#000000"}};
  static const bench_bar isas[] = {{"loose, baseline", "#b9dcf2"}, {"loose, avx2", "#7cc0ea"},
                                   {"loose, avx512", "#56b4e9"},   {"runs, baseline", "#f5c9a8"},
                                   {"runs, avx2", "#e88f4a"},      {"runs, avx512", "#d55e00"}};
  choice by_form[FORMS], by_isa[2 * ISAS];
  for (int k = 0; k < FORMS; ++k) by_form[k] = (choice){(form)k, f->best_isa};
  for (int k = 0; k < 2 * ISAS; ++k)
    by_isa[k] = (choice){k < ISAS ? LOOSE_LATTICE : RUNS, k % ISAS};
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 1600, 1100, 20.0));
  for (int b = 0; b < 2; ++b) {
    draw_panel(&picture, f, b, 1, "ways to hold bonds", by_form, forms, FORMS);
    draw_panel(&picture, f, b, 0, "instruction sets", by_isa, isas, 2 * ISAS);
  }
  snprintf(path, sizeof path, "%s/kernels.png", directory);
  return sdr_picture_end(&picture, path);
}

/* ---- main ------------------------------------------------------------------------------------ */

int main(int count, char **words)
{
  static figures f;
  const int quick = count == 2 && strcmp(words[1], "--quick") == 0;
  char directory[BENCH_PATH];
  if (count > 1 && !quick) {
    fputs("usage: bench_kernels [--quick]\n--quick: smaller bodies, fewer repetitions\n", stderr);
    return SDR_BAD_INPUT;
  }
  sdr_status status = bench_directory("kernels", directory);
  if (status == SDR_OK) status = measure_all(quick, &f);
  if (status == SDR_OK) {
    print_all(&f);
    status = write_csv(&f, directory);
  }
  if (status == SDR_OK) status = draw(&f, directory);
  if (status == SDR_OK) printf("%s/kernels.csv\n%s/kernels.png\n", directory, directory);
  if (status != SDR_OK) fprintf(stderr, "kernels: %s\n", sdr_error_message());
  return (int)status;
}
