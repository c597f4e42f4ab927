/* Pairs that hold nothing any more: cut at the start, or lost in each half that there is. Contact
   between pieces wants to know them, all and those of a step. */
#ifndef SDR_MECHANICS_LOST_H
#define SDR_MECHANICS_LOST_H

#include "damage/laws.h"
#include "nom/bonds.h"

enum { SDR_LOST_STRIPES = 256 };

typedef struct {
  int32_t i, j;
} sdr_lost_pair;

/* Pairs by stripe, in the order in which they were noted. */
typedef struct sdr_lost {
  struct {
    sdr_lost_pair *pair;
    int32_t count, room;
  } stripe[SDR_LOST_STRIPES];
  int failed[SDR_LOST_STRIPES]; /* 1: a pair is missing, memory ran out */
} sdr_lost;

/* Add a pair; of several threads each has its own stripes. */
void sdr_lost_add(sdr_lost *lost, int stripe, int32_t i, int32_t j);
/* Add a pair with these flags if it is the primary one and holds nothing any more. */
void sdr_lost_note(sdr_lost *lost, int stripe, const sdr_pair *pair, sdr_flags flags);
/* SDR_RUN_FAILED if some pair is missing. */
sdr_status sdr_lost_check(const sdr_lost *lost);
int64_t sdr_lost_count(const sdr_lost *lost);
void sdr_lost_empty(sdr_lost *lost); /* keeps the room */
void sdr_lost_clear(sdr_lost *lost);

/* What bodies keep of their pairs, a slot: flags, or a stretch that says SDR_STRETCH_CUT. Arrays
   that a body lacks are NULL. */
typedef struct {
  const sdr_points *points;
  const sdr_bonds *bonds;
  const sdr_flags *flags, *loose_flags;
  const float *stretch, *loose_stretch;
  const uint8_t *run_flagged; /* a run: 0 if none of its pairs is lost; NULL: not known */
} sdr_lost_where;

typedef void (*sdr_lost_visitor)(void *context, int32_t i, int32_t j);

/* Visit the pairs of stripe s that hold nothing, each once. */
void sdr_lost_visit(const sdr_lost_where *where, int s, sdr_lost_visitor visit, void *context);

#endif
