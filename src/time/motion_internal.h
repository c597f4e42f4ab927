/* Inside src/time/motion*.c. */
#ifndef SDR_TIME_MOTION_INTERNAL_H
#define SDR_TIME_MOTION_INTERNAL_H

#include "time/motion.h"

enum { SDR_MOTION_SAMPLES = 5 };

struct sdr_motion {
  sdr_implicit *implicit;
  double from, until;  /* of the stretch */
  double first, last;  /* the moments inside it that its ends stand for */
  double at, rates_at; /* times of loads and positions; of rates. NAN: none */
  double *mass;        /* of q */
  int32_t *place;      /* an unknown: where it stands in q; -1: not there */
  /* An entry of the supports' list: where it is prescribed (NAN: not), how fast, how fast that
     changes; and what the supports say at some times (displacements, or velocities). */
  double *position, *rate, *bend, *sample[SDR_MOTION_SAMPLES];
  int has_velocities;
  double *layer_rate; /* a' of the layers' components */
  uint64_t flags;     /* of bonds, as one number */
  int broke;          /* 1: the last commit changed them */
  double *raw;        /* the model's force on touched components before layers handed theirs on */
  /* Means of supports: of each the entries of the supports' list, from mean_first[mean] on; where
     those stand in q; the force on each point, N. */
  int32_t *mean_first, *mean_entry, *mean_place;
  double *mean_pull;
  const double *viscous;
  double *slack[3]; /* displacements of layers where the body rests; a component each */
  double held[SDR_MOTION_RATES]; /* kinetic energy and momenta of prescribed components */
};

/* motion_time.c: bring loads and positions, and rates, to time t. */
sdr_status sdr_motion_stand(sdr_motion *motion, double t);
sdr_status sdr_motion_find_rates(sdr_motion *motion, double t);

/* motion_time.c: a number that changes if bonds were cut. */
uint64_t sdr_motion_flags(const sdr_motion *motion);

/* motion_means.c: make room; find who stands where, after the stretch's components are known; bring
   means of u (or v) to their positions (or rates); the forces that keep them, added to g and to the
   system's f. */
sdr_status sdr_motion_make_means(sdr_motion *motion);
sdr_status sdr_motion_number_means(sdr_motion *motion);
void sdr_motion_shift_means(const sdr_motion *motion, const double *wanted, double *const from[3]);
void sdr_motion_pull_means(sdr_motion *motion, double *g);

/* motion_books.c: what prescribed components hold of kinetic energy and momenta; the body's energy
   and momenta as a whole; add to the system's books. */
void sdr_motion_sum_held(const sdr_motion *motion, double sum[SDR_MOTION_RATES]);
void sdr_motion_sum_body(sdr_system *system, double sum[SDR_MOTION_RATES]);
void sdr_motion_book(sdr_system *system, const double change[SDR_MOTION_RATES]);

/* motion.c: to[component][point] = from[k] at the free components; velocities of the others, where
   those have theirs. */
void sdr_motion_spread(const sdr_motion *motion, const double *from, double *const to[3]);
void sdr_motion_put_velocities(const sdr_motion *motion);

#endif
