/* What a bond-based body takes over from the one whose points have split (000 sec. 5.3). A pair of
   children of different points has the state of their parents' pair; one within a parent is whole.
   Pairs cut or protected before the run are known by their place, so they are marked anew where a
   point split.

   A softening pair keeps its largest stretch, which is the opening of a crack over the bond's
   length whatever the horizon; its damage falls, since thresholds grow as the horizon shrinks. */
#include "base/memory.h"
#include "mechanics/bond_internal.h"

#include <math.h>
#include <string.h>

/* ---- pairs by their points ------------------------------------------------------------------- */

/* An open-addressed table of the pairs of before that have a history; first < second. */
typedef struct {
  int32_t first, second; /* second 0: nothing here */
  sdr_flags flags;       /* I: first's half */
  float stretch;
} entry;

typedef struct {
  entry *list;
  uint64_t mask;
  int64_t room, count;
} table;

static uint64_t place_of(const table *t, int32_t first, int32_t second)
{
  uint64_t key = (uint64_t)(uint32_t)first << 32 | (uint32_t)second;
  key *= UINT64_C(0x9e3779b97f4a7c15);
  return (key ^ key >> 29) & t->mask;
}

static entry *find(const table *t, int32_t first, int32_t second)
{
  uint64_t at = place_of(t, first, second);
  while (t->list[at].second != 0 && (t->list[at].first != first || t->list[at].second != second))
    at = (at + 1) & t->mask;
  return &t->list[at];
}

static sdr_status make_table(int64_t count, table *t)
{
  uint64_t size = 64;
  while (size < 2 * (uint64_t)count) size *= 2;
  t->mask = size - 1;
  t->list = sdr_alloc(size, sizeof *t->list);
  return t->list ? SDR_OK : SDR_RUN_FAILED;
}

static sdr_flags turned(sdr_flags flags)
{
  const sdr_flags rest = flags & ~(SDR_LOST_I | SDR_LOST_J);
  return rest | (flags & SDR_LOST_I ? SDR_LOST_J : 0) | (flags & SDR_LOST_J ? SDR_LOST_I : 0);
}

/* ---- what was -------------------------------------------------------------------------------- */

typedef struct {
  const sdr_bond_body *was, *now;
  const sdr_point_map *map;
  const sdr_pair_mark_of *mark;
  uint8_t *before, *after; /* a point: 1 if a pair of it has a history; if it may have to get one */
  uint8_t *near;           /* a point: 1 if it is new and some pair of it may be marked */
  table pairs;
  int any_loose;
} handing;

static float stretch_of(const sdr_bond_body *body, const sdr_pair *pair)
{
  const float *stretch = pair->loose ? body->loose_stretch : body->stretch;
  return stretch ? stretch[pair->slot] : 0.0f;
}

static sdr_flags flags_of(const sdr_bond_body *body, const sdr_pair *pair)
{
  const sdr_flags *flags = pair->loose ? body->loose_flags : body->flags;
  return flags ? flags[pair->slot] & ~(SDR_FRESH_I | SDR_FRESH_J) : 0;
}

static int has_history(const sdr_bond_body *body, const sdr_pair *pair)
{
  return pair->primary && (flags_of(body, pair) != 0 || stretch_of(body, pair) != 0.0f);
}

static sdr_pair first_of(const sdr_bonds *bonds, const sdr_bond_run *run)
{
  const sdr_bond_class *class = &bonds->classes[run->class_index];
  return (sdr_pair){.primary = 1,
                    .xi = {class->xi[0], class->xi[1], class->xi[2]},
                    .length = class->length,
                    .weight_ij = class->weight_ij,
                    .weight_ji = class->weight_ji};
}

static void move_to(sdr_pair *pair, const sdr_bond_run *run, int32_t k)
{
  pair->i = run->i0 + k;
  pair->j = run->j0 + k;
  pair->slot = run->slot + k;
}

/* The same of a run's pairs with a history alone. */
static void visit_kept_run(const sdr_bond_body *body, const sdr_bond_run *run,
                           sdr_pair_visitor visit, void *context)
{
  const float *stretch = body->stretch ? body->stretch + run->slot : NULL;
  const sdr_flags *flags = body->flags ? body->flags + run->slot : NULL;
  int any = 0;
  for (int32_t k = 0; stretch && k < run->length; ++k) any |= stretch[k] != 0.0f;
  for (int32_t k = 0; flags && k < run->length; ++k) any |= flags[k];
  if (!any) return;
  sdr_pair pair = first_of(body->bonds, run);
  for (int32_t k = 0; k < run->length; ++k) {
    if (!(stretch && stretch[k] != 0.0f) && !(flags && flags[k] != 0)) continue;
    move_to(&pair, run, k);
    visit(context, &pair);
  }
}

static int any_loose_history(const sdr_bond_body *body, int32_t i)
{
  int64_t slot;
  int any = 0;
  for (const int64_t end = sdr_loose_slots(&body->bonds->loose, i, &slot); slot < end;
       slot += SDR_LANES)
    any |= (body->loose_stretch && body->loose_stretch[slot] != 0.0f) ||
           (body->loose_flags && body->loose_flags[slot] != 0);
  return any;
}

/* Visit the pairs with a history, loose ones by each slot of a point with one. */
static void visit_kept(const sdr_bond_body *body, sdr_pair_visitor visit, void *context)
{
  const sdr_bonds *bonds = body->bonds;
  for (int64_t r = 0; r < bonds->run_count; ++r)
    visit_kept_run(body, &bonds->runs[r], visit, context);
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = 0; i < body->points->count; ++i)
      if (any_loose_history(body, i)) sdr_bonds_visit_loose_point(bonds, i, visit, context);
}

static void count_pair(void *context, const sdr_pair *pair)
{
  handing *h = context;
  h->pairs.count += has_history(h->was, pair);
}

static void keep_pair(void *context, const sdr_pair *pair)
{
  handing *h = context;
  if (!has_history(h->was, pair)) return;
  const int swap = pair->j < pair->i;
  const int32_t first = swap ? pair->j : pair->i, second = swap ? pair->i : pair->j;
  const sdr_flags flags = flags_of(h->was, pair);
  *find(&h->pairs, first, second) =
      (entry){first, second, swap ? turned(flags) : flags, stretch_of(h->was, pair)};
  h->before[first] = h->before[second] = 1;
}

/* ---- what becomes of it ---------------------------------------------------------------------- */

static void set_stretch(const handing *h, const sdr_pair *pair, float stretch)
{
  (pair->loose ? h->now->loose_stretch : h->now->stretch)[pair->slot] = stretch;
}

static void set_flags(const handing *h, const sdr_pair *pair, sdr_flags flags)
{
  sdr_flags *at = pair->loose ? h->now->loose_flags : h->now->flags;
  if (at) at[pair->slot] = flags;
}

/* Cut or protected by its place; 0: neither. */
static int mark_of(const handing *h, const sdr_pair *pair)
{
  const sdr_points *points = h->now->points;
  double a[3] = {0.0}, b[3] = {0.0};
  for (int c = 0; c < points->components; ++c) {
    a[c] = points->x[c][pair->i];
    b[c] = points->x[c][pair->j];
  }
  return h->mark->mark(h->mark->context, a, b);
}

static void set_mark(handing *h, const sdr_pair *pair, int mark)
{
  h->any_loose |= pair->loose;
  if (sdr_law_softens((int)h->now->law))
    set_stretch(h, pair, mark == SDR_CUT ? SDR_STRETCH_CUT : SDR_STRETCH_PROTECTED);
  else
    set_flags(h, pair, mark == SDR_CUT ? SDR_CUT | SDR_LOST_I | SDR_LOST_J : SDR_PROTECTED);
}

/* A pair neither of whose points split: what was, marks included. */
static void keep(handing *h, const sdr_pair *pair, const entry *was, int swap)
{
  if (was->flags >= SDR_CUT || was->stretch < 0.0f) h->any_loose |= pair->loose;
  if (sdr_law_softens((int)h->now->law))
    set_stretch(h, pair, was->stretch);
  else
    set_flags(h, pair, swap ? turned(was->flags) : was->flags);
}

static void hand_over(void *context, const sdr_pair *pair)
{
  handing *h = context;
  const int32_t p = h->map->parent[pair->i], q = h->map->parent[pair->j];
  const int swap = q < p;
  const int mark = h->near[pair->i] || h->near[pair->j] ? mark_of(h, pair) : 0;
  if (mark != 0) {
    set_mark(h, pair, mark);
    return;
  }
  if (p == q || !h->before[p] || !h->before[q]) return;
  const entry *was = find(&h->pairs, swap ? q : p, swap ? p : q);
  if (was->second == 0) return;
  if (!sdr_splits(h->map, p) && !sdr_splits(h->map, q))
    keep(h, pair, was, swap);
  else if (was->stretch > 0.0f)
    set_stretch(h, pair, was->stretch);
  else if (was->flags != 0 && was->flags < SDR_CUT)
    set_flags(h, pair, swap ? turned(was->flags) : was->flags);
}

/* ---- visiting pairs of chosen points --------------------------------------------------------- */

static int any(const uint8_t *at, int32_t length)
{
  return memchr(at, 1, (size_t)length) != NULL;
}

typedef struct {
  const uint8_t *at;
  sdr_pair_visitor visit;
  void *context;
} chosen;

static void visit_chosen_run(const sdr_bonds *bonds, const sdr_bond_run *run, const chosen *c)
{
  const uint8_t *i = c->at + run->i0, *j = c->at + run->j0;
  if (!any(i, run->length) && !any(j, run->length)) return;
  sdr_pair pair = first_of(bonds, run);
  for (int32_t k = 0; k < run->length; ++k) {
    if (!i[k] && !j[k]) continue;
    move_to(&pair, run, k);
    c->visit(c->context, &pair);
  }
}

static void visit_chosen(void *context, const sdr_pair *pair)
{
  const chosen *c = context;
  if (c->at[pair->i] || c->at[pair->j]) c->visit(c->context, pair);
}

static int any_loose(const sdr_loose *loose, const uint8_t *at, int32_t i)
{
  int64_t slot;
  int any = at[i];
  for (const int64_t end = sdr_loose_slots(loose, i, &slot); !any && slot < end; slot += SDR_LANES)
    any = at[loose->j[slot]];
  return any;
}

/* Pairs of runs once, loose ones by each slot of a point, with an end at a chosen point (at[i] 1).
 */
static void visit_pairs_at(const sdr_bonds *bonds, const sdr_points *points, const uint8_t *at,
                           sdr_pair_visitor visit, void *context)
{
  chosen c = {at, visit, context};
  for (int64_t r = 0; r < bonds->run_count; ++r) visit_chosen_run(bonds, &bonds->runs[r], &c);
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = 0; i < points->count; ++i)
      if (any_loose(&bonds->loose, at, i)) sdr_bonds_visit_loose_point(bonds, i, visit_chosen, &c);
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* 1 if some pair of point i, none longer than `reach`, may be marked. */
static int is_near_mark(const handing *h, int32_t i, double reach)
{
  const sdr_points *points = h->now->points;
  double low[3] = {0.0}, high[3] = {0.0};
  for (int a = 0; a < points->components; ++a) {
    low[a] = points->x[a][i] - reach;
    high[a] = points->x[a][i] + reach;
  }
  return h->mark->may(h->mark->context, low, high) != 0;
}

static void choose_points(const handing *h)
{
  double reach = 0.0;
  for (int32_t i = 0; i < h->map->now; ++i) reach = fmax(reach, h->now->points->horizon[i]);
  for (int32_t i = 0; i < h->map->now; ++i) {
    h->near[i] = h->mark->mark && sdr_is_child(h->map, i) && is_near_mark(h, i, reach * (1 + 1e-9));
    h->after[i] = h->before[h->map->parent[i]] || h->near[i];
  }
}

static void mark_runs(sdr_bond_body *body)
{
  for (int64_t r = 0; body->run_marked && r < body->bonds->run_count; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    body->run_marked[r] = 0;
    for (int64_t slot = run->slot; slot < run->slot + run->length; ++slot)
      if (body->stretch ? body->stretch[slot] < 0.0f : body->flags[slot] >= SDR_CUT)
        body->run_marked[r] = 1;
  }
}

static sdr_status make_room(sdr_bond_model *bond, const sdr_bond_model *was)
{
  sdr_bond_body *body = &bond->body;
  const int marked = was->body.run_marked || was->body.loose_marked;
  if (was->body.flags || was->body.loose_flags) SDR_TRY(sdr_bond_alloc_flags(bond));
  if (marked && bond->bonds->run_count > 0 && !body->run_marked) {
    body->run_marked = sdr_alloc((size_t)bond->bonds->run_count, 1);
    if (!body->run_marked) return SDR_RUN_FAILED;
  }
  return SDR_OK;
}

static void take_booked(sdr_bond_model *bond, const sdr_bond_model *was)
{
  if (!bond->booked || !was->booked) return;
  for (int s = 0; s < was->head.points->stripe_count; ++s) bond->booked[0] += was->booked[s];
}

sdr_status sdr_bond_inherit(sdr_model *model, const sdr_model *before, const sdr_point_map *map,
                            const sdr_pair_mark_of *mark)
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  const sdr_bond_model *was = (const sdr_bond_model *)before;
  handing h = {.was = &was->body, .now = &bond->body, .map = map, .mark = mark};
  h.before = sdr_alloc((size_t)map->before, 1);
  h.after = sdr_alloc((size_t)map->now, 1);
  h.near = sdr_alloc((size_t)map->now, 1);
  sdr_status status = h.before && h.after && h.near ? make_room(bond, was) : SDR_RUN_FAILED;
  if (status == SDR_OK) {
    visit_kept(&was->body, count_pair, &h);
    status = make_table(h.pairs.count, &h.pairs);
  }
  if (status == SDR_OK) {
    visit_kept(&was->body, keep_pair, &h);
    choose_points(&h);
    visit_pairs_at(bond->bonds, model->points, h.after, hand_over, &h);
    mark_runs(&bond->body);
    sdr_bond_note_flags(&bond->body, 0, bond->bonds->run_count);
    bond->body.loose_marked = h.any_loose;
    take_booked(bond, was);
  }
  sdr_free(h.pairs.list);
  sdr_free(h.before);
  sdr_free(h.after);
  sdr_free(h.near);
  return status;
}

typedef struct {
  const sdr_bond_model *model;
  double *const *u;
  sdr_held_visitor visit;
  void *context;
  const uint8_t *at;
} held_call;

static void visit_held(void *context, const sdr_pair *pair)
{
  const held_call *call = context;
  const int n = call->model->head.points->components;
  const sdr_pair_answer answer =
      sdr_pair_answer_at(&call->model->body, pair, sdr_pair_stretch(pair, n, call->u));
  const double intact = 1.0 - fmax(answer.ij.damage, answer.ji.damage);
  if (call->at[pair->i]) call->visit(call->context, pair->i, pair->j, intact);
  if (!pair->loose && call->at[pair->j]) call->visit(call->context, pair->j, pair->i, intact);
}

void sdr_bond_visit_held(const sdr_model *model, double *const u[3], const uint8_t *at,
                         sdr_held_visitor visit, void *context)
{
  const sdr_bond_model *bond = (const sdr_bond_model *)model;
  held_call call = {bond, u, visit, context, at};
  visit_pairs_at(bond->bonds, model->points, at, visit_held, &call);
}
