/* What a bond-based body takes over from the one whose points have split (000 sec. 5.3). A pair of
   children of different points has the state of their parents' pair; one within a parent is whole.
   Pairs cut or protected before the run are known by their place, so they are marked anew where a
   point split.

   A softening pair keeps its largest stretch, which is the opening of a crack over the bond's
   length whatever the horizon; its damage falls, since thresholds grow as the horizon shrinks. */
#include "base/memory.h"
#include "mechanics/bond_internal.h"

#include <math.h>

/* ---- pairs by their points ------------------------------------------------------------------- */

/* An open-addressed table of the pairs of before that have a history; first < second. */
typedef struct {
  int32_t first, second; /* second 0: nothing here */
  sdr_flags flags;       /* I: first's half */
  double stretch;
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

/* Visit the pairs with a history, loose ones by each slot. */
static void visit_kept(const sdr_bond_body *body, sdr_pair_visitor visit, void *context)
{
  const sdr_bonds *bonds = body->bonds;
  for (int64_t r = 0; r < bonds->run_count; ++r) {
    const sdr_bond_run *run = &bonds->runs[r];
    int any = 0;
    for (int64_t slot = run->slot; slot < run->slot + run->length; ++slot)
      any |= body->stretch ? body->stretch[slot] != 0.0f : body->flags && body->flags[slot] != 0;
    if (any) sdr_bonds_visit_run(bonds, run, visit, context);
  }
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = 0; i < body->points->count; ++i)
      sdr_bonds_visit_loose_point(bonds, i, visit, context);
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
      (entry){first, second, swap ? turned(flags) : flags, (double)stretch_of(h->was, pair)};
  h->before[first] = h->before[second] = 1;
}

/* ---- what becomes of it ---------------------------------------------------------------------- */

static void set_stretch(const handing *h, const sdr_pair *pair, double stretch)
{
  (pair->loose ? h->now->loose_stretch : h->now->stretch)[pair->slot] = (float)stretch;
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
  if (!h->mark->mark) return 0;
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
    set_stretch(h, pair, (double)(mark == SDR_CUT ? SDR_STRETCH_CUT : SDR_STRETCH_PROTECTED));
  else
    set_flags(h, pair, mark == SDR_CUT ? SDR_CUT | SDR_LOST_I | SDR_LOST_J : SDR_PROTECTED);
}

/* A pair neither of whose points split: what was, marks included. */
static void keep(handing *h, const sdr_pair *pair, const entry *was, int swap)
{
  if (was->flags >= SDR_CUT || was->stretch < 0.0) h->any_loose |= pair->loose;
  if (sdr_law_softens((int)h->now->law))
    set_stretch(h, pair, was->stretch);
  else
    set_flags(h, pair, swap ? turned(was->flags) : was->flags);
}

static void hand_over(void *context, const sdr_pair *pair)
{
  handing *h = context;
  const int32_t p = h->map->parent[pair->i], q = h->map->parent[pair->j];
  const int split = sdr_splits(h->map, p) || sdr_splits(h->map, q);
  const int swap = q < p;
  const int mark = split ? mark_of(h, pair) : 0;
  if (mark != 0) {
    set_mark(h, pair, mark);
    return;
  }
  if (p == q || !h->before[p] || !h->before[q]) return;
  const entry *was = find(&h->pairs, swap ? q : p, swap ? p : q);
  if (was->second == 0) return;
  if (!split)
    keep(h, pair, was, swap);
  else if (was->stretch > 0.0)
    set_stretch(h, pair, was->stretch);
  else if (was->flags != 0 && was->flags < SDR_CUT)
    set_flags(h, pair, swap ? turned(was->flags) : was->flags);
}

/* ---- visiting pairs of chosen points --------------------------------------------------------- */

static int any(const uint8_t *at, int32_t first, int32_t length)
{
  for (int32_t i = first; i < first + length; ++i)
    if (at[i]) return 1;
  return 0;
}

typedef struct {
  const uint8_t *at;
  sdr_pair_visitor visit;
  void *context;
} chosen;

static void visit_chosen(void *context, const sdr_pair *pair)
{
  const chosen *c = context;
  if (c->at[pair->i] || c->at[pair->j]) c->visit(c->context, pair);
}

/* Pairs of runs once, loose ones by each slot of a point, with an end at a chosen point. */
static void visit_pairs_at(const sdr_bonds *bonds, const sdr_points *points, const uint8_t *at,
                           sdr_pair_visitor visit, void *context)
{
  chosen c = {at, visit, context};
  for (int64_t r = 0; r < bonds->run_count; ++r) {
    const sdr_bond_run *run = &bonds->runs[r];
    if (any(at, run->i0, run->length) || any(at, run->j0, run->length))
      sdr_bonds_visit_run(bonds, run, visit_chosen, &c);
  }
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = 0; i < points->count; ++i)
      sdr_bonds_visit_loose_point(bonds, i, visit_chosen, &c);
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void choose_points(const handing *h)
{
  for (int32_t i = 0; i < h->map->now; ++i)
    h->after[i] = h->before[h->map->parent[i]] || (h->mark->mark && sdr_is_child(h->map, i));
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
  sdr_status status = h.before && h.after ? make_room(bond, was) : SDR_RUN_FAILED;
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
