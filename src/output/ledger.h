/* The energy ledger over time: history.csv, with probes and reactions as further columns. */
#ifndef SDR_OUTPUT_LEDGER_H
#define SDR_OUTPUT_LEDGER_H

#include "output/observer.h"

typedef struct sdr_ledger sdr_ledger; /* is an sdr_observer */

/* history.csv in the directory (design sec. 5): time,kinetic,stored,dissipated,viscous,contact,
   refinement,external_work,imbalance,max_damage,broken_bonds, then per probe and support the
   columns NAME.field[.x|.y|.z] and NAME.reaction.x ...; 17 digits; a row every
   scene->output.history_every steps, the first at t = 0, the last at the end. Flushed per row. */
sdr_status sdr_ledger_create(const sdr_scene *scene, const sdr_points *points, sdr_observer **out);

/* The books so far, for the summary and the progress bar. */
typedef struct {
  double kinetic, stored, dissipated, external_work;
  double imbalance;          /* E - E(0) - W now */
  double imbalance_relative; /* over the largest energy (kinetic + stored + dissipated) so far */
  double imbalance_largest;  /* running maximum of |imbalance| / largest energy so far */
  double linear_residual, angular_residual; /* momentum minus impulse minus start, over its scale */
  double max_damage;
  int64_t broken;
} sdr_books;

sdr_books sdr_ledger_books(const sdr_observer *ledger);

#endif
