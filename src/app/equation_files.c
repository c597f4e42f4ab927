#include "app/equation_files.h"

#include "base/memory.h"
#include "output/frames.h"
#include "output/xdmf.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* ---- snapshots ------------------------------------------------------------------------------- */

enum { MOST_FIELDS = 8 };

/* Fields of the frame: their values, `width` a point, are borrowed. */
typedef struct {
  int count;
  sdr_field_info info[MOST_FIELDS];
  const sdr_field_info *list[MOST_FIELDS];
  const double *value[MOST_FIELDS];
  int widest;
} fields;

static void add(fields *all, const char *name, const char *unit, int width, int is_tensor,
                const double *value)
{
  if (!value) return;
  const int k = all->count++;
  const sdr_field_kind kind = is_tensor   ? SDR_TENSOR_FIELD
                              : width > 1 ? SDR_VECTOR_FIELD
                                          : SDR_SCALAR_FIELD;
  all->info[k] = (sdr_field_info){name, unit, kind};
  all->list[k] = &all->info[k];
  all->value[k] = value;
  if (width > all->widest) all->widest = width;
}

/* The difference over the largest exact value; NULL in *out if nothing exact is known. */
static sdr_status find_error(const sdr_equation_run *run, double **out)
{
  const sdr_solution *s = run->solution;
  const size_t values = (size_t)s->width * (size_t)run->problem->points->count;
  double largest = 0.0;
  if (!s->exact) return SDR_OK;
  *out = sdr_alloc(values, sizeof **out);
  if (!*out) return SDR_RUN_FAILED;
  for (size_t k = 0; k < values; ++k) largest = fmax(largest, fabs(s->exact[k]));
  for (size_t k = 0; k < values; ++k)
    (*out)[k] = (s->value[k] - s->exact[k]) / (largest > 0.0 ? largest : 1.0);
  return SDR_OK;
}

static void choose_fields(const sdr_equation_run *run, const double *error, fields *all)
{
  const sdr_solution *s = run->solution;
  const sdr_problem *p = run->problem;
  const int32_t count = p->points->count;
  add(all, p->words->solution, p->words->symbol, s->width, 0, s->value);
  if (p->equation->kind == SDR_PLATE) add(all, "moment", "N", 1, 0, s->value + count);
  add(all, "stress", "Pa", s->stresses, 1, s->stress);
  add(all, "exact", p->words->symbol, s->width, 0, s->exact);
  add(all, "error", "1", s->width, 0, error);
  add(all, "condition", "1", 1, 0, p->shape.condition);
}

static sdr_status write_file(const sdr_equation_run *run, const fields *all, const char *path)
{
  const sdr_points *points = run->problem->points;
  sdr_hdf *file = NULL;
  float *packed = sdr_alloc((size_t)all->widest * (size_t)points->count, sizeof *packed);
  sdr_status status = packed ? sdr_hdf_create(path, &file) : SDR_RUN_FAILED;
  if (status == SDR_OK) status = sdr_frames_write_points(file, -1, points);
  for (int k = 0; status == SDR_OK && k < all->count; ++k)
    status =
        sdr_frame_write(file, 0, all->list[k], sdr_field_width(all->list[k], points->components),
                        points, all->value[k], packed);
  if (status == SDR_OK) status = sdr_frame_finish(file, 0, 0.0);
  if (status == SDR_OK) status = sdr_hdf_close(&file);
  if (status != SDR_OK) {
    sdr_hdf_discard(&file);
    unlink(path);
  }
  sdr_free(packed);
  return status;
}

sdr_status sdr_equation_write_frame(const sdr_equation_run *run)
{
  static const double start = 0.0;
  static const int own = 0;
  const sdr_points *points = run->problem->points;
  char path[1024];
  double *error = NULL;
  fields all = {0};
  snprintf(path, sizeof path, "%s/snapshots.h5", run->directory);
  SDR_TRY(find_error(run, &error));
  choose_fields(run, error, &all);
  const sdr_xdmf what = {.points = &points->count,
                         .own_points = &own,
                         .components = points->components,
                         .frame_count = 1,
                         .times = &start,
                         .field_count = all.count,
                         .fields = all.list};
  sdr_status status = write_file(run, &all, path);
  if (status == SDR_OK) status = sdr_xdmf_write(run->directory, &what);
  sdr_free(error);
  return status;
}

/* ---- summary --------------------------------------------------------------------------------- */

static void put_equation(sdr_record *r, const sdr_equation_run *run)
{
  const sdr_problem *p = run->problem;
  const sdr_equation *e = p->equation;
  sdr_record_text(r, "model", "nonlocal_operators");
  sdr_record_text(r, "equation", p->words->word);
  sdr_record_text(r, "form", e->variational ? "variational" : "collocation");
  sdr_record_whole(r, "order", e->order);
  sdr_record_whole(r, "threads", run->threads);
  sdr_record_whole(r, "points", p->points->count);
}

static void put_solver(sdr_record *r, const sdr_equation_run *run)
{
  const sdr_solution *s = run->solution;
  const sdr_problem *p = run->problem;
  sdr_record solver = sdr_record_begin(), condition = sdr_record_begin();
  sdr_record_text(&solver, "name", s->solver.name);
  sdr_record_whole(&solver, "unknowns", s->unknowns);
  sdr_record_whole(&solver, "nonzeros", s->nonzeros);
  sdr_record_real(&solver, "assemble_seconds", s->assemble_seconds);
  sdr_record_real(&solver, "solve_seconds", s->solve_seconds);
  sdr_record_real(&solver, "memory_bytes", s->solver.bytes);
  sdr_record_whole(&solver, "iterations", s->solver.iterations);
  sdr_record_real(&solver, "residual", s->solver.residual);
  sdr_record_real(&condition, "worst", p->shape.condition[p->shape.worst]);
  sdr_record_real(&condition, "mean", sdr_problem_mean_condition(p));
  sdr_record_part(&solver, "condition", condition);
  sdr_record_whole(&solver, "enlarged_supports", p->shape.enlarged);
  sdr_record_part(r, "solver", solver);
}

static void put_study(sdr_record *r, const sdr_equation_run *run)
{
  json_t *list = json_array();
  for (int k = 0; k < run->level_count; ++k) {
    const sdr_study_level *level = &run->level[k];
    sdr_record one = sdr_record_begin();
    sdr_record_real(&one, "spacing", level->spacing);
    sdr_record_whole(&one, "points", level->points);
    sdr_record_real(&one, "error_l2", level->error_l2);
    sdr_record_real(&one, "error_max", level->error_max);
    sdr_record_real(&one, "error_stress", level->error_stress);
    if (one.failed || json_array_append_new(list, one.object) != 0) r->failed = 1;
  }
  sdr_record_put(r, "study", list);
}

static void put_cost(sdr_record *r, const sdr_equation_run *run)
{
  struct rusage usage;
  sdr_record wall = sdr_record_begin();
  sdr_record_real(&wall, "setup", run->setup_seconds);
  sdr_record_real(&wall, "solve", run->solve_seconds);
  sdr_record_real(&wall, "output", run->output_seconds);
  sdr_record_real(&wall, "total", run->total_seconds);
  sdr_record_part(r, "wall_seconds", wall);
  const int known = getrusage(RUSAGE_SELF, &usage) == 0;
  sdr_record_whole(r, "peak_memory_bytes", known ? (int64_t)usage.ru_maxrss * 1024 : 0);
}

sdr_status sdr_equation_write_summary(const sdr_equation_run *run)
{
  const sdr_scene *scene = run->problem->scene;
  sdr_record r = sdr_record_begin();
  sdr_summary_identity(&r, scene, NULL, run->commit);
  put_equation(&r, run);
  put_cost(&r, run);
  put_solver(&r, run);
  put_study(&r, run);
  sdr_summary_figures(&r, scene, run->measured, run->measured_count);
  return sdr_record_write(&r, run->directory);
}
