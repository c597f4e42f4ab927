#include "output/summary.h"

#include "damage/laws.h"
#include "output/record.h"
#include "output/version.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

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
  static const char *const names[] = SDR_LAW_NAMES;
  return names[law];
}

void sdr_summary_identity(sdr_record *r, const sdr_scene *scene, const char *version,
                          const char *commit)
{
  sdr_record_text(r, "program", "sunder");
  sdr_record_text(r, "version", version ? version : SUNDER_VERSION);
  sdr_record_text(r, "commit", commit);
  sdr_record_text(r, "scene", scene->name);
  sdr_record_text(r, "title", scene->title);
  sdr_record_text(r, "dimension", scene->stateless ? "2d" : dimension_text(scene->dimension));
}

static void put_identity(sdr_record *r, const sdr_summary *s)
{
  sdr_summary_identity(r, s->scene, s->version, s->commit);
  sdr_record_text(r, "model", model_text(s->scene->model));
  sdr_record_text(r, "damage_law", law_text(s->scene->damage.law));
  sdr_record_text(r, "integrator", s->scene->time.integrator);
  sdr_record_text(r, "precision", s->scene->mixed ? "mixed" : "double");
  sdr_record_whole(r, "threads", s->threads);
}

static void put_constants(sdr_record *r, const sdr_material_constants *c)
{
  if (!c) return;
  sdr_record constants = sdr_record_begin();
  sdr_record_real(&constants, "poisson", c->poisson);
  sdr_record_real(&constants, "bulk", c->bulk);
  sdr_record_real(&constants, "shear", c->shear);
  sdr_record_real(&constants, "control_shear", c->control_shear);
  sdr_record_real(&constants, "control_normal", c->control_normal);
  sdr_record_real(&constants, "condition", c->condition);
  sdr_record_real(&constants, "ell", c->ell);
  sdr_record_real(&constants, "critical_stretch", c->critical_stretch);
  sdr_record_part(r, "constants", constants);
}

static void put_size(sdr_record *r, const sdr_summary *s)
{
  sdr_record_whole(r, "points", s->points);
  sdr_record_whole(r, "bonds", s->bonds);
  sdr_record_whole(r, "pairs", s->pairs);
  sdr_record_whole(r, "runs", s->runs);
  sdr_record_whole(r, "loose", s->loose);
  sdr_record_whole(r, "steps", s->steps);
  sdr_record_real(r, "step", s->step_size);
  sdr_record_real(r, "time_end", s->time_end);
}

static void put_cost(sdr_record *r, const sdr_summary *s)
{
  sdr_record wall = sdr_record_begin();
  sdr_record_real(&wall, "setup", s->wall_setup);
  sdr_record_real(&wall, "integrate", s->wall_integrate);
  sdr_record_real(&wall, "output", s->wall_output);
  sdr_record_real(&wall, "total", s->wall_total);
  sdr_record_part(r, "wall_seconds", wall);

  const double steps = (double)(s->steps_run > 0 ? s->steps_run : s->steps);
  struct rusage usage;
  sdr_record_real(r, "ns_per_bond_step", 1e9 * s->wall_integrate / ((double)s->bonds * steps));
  const int known = getrusage(RUSAGE_SELF, &usage) == 0;
  sdr_record_whole(r, "peak_memory_bytes", known ? (int64_t)usage.ru_maxrss * 1024 : 0);
}

static void put_balance(sdr_record *r, const sdr_summary *s)
{
  sdr_record energy = sdr_record_begin(), momentum = sdr_record_begin(),
             damage = sdr_record_begin();
  sdr_record_real(&energy, "kinetic", s->books.kinetic);
  sdr_record_real(&energy, "stored", s->books.stored);
  sdr_record_real(&energy, "dissipated", s->books.dissipated);
  sdr_record_real(&energy, "viscous", s->books.viscous);
  sdr_record_real(&energy, "contact", s->books.contact);
  sdr_record_real(&energy, "refinement", s->books.refinement);
  sdr_record_real(&energy, "external_work", s->books.external_work);
  sdr_record_real(&energy, "imbalance", s->books.imbalance);
  sdr_record_real(&energy, "imbalance_relative", s->books.imbalance_relative);
  sdr_record_real(&energy, "imbalance_largest", s->books.imbalance_largest);
  sdr_record_part(r, "energy", energy);
  sdr_record_real(&momentum, "linear", s->books.linear_residual);
  sdr_record_real(&momentum, "angular", s->books.angular_residual);
  sdr_record_part(r, "momentum", momentum);
  sdr_record_real(&damage, "onset_time", s->onset_time);
  sdr_record_real(&damage, "max", s->damage_max);
  sdr_record_real(&damage, "mean", s->damage_mean);
  sdr_record_part(r, "damage", damage);
}

static void put_fragments(sdr_record *r, const sdr_summary *s)
{
  sdr_record fragments = sdr_record_begin();
  if (s->fragments_known) {
    sdr_record_whole(&fragments, "count", s->fragments.count);
    sdr_record_whole(&fragments, "largest", s->fragments.largest);
  } else {
    sdr_record_put(&fragments, "count", json_null());
    sdr_record_put(&fragments, "largest", json_null());
  }
  sdr_record_part(r, "fragments", fragments);
}

static json_t *fork_record(const sdr_crack_fork *fork, int components)
{
  static const char *const axes[] = {"x", "y", "z"};
  sdr_record one = sdr_record_begin();
  sdr_record_real(&one, "time", fork->time);
  for (int c = 0; c < components; ++c) sdr_record_real(&one, axes[c], fork->x[c]);
  sdr_record_real(&one, "distance", fork->distance);
  sdr_record_real(&one, "speed", fork->speed);
  return one.object;
}

/* What was told of each crack that was followed. */
static void put_cracks(sdr_record *r, const sdr_summary *s)
{
  const sdr_cracks_output *wanted = &s->scene->output.cracks;
  sdr_record cracks = sdr_record_begin();
  for (int k = 0; s->cracks && k < wanted->tip_count; ++k) {
    sdr_record one = sdr_record_begin();
    json_t *forks = json_array();
    for (int n = 0; n < SDR_CRACK_FIGURES; ++n)
      sdr_record_real(&one, sdr_crack_figure_words[n], s->cracks[k].figure[n]);
    for (int n = 0; n < s->cracks[k].fork_count; ++n)
      if (json_array_append_new(
              forks, fork_record(&s->cracks[k].fork[n], sdr_components(s->scene->dimension))) != 0)
        r->failed = 1;
    sdr_record_put(&one, "forks", forks);
    sdr_record_part(&cracks, wanted->tip[k].name, one);
  }
  sdr_record_part(r, "cracks", cracks);
}

static void put_solve(sdr_record *r, const sdr_solve_record *solve)
{
  sdr_record_text(r, "name", solve->name);
  sdr_record_whole(r, "unknowns", solve->unknowns);
  sdr_record_whole(r, "nonzeros", solve->nonzeros);
  sdr_record_real(r, "assemble_seconds", solve->assemble_seconds);
  sdr_record_real(r, "factor_seconds", solve->factor_seconds);
  sdr_record_real(r, "solve_seconds", solve->solve_seconds);
  sdr_record_real(r, "memory_bytes", solve->bytes);
  sdr_record_whole(r, "iterations", solve->iterations);
  sdr_record_real(r, "residual", solve->residual);
  sdr_record_real(r, "nonlinearity", solve->nonlinearity);
  sdr_record_whole(r, "accepted", solve->accepted);
  sdr_record_whole(r, "cuts", solve->cuts);
  sdr_record_whole(r, "newton_iterations", solve->newton);
  sdr_record_whole(r, "factorisations", solve->factorisations);
  sdr_record_whole(r, "fallbacks", solve->fallbacks);
}

static void put_method(sdr_record *r, const sdr_method_record *method)
{
  sdr_record_text(r, "method", method->name);
  sdr_record_text(r, "name", method->solver);
  sdr_record_whole(r, "unknowns", method->unknowns);
  sdr_record_whole(r, "steps", method->steps);
  sdr_record_whole(r, "force_evaluations", method->evaluations);
  sdr_record_whole(r, "newton_iterations", method->iterations);
  sdr_record_whole(r, "iterations", method->linear_iterations);
  sdr_record_whole(r, "error_test_failures", method->error_failures);
  sdr_record_whole(r, "newton_failures", method->iteration_failures);
  sdr_record_whole(r, "tangents", method->tangents);
  sdr_record_whole(r, "factorisations", method->factors);
  sdr_record_whole(r, "order", method->order);
  sdr_record_real(r, "last_step", method->last_step);
  sdr_record_real(r, "residual", method->residual);
}

static void put_solver(sdr_record *r, const sdr_summary *s)
{
  sdr_record solver = sdr_record_begin();
  sdr_record_real(&solver, "stable_step", s->stable_step);
  sdr_record_text(&solver, "instruction_set", s->instruction_set);
  if (s->solve && s->solve->name) put_solve(&solver, s->solve);
  if (s->method && s->method->name) put_method(&solver, s->method);
  sdr_record_part(r, "solver", solver);

  json_t *skipped = json_array();
  for (int k = 0; k < s->skipped_count; ++k) {
    json_t *line = json_string(s->skipped[k]);
    if (json_array_append_new(skipped, line ? line : json_null()) != 0) r->failed = 1;
  }
  sdr_record_put(r, "skipped", skipped);
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

static void put_figure(sdr_record *figures, const sdr_figure *range, const sdr_measured *measured)
{
  sdr_record one = sdr_record_begin();
  sdr_record_real(&one, "value", measured->value);
  sdr_record_real(&one, "low", range->low);
  sdr_record_real(&one, "high", range->high);
  sdr_record_real(&one, "paper", range->paper);
  sdr_record_part(figures, measured->name, one);
}

void sdr_summary_figures(sdr_record *r, const sdr_scene *scene, const sdr_measured *measured,
                         int count)
{
  const sdr_figure open_range = {.low = NAN, .high = NAN, .paper = NAN};
  sdr_record figures = sdr_record_begin();
  for (int f = 0; f < scene->figure_count; ++f)
    put_figure(&figures, &scene->figure[f], look_up(scene->figure[f].name, measured, count));
  for (int k = 0; k < count; ++k)
    if (measured[k].always && !json_object_get(figures.object, measured[k].name))
      put_figure(&figures, &open_range, &measured[k]);
  sdr_record_part(r, "figures", figures);
}

sdr_status sdr_summary_write(const char *directory, const sdr_summary *summary)
{
  SDR_TRY(sdr_figures_check(summary->scene, summary->measured, summary->measured_count));
  sdr_record r = sdr_record_begin();
  put_identity(&r, summary);
  put_constants(&r, summary->constants);
  put_size(&r, summary);
  put_cost(&r, summary);
  put_balance(&r, summary);
  put_fragments(&r, summary);
  if (summary->cracks) put_cracks(&r, summary);
  put_solver(&r, summary);
  sdr_summary_figures(&r, summary->scene, summary->measured, summary->measured_count);
  return sdr_record_write(&r, directory);
}
