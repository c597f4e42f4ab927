/* Pairs marked before a run: cut by pre-cracks, or protected. */
#include "base/memory.h"
#include "mechanics/bond_internal.h"

typedef struct {
  sdr_bond_model *model;
  sdr_pair_mark mark;
  const void *context;
  int64_t cut; /* directed bonds */
  int any_loose;
} mark_call;

static void mark_pair(void *context, const sdr_pair *pair)
{
  mark_call *call = context;
  sdr_bond_body *body = &call->model->body;
  const sdr_points *points = body->points;
  double a[3] = {0.0}, b[3] = {0.0};
  for (int c = 0; c < points->components; ++c) {
    a[c] = points->x[c][pair->i];
    b[c] = points->x[c][pair->j];
  }
  const int mark = call->mark(call->context, a, b);
  if (mark == 0) return;
  if (pair->loose) call->any_loose = 1;
  if (body->precise && sdr_law_softens((int)body->law))
    (pair->loose ? body->loose_history : body->history)[pair->slot] =
        mark == SDR_CUT ? (double)SDR_STRETCH_CUT : (double)SDR_STRETCH_PROTECTED;
  else if (sdr_law_softens((int)body->law))
    (pair->loose ? body->loose_stretch : body->stretch)[pair->slot] =
        mark == SDR_CUT ? SDR_STRETCH_CUT : SDR_STRETCH_PROTECTED;
  else
    (pair->loose ? body->loose_flags : body->flags)[pair->slot] =
        (mark == SDR_CUT ? SDR_CUT | SDR_LOST_I | SDR_LOST_J : SDR_PROTECTED);
  if (mark == SDR_CUT && pair->primary)
    call->cut += (pair->weight_ij > 0.0) + (pair->weight_ji > 0.0);
}

static int run_has_mark(const sdr_bond_body *body, const sdr_bond_run *run)
{
  for (int64_t slot = run->slot; slot < run->slot + run->length; ++slot)
    if (body->history   ? body->history[slot] < 0.0
        : body->stretch ? body->stretch[slot] < 0.0f
                        : body->flags[slot] >= SDR_CUT)
      return 1;
  return 0;
}

void sdr_bond_note_flags(sdr_bond_body *body, int64_t first, int64_t end)
{
  for (int64_t r = first; body->run_flagged && r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    sdr_flags any = 0;
    for (int64_t slot = run->slot; slot < run->slot + run->length; ++slot) any |= body->flags[slot];
    body->run_flagged[r] = any != 0;
  }
}

sdr_status sdr_bond_mark(sdr_model *model, sdr_pair_mark mark, const void *context,
                         int64_t *cut_bonds)
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  sdr_bond_body *body = &bond->body;
  if (body->law == SDR_LAW_NONE) SDR_TRY(sdr_bond_alloc_flags(bond));
  mark_call call = {.model = bond, .mark = mark, .context = context};
  sdr_bonds_visit(bond->bonds, model->points, mark_pair, &call);
  if (call.any_loose) body->loose_marked = 1;
  if (bond->bonds->run_count > 0 && !body->run_marked) {
    body->run_marked = sdr_alloc((size_t)bond->bonds->run_count, 1);
    if (!body->run_marked) return SDR_RUN_FAILED;
  }
  for (int64_t r = 0; r < bond->bonds->run_count; ++r)
    body->run_marked[r] = (uint8_t)run_has_mark(body, &bond->bonds->runs[r]);
  sdr_bond_note_flags(body, 0, bond->bonds->run_count);
  *cut_bonds = call.cut;
  return SDR_OK;
}

void sdr_bond_visit_lost(const sdr_model *model, int s, sdr_lost_visitor visit, void *context)
{
  const sdr_bond_body *body = &((const sdr_bond_model *)model)->body;
  const int critical = body->law == SDR_LAW_CRITICAL_STRETCH;
  const int loose = critical || body->loose_marked;
  sdr_lost_where where = {.points = model->points, .bonds = body->bonds};
  if (critical || body->run_marked) {
    where.flags = body->flags;
    where.stretch = body->stretch;
    where.run_flagged = critical ? NULL : body->run_marked;
  }
  where.loose_flags = loose ? body->loose_flags : NULL;
  where.loose_stretch = loose ? body->loose_stretch : NULL;
  sdr_lost_visit(&where, s, visit, context);
}
