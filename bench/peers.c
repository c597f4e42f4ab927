/* Sunder beside LAMMPS PERI on the same points, bonds and law: time, memory, displacements */
#include "app/build.h"
#include "app/plot_gnuplot.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "support/report.h"

#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST_ROUNDS = 15, FILES = 700 };

static const char deck[] = "bench/peers/lammps/cylinder.in";

/* What one program took for one run. Seconds are of the processor. */
typedef struct {
  int64_t bonds; /* directed */
  double setup, loop, bytes;
} cost;

/* The scene as LAMMPS's deck wants it. */
typedef struct {
  int32_t points;
  int components, steps;
  double spacing, horizon, constant, stretch, step;
} deck_values;

/* What the process that runs Sunder tells; shared memory. */
typedef struct {
  cost cost;
  deck_values values;
} told;

typedef struct {
  const char *name, *scene;
  double target; /* how many times less a bond and step should cost */
} peer_case;

static const peer_case cases[] = {{"ring", "bench/peers/ring.yaml", 25.0},
                                  {"cylinder", "bench/peers/cylinder.yaml", 10.0}};
enum { CASES = sizeof cases / sizeof *cases };

typedef struct {
  deck_values values;
  int rounds;
  cost ours[MOST_ROUNDS], theirs[MOST_ROUNDS];
  double difference; /* largest of displacements, over the largest displacement */
} comparison;

/* ---- ours ------------------------------------------------------------------------------------ */

static sdr_status write_points(const sdr_built *built, FILE *file)
{
  const sdr_points *points = built->points;
  const double density = built->scene->material[0].density;
  double far[3]; /* twice the body: LAMMPS sorts points into cells over all of this */
  for (int a = 0; a < 3; ++a) {
    far[a] = points->horizon[0];
    for (int32_t i = 0; a < points->components && i < points->count; ++i)
      far[a] = fmax(far[a], 2.0 * fabs(points->x[a][i]));
  }
  fprintf(file, "points of a benchmark\n\n%d atoms\n1 atom types\n\n", points->count);
  for (int a = 0; a < 3; ++a)
    fprintf(file, "%.17g %.17g %clo %chi\n", -far[a], far[a], "xyz"[a], "xyz"[a]);
  fprintf(file, "\nAtoms # peri\n\n");
  for (int32_t i = 0; i < points->count; ++i) {
    fprintf(file, "%d 1 %.17g %.17g", i + 1, points->volume[i], density);
    for (int a = 0; a < 3; ++a)
      fprintf(file, " %.17g", a < points->components ? points->x[a][i] : 0.0);
    fputc('\n', file);
  }
  fprintf(file, "\nVelocities\n\n");
  for (int32_t i = 0; i < points->count; ++i) {
    fprintf(file, "%d", i + 1);
    for (int a = 0; a < 3; ++a)
      fprintf(file, " %.17g", a < points->components ? built->system->v[a][i] : 0.0);
    fputc('\n', file);
  }
  return ferror(file) ? sdr_fail(SDR_IO_ERROR, "the points cannot be written: disk full") : SDR_OK;
}

static sdr_status write_displacements(const sdr_built *built, FILE *file)
{
  for (int a = 0; a < built->points->components; ++a)
    fwrite(built->system->u[a], sizeof(double), (size_t)built->points->count, file);
  return ferror(file) ? sdr_fail(SDR_IO_ERROR, "the displacements cannot be written: disk full")
                      : SDR_OK;
}

static sdr_status to_file(const sdr_built *built, const char *path,
                          sdr_status (*write)(const sdr_built *built, FILE *file))
{
  FILE *file = fopen(path, "w");
  if (!file) return sdr_fail(SDR_IO_ERROR, "%s: cannot be written", path);
  const sdr_status status = write(built, file);
  if (fclose(file) != 0 && status == SDR_OK) return sdr_fail(SDR_IO_ERROR, "%s: disk full", path);
  return status;
}

static void tell(const sdr_built *built, told *out)
{
  const sdr_bond_body *body = &((const sdr_bond_model *)built->model)->body;
  out->cost.bonds = built->model->bonds;
  out->values = (deck_values){.points = built->points->count,
                              .components = built->points->components,
                              .steps = (int)built->steps,
                              .spacing = built->scene->points.spacing,
                              .horizon = built->points->horizon[0],
                              .constant = 2.0 * body->stiffness, /* ours is of a directed bond */
                              .stretch = sqrt(body->threshold),
                              .step = built->step};
}

/* In a process of its own: the peak of memory is one run's. */
static sdr_status run_ours(const peer_case *which, const char *data, const char *result, told *out)
{
  sdr_built built = {0};
  sdr_set_threads(1);
  double from = bench_processor_clock();
  SDR_TRY(sdr_build(which->scene, NULL, 0, NULL, &built));
  const double made = bench_processor_clock() - from;
  tell(&built, out);
  sdr_status status = to_file(&built, data, write_points);
  from = bench_processor_clock();
  if (status == SDR_OK) status = built.integrator->start(built.system, built.step);
  out->cost.setup = made + bench_processor_clock() - from;
  from = bench_processor_clock();
  while (status == SDR_OK && built.system->step < built.steps)
    status = built.integrator->step(built.system, built.step);
  out->cost.loop = bench_processor_clock() - from;
  if (status == SDR_OK) status = to_file(&built, result, write_displacements);
  sdr_built_destroy(&built);
  return status;
}

/* Wait for a process; its peak of memory, and its processor time. */
static sdr_status wait_for(pid_t process, const char *what, double *seconds, double *bytes)
{
  struct rusage usage;
  int state = 0;
  if (process < 0 || wait4(process, &state, 0, &usage) < 0)
    return sdr_fail(SDR_RUN_FAILED, "%s cannot be started", what);
  if (!WIFEXITED(state) || WEXITSTATUS(state) != 0)
    return sdr_fail(SDR_RUN_FAILED, "%s failed", what);
  *seconds = (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
             1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  *bytes = 1024.0 * (double)usage.ru_maxrss;
  return SDR_OK;
}

static sdr_status measure_ours(const peer_case *which, const char *data, const char *result,
                               told *out)
{
  double seconds;
  fflush(NULL);
  const pid_t process = fork();
  if (process == 0) {
    const sdr_status status = run_ours(which, data, result, out);
    if (status != SDR_OK) fprintf(stderr, "%s\n", sdr_error_message());
    _exit((int)status);
  }
  return wait_for(process, "Sunder", &seconds, &out->cost.bytes);
}

/* ---- LAMMPS ---------------------------------------------------------------------------------- */

/* Become LAMMPS, with what it says in `log`; returns if it is not there. */
static void become_lammps(const deck_values *v, const char *data, const char *dump, const char *log)
{
  char number[6][40];
  const double values[] = {v->spacing, v->horizon, v->constant, v->stretch, v->step};
  const int screen = open("/dev/null", O_WRONLY);
  if (screen >= 0) dup2(screen, STDOUT_FILENO);
  for (int k = 0; k < 5; ++k) snprintf(number[k], sizeof number[k], "%.17g", values[k]);
  snprintf(number[5], sizeof number[5], "%d", v->steps);
  setenv("OMP_NUM_THREADS", "1", 1);
  /* its MPI will not start for root without this, and is not used */
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  execlp("lmp", "lmp", "-in", deck, "-log", log, "-screen", "none", "-var", "data", data, "-var",
         "out", dump, "-var", "spacing", number[0], "-var", "horizon", number[1], "-var",
         "constant", number[2], "-var", "stretch", number[3], "-var", "step", number[4], "-var",
         "steps", number[5], (char *)NULL);
}

/* The time of its loop and its count of bonds, from its log. */
static sdr_status read_log(const char *path, cost *out)
{
  char line[512];
  FILE *file = fopen(path, "r");
  if (!file) return sdr_fail(SDR_IO_ERROR, "%s: cannot be read", path);
  int found = 0;
  while (fgets(line, sizeof line, file)) {
    long long bonds;
    double number;
    if (sscanf(line, " total # of bonds = %lld", &bonds) == 1) {
      out->bonds = bonds;
      found |= 1;
    } else if (sscanf(line, "Loop time of %lf on", &number) == 1) {
      out->loop = number;
      found |= 2;
    } else if (sscanf(line, "%lf%% CPU use", &number) == 1) {
      out->loop *= number / 100.0; /* what others did on this machine does not count */
      found |= 4;
    }
  }
  fclose(file);
  return found == 7 ? SDR_OK : sdr_fail(SDR_RUN_FAILED, "%s: LAMMPS did not finish", path);
}

static sdr_status measure_theirs(const deck_values *values, const char *data, const char *dump,
                                 const char *log, cost *out)
{
  double seconds;
  fflush(NULL);
  const pid_t process = fork();
  if (process == 0) {
    become_lammps(values, data, dump, log);
    fputs("peers: LAMMPS (lmp) is not installed\n", stderr);
    _exit(127);
  }
  SDR_TRY(wait_for(process, "LAMMPS", &seconds, &out->bytes));
  SDR_TRY(read_log(log, out));
  out->setup = seconds - out->loop;
  return SDR_OK;
}

/* ---- one beside the other -------------------------------------------------------------------- */

/* Its positions after the last step, in the order of its ids. */
static sdr_status read_dump(const char *path, const deck_values *values, double *x)
{
  char line[512];
  int32_t id = 0, count = 0;
  FILE *file = fopen(path, "r");
  if (!file) return sdr_fail(SDR_IO_ERROR, "%s: cannot be read", path);
  while (fgets(line, sizeof line, file) && strncmp(line, "ITEM: ATOMS", 11) != 0) {
  }
  for (; fgets(line, sizeof line, file); ++count) {
    double at[3];
    if (sscanf(line, "%d %lf %lf %lf", &id, &at[0], &at[1], &at[2]) != 4 || id < 1 ||
        id > values->points)
      break;
    for (int a = 0; a < values->components; ++a)
      x[(size_t)a * (size_t)values->points + (size_t)(id - 1)] = at[a];
  }
  fclose(file);
  return count == values->points ? SDR_OK
                                 : sdr_fail(SDR_RUN_FAILED, "%s: not all points are there", path);
}

/* The scene's positions at rest, as LAMMPS was given them, are those of `data`. */
static sdr_status read_data(const char *path, const deck_values *values, double *x)
{
  char line[512];
  int32_t id, count = 0;
  FILE *file = fopen(path, "r");
  if (!file) return sdr_fail(SDR_IO_ERROR, "%s: cannot be read", path);
  while (fgets(line, sizeof line, file) && strncmp(line, "Atoms", 5) != 0) {
  }
  while (count < values->points && fgets(line, sizeof line, file)) {
    double at[3];
    if (sscanf(line, "%d 1 %*f %*f %lf %lf %lf", &id, &at[0], &at[1], &at[2]) != 4) continue;
    for (int a = 0; a < values->components; ++a)
      x[(size_t)a * (size_t)values->points + (size_t)(id - 1)] = at[a];
    ++count;
  }
  fclose(file);
  return count == values->points ? SDR_OK
                                 : sdr_fail(SDR_RUN_FAILED, "%s: not all points are there", path);
}

static sdr_status compare_fields(const char *data, const char *dump, const char *result,
                                 comparison *c)
{
  const size_t n = (size_t)c->values.points * (size_t)c->values.components;
  double *before = sdr_alloc(n, sizeof(double)), *after = sdr_alloc(n, sizeof(double));
  double *ours = sdr_alloc(n, sizeof(double)), most = 0.0, apart = 0.0;
  FILE *file = fopen(result, "r");
  sdr_status status = SDR_RUN_FAILED;
  if (!before || !after || !ours) goto done;
  status = sdr_fail(SDR_IO_ERROR, "%s: cannot be read", result);
  if (!file || fread(ours, sizeof(double), n, file) != n) goto done;
  if ((status = read_data(data, &c->values, before)) != SDR_OK) goto done;
  if ((status = read_dump(dump, &c->values, after)) != SDR_OK) goto done;
  for (size_t k = 0; k < n; ++k) {
    most = fmax(most, fabs(ours[k]));
    apart = fmax(apart, fabs(ours[k] - (after[k] - before[k])));
  }
  c->difference = apart / most;
done:
  if (file) fclose(file);
  sdr_free(before);
  sdr_free(after);
  sdr_free(ours);
  return status;
}

static sdr_status run_case(const peer_case *which, const char *directory, int rounds, told *shared,
                           comparison *out)
{
  char data[FILES], dump[FILES], log[FILES], result[FILES];
  snprintf(data, sizeof data, "%s/%s.data", directory, which->name);
  snprintf(dump, sizeof dump, "%s/%s.dump", directory, which->name);
  snprintf(log, sizeof log, "%s/%s.log", directory, which->name);
  snprintf(result, sizeof result, "%s/%s.bin", directory, which->name);
  out->rounds = rounds;
  for (int k = 0; k < rounds; ++k) {
    fprintf(stderr, "%s, round %d of %d ...\n", which->name, k + 1, rounds);
    SDR_TRY(measure_ours(which, data, result, shared));
    out->ours[k] = shared->cost;
    out->values = shared->values;
    SDR_TRY(measure_theirs(&out->values, data, dump, log, &out->theirs[k]));
  }
  SDR_TRY(compare_fields(data, dump, result, out));
  remove(data);
  remove(dump);
  remove(result);
  return SDR_OK;
}

/* ---- what is shown --------------------------------------------------------------------------- */

static int by_size(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

/* ns a directed bond and step: least, median, largest. */
static void per_bond(const cost *costs, const comparison *c, double ns[3])
{
  double all[MOST_ROUNDS];
  for (int k = 0; k < c->rounds; ++k)
    all[k] = 1e9 * costs[k].loop / ((double)costs[k].bonds * c->values.steps);
  qsort(all, (size_t)c->rounds, sizeof *all, by_size);
  ns[0] = all[0];
  ns[1] = all[c->rounds / 2];
  ns[2] = all[c->rounds - 1];
}

static void print_program(FILE *csv, const peer_case *which, const char *program, const cost *costs,
                          const comparison *c)
{
  double ns[3];
  per_bond(costs, c, ns);
  printf("  %-9s %-7s %9d %10lld %8.2f %8.2f %8.2f %9.2f %9.1f\n", which->name, program,
         c->values.points, (long long)costs->bonds, ns[0], ns[1], ns[2], costs->setup,
         costs->bytes / 1e6);
  fprintf(csv, "%s,%s,%d,%lld,%d,%.4g,%.4g,%.4g,%.4g,%.4g,%.3g\n", which->name, program,
          c->values.points, (long long)costs->bonds, c->values.steps, ns[0], ns[1], ns[2],
          costs->setup, costs->bytes, c->difference);
}

static void print_case(FILE *csv, const peer_case *which, const comparison *c)
{
  double ours[3], theirs[3];
  print_program(csv, which, "Sunder", c->ours, c);
  print_program(csv, which, "LAMMPS", c->theirs, c);
  per_bond(c->ours, c, ours);
  per_bond(c->theirs, c, theirs);
  const double ratio = theirs[1] / ours[1];
  printf(
      "  %-9s a bond and step costs %.1f times less (%.1f to %.1f; wanted %g: %s); displacements "
      "differ by %.1e of the largest\n",
      "", ratio, theirs[0] / ours[2], theirs[2] / ours[0], which->target,
      ratio >= which->target ? "met" : "NOT MET", c->difference);
}

static sdr_status draw(const comparison *c, const char *directory)
{
  char path[FILES];
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 900, 420, 15.0));
  sdr_picture_clear_axes(&picture);
  sdr_picture_place(&picture, (sdr_area){90, 60, 780, 270});
  sdr_picture_text(&picture, 20, 395, "left", 1.2, 860,
                   "Cost of a bond and step beside LAMMPS PERI: same points, bonds and law");
  sdr_picture_text(&picture, 20, 368, "left", 0.9, 860, bench_origin());
  FILE *s = picture.script;
  fprintf(s, "set logscale y\nset yrange [0.1:200]\nset ytics\nset grid ytics\n"
             "set ylabel 'ns, one core'\nset style fill solid 0.85\nset boxwidth 0.35\n"
             "set xrange [-0.6:1.6]\nset xtics ('ring, plane' 0, 'cylinder, space' 1)\n"
             "set key top left Left reverse\n");
  fprintf(s, "plot '-' using 1:2 with boxes lc rgb '#2a6fbb' title 'Sunder', '-' using 1:2:(sprintf"
             "('%%.2f', $2)) with labels offset 0,0.8 notitle, '-' using 1:2 with boxes lc rgb "
             "'#b0b0b0' title 'LAMMPS', '-' using 1:2:(sprintf('%%.1f', $2)) with labels offset "
             "0,0.8 notitle\n");
  for (int part = 0; part < 4; ++part) {
    for (int k = 0; k < CASES; ++k) {
      double ns[3];
      per_bond(part < 2 ? c[k].ours : c[k].theirs, &c[k], ns);
      fprintf(s, "%g %g\n", k + (part < 2 ? -0.19 : 0.19), ns[1]);
    }
    fprintf(s, "e\n");
  }
  snprintf(path, sizeof path, "%s/peers.png", directory);
  return sdr_picture_end(&picture, path);
}

static sdr_status compare_programs(int rounds, told *shared)
{
  char directory[BENCH_PATH];
  static comparison results[CASES];
  FILE *csv = NULL;
  SDR_TRY(bench_directory("peers", directory));
  SDR_TRY(bench_csv(directory, "peers", &csv));
  fputs("body,program,points,directed_bonds,steps,ns_least,ns_median,ns_largest,setup_seconds,"
        "peak_bytes,difference\n",
        csv);
  sdr_status status = SDR_OK;
  for (int k = 0; k < CASES && status == SDR_OK; ++k)
    status = run_case(&cases[k], directory, rounds, shared, &results[k]);
  if (status == SDR_OK) {
    printf("  body      program    points      bonds   ns a directed bond and step  set-up s  "
           "peak MB\n%46s %8s %8s\n",
           "least", "median", "largest");
    for (int k = 0; k < CASES; ++k) print_case(csv, &cases[k], &results[k]);
    puts("Processor time of one core. LAMMPS also looks for pieces that touch, and computes three\n"
         "components in the plane; Sunder also books energy. Both test every bond for breakage.");
    status = draw(results, directory);
  }
  if (fclose(csv) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "%s: disk full", directory);
  if (status == SDR_OK)
    printf("%s\n%s/peers.csv\n%s/peers.png\n", bench_origin(), directory, directory);
  return status;
}

int main(int count, char **words)
{
  const int quick = count == 2 && strcmp(words[1], "--quick") == 0;
  if (count > 1 && !quick) {
    fputs("usage: bench_peers [--quick]\n--quick: one round instead of five\n", stderr);
    return SDR_BAD_INPUT;
  }
  told *shared =
      mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) return SDR_RUN_FAILED;
  const sdr_status status = compare_programs(quick ? 1 : 5, shared);
  if (status != SDR_OK) fprintf(stderr, "peers: %s\n", sdr_error_message());
  return (int)status;
}
