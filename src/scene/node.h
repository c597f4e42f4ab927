/* The tree of a YAML text: mappings, sequences and scalars that know where they stand. */
#ifndef SDR_SCENE_NODE_H
#define SDR_SCENE_NODE_H

#include "base/status.h"
#include "scene/scene.h"
#include "scene/store.h"

typedef enum { SDR_SCALAR, SDR_SEQUENCE, SDR_MAPPING } sdr_node_kind;

/* A key that somebody asked a mapping for. */
typedef struct sdr_known_key {
  const char *key;
  struct sdr_known_key *next;
} sdr_known_key;

typedef struct sdr_node {
  sdr_node_kind kind;
  const char *key;       /* of an entry of a mapping, else NULL */
  const char *text;      /* of a scalar */
  int quoted;            /* scalar: in quotes or a block, so never a missing value */
  int text_column;       /* column where `text` itself begins, 0 if it is not as in the file */
  const char *canonical; /* scalar read as a number: its SI value, for the hash */
  sdr_origin origin, key_origin;
  struct sdr_node *parent, *first, *last, *next;
  int count;                       /* children */
  sdr_known_key *known, *last_key; /* in the order of asking */
} sdr_node;

/* A node without children; NULL if memory runs out. */
sdr_node *sdr_node_create(sdr_store *store, sdr_node_kind kind, sdr_origin origin);
void sdr_node_append(sdr_node *parent, sdr_node *child);
/* Put `fresh` in the place of `old`, keeping the place in the order. */
void sdr_node_replace(sdr_node *old, sdr_node *fresh);
void sdr_node_remove(sdr_node *child);

sdr_node *sdr_node_find(const sdr_node *mapping, const char *key); /* NULL: none */
sdr_node *sdr_node_item(const sdr_node *node, int index);          /* NULL: none */
int sdr_node_is_null(const sdr_node *node); /* a plain empty scalar, ~ or null */
const char *sdr_node_kind_name(sdr_node_kind kind);

sdr_node *sdr_node_copy(sdr_store *store, const sdr_node *node); /* NULL: memory */

/* Merge `over` into the mapping `base`: mappings deep, everything else replaced whole. Two
   one-entry mappings whose keys both are choices of one thing (`is_choice`, may be NULL) are
   alternatives: the later one replaces the earlier. SDR_RUN_FAILED: memory. */
sdr_status sdr_node_merge(sdr_store *store, sdr_node *base, const sdr_node *over,
                          int (*is_choice)(const char *key));

/* Put `value` at `path` ("loads.0.pressure.value"), making mappings on the way. A path that leads
   through a scalar or past the end of a list is SDR_BAD_INPUT: the message says why, without
   place. An index one past the end appends. */
sdr_status sdr_node_set(sdr_store *store, sdr_node *root, const char *path, sdr_node *value);

/* "loads.0.pressure.value" from the root, cut to `size`. */
void sdr_node_path(const sdr_node *node, char *path, size_t size);

#endif
