/* Runs of bonds on one lattice with one horizon, from its rows; no neighbourhood is built. */
#ifndef SDR_NOM_LATTICE_RUNS_H
#define SDR_NOM_LATTICE_RUNS_H

#include "nom/bonds.h"

/* Fill in classes, runs, stripe_run and counts of an empty `bonds`. */
sdr_status sdr_lattice_runs(const sdr_points *points, const sdr_bonds_how *how, sdr_bonds *bonds);

#endif
