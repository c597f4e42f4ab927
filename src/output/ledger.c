#include "output/ledger.h"

#include "base/memory.h"
#include "base/small.h"
#include "output/columns.h"
#include "output/history.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char fixed_header[] = "time,kinetic,stored,dissipated,viscous,contact,refinement,"
                                   "external_work,imbalance,max_damage,broken_bonds";
enum { FIXED_COLUMNS = 11 };

/* What a checkpoint holds. */
typedef struct {
  double energy0, momentum0[3], angular0[3];
  double largest_energy, largest_momentum, largest_angular;
  sdr_books books;
} account;

typedef struct {
  sdr_observer head;
  const sdr_scene *scene;
  account now;
  int64_t row_step; /* step of the latest row; -1: none */
  sdr_columns *columns;
  double *values; /* one row */
  char *header;
  sdr_history_file *history; /* NULL until the first row */
} ledger;

static ledger *of(sdr_observer *observer)
{
  return (ledger *)(void *)observer;
}

static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  const ledger *l = (const ledger *)(const void *)observer;
  int64_t every = l->scene->output.history_every;
  if (every <= 0) every = moment->steps / 200; /* 0 steps: as many as the integrator likes */
  if (every < 1) every = 1;
  const int is_due = moment->step % every == 0 || moment->last;
  if (is_due) *wants_balance = 1;
  return is_due;
}

static double share(double part, double whole)
{
  return whole > 0.0 ? part / whole : 0.0;
}

static double residual(const double now[3], const double start[3], const double impulse[3],
                       double scale)
{
  double left[3];
  for (int c = 0; c < 3; ++c) left[c] = now[c] - start[c] - impulse[c];
  return share(sdr_norm3(left), scale);
}

static void open_account(account *a, const sdr_balance *balance, double energy)
{
  *a = (account){.energy0 = energy};
  memcpy(a->momentum0, balance->momentum, sizeof a->momentum0);
  memcpy(a->angular0, balance->angular, sizeof a->angular0);
}

static void book(account *a, const sdr_balance *balance, const sdr_moment *moment)
{
  const sdr_system *system = moment->system;
  const double energy =
      balance->kinetic + balance->model.stored + balance->contact + balance->model.dissipated;
  if (moment->step == 0) open_account(a, balance, energy);
  a->largest_energy = fmax(a->largest_energy, energy);
  a->largest_momentum = fmax(a->largest_momentum, balance->momentum_scale);
  a->largest_angular = fmax(a->largest_angular, balance->angular_scale);
  sdr_books *b = &a->books;
  b->kinetic = balance->kinetic;
  b->stored = balance->model.stored;
  b->dissipated = balance->model.dissipated;
  b->contact = balance->contact;
  b->external_work = system->external_work;
  b->viscous = system->viscous;
  b->refinement = system->refinement;
  b->imbalance = energy + b->viscous - a->energy0 - system->external_work - b->refinement;
  b->imbalance_relative = share(b->imbalance, a->largest_energy);
  b->imbalance_largest = fmax(b->imbalance_largest, fabs(b->imbalance_relative));
  b->linear_residual =
      residual(balance->momentum, a->momentum0, system->impulse, a->largest_momentum);
  b->angular_residual =
      residual(balance->angular, a->angular0, system->angular_impulse, a->largest_angular);
  b->max_damage = balance->model.max_damage;
  b->broken = balance->model.broken;
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  ledger *l = of(observer);
  sdr_balance own;
  const sdr_balance *balance = moment->balance;
  if (!balance) {
    sdr_system_balance(moment->system, &own);
    balance = &own;
  }
  book(&l->now, balance, moment);
  if (l->row_step == moment->step) return SDR_OK; /* a run that ends before its next step */
  const sdr_books *b = &l->now.books;
  const double fixed[FIXED_COLUMNS] = {
      moment->time,  b->kinetic,       b->stored,    b->dissipated, b->viscous,       b->contact,
      b->refinement, b->external_work, b->imbalance, b->max_damage, (double)b->broken};
  memcpy(l->values, fixed, sizeof fixed);
  SDR_TRY(sdr_columns_values(l->columns, moment->system, l->values + FIXED_COLUMNS));
  if (!l->history) SDR_TRY(sdr_history_file_create(moment->directory, l->header, &l->history));
  SDR_TRY(
      sdr_history_file_row(l->history, l->values, FIXED_COLUMNS + sdr_columns_count(l->columns)));
  l->row_step = moment->step;
  return SDR_OK;
}

static sdr_status finish(sdr_observer *observer, const sdr_moment *moment)
{
  ledger *l = of(observer);
  const sdr_status status = l->row_step == moment->step ? SDR_OK : look(observer, moment);
  sdr_history_file_close(&l->history);
  return status;
}

static void state(sdr_observer *observer, sdr_state_block *blocks, int *count)
{
  ledger *l = of(observer);
  blocks[0] = (sdr_state_block){"account", &l->now, sizeof l->now};
  *count = 1;
}

/* A run killed between its checkpoint and its row, or resumed in another directory, lacks a row. */
static sdr_status resumed(sdr_observer *observer, const sdr_moment *moment)
{
  ledger *l = of(observer);
  double last;
  int wants_balance = 0;
  sdr_history_file_close(&l->history);
  SDR_TRY(sdr_history_file_continue(moment->directory, l->header,
                                    moment->time + sdr_moment_slack(moment), &last, &l->history));
  const int row_there = last >= moment->time - sdr_moment_slack(moment);
  l->row_step = row_there ? moment->step : -1;
  return !row_there && due(observer, moment, &wants_balance) ? look(observer, moment) : SDR_OK;
}

/* The points that probes look at may have split; names and their number stay. */
static sdr_status points_changed(sdr_observer *observer, const sdr_moment *moment,
                                 const sdr_point_map *map)
{
  ledger *l = of(observer);
  sdr_columns *columns = NULL;
  (void)map;
  SDR_TRY(sdr_columns_create(l->scene, moment->system->model->points, &columns));
  sdr_columns_destroy(&l->columns);
  l->columns = columns;
  return SDR_OK;
}

static void destroy(sdr_observer *observer)
{
  ledger *l = of(observer);
  sdr_history_file_close(&l->history);
  sdr_columns_destroy(&l->columns);
  sdr_free(l->values);
  sdr_free(l->header);
  sdr_free(l);
}

static const sdr_observer_ops ops = {.name = "ledger",
                                     .due = due,
                                     .look = look,
                                     .finish = finish,
                                     .state = state,
                                     .resumed = resumed,
                                     .points_changed = points_changed,
                                     .destroy = destroy};

static char *make_header(const sdr_columns *columns)
{
  const int count = sdr_columns_count(columns);
  size_t size = sizeof fixed_header;
  for (int k = 0; k < count; ++k) size += strlen(sdr_columns_name(columns, k)) + 1;
  char *header = sdr_alloc(size, 1);
  if (!header) return NULL;
  char *end = stpcpy(header, fixed_header);
  for (int k = 0; k < count; ++k) {
    *end++ = ',';
    end = stpcpy(end, sdr_columns_name(columns, k));
  }
  return header;
}

sdr_status sdr_ledger_create(const sdr_scene *scene, const sdr_points *points, sdr_observer **out)
{
  ledger *l = sdr_alloc(1, sizeof *l);
  if (!l) return SDR_RUN_FAILED;
  *l = (ledger){.head.ops = &ops, .scene = scene, .row_step = -1};
  sdr_status status = sdr_columns_create(scene, points, &l->columns);
  if (status == SDR_OK) {
    l->values =
        sdr_alloc((size_t)(FIXED_COLUMNS + sdr_columns_count(l->columns)), sizeof *l->values);
    l->header = make_header(l->columns);
    if (!l->values || !l->header) status = SDR_RUN_FAILED;
  }
  if (status == SDR_OK)
    *out = &l->head;
  else
    destroy(&l->head);
  return status;
}

void sdr_ledger_book(sdr_observer *observer, const sdr_moment *moment)
{
  ledger *l = of(observer);
  if (l->row_step != moment->step) book(&l->now, moment->balance, moment);
}

sdr_books sdr_ledger_books(const sdr_observer *observer)
{
  return ((const ledger *)(const void *)observer)->now.books;
}
