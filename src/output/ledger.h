/* The energy ledger over time: history.csv, with probes and reactions as further columns. */
#ifndef SDR_OUTPUT_LEDGER_H
#define SDR_OUTPUT_LEDGER_H

#include "output/observer.h"

/* history.csv in the moment's directory (design sec. 5): time,kinetic,stored,dissipated,viscous,
   contact,refinement,external_work,imbalance,max_damage,broken_bonds, then the columns of probes
   (NAME.field[.x]) and supports (NAME.reaction.x); 17 digits; a row every
   scene->output.history_every steps (0: 200 rows over the run), the first at t = 0, the last at the
   end. Each row is on the disk when the look is over. On resume rows after the
   checkpoint are cut. Borrows the scene. Owner: the caller. */
sdr_status sdr_ledger_create(const sdr_scene *scene, const sdr_points *points, sdr_observer **out);

/* The books of the latest row, for the summary and the progress bar; E = kinetic + stored +
   contact + dissipated. All largest values run over the rows. */
typedef struct {
  /* J; contact: of pieces that touch */
  double kinetic, stored, contact, dissipated, viscous, external_work;
  double refinement;         /* J: by how much the energy grew when points split */
  double imbalance;          /* J: E + viscous - E(0) - external work - refinement */
  double imbalance_relative; /* over the largest E so far; 0 if that is 0 */
  double imbalance_largest;  /* running maximum of |imbalance_relative| */
  /* |momentum - its start - impulse| over the largest sum m|v| so far; likewise about the origin
     over sum m|x||v|; 0 if the scale is 0 */
  double linear_residual, angular_residual;
  double max_damage;
  int64_t broken;
} sdr_books;

/* Bring the books to this moment, without a row; nothing if its row has been written. Needs
   moment->balance. For observers after the ledger that want more than the rows. */
void sdr_ledger_book(sdr_observer *ledger, const sdr_moment *moment);

sdr_books sdr_ledger_books(const sdr_observer *ledger);

#endif
