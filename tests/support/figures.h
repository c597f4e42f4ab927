/* Run a problem as the program does and look at the figures of its summary. */
#ifndef SDR_TESTS_FIGURES_H
#define SDR_TESTS_FIGURES_H

#include "app/find_scene.h"
#include "app/run.h"
#include "support/cmocka_all.h"

#include <ftw.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  json_t *root, *figures;
} figures;

static inline int figures_remove(const char *path, const struct stat *status, int kind,
                                 struct FTW *where)
{
  (void)status;
  (void)kind;
  (void)where;
  return remove(path);
}

/* Problem `name` with a variant (NULL: none) and overrides, ended by NULL. On one thread: the
   problems of this kind are small. */
static inline void figures_run(figures *f, const char *name, const char *variant,
                               const char *const *sets)
{
  char directory[] = "sunder_figures_XXXXXX", path[SDR_SCENE_PATH], summary[64];
  sdr_run_options options = {.scene = path, .variant = variant, .threads = 1, .quiet = 1};
  json_error_t error;
  assert_non_null(mkdtemp(directory));
  options.directory = directory;
  while (sets && sets[options.set_count]) ++options.set_count;
  options.sets = sets;
  assert_int_equal(sdr_find_scene(name, path), SDR_OK);
  FILE *out = fopen("/dev/null", "w");
  assert_non_null(out);
  if (sdr_run(&options, out) != SDR_OK) fail_msg("%s: %s", name, sdr_error_message());
  fclose(out);
  snprintf(summary, sizeof summary, "%s/summary.json", directory);
  f->root = json_load_file(summary, 0, &error);
  if (!f->root) fail_msg("%s: %s", summary, error.text);
  f->figures = json_object_get(f->root, "figures");
  nftw(directory, figures_remove, 8, FTW_DEPTH | FTW_PHYS);
}

static inline void figures_free(figures *f)
{
  json_decref(f->root);
  *f = (figures){0};
}

/* NAN: null. */
static inline double figures_value(const figures *f, const char *name)
{
  const json_t *figure = json_object_get(f->figures, name);
  if (!figure) fail_msg("there is no figure '%s'", name);
  const json_t *value = json_object_get(figure, "value");
  return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

/* Every figure with a range lies in it, and at least `least` have one. */
static inline void figures_assert_accepted(const figures *f, int least)
{
  const char *name;
  json_t *figure;
  int ranges = 0, wrong = 0;
  json_object_foreach(f->figures, name, figure)
  {
    const json_t *low = json_object_get(figure, "low"), *high = json_object_get(figure, "high");
    const double value = figures_value(f, name);
    if (!json_is_number(low) && !json_is_number(high)) continue;
    ++ranges;
    const int good = (!json_is_number(low) || value >= json_number_value(low)) &&
                     (!json_is_number(high) || value <= json_number_value(high));
    if (!good) print_error("figure %s = %g is outside its range\n", name, value);
    wrong += !good;
  }
  assert_int_equal(wrong, 0);
  assert_true(ranges >= least);
}

#endif
