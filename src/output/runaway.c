#include "output/runaway.h"

#include "base/memory.h"
#include "output/ledger.h"

#include <math.h>

typedef struct {
  sdr_observer head;
  sdr_observer *ledger;
  int64_t rows; /* bad ones without a good one between */
} runaway;

/* The first steps under a sudden load are out of balance too, while next to no energy is there. */
static const int64_t patience = 5;

static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  const runaway *r = (const runaway *)(const void *)observer;
  return r->ledger->ops->due(r->ledger, moment, wants_balance);
}

static int32_t fastest(const sdr_system *system)
{
  int32_t point = 0;
  double most = -1.0;
  for (int32_t i = 0; i < system->count; ++i) {
    double square = 0.0;
    for (int a = 0; a < system->components; ++a) square += system->v[a][i] * system->v[a][i];
    if (square > most) {
      most = square;
      point = i;
    }
  }
  return point;
}

/* Share of the energy that neither the start nor loads gave: what the balance lacks, and what bonds
   gave away that broke over and over with more than they had. NAN where the books are no numbers.
 */
static double from_nowhere(const sdr_books *books)
{
  const double moving = books->kinetic + books->stored;
  if (!isfinite(books->imbalance) || !isfinite(moving) || !isfinite(books->dissipated))
    return (double)NAN;
  return moving > 0.0 ? fmax(books->imbalance_relative, -books->dissipated / moving)
                      : books->imbalance_relative;
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  runaway *r = (runaway *)(void *)observer;
  const sdr_books books = sdr_ledger_books(r->ledger);
  const double share = from_nowhere(&books);
  if (isnan(share))
    return sdr_fail(SDR_RUN_FAILED,
                    "the run's energy is no number at t = %.6g s (step %lld): kinetic %g J, stored "
                    "%g J, dissipated %g J, work %g J; look for materials, loads or a time.step of "
                    "extreme size",
                    moment->time, (long long)moment->step, books.kinetic, books.stored,
                    books.dissipated, books.external_work);
  r->rows = share > 0.5 ? r->rows + 1 : 0;
  if (r->rows < patience) return SDR_OK;
  const sdr_points *points = moment->system->model->points;
  const int32_t i = fastest(moment->system);
  return sdr_fail(SDR_RUN_FAILED,
                  "the run blew up by t = %.6g s (step %lld): %.0f %% of its energy came from "
                  "nowhere; the fastest point is at (%g, %g, %g) m; take a smaller time.step",
                  moment->time, (long long)moment->step, 100.0 * share, points->x[0][i],
                  points->components > 1 ? points->x[1][i] : 0.0,
                  points->components > 2 ? points->x[2][i] : 0.0);
}

static void state(sdr_observer *observer, sdr_state_block *blocks, int *count)
{
  runaway *r = (runaway *)(void *)observer;
  blocks[0] = (sdr_state_block){"rows", &r->rows, sizeof r->rows};
  *count = 1;
}

static void destroy(sdr_observer *observer)
{
  sdr_free(observer);
}

static const sdr_observer_ops ops = {
    .name = "runaway", .due = due, .look = look, .state = state, .destroy = destroy};

sdr_status sdr_runaway_create(sdr_observer *ledger, sdr_observer **out)
{
  runaway *r = sdr_alloc(1, sizeof *r);
  if (!r) return SDR_RUN_FAILED;
  *r = (runaway){.head.ops = &ops, .ledger = ledger};
  *out = &r->head;
  return SDR_OK;
}
