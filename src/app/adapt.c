#include "app/adapt.h"

#include "app/adapt_zone.h"
#include "app/body.h"
#include "base/memory.h"
#include "mechanics/refine_motion.h"
#include "nom/own_share.h"
#include "output/hdf.h"
#include "time/stable_step.h"

#include <math.h>
#include <string.h>
#include <time.h>

/* What a checkpoint holds beside the levels. Doubles and int64 only: no padding. */
typedef struct {
  double looked; /* s, the latest look; negative: none */
  double energy; /* J */
  int64_t events;
  int64_t owed; /* 1: a look was due when the run ended, and is taken if it goes on */
} standing;

typedef struct {
  sdr_observer head;
  sdr_built *built;
  sdr_moment *moment;
  sdr_observer *const *observers;
  const int *observer_count;
  sdr_adapt_zone *zone;
  standing now;
  int32_t first_points;
  int first_level;    /* the finest that the run begins with */
  double first_limit; /* s, its stable step */
  double *young;      /* Pa, of the first points by generation */
  double *share;      /* likewise: of a full family's energy of dilation (sdr_own_shares) */
  int32_t *root;      /* of each point, by generation: the first point it came out of, likewise */
  uint8_t *levels;    /* of each point, by generation */
  double *energy, *damage; /* scratch, a point */
  uint8_t *split;          /* likewise */
  double seconds, looking; /* s */
} adapt;

static adapt *of(sdr_observer *observer)
{
  return (adapt *)(void *)observer;
}

static double wall(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int32_t rank_of(const sdr_points *points, int32_t i)
{
  return points->generated ? points->generated[i] : i;
}

static int finest(const sdr_points *points)
{
  int level = 0;
  for (int r = 0; r < points->row_count; ++r)
    if (points->rows[r].level > level) level = points->rows[r].level;
  return level;
}

/* ---- arrays over points ---------------------------------------------------------------------- */

static void free_arrays(adapt *a)
{
  sdr_free(a->root);
  sdr_free(a->levels);
  sdr_free(a->energy);
  sdr_free(a->damage);
  sdr_free(a->split);
}

/* Room for what there is of the present points; `root` is set. */
static sdr_status make_arrays(adapt *a, int32_t *root)
{
  const sdr_points *points = a->built->points;
  const size_t count = (size_t)points->count;
  free_arrays(a);
  a->root = root;
  a->levels = sdr_alloc(count, 1);
  a->energy = sdr_alloc(count, sizeof *a->energy);
  a->damage = sdr_alloc(count, sizeof *a->damage);
  a->split = sdr_alloc(count, 1);
  if (!a->levels || !a->energy || !a->damage || !a->split) return SDR_RUN_FAILED;
  for (int r = 0; r < points->row_count; ++r)
    for (int32_t k = 0; k < points->rows[r].length; ++k)
      a->levels[rank_of(points, points->rows[r].first + k)] = (uint8_t)points->rows[r].level;
  return SDR_OK;
}

/* The first point of each new one, by generation; NULL: out of memory. */
static int32_t *roots_of(const adapt *a, const sdr_points *before, const sdr_points *now,
                         const sdr_point_map *map)
{
  int32_t *root = sdr_alloc((size_t)now->count, sizeof *root);
  for (int32_t i = 0; root && i < now->count; ++i)
    root[rank_of(now, i)] = a->root[rank_of(before, map->parent[i])];
  return root;
}

/* ---- building anew --------------------------------------------------------------------------- */

/* Families, model, loads, supports and system over next->points. */
static sdr_status build_next(const adapt *a, const int32_t *root, sdr_built *next)
{
  const sdr_points *points = next->points;
  const size_t padded = sdr_points_padded(points);
  double *young = sdr_alloc(2 * padded, sizeof *young);
  if (!young) return SDR_RUN_FAILED;
  double *share = young + padded;
  for (int32_t i = 0; i < points->count; ++i) {
    const int32_t first = root[rank_of(points, i)];
    young[i] = a->young[first];
    share[i] = a->share[first];
  }
  sdr_status status = sdr_built_model(next, young, share);
  sdr_free(young);
  if (status == SDR_OK) status = sdr_built_system(next);
  return status;
}

/* Prescribed components take the motion that is prescribed now. */
static sdr_status move_supports(sdr_system *system)
{
  const int32_t count = sdr_supports_count(system->supports);
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  if (count == 0) return SDR_OK;
  SDR_TRY(sdr_supports_values(system->supports, system->time, system->motion));
  for (int32_t k = 0; k < count; ++k) {
    if (isnan(system->motion[k]) || list[k].mean >= 0) continue;
    (list[k].is_velocity ? system->v : system->u)[list[k].component][list[k].point] =
        system->motion[k];
  }
  return SDR_OK;
}

/* The stable step scales with the spacing where horizons do; else it is found anew. */
static sdr_status find_limit(const adapt *a, sdr_built *next)
{
  const sdr_scene *scene = next->scene;
  const int level = finest(next->points);
  if (!scene->horizon_relative || sdr_expression_uses(scene->horizon))
    return sdr_stable_step(next->system, &next->stable_step);
  next->stable_step = ldexp(a->first_limit, a->first_level - level);
  return SDR_OK;
}

/* A shorter step where the finest points ask for one. */
static sdr_status choose_step(const adapt *a, sdr_built *next)
{
  const sdr_time_scene *time = &next->scene->time;
  SDR_TRY(find_limit(a, next));
  const double usual = time->safety * next->stable_step;
  double longest = next->stable_step;
  if (isnan(time->step)) longest = usual;
  if (next->step <= longest || time->allow_unstable) return SDR_OK;
  next->step = usual;
  next->system->time_since = next->system->time;
  next->system->step_since = next->system->step;
  next->steps = sdr_steps_until(time->end, next->system, next->step);
  return SDR_OK;
}

/* Everything that changes, from *a->built to *next, but for the state of the outside. */
static sdr_status change(const adapt *a, const sdr_point_map *map, const int32_t *root,
                         sdr_built *next)
{
  const sdr_built *built = a->built;
  const sdr_pair_mark_of mark = sdr_built_mark(built->scene);
  SDR_TRY(build_next(a, root, next));
  SDR_TRY(sdr_refine_motion(built->system, map, next->system));
  SDR_TRY(move_supports(next->system));
  SDR_TRY(next->model->ops->inherit(next->model, built->model, map, &mark));
  SDR_TRY(choose_step(a, next));
  return next->integrator->begin(next->system, next->step);
}

static double energy_of(const sdr_balance *balance)
{
  return balance->kinetic + balance->model.stored + balance->model.dissipated;
}

static void book_energy(adapt *a, const sdr_built *next)
{
  sdr_balance before, after;
  sdr_system_balance(a->built->system, &before);
  sdr_system_balance(next->system, &after);
  const double grown = energy_of(&after) - energy_of(&before);
  next->system->refinement += grown;
  a->now.energy += fabs(grown);
}

/* Make *next what the run goes on with, and tell everybody. */
static sdr_status put_in_place(adapt *a, const sdr_point_map *map, int32_t *root, sdr_built *next)
{
  sdr_built old = *a->built;
  *a->built = *next;
  old.scene = NULL; /* the same */
  *next = old;
  a->moment->system = a->built->system;
  a->moment->step_size = a->built->step;
  a->moment->steps = a->built->steps;
  SDR_TRY(make_arrays(a, root));
  for (int k = 0; k < *a->observer_count; ++k) {
    sdr_observer *observer = a->observers[k];
    if (observer->ops->points_changed)
      SDR_TRY(observer->ops->points_changed(observer, a->moment, map));
  }
  return SDR_OK;
}

/* All that *next has of its own. */
static sdr_built next_of(const sdr_built *built, sdr_points *points)
{
  sdr_built next = *built;
  next.points = points;
  next.families = NULL;
  next.model = NULL;
  next.loads = NULL;
  next.supports = NULL;
  next.system = NULL;
  return next;
}

static sdr_status split_points(adapt *a)
{
  sdr_points *points = NULL;
  sdr_point_map map = {0};
  SDR_TRY(sdr_split_points(a->built->scene, a->built->points, a->split, &points, &map));
  sdr_built next = next_of(a->built, points);
  int32_t *root = roots_of(a, a->built->points, points, &map);
  sdr_status status = root ? change(a, &map, root, &next) : SDR_RUN_FAILED;
  if (status == SDR_OK) {
    book_energy(a, &next);
    ++a->now.events;
    status = put_in_place(a, &map, root, &next); /* next is what was */
  } else {
    sdr_free(root);
  }
  next.scene = NULL;
  sdr_built_destroy(&next);
  sdr_point_map_clear(&map);
  return status;
}

/* ---- the observer ---------------------------------------------------------------------------- */

/* Nothing that breaks outruns shear waves, which go at 0.6 of the speed of the fastest ones: in a
   stable step those pass about a spacing. */
static double interval(const adapt *a)
{
  const double given = a->built->scene->points.adapt->every;
  if (!isnan(given)) return given;
  const double h = ldexp(a->built->points->lattice_spacing, -a->first_level);
  return fmax(0.5, sdr_adapt_zone_reach(a->zone) / h) * a->first_limit;
}

static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  const adapt *a = (const adapt *)(const void *)observer;
  (void)wants_balance;
  if (moment->step == 0) return 0;
  return moment->time - a->now.looked >= interval(a) - 0.5 * moment->step_size;
}

/* Split at this moment what must. */
static sdr_status look_now(adapt *a, const sdr_moment *moment)
{
  const double started = wall();
  sdr_model *model = a->built->model;
  a->now.looked = moment->time;
  const int by_energy = isfinite(a->built->scene->points.adapt->energy);
  SDR_TRY(
      model->ops->split_state(model, a->built->system->u, by_energy ? a->energy : NULL, a->damage));
  const int32_t count =
      sdr_adapt_zone_choose(a->zone, a->built->points, a->energy, a->damage, a->split);
  const double chosen = wall();
  a->looking += chosen - started;
  if (count == 0) return SDR_OK;
  SDR_TRY(split_points(a));
  if (a->built->scene->points.adapt->levels > 1)
    a->now.looked = (double)-INFINITY; /* children may too */
  a->seconds += wall() - chosen;
  return SDR_OK;
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  adapt *a = of(observer);
  a->now.owed = moment->last;
  return moment->last ? SDR_OK : look_now(a, moment);
}

static void state(sdr_observer *observer, sdr_state_block *blocks, int *count)
{
  adapt *a = of(observer);
  blocks[0] = (sdr_state_block){"standing", &a->now, sizeof a->now};
  blocks[1] = (sdr_state_block){"levels", a->levels, (size_t)a->built->points->count};
  *count = 2;
}

static sdr_status resumed(sdr_observer *observer, const sdr_moment *moment)
{
  adapt *a = of(observer);
  a->built->step = moment->step_size;
  a->built->steps = moment->steps;
  SDR_TRY(find_limit(a, a->built));
  if (!a->now.owed) return SDR_OK;
  a->now.owed = 0;
  return look_now(a, moment);
}

static void destroy(sdr_observer *observer)
{
  adapt *a = of(observer);
  free_arrays(a);
  sdr_adapt_zone_destroy(&a->zone);
  sdr_free(a->young);
  sdr_free(a->share);
  sdr_free(a);
}

static const sdr_observer_ops ops = {.name = "adapt",
                                     .due = due,
                                     .look = look,
                                     .state = state,
                                     .resumed = resumed,
                                     .destroy = destroy};

static sdr_status begin(adapt *a)
{
  const sdr_points *points = a->built->points;
  int32_t *root = sdr_alloc((size_t)points->count, sizeof *root);
  double *drawn = sdr_alloc(sdr_points_padded(points), sizeof *drawn);
  a->young = sdr_alloc((size_t)points->count, sizeof *a->young);
  a->share = sdr_alloc((size_t)points->count, sizeof *a->share);
  sdr_status status = root && drawn && a->young && a->share ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = sdr_body_young(a->built->scene, points, drawn);
  for (int32_t i = 0; status == SDR_OK && i < points->count; ++i) {
    a->young[rank_of(points, i)] = drawn[i];
    root[i] = i;
  }
  if (status == SDR_OK) {
    sdr_own_shares(a->built->bonds, a->built->families, drawn);
    for (int32_t i = 0; i < points->count; ++i) a->share[rank_of(points, i)] = drawn[i];
  }
  sdr_free(drawn);
  if (status == SDR_OK) status = sdr_adapt_zone_create(a->built->scene, points, &a->zone);
  if (status == SDR_OK) return make_arrays(a, root);
  sdr_free(root);
  return status;
}

sdr_status sdr_adapt_create(sdr_built *built, sdr_moment *moment, sdr_observer *const *observers,
                            const int *count, sdr_observer **out)
{
  adapt *a = sdr_alloc(1, sizeof *a);
  if (!a) return SDR_RUN_FAILED;
  *a = (adapt){.head.ops = &ops,
               .built = built,
               .moment = moment,
               .observers = observers,
               .observer_count = count,
               .now = {.looked = (double)-INFINITY},
               .first_points = built->points->count,
               .first_level = finest(built->points),
               .first_limit = built->stable_step};
  const sdr_status status = begin(a);
  if (status == SDR_OK)
    *out = &a->head;
  else
    destroy(&a->head);
  return status;
}

sdr_adapt_record sdr_adapt_look(const sdr_observer *observer)
{
  const adapt *a = (const adapt *)(const void *)observer;
  return (sdr_adapt_record){a->now.events, a->first_points, a->now.energy, a->seconds, a->looking};
}

/* ---- resuming -------------------------------------------------------------------------------- */

/* The levels in a checkpoint, by generation; *levels NULL: it has none. */
static sdr_status read_levels(const char *path, uint8_t **levels, size_t *count)
{
  static const char name[] = "observers/adapt/levels";
  sdr_hdf *file = NULL;
  sdr_hdf_shape shape;
  *levels = NULL;
  if (sdr_hdf_open(path, 0, &file) != SDR_OK) return SDR_OK;
  sdr_status status = SDR_OK;
  if (sdr_hdf_has(file, name) && sdr_hdf_shape_of(file, name, &shape) == SDR_OK && shape.rows > 0 &&
      shape.rows < INT32_MAX) {
    *levels = sdr_alloc(shape.rows, 1);
    if (!*levels) status = SDR_RUN_FAILED;
    shape = (sdr_hdf_shape){SDR_HDF_BYTES, 1, shape.rows, 1};
    if (status == SDR_OK && sdr_hdf_read(file, name, shape, *levels) != SDR_OK) {
      sdr_free(*levels);
      *levels = NULL;
    }
    *count = shape.rows;
  }
  sdr_hdf_discard(&file);
  return status;
}

/* Behind the points of the list that a point of that level has become; past its end if the list is
   none of these points. */
static size_t behind(const uint8_t *levels, size_t count, size_t at, int level, int children)
{
  if (at >= count || levels[at] < level || levels[at] > 20) return count + 1;
  if (levels[at] == level) return at + 1;
  for (int c = 0; c < children && at <= count; ++c)
    at = behind(levels, count, at, level + 1, children);
  return at;
}

/* split[i] = 1 where the list has children of point i. 0: none has, -1: the list does not fit. */
static int compare_levels(const sdr_points *points, const uint8_t *own, const uint8_t *levels,
                          size_t count, uint8_t *split)
{
  int any = 0;
  size_t at = 0;
  int32_t *stored = sdr_alloc((size_t)points->count, sizeof *stored);
  if (!stored) return -1;
  for (int32_t i = 0; i < points->count; ++i) stored[rank_of(points, i)] = i;
  for (int32_t g = 0; g < points->count && at <= count; ++g) {
    const size_t from = at;
    at = behind(levels, count, from, own[g], 1 << points->components);
    split[stored[g]] = at <= count && at > from + 1;
    any |= split[stored[g]];
  }
  sdr_free(stored);
  return at == count ? any : -1;
}

/* Split points until they are those of the list. `map` leads there from the first. */
static sdr_status follow_levels(adapt *a, const uint8_t *levels, size_t count)
{
  for (;;) {
    const int any = compare_levels(a->built->points, a->levels, levels, count, a->split);
    sdr_points *points = NULL;
    sdr_point_map map = {0};
    if (any <= 0) return SDR_OK;
    SDR_TRY(sdr_split_points(a->built->scene, a->built->points, a->split, &points, &map));
    sdr_built next = next_of(a->built, points);
    int32_t *root = roots_of(a, a->built->points, points, &map);
    sdr_status status = root ? build_next(a, root, &next) : SDR_RUN_FAILED;
    if (status == SDR_OK) {
      const sdr_pair_mark_of mark = sdr_built_mark(next.scene);
      status = next.model->ops->inherit(next.model, a->built->model, &map, &mark);
    }
    if (status == SDR_OK)
      status = put_in_place(a, &map, root, &next);
    else
      sdr_free(root);
    next.scene = NULL;
    sdr_built_destroy(&next);
    sdr_point_map_clear(&map);
    if (status != SDR_OK) return status;
  }
}

sdr_status sdr_adapt_resume(sdr_observer *observer, const char *path)
{
  adapt *a = of(observer);
  uint8_t *levels = NULL;
  size_t count = 0;
  SDR_TRY(read_levels(path, &levels, &count));
  const sdr_status status = levels ? follow_levels(a, levels, count) : SDR_OK;
  sdr_free(levels);
  return status;
}
