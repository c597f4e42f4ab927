/* every problem's figures beside their accepted ranges and the papers' values; names of problems,
   or PROBLEM:VARIANT, choose some, --papers all that a paper prints figures of */
#include "app/find_scene.h"
#include "app/plot_gnuplot.h"
#include "app/run.h"
#include "app/rundata.h"
#include "base/memory.h"
#include "scene/yaml.h"
#include "support/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_COMPARED = 200 };

/* A figure that a paper prints too. */
typedef struct {
  char name[3 * SDR_NAME_MAX];
  double value, low, high, paper;
} compared;

/* What has come out so far. */
typedef struct {
  char directory[BENCH_PATH];
  FILE *csv;
  int runs, refused, failed, figures, ranged, outside;
  double seconds; /* of the present run */
  int papers_only;
  compared beside[MOST_COMPARED];
  int beside_count;
} table;

/* ---- one figure ------------------------------------------------------------------------------ */

static void print_number(FILE *out, const char *format, double value, const char *without)
{
  if (isnan(value))
    fputs(without, out);
  else
    fprintf(out, format, value);
}

static void print_range(double low, double high)
{
  char text[64] = "";
  if (!isnan(low) && !isnan(high))
    snprintf(text, sizeof text, "%.4g to %.4g", low, high);
  else if (!isnan(low))
    snprintf(text, sizeof text, "from %.4g", low);
  else if (!isnan(high))
    snprintf(text, sizeof text, "up to %.4g", high);
  printf(" %-18s", text);
}

static double number_of(const sdr_rundata *data, const char *figure, const char *which)
{
  char key[2 * SDR_NAME_MAX];
  snprintf(key, sizeof key, "figures.%s.%s", figure, which);
  return sdr_rundata_number(data, key);
}

static void keep_for_picture(table *t, const sdr_scene *scene, const char *figure,
                             const double number[4])
{
  if (!(number[0] > 0.0 && number[3] > 0.0) || t->beside_count == MOST_COMPARED) return;
  compared *c = &t->beside[t->beside_count++];
  snprintf(c->name, sizeof c->name, "%s%s%s  %s", scene->name, scene->variant[0] ? " " : "",
           scene->variant, figure);
  c->value = number[0];
  /* a range with one end goes on to the edge of the picture */
  c->low = isnan(number[1]) && !isnan(number[2]) ? 0.0 : number[1];
  c->high = isnan(number[2]) && !isnan(number[1]) ? 1e3 * number[3] : number[2];
  c->paper = number[3];
}

static void add_figure(table *t, const sdr_rundata *data, const sdr_scene *scene, const char *name)
{
  const double value = number_of(data, name, "value"), low = number_of(data, name, "low");
  const double high = number_of(data, name, "high"), paper = number_of(data, name, "paper");
  const int has_range = !isnan(low) || !isnan(high);
  const int is_outside = has_range && (isnan(value) || value < low || value > high);
  const char *verdict = !has_range ? "-" : is_outside ? "OUTSIDE" : "ok";
  ++t->figures;
  t->ranged += has_range;
  t->outside += is_outside;
  printf("%-24s %-28s %-20s ", scene->name, scene->variant, name);
  print_number(stdout, "%-11.4g", value, "none       ");
  print_range(low, high);
  print_number(stdout, " %-9.4g", paper, "          ");
  printf(" %-7s %8.1f\n", verdict, t->seconds);
  fprintf(t->csv, "%s,%s,%s", scene->name, scene->variant, name);
  const double numbers[] = {value, low, high, paper};
  keep_for_picture(t, scene, name, numbers);
  for (int k = 0; k < 4; ++k) {
    fputc(',', t->csv);
    print_number(t->csv, "%.9g", numbers[k], "");
  }
  fprintf(t->csv, ",%s,%.2f\n", verdict, t->seconds);
}

/* ---- one run --------------------------------------------------------------------------------- */

static int is_figure(const sdr_scene *scene, const char *name)
{
  for (int k = 0; k < scene->figure_count; ++k)
    if (strcmp(scene->figure[k].name, name) == 0) return 1;
  return 0;
}

static sdr_status run_silently(const sdr_run_options *options)
{
  FILE *silent = fopen("/dev/null", "w");
  const sdr_status status = sdr_run(options, silent ? silent : stderr);
  if (silent) fclose(silent);
  return status;
}

static sdr_status run_one(table *t, const char *path, const char *variant, sdr_scene *scene)
{
  char directory[BENCH_PATH + 3 * SDR_NAME_MAX];
  sdr_rundata *data = NULL;
  snprintf(directory, sizeof directory, "%s/%s%s%s", t->directory, scene->name,
           variant[0] ? "-" : "", variant);
  /* no frames of a motion: the figures do not need them */
  const char *sets[] = {"output.snapshots=0"};
  const sdr_run_options options = {.scene = path,
                                   .variant = variant,
                                   .directory = directory,
                                   .set_count = scene->equation ? 0 : 1,
                                   .sets = sets,
                                   .threads = 1, /* small problems */
                                   .quiet = 1};
  const double from = bench_clock();
  SDR_TRY(run_silently(&options));
  t->seconds = bench_clock() - from;
  SDR_TRY(sdr_rundata_open(directory, &data));
  for (int k = 0; k < scene->figure_count; ++k) add_figure(t, data, scene, scene->figure[k].name);
  for (int k = 0; k < scene->output.measure_count; ++k)
    if (!is_figure(scene, scene->output.measure[k].name))
      add_figure(t, data, scene, scene->output.measure[k].name);
  sdr_rundata_destroy(&data);
  return SDR_OK;
}

/* What breaks shows no errors, unless the scene measures some: for those who name it. */
static int is_about_accuracy(const sdr_scene *scene)
{
  if (scene->output.measure_count > 0) return 1;
  return scene->figure_count > 0 && scene->damage.law == SDR_LAW_NONE;
}

static int has_paper(const sdr_scene *scene)
{
  for (int k = 0; k < scene->figure_count; ++k)
    if (!isnan(scene->figure[k].paper)) return 1;
  return 0;
}

static int is_wanted(const table *t, const sdr_scene *scene, int is_named)
{
  if (t->papers_only) return has_paper(scene);
  return is_named || is_about_accuracy(scene);
}

static int has_ranges(const sdr_scene *scene)
{
  for (int k = 0; k < scene->figure_count; ++k)
    if (!isnan(scene->figure[k].low) || !isnan(scene->figure[k].high)) return 1;
  return 0;
}

/* A run that fails is a line of the table too. Of a variant that nothing is expected of, some are
   there to be refused: a horizon of one spacing makes a mechanism. */
static void try_one(table *t, const char *path, const char *variant, int is_named)
{
  sdr_scene *scene = NULL;
  sdr_status status = sdr_scene_load(path, variant, 0, NULL, &scene);
  if (status == SDR_OK && is_wanted(t, scene, is_named)) {
    fprintf(stderr, "%s %s ... ", scene->name, variant);
    status = run_one(t, path, variant, scene);
    fprintf(stderr, status == SDR_OK ? "%.1f s\n" : "failed\n", t->seconds);
    ++t->runs;
  }
  if (status != SDR_OK) {
    const int refused = scene && !has_ranges(scene);
    printf("%-24s %-28s %s: %s\n", scene ? scene->name : path, variant,
           refused ? "refused" : "failed", sdr_error_message());
    ++*(refused ? &t->refused : &t->failed);
  }
  fflush(stdout);
  sdr_scene_destroy(&scene);
}

/* ---- variants and problems ------------------------------------------------------------------- */

static sdr_status parse(const char *path, sdr_store *store, sdr_node **root)
{
  char *text;
  size_t length;
  SDR_TRY(sdr_yaml_read_file(path, &text, &length));
  const sdr_status status = sdr_yaml_parse(store, text, length, path, root);
  sdr_free(text);
  return status;
}

/* All variants of a problem, or, of PROBLEM:VARIANT, that one ("": the scene itself). */
static sdr_status try_problem(table *t, const char *name, int is_named)
{
  char path[SDR_SCENE_PATH], problem[SDR_SCENE_PATH];
  const char *colon = strchr(name, ':');
  sdr_node *root = NULL;
  snprintf(problem, sizeof problem, "%.*s", (int)strcspn(name, ":"), name);
  SDR_TRY(sdr_find_scene(problem, path));
  if (colon) {
    try_one(t, path, colon + 1, is_named);
    return SDR_OK;
  }
  sdr_store *store = sdr_store_create();
  sdr_status status = store ? parse(path, store, &root) : SDR_RUN_FAILED;
  if (status == SDR_OK) {
    const sdr_node *variants = root ? sdr_node_find(root, "variants") : NULL;
    try_one(t, path, "", is_named);
    for (const sdr_node *v = variants ? variants->first : NULL; v; v = v->next)
      try_one(t, path, v->key, is_named);
  }
  sdr_store_destroy(&store);
  return status;
}

/* The first words of the lines of `sunder problems`. */
static sdr_status try_all(table *t)
{
  char *text = NULL, *rest = NULL;
  size_t size = 0;
  FILE *list = open_memstream(&text, &size);
  if (!list) return sdr_fail(SDR_RUN_FAILED, "out of memory for the list of problems");
  sdr_status status = sdr_list_problems(list);
  fclose(list);
  for (char *line = strtok_r(text, "\n", &rest); line && status == SDR_OK;
       line = strtok_r(NULL, "\n", &rest)) {
    line[strcspn(line, " \t")] = '\0';
    status = try_problem(t, line, 0);
  }
  free(text);
  return status;
}

/* ---- picture --------------------------------------------------------------------------------- */

/* Ours over the paper's, a row a figure; the accepted range as a bar. */
static sdr_status draw(const table *t, const char *path)
{
  const double row = 22.0, left = 470.0;
  const int height = (int)(row * t->beside_count) + 130;
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 1400, height, 17.0));
  sdr_picture_place(&picture, (sdr_area){left, 75, 1400 - left - 40, height - 125.0});
  FILE *script = picture.script;
  fputs("$d << E\n", script);
  for (int k = t->beside_count - 1; k >= 0; --k) {
    const compared *c = &t->beside[k];
    fprintf(script, "\"%s\" %g %g %g\n", c->name, c->value / c->paper,
            fmax(c->low / c->paper, 1e-3), c->high / c->paper);
  }
  fprintf(script,
          "E\nset border 3\nset xtics nomirror (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)\n"
          "set ytics nomirror scale 0 font ',10'\nset grid x lc '#e8e8e8'\nset logscale x\n"
          "set xrange [0.015:6]\nset yrange [-0.7:%g]\n"
          "set xlabel 'ours / the value that the paper prints (errors: less is better)'\n"
          "set key outside top center horizontal\n"
          "set arrow from 1,graph 0 to 1,graph 1 nohead lc '#000000'\n"
          "plot $d using 3:0:($4-$3):(0):ytic(1) with vectors nohead lw 7 lc '#cfe3f3' "
          "t 'accepted range', $d using 2:0 with points pt 7 ps 1.2 lc '#0072b2' t 'ours'\n",
          t->beside_count - 0.3);
  return sdr_picture_end(&picture, path);
}

static sdr_status make_table(table *t, int count, char **names)
{
  SDR_TRY(bench_directory("accuracy", t->directory));
  SDR_TRY(bench_csv(t->directory, "accuracy", &t->csv));
  fputs("problem,variant,figure,value,low,high,paper,verdict,seconds\n", t->csv);
  printf("%-24s %-28s %-20s %-11s %-18s %-9s %-7s %8s\n", "problem", "variant", "figure (SI)",
         "value", "accepted", "paper", "", "run, s");
  sdr_status status = count > 0 ? SDR_OK : try_all(t);
  for (int k = 0; k < count && status == SDR_OK; ++k) status = try_problem(t, names[k], 1);
  if (fclose(t->csv) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "%s: disk full", t->directory);
  if (status == SDR_OK && t->beside_count > 0) {
    char path[2 * BENCH_PATH];
    snprintf(path, sizeof path, "%s/accuracy.png", t->directory);
    status = draw(t, path);
  }
  return status;
}

int main(int count, char **arguments)
{
  static table t;
  t.papers_only = count > 1 && strcmp(arguments[1], "--papers") == 0;
  if (make_table(&t, count - 1 - t.papers_only, arguments + 1 + t.papers_only) != SDR_OK) {
    fprintf(stderr, "bench accuracy: %s\n", sdr_error_message());
    return 1;
  }
  printf("\n%d runs (%d refused, %d failed), %d figures, %d with a range, %d of them outside it\n"
         "%s\ntable: %s/accuracy.csv%s\n",
         t.runs, t.refused, t.failed, t.figures, t.ranged, t.outside, bench_origin(), t.directory,
         t.beside_count > 0 ? ", picture beside it" : "");
  return t.failed > 0 || t.outside > 0;
}
