/* Shared by the files of contact. Exposed points are numbered 0.. ("spots") apart from points. */
#ifndef SDR_MECHANICS_CONTACT_INTERNAL_H
#define SDR_MECHANICS_CONTACT_INTERNAL_H

#include "mechanics/contact.h"

enum { SDR_CONTACT_CHUNK = 256 };

/* The partners of SDR_CONTACT_CHUNK spots, each pair in both spots' rows, a row in the order of the
   partners' points: so that sums do not depend on when a partner was found. */
typedef struct {
  int32_t row[SDR_CONTACT_CHUNK + 1];
  int32_t *partner; /* spots */
  double *distance; /* d of the pair, m */
  int32_t room;
  int failed;     /* 1: no memory */
  double moved;   /* m^2: the most that a spot moved since the search */
  double closest; /* least (l/d)^2 */
} sdr_contact_rows;

/* A partner to be put into the row of spot a. */
typedef struct {
  int32_t a, b, point; /* spots; b's point */
  double distance;
} sdr_contact_entry;

struct sdr_contact {
  sdr_model *model;
  const sdr_points *points;
  double range;      /* of contact, spacings */
  double *stiffness; /* a point: k of it, N/m */
  double most_range; /* m: largest d */
  uint8_t *exposed;  /* a point */
  uint8_t *surface;  /* a point: exposed from the start */
  int32_t *spot_of;  /* a point; -1: none */
  int32_t count;     /* spots */
  int32_t room;      /* of the arrays below, spots */
  int32_t *point;    /* of a spot */
  double *place;     /* 3 a spot: present position, m */
  double *searched;  /* 3 a spot: that at the search */
  double skin;       /* m */
  int stale;         /* 1: search before the next force */
  int64_t since;     /* forces since the search */
  int64_t late_at;   /* `since` when the first pair after it was lost; 0: none was */
  int64_t searches;

  int32_t chunk_count, chunk_room;
  sdr_contact_rows *chunks;
  sdr_contact_entry *late; /* of bonds lost in this step */
  int32_t late_count, late_room;
  double closest; /* least l/d ever */

  /* Scratch of a search: cells over spots, and partners by lost bonds in rows over spots. */
  double low[3], cell;
  int32_t cells[3];
  int32_t *first, *member, *torn_row, *torn;
  size_t first_room, torn_room;
  sdr_lost lost, near;
  double *const *u;
};

/* d of a pair of points, m, with |X_j - X_i|^2. */
double sdr_contact_reach(const sdr_contact *contact, int32_t i, int32_t j, double reference_square);

/* Bring the places of the spots to u; the most that one moved since the search, m. */
double sdr_contact_follow(sdr_contact *contact, double *const u[3]);

/* Find all partners anew at u. */
sdr_status sdr_contact_search(sdr_contact *contact, double *const u[3]);

/* Put contact->late into the rows, and empty it. */
sdr_status sdr_contact_merge(sdr_contact *contact);

/* Make point i a spot, at the end. */
sdr_status sdr_contact_expose(sdr_contact *contact, int32_t i);

#endif
