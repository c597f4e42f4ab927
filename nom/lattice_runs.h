/* Runs of bonds on a lattice, or within each level of nested ones, from the rows; no neighbourhood
   is built. */
#ifndef SDR_NOM_LATTICE_RUNS_H
#define SDR_NOM_LATTICE_RUNS_H

#include "nom/bonds.h"
#include "nom/lattice_groups.h"

/* Fill in classes, runs, stripe_run and counts of an empty `bonds`. */
sdr_status sdr_lattice_runs(const sdr_points *points, const sdr_bonds_how *how,
                            const sdr_lattice_groups *groups, sdr_bonds *bonds);

#endif
