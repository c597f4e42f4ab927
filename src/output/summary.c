#include "output/summary.h"

#include "output/rundir.h"
#include "output/version.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

/* An object that remembers whether anything could not be put into it. */
typedef struct {
  json_t *object;
  int failed;
} record;

static record begin(void)
{
  json_t *object = json_object();
  return (record){object, object == NULL};
}

static void put(record *r, const char *key, json_t *value)
{
  if (!value || json_object_set_new(r->object, key, value) != 0) r->failed = 1;
}

static void put_record(record *r, const char *key, record part)
{
  r->failed |= part.failed;
  put(r, key, part.object);
}

static void put_real(record *r, const char *key, double value)
{
  put(r, key, isfinite(value) ? json_real(value) : json_null());
}

static void put_whole(record *r, const char *key, int64_t value)
{
  put(r, key, json_integer((json_int_t)value));
}

/* Text that is not UTF-8 (from a command line) is null too. */
static void put_text(record *r, const char *key, const char *text)
{
  json_t *value = text ? json_string(text) : NULL;
  put(r, key, value ? value : json_null());
}

static const char *dimension_text(sdr_dimension dimension)
{
  static const char *const names[] = {"1d", "plane_stress", "plane_strain", "3d"};
  return names[dimension];
}

static const char *model_text(sdr_model_kind model)
{
  static const char *const names[] = {"bond_based", "ordinary", "nonordinary"};
  return names[model];
}

static const char *law_text(sdr_law law)
{
  static const char *const names[] = {"none", "variational", "critical_stretch"};
  return names[law];
}

static void put_identity(record *r, const sdr_summary *s)
{
  put_text(r, "program", "sunder");
  put_text(r, "version", s->version ? s->version : SUNDER_VERSION);
  put_text(r, "commit", s->commit);
  put_text(r, "scene", s->scene->name);
  put_text(r, "title", s->scene->title);
  put_text(r, "dimension", dimension_text(s->scene->dimension));
  put_text(r, "model", model_text(s->scene->model));
  put_text(r, "damage_law", law_text(s->scene->damage.law));
  put_text(r, "integrator", s->scene->time.integrator);
  put_text(r, "precision", s->scene->mixed ? "mixed" : "double");
  put_whole(r, "threads", s->threads);
}

static void put_size(record *r, const sdr_summary *s)
{
  put_whole(r, "points", s->points);
  put_whole(r, "bonds", s->bonds);
  put_whole(r, "pairs", s->pairs);
  put_whole(r, "runs", s->runs);
  put_whole(r, "loose", s->loose);
  put_whole(r, "steps", s->steps);
  put_real(r, "step", s->step_size);
  put_real(r, "time_end", s->time_end);
}

static void put_cost(record *r, const sdr_summary *s)
{
  record wall = begin();
  put_real(&wall, "setup", s->wall_setup);
  put_real(&wall, "integrate", s->wall_integrate);
  put_real(&wall, "output", s->wall_output);
  put_real(&wall, "total", s->wall_total);
  put_record(r, "wall_seconds", wall);

  const double steps = (double)(s->steps_run > 0 ? s->steps_run : s->steps);
  struct rusage usage;
  put_real(r, "ns_per_bond_step", 1e9 * s->wall_integrate / ((double)s->bonds * steps));
  const int known = getrusage(RUSAGE_SELF, &usage) == 0;
  put_whole(r, "peak_memory_bytes", known ? (int64_t)usage.ru_maxrss * 1024 : 0);
}

static void put_balance(record *r, const sdr_summary *s)
{
  record energy = begin(), momentum = begin(), damage = begin();
  put_real(&energy, "kinetic", s->books.kinetic);
  put_real(&energy, "stored", s->books.stored);
  put_real(&energy, "dissipated", s->books.dissipated);
  put_real(&energy, "external_work", s->books.external_work);
  put_real(&energy, "imbalance", s->books.imbalance);
  put_real(&energy, "imbalance_relative", s->books.imbalance_relative);
  put_real(&energy, "imbalance_largest", s->books.imbalance_largest);
  put_record(r, "energy", energy);
  put_real(&momentum, "linear", s->books.linear_residual);
  put_real(&momentum, "angular", s->books.angular_residual);
  put_record(r, "momentum", momentum);
  put_real(&damage, "onset_time", s->onset_time);
  put_real(&damage, "max", s->damage_max);
  put_real(&damage, "mean", s->damage_mean);
  put_record(r, "damage", damage);
}

static void put_fragments(record *r, const sdr_summary *s)
{
  record fragments = begin();
  if (s->fragments_known) {
    put_whole(&fragments, "count", s->fragments.count);
    put_whole(&fragments, "largest", s->fragments.largest);
  } else {
    put(&fragments, "count", json_null());
    put(&fragments, "largest", json_null());
  }
  put_record(r, "fragments", fragments);
}

static void put_solve(record *r, const sdr_solve_record *solve)
{
  put_text(r, "name", solve->name);
  put_whole(r, "unknowns", solve->unknowns);
  put_whole(r, "nonzeros", solve->nonzeros);
  put_real(r, "assemble_seconds", solve->assemble_seconds);
  put_real(r, "factor_seconds", solve->factor_seconds);
  put_real(r, "solve_seconds", solve->solve_seconds);
  put_real(r, "memory_bytes", solve->bytes);
  put_whole(r, "iterations", solve->iterations);
  put_real(r, "residual", solve->residual);
  put_real(r, "nonlinearity", solve->nonlinearity);
}

static void put_solver(record *r, const sdr_summary *s)
{
  record solver = begin();
  put_real(&solver, "stable_step", s->stable_step);
  put_text(&solver, "instruction_set", s->instruction_set);
  if (s->solve && s->solve->name) put_solve(&solver, s->solve);
  put_record(r, "solver", solver);

  json_t *skipped = json_array();
  for (int k = 0; k < s->skipped_count; ++k) {
    json_t *line = json_string(s->skipped[k]);
    if (json_array_append_new(skipped, line ? line : json_null()) != 0) r->failed = 1;
  }
  put(r, "skipped", skipped);
}

static const sdr_measured *look_up(const char *name, const sdr_measured *measured, int count)
{
  for (int k = 0; k < count; ++k)
    if (strcmp(measured[k].name, name) == 0) return &measured[k];
  return NULL;
}

sdr_status sdr_figures_check(const sdr_scene *scene, const sdr_measured *measured, int count)
{
  for (int f = 0; f < scene->figure_count; ++f) {
    const sdr_figure *figure = &scene->figure[f];
    char known[1024] = "nothing";
    size_t length = 0;
    if (look_up(figure->name, measured, count)) continue;
    for (int k = 0; k < count && length + 2 * SDR_NAME_MAX < sizeof known; ++k)
      length += (size_t)snprintf(known + length, sizeof known - length, "%s%.*s", k ? ", " : "",
                                 SDR_NAME_MAX, measured[k].name);
    return sdr_fail(SDR_BAD_INPUT, "%s: nothing measures the figure '%s'; this run measures %s",
                    sdr_origin_text(figure->origin), figure->name, known);
  }
  return SDR_OK;
}

static void put_figure(record *figures, const sdr_figure *range, const sdr_measured *measured)
{
  record one = begin();
  put_real(&one, "value", measured->value);
  put_real(&one, "low", range->low);
  put_real(&one, "high", range->high);
  put_real(&one, "paper", range->paper);
  put_record(figures, measured->name, one);
}

/* The scene's figures in its order, then measures without a range. */
static void put_figures(record *r, const sdr_summary *s)
{
  const sdr_figure open_range = {.low = NAN, .high = NAN, .paper = NAN};
  record figures = begin();
  for (int f = 0; f < s->scene->figure_count; ++f)
    put_figure(&figures, &s->scene->figure[f],
               look_up(s->scene->figure[f].name, s->measured, s->measured_count));
  for (int k = 0; k < s->measured_count; ++k)
    if (s->measured[k].always && !json_object_get(figures.object, s->measured[k].name))
      put_figure(&figures, &open_range, &s->measured[k]);
  put_record(r, "figures", figures);
}

sdr_status sdr_summary_write(const char *directory, const sdr_summary *summary)
{
  SDR_TRY(sdr_figures_check(summary->scene, summary->measured, summary->measured_count));
  record r = begin();
  put_identity(&r, summary);
  put_size(&r, summary);
  put_cost(&r, summary);
  put_balance(&r, summary);
  put_fragments(&r, summary);
  put_solver(&r, summary);
  put_figures(&r, summary);
  char *text = NULL;
  size_t size = 0;
  FILE *to = r.failed ? NULL : open_memstream(&text, &size);
  int failed = !to || json_dumpf(r.object, to, JSON_INDENT(2)) != 0 || fputc('\n', to) == EOF;
  if (to && fclose(to) != 0) failed = 1;
  json_decref(r.object);
  const sdr_status status = failed ? sdr_fail(SDR_RUN_FAILED, "out of memory for summary.json")
                                   : sdr_rundir_write(directory, "summary.json", text);
  free(text);
  return status;
}
