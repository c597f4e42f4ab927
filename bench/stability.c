/* where each integrator, law and model stops being accurate, where it fails, and that it says so */
#include "app/plot_gnuplot.h"
#include "app/run.h"
#include "app/rundata.h"
#include "support/report.h"
#include "support/stress.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST_SWEEPS = 32, MOST_SECONDS = 120, MESSAGE = 240, REPEATS = 9 };

/* What became of a case. A run that ends well has finite results, or it is `unsaid`. */
typedef enum { GOOD, INACCURATE, REFUSED, STOPPED, UNSAID, CRASHED, SLOW } verdict;
static const char *const verdicts[] = {"accurate", "inaccurate", "refused", "stopped",
                                       "UNSAID",   "CRASHED",    "TOO SLOW"};

typedef struct {
  int status; /* of the run; negative: it did not end by itself */
  double error, seconds;
  double same[4]; /* shares of stored, kinetic and dissipated energy; mean damage */
  long long steps;
  char message[MESSAGE];
  verdict verdict;
} outcome;

typedef struct {
  char directory[BENCH_PATH];
  FILE *csv;
  outcome out[MOST_SWEEPS][STRESS_VARIANTS][STRESS_LEVELS];
} study;

/* ---- one case, in a process of its own ------------------------------------------------------- */

/* Least squares slope of the imbalance, over the largest energy, in a million steps. */
static double drift_of(const sdr_rundata *run, long long steps)
{
  const double *time = sdr_rundata_column(run, "time"), *off = sdr_rundata_column(run, "imbalance");
  const double *kinetic = sdr_rundata_column(run, "kinetic");
  const double *stored = sdr_rundata_column(run, "stored");
  const int count = run->history.row_count;
  double n = 0, t = 0, tt = 0, e = 0, te = 0, most = 0;
  for (int k = 0; k < count; ++k) {
    n += 1.0;
    t += time[k];
    tt += time[k] * time[k];
    e += off[k];
    te += time[k] * off[k];
    most = fmax(most, kinetic[k] + stored[k]);
  }
  const double slope = (n * te - t * e) / (n * tt - t * t);
  return fabs(slope * time[count - 1] / most * 1e6 / (double)steps);
}

static void look(const sdr_rundata *run, const stress_sweep *sweep, outcome *o)
{
  const char *const energies[] = {"energy.stored", "energy.kinetic", "energy.dissipated"};
  double sum = 0.0;
  o->steps = (long long)sdr_rundata_number(run, "steps");
  o->seconds = sdr_rundata_number(run, "wall_seconds.integrate");
  for (int k = 0; k < 3; ++k) sum += fabs(o->same[k] = sdr_rundata_number(run, energies[k]));
  for (int k = 0; k < 3; ++k) o->same[k] = sum > 0.0 ? o->same[k] / sum : o->same[k];
  o->same[3] = sdr_rundata_number(run, "damage.mean");
  switch (sweep->kind) {
  case STRESS_EXACT:
    o->error = sdr_rundata_number(run, "figures.err.value");
    if (isnan(o->error)) o->error = sdr_rundata_number(run, "figures.error_l2.value");
    break;
  case STRESS_DRIFT:
    o->error = drift_of(run, o->steps);
    break;
  case STRESS_COST:
    o->error = sdr_rundata_number(run, "ns_per_bond_step");
    break;
  case STRESS_END:
    o->error = fabs(sdr_rundata_number(run, "energy.imbalance_relative"));
    break;
  case STRESS_IMBALANCE:
  case STRESS_SAME:
    o->error = fabs(sdr_rundata_number(run, "energy.imbalance_largest"));
  }
}

static sdr_status run_here(const study *s, const stress_sweep *sweep, int variant, double level,
                           outcome *o)
{
  char path[2 * BENCH_PATH], directory[2 * BENCH_PATH];
  sdr_rundata *run = NULL;
  snprintf(path, sizeof path, "%s/%s-%d-%g.yaml", s->directory, sweep->name, variant, level);
  snprintf(directory, sizeof directory, "%s/case", s->directory);
  FILE *file = fopen(path, "w"), *silent = fopen("/dev/null", "w");
  if (!file || !silent) return sdr_fail(SDR_IO_ERROR, "%s: %s", path, strerror(errno));
  sweep->scene(file, variant, level);
  if (fclose(file) != 0) return sdr_fail(SDR_IO_ERROR, "%s: %s", path, strerror(errno));
  const sdr_run_options options = {.scene = path, .directory = directory, .quiet = 1};
  const int times = sweep->kind == STRESS_COST ? REPEATS : 1;
  double least = (double)INFINITY;
  for (int k = 0; k < times; ++k) {
    SDR_TRY(sdr_run(&options, silent));
    SDR_TRY(sdr_rundata_open(directory, &run));
    look(run, sweep, o);
    least = fmin(least, o->error);
    sdr_rundata_destroy(&run);
  }
  if (times > 1) o->error = least;
  return SDR_OK;
}

static void child(const study *s, const stress_sweep *sweep, int variant, double level, int pipe)
{
  outcome o = {.error = (double)NAN};
  setrlimit(RLIMIT_CPU, &(struct rlimit){MOST_SECONDS, MOST_SECONDS + 5});
  if (!freopen("/dev/null", "w", stderr)) _exit(1);
  o.status = (int)run_here(s, sweep, variant, level, &o);
  if (o.status != SDR_OK) snprintf(o.message, sizeof o.message, "%s", sdr_error_message());
  o.message[strcspn(o.message, "\n")] = '\0';
  _exit(write(pipe, &o, sizeof o) != (ssize_t)sizeof o);
}

static verdict judge(const stress_sweep *sweep, const outcome *o)
{
  int finite = isfinite(o->error);
  for (int k = 0; k < 4; ++k)
    if (sweep->kind != STRESS_EXACT && !isfinite(o->same[k])) finite = 0;
  if (o->status == SDR_BAD_INPUT) return REFUSED;
  if (o->status != SDR_OK) return o->message[0] ? STOPPED : UNSAID;
  return !finite ? UNSAID : o->error <= sweep->accurate ? GOOD : INACCURATE;
}

static sdr_status run_case(const study *s, const stress_sweep *sweep, int variant, double level,
                           outcome *o)
{
  int ends[2], ended = 0;
  fflush(NULL);
  if (pipe(ends) != 0) return sdr_fail(SDR_IO_ERROR, "no pipe: %s", strerror(errno));
  const pid_t pid = fork();
  if (pid < 0) return sdr_fail(SDR_IO_ERROR, "no process: %s", strerror(errno));
  if (pid == 0) child(s, sweep, variant, level, ends[1]);
  close(ends[1]);
  const int whole = read(ends[0], o, sizeof *o) == (ssize_t)sizeof *o;
  close(ends[0]);
  waitpid(pid, &ended, 0);
  if (!whole) {
    *o = (outcome){.status = -1, .error = (double)NAN, .verdict = CRASHED};
    if (WIFSIGNALED(ended) && WTERMSIG(ended) == SIGXCPU) o->verdict = SLOW;
    snprintf(o->message, sizeof o->message, "ended by signal %d",
             WIFSIGNALED(ended) ? WTERMSIG(ended) : 0);
    return SDR_OK;
  }
  o->verdict = judge(sweep, o);
  return SDR_OK;
}

/* ---- a sweep --------------------------------------------------------------------------------- */

/* Errors against the sweep's base, where that is how it is judged. */
static void compare(const stress_sweep *sweep, outcome *o)
{
  const outcome base = o[sweep->base];
  for (int k = 0; k < sweep->level_count; ++k) {
    if (o[k].status != SDR_OK) continue;
    if (sweep->kind == STRESS_SAME) {
      o[k].error = 0.0;
      for (int e = 0; e < 4; ++e) o[k].error = fmax(o[k].error, fabs(o[k].same[e] - base.same[e]));
      for (int e = 0; e < 4; ++e)
        if (isnan(o[k].same[e])) o[k].error = (double)NAN;
    } else if (sweep->kind == STRESS_COST) {
      o[k].error = o[k].error / base.error - 1.0;
    }
    o[k].verdict = judge(sweep, &o[k]);
  }
}

static void put(study *s, const stress_sweep *sweep, int v, const outcome *o)
{
  printf("  %-30s", sweep->variant[v]);
  for (int k = 0; k < sweep->level_count; ++k) {
    if (o[k].verdict <= INACCURATE)
      printf(" %8.1e%c", o[k].error, o[k].verdict == GOOD ? ' ' : '*');
    else
      printf(" %9s", verdicts[o[k].verdict]);
    fprintf(s->csv, "%s,\"%s\",%.9g,%s,%.6e,%lld,%.4g,\"", sweep->name, sweep->variant[v],
            sweep->level[k], verdicts[o[k].verdict], o[k].error, o[k].steps, o[k].seconds);
    for (const char *c = o[k].message; *c; ++c) fputc(*c == '"' ? '\'' : *c, s->csv);
    fputs("\"\n", s->csv);
  }
  printf("\n");
  fflush(stdout);
}

static void put_messages(const stress_sweep *sweep, outcome out[][STRESS_LEVELS])
{
  const char *before = "";
  for (int v = 0; v < STRESS_VARIANTS && sweep->variant[v]; ++v)
    for (int k = 0; k < sweep->level_count; ++k) {
      const outcome *o = &out[v][k];
      if (o->verdict < REFUSED || strcmp(o->message, before) == 0) continue;
      before = o->message;
      printf("    %s, %g: %s: %s\n", sweep->variant[v], sweep->level[k], verdicts[o->verdict],
             o->message[0] ? o->message : "results are not finite");
    }
}

static sdr_status run_sweep(study *s, int w)
{
  const stress_sweep *sweep = &stress_sweeps[w];
  printf("%s (%s; accurate: up to %g)\n  %-30s", sweep->title, sweep->what, sweep->accurate, "");
  for (int k = 0; k < sweep->level_count; ++k) printf(" %8g ", sweep->level[k]);
  printf("\n");
  for (int v = 0; v < STRESS_VARIANTS && sweep->variant[v]; ++v) {
    for (int k = 0; k < sweep->level_count; ++k)
      SDR_TRY(run_case(s, sweep, v, sweep->level[k], &s->out[w][v][k]));
    compare(sweep, s->out[w][v]);
    put(s, sweep, v, s->out[w][v]);
  }
  put_messages(sweep, s->out[w]);
  return SDR_OK;
}

/* ---- picture --------------------------------------------------------------------------------- */

static const char *const colours[] = {"#0072b2", "#d55e00", "#009e73",
                                      "#cc79a7", "#e69f00", "#000000"};

/* Columns: index of the level, error, 1 where the run was refused or stopped. */
static void put_data(const study *s, FILE *script, int w)
{
  for (int v = 0; v < STRESS_VARIANTS && stress_sweeps[w].variant[v]; ++v) {
    fprintf(script, "$d%d_%d << E\n", w, v);
    for (int k = 0; k < stress_sweeps[w].level_count; ++k) {
      const outcome *o = &s->out[w][v][k];
      if (o->verdict <= INACCURATE)
        fprintf(script, "%d %g NaN\n", k, fmin(fmax(fabs(o->error), 1e-17), 1e3));
      else
        fprintf(script, "%d NaN %g\n", k, 2e2 * pow(3.0, v));
    }
    fputs("E\n", script);
  }
}

static void plot(FILE *script, int w)
{
  const stress_sweep *sweep = &stress_sweeps[w];
  fputs("set xtics (", script);
  for (int k = 0; k < sweep->level_count; ++k)
    fprintf(script, "%s'%g' %d", k ? ", " : "", sweep->level[k], k);
  fprintf(script, ") font ',10'\nset xlabel '%s'\nset title '%s'\nset xrange [-0.3:%g]\n",
          sweep->what, sweep->title, sweep->level_count - 0.7);
  fprintf(script, "plot %g w l lc '#999999' dt 2 notitle", sweep->accurate);
  for (int v = 0; v < STRESS_VARIANTS && sweep->variant[v]; ++v)
    fprintf(script,
            ", $d%d_%d u 1:2 w lp lw 1.5 pt 7 ps 0.6 lc '%s' t '%s'"
            ", $d%d_%d u 1:3 w p pt 2 ps 0.9 lw 1.5 lc '%s' notitle",
            w, v, colours[v], sweep->variant[v], w, v, colours[v]);
  fputc('\n', script);
}

static sdr_status draw(const study *s)
{
  enum { COLUMNS = 3, WIDTH = 560, HEIGHT = 380 };
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  const int lines = (stress_sweep_count + COLUMNS - 1) / COLUMNS;
  SDR_TRY(sdr_picture_begin(&picture, COLUMNS * WIDTH + 40, lines * HEIGHT + 20, 15.0));
  FILE *script = picture.script;
  for (int w = 0; w < stress_sweep_count; ++w) put_data(s, script, w);
  fputs("set border 3\nset ytics nomirror out 1e3\nset mytics 1\nset grid ytics lc '#e4e4e4'\n"
        "set logscale y\nset format y '%.0e'\nset yrange [1e-17:1e6]\n"
        "set key left bottom font ',10' samplen 1 spacing 0.85\n",
        script);
  for (int w = 0; w < stress_sweep_count; ++w) {
    const double left = 90.0 + WIDTH * (double)(w % COLUMNS);
    const double bottom = 80.0 + HEIGHT * (double)(lines - 1 - w / COLUMNS);
    sdr_picture_place(&picture, (sdr_area){left, bottom, WIDTH - 110.0, HEIGHT - 120.0});
    plot(script, w);
  }
  snprintf(path, sizeof path, "%s/stability.png", s->directory);
  return sdr_picture_end(&picture, path);
}

/* ---- main ------------------------------------------------------------------------------------ */

static int is_asked(const stress_sweep *sweep, int count, char **words)
{
  for (int k = 1; k < count; ++k)
    if (strcmp(words[k], sweep->name) == 0) return 1;
  return count < 2;
}

static sdr_status run_all(study *s, int count, char **words)
{
  SDR_TRY(bench_directory("stability", s->directory));
  SDR_TRY(bench_csv(s->directory, "stability", &s->csv));
  fputs("sweep,variant,level,verdict,error,steps,seconds,message\n", s->csv);
  sdr_status status = SDR_OK;
  int asked = 0;
  for (int w = 0; w < stress_sweep_count && status == SDR_OK; ++w)
    if (is_asked(&stress_sweeps[w], count, words)) {
      status = run_sweep(s, w);
      ++asked;
    }
  if (fclose(s->csv) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "%s: disk full", s->directory);
  if (status == SDR_OK && asked == stress_sweep_count) status = draw(s);
  if (status == SDR_OK && asked == 0) status = sdr_fail(SDR_BAD_INPUT, "there is no such sweep");
  return status;
}

static int count_bad(const study *s)
{
  int bad = 0;
  for (int w = 0; w < stress_sweep_count; ++w)
    for (int v = 0; v < STRESS_VARIANTS; ++v)
      for (int k = 0; k < STRESS_LEVELS; ++k) bad += s->out[w][v][k].verdict >= UNSAID;
  return bad;
}

int main(int count, char **words)
{
  static study s;
  setenv("OMP_NUM_THREADS", "1", 0);
  const sdr_status status = run_all(&s, count, words);
  if (status != SDR_OK) {
    fprintf(stderr, "stability: %s\n", sdr_error_message());
    return (int)status;
  }
  const int bad = count_bad(&s);
  printf("\n*: not accurate. %d case%s failed without saying so, crashed or took over %d s of "
         "processor time\n%s\n"
         "%s/stability.csv%s\n",
         bad, bad == 1 ? "" : "s", (int)MOST_SECONDS, bench_origin(), s.directory,
         count < 2 ? " and .png" : "");
  return bad ? (int)SDR_RUN_FAILED : (int)SDR_OK;
}
