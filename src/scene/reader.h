/* Typed reading of a tree of YAML nodes: every key asked for is known, every default taken is
   written into the tree and listed, every error is collected with its place. */
#ifndef SDR_SCENE_READER_H
#define SDR_SCENE_READER_H

#include "scene/node.h"
#include "scene/units.h"

enum { SDR_READER_SHOWN_ERRORS = 20, SDR_READER_KEPT_ERRORS = 200 };

typedef struct {
  sdr_origin origin;
  const char *text;
} sdr_reader_error;

typedef struct {
  sdr_store *store;
  const char *file; /* errors elsewhere (--set) are listed after those in this file */
  sdr_dimension dimension;
  int error_count; /* all, kept or not */
  sdr_reader_error error[SDR_READER_KEPT_ERRORS];
  sdr_status fatal; /* SDR_OK, or what stopped the reading: no memory, no table of units */
  char fatal_text[300];
  const struct sdr_import *imported; /* read before, and how: not read again */
  char imported_how[600];
  int unreadable; /* 1: an imported file cannot be read by this build */
  int default_count, default_room;
  char **defaults;
  int idle_count, idle_room;
  char **idle; /* what the scene says and nothing looks at */
} sdr_reader;

/* Fallbacks: NULL: the key is required; SDR_OPTIONAL: it may be absent, nothing is filled in;
   else the YAML text that is filled in and listed as a default. */
#define SDR_OPTIONAL ""

/* What a number must be. */
typedef struct {
  sdr_unit unit;
  double low, high;          /* allowed range in SI, +-INFINITY: open */
  int above_low, below_high; /* 1: the bound itself is excluded */
} sdr_quantity;

void sdr_read_error(sdr_reader *reader, sdr_origin origin, const char *format, ...)
    SDR_PRINTF(3, 4);
/* Note what a scene says without effect. */
void sdr_note_idle(sdr_reader *reader, const char *format, ...) SDR_PRINTF(2, 3);
/* Note that memory ran out, or another failure that is not the input's fault. */
void sdr_read_fatal(sdr_reader *reader, sdr_status status);
/* SDR_OK if nothing was wrong, else record the sorted list of errors. */
sdr_status sdr_read_finish(sdr_reader *reader);

/* The value of `key`, with its default filled in; NULL if there is none (absent and optional, or
   in error). `what` says what is wanted: "a length, like 1 mm". */
sdr_node *sdr_read_value(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                         const char *what);
/* 1 if the mapping has the key (which makes it known). */
int sdr_read_has(sdr_reader *reader, sdr_node *map, const char *key);
/* Make a key known without reading it. */
void sdr_read_allow(sdr_reader *reader, sdr_node *map, const char *key);
/* Complain about each key of the mapping that nothing has asked for. */
void sdr_read_done(sdr_reader *reader, sdr_node *map);

/* A value that must be a mapping or a list. A mapping with fallback "{}" is filled in without being
   listed: its keys will be. */
sdr_node *sdr_read_map(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback);
sdr_node *sdr_read_list(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback);
/* 1 if the node is of that kind, else an error. */
int sdr_read_is(sdr_reader *reader, const sdr_node *node, sdr_node_kind kind, const char *what);

/* Each returns 1 and writes *out (and writes nothing else) if there is a good value. */
int sdr_read_number(sdr_reader *reader, sdr_node *map, const char *key, sdr_quantity quantity,
                    const char *fallback, double *out);
int sdr_read_number_node(sdr_reader *reader, sdr_node *node, sdr_quantity quantity, double *out);
int sdr_read_length(sdr_reader *reader, sdr_node *map, const char *key, const char *relative,
                    sdr_quantity quantity, const char *fallback, sdr_length *out);
int sdr_read_integer(sdr_reader *reader, sdr_node *map, const char *key, int64_t low, int64_t high,
                     const char *fallback, int64_t *out);
/* A list of the scene's components (numbers); others are 0. */
int sdr_read_vector(sdr_reader *reader, sdr_node *map, const char *key, sdr_quantity quantity,
                    const char *fallback, double out[3]);
int sdr_read_vector_node(sdr_reader *reader, sdr_node *node, sdr_quantity quantity, double out[3]);
int sdr_read_flag(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                  int *out);
/* One of `words` (ended by NULL): *out is its index. `later` (may be NULL): words of the contract
   that this version does not have. */
int sdr_read_word(sdr_reader *reader, sdr_node *map, const char *key, const char *const *words,
                  const char *const *later, const char *fallback, int *out);
int sdr_read_word_node(sdr_reader *reader, const sdr_node *node, const char *what,
                       const char *const *words, const char *const *later, int *out);
/* Text of at most size - 1 bytes. */
int sdr_read_text(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                  char *out, size_t size);
/* A word of letters, digits, _ and -. */
int sdr_read_name(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                  char out[SDR_NAME_MAX]);
int sdr_read_is_name(sdr_reader *reader, const char *text, sdr_origin origin, const char *what);

/* A number, or the word `word` that stands for the value `word_value`. */
int sdr_read_number_or(sdr_reader *reader, sdr_node *map, const char *key, const char *word,
                       double word_value, sdr_quantity quantity, const char *fallback, double *out);

/* A formula; it may use what is in `allowed` (SDR_USES_...). Owned by the reader's store. */
int sdr_read_formula(sdr_reader *reader, sdr_node *map, const char *key, sdr_unit unit, int allowed,
                     const char *fallback, sdr_expression **out);
/* A formula or a number with the unit `relative`. */
int sdr_read_relative_node(sdr_reader *reader, sdr_node *node, sdr_unit unit, const char *relative,
                           int allowed, int *is_relative, sdr_expression **out);
int sdr_read_formula_node(sdr_reader *reader, sdr_node *node, sdr_unit unit, int allowed,
                          sdr_expression **out);
/* Components as a list of all or a mapping of some ({x: ..., y: ...}); NULL where not given. The
   entries of the list that are null count as not given. Returns how many were given. */
int sdr_read_components(sdr_reader *reader, sdr_node *node, sdr_unit unit, int allowed,
                        sdr_expression *out[3]);

/* The nearest of `count` names to `word`, NULL if none is near. */
const char *sdr_read_nearest(const char *word, const char *const *names, int count);

#endif
