#include "mechanics/lost.h"

#include "base/memory.h"

#include <string.h>

void sdr_lost_add(sdr_lost *lost, int stripe, int32_t i, int32_t j)
{
  const int32_t count = lost->stripe[stripe].count, room = lost->stripe[stripe].room;
  if (count == room) {
    const int32_t more = 2 * room + 64;
    sdr_lost_pair *grown = sdr_realloc(lost->stripe[stripe].pair, (size_t)more, sizeof *grown);
    if (!grown) {
      lost->failed[stripe] = 1;
      return;
    }
    lost->stripe[stripe].pair = grown;
    lost->stripe[stripe].room = more;
  }
  lost->stripe[stripe].pair[count] = (sdr_lost_pair){i, j};
  lost->stripe[stripe].count = count + 1;
}

/* No half of the pair is there any more. */
static int holds_nothing(double weight_ij, double weight_ji, sdr_flags flags)
{
  return (flags & SDR_LOST_I || !(weight_ij > 0.0)) && (flags & SDR_LOST_J || !(weight_ji > 0.0));
}

void sdr_lost_note(sdr_lost *lost, int stripe, const sdr_pair *pair, sdr_flags flags)
{
  if (pair->primary && holds_nothing(pair->weight_ij, pair->weight_ji, flags))
    sdr_lost_add(lost, stripe, pair->i, pair->j);
}

sdr_status sdr_lost_check(const sdr_lost *lost)
{
  for (int s = 0; s < SDR_LOST_STRIPES; ++s)
    if (lost->failed[s])
      return sdr_fail(SDR_RUN_FAILED, "out of memory: the list of lost bonds cannot grow");
  return SDR_OK;
}

int64_t sdr_lost_count(const sdr_lost *lost)
{
  int64_t count = 0;
  for (int s = 0; s < SDR_LOST_STRIPES; ++s) count += lost->stripe[s].count;
  return count;
}

void sdr_lost_empty(sdr_lost *lost)
{
  for (int s = 0; s < SDR_LOST_STRIPES; ++s) lost->stripe[s].count = 0;
}

void sdr_lost_clear(sdr_lost *lost)
{
  for (int s = 0; s < SDR_LOST_STRIPES; ++s) sdr_free(lost->stripe[s].pair);
  memset(lost, 0, sizeof *lost);
}

/* ---- all that there are ---------------------------------------------------------------------- */

enum { BLOCK = 64, LOST = SDR_LOST_I | SDR_LOST_J };

/* Most pairs are whole: blocks of them are passed over at once. */
static void visit_flags_of_run(const sdr_lost_where *where, const sdr_bond_run *run,
                               sdr_lost_visitor visit, void *context)
{
  const sdr_bond_class *class = &where->bonds->classes[run->class_index];
  for (int32_t start = 0; start < run->length; start += BLOCK) {
    const int32_t end = run->length - start < BLOCK ? run->length : start + BLOCK;
    const sdr_flags *flags = where->flags + run->slot;
    sdr_flags any = 0;
    for (int32_t k = start; k < end; ++k) any |= flags[k];
    for (int32_t k = start; any & LOST && k < end; ++k)
      if (flags[k] & LOST && holds_nothing(class->weight_ij, class->weight_ji, flags[k]))
        visit(context, run->i0 + k, run->j0 + k);
  }
}

static void visit_cuts_of_run(const sdr_lost_where *where, const sdr_bond_run *run,
                              sdr_lost_visitor visit, void *context)
{
  for (int32_t k = 0; k < run->length; ++k)
    if (where->stretch[run->slot + k] == SDR_STRETCH_CUT) visit(context, run->i0 + k, run->j0 + k);
}

typedef struct {
  const sdr_lost_where *where;
  sdr_lost_visitor visit;
  void *context;
} loose_call;

static void visit_loose(void *context, const sdr_pair *pair)
{
  const loose_call *call = context;
  const sdr_lost_where *where = call->where;
  if (!pair->primary) return;
  const int lost = where->loose_flags ? holds_nothing(pair->weight_ij, pair->weight_ji,
                                                      where->loose_flags[pair->slot])
                                      : where->loose_stretch[pair->slot] == SDR_STRETCH_CUT;
  if (lost) call->visit(call->context, pair->i, pair->j);
}

void sdr_lost_visit(const sdr_lost_where *where, int s, sdr_lost_visitor visit, void *context)
{
  const sdr_bonds *bonds = where->bonds;
  const int32_t *stripe = where->points->stripe_first;
  const int runs = where->flags || where->stretch;
  for (int64_t r = bonds->stripe_run[s]; runs && r < bonds->stripe_run[s + 1]; ++r) {
    if (where->run_flagged && !where->run_flagged[r]) continue;
    if (where->flags)
      visit_flags_of_run(where, &bonds->runs[r], visit, context);
    else
      visit_cuts_of_run(where, &bonds->runs[r], visit, context);
  }
  if (bonds->loose.chunk_count == 0 || !(where->loose_flags || where->loose_stretch)) return;
  loose_call call = {where, visit, context};
  for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i)
    sdr_bonds_visit_loose_point(bonds, i, visit_loose, &call);
}
