/* YAML text to a tree of nodes and back. */
#ifndef SDR_SCENE_YAML_H
#define SDR_SCENE_YAML_H

#include "scene/node.h"

enum {
  SDR_YAML_MAX_BYTES = 4 * 1024 * 1024,
  SDR_YAML_MAX_DEPTH = 64,
  SDR_YAML_MAX_NODES = 200000,
  SDR_YAML_MAX_KEYS = 1000 /* of one mapping: a duplicate is searched for */
};

/* Read a whole file of at most SDR_YAML_MAX_BYTES. SDR_IO_ERROR: cannot be read, is a directory;
   SDR_BAD_INPUT: too big. The caller frees *text with sdr_free. */
sdr_status sdr_yaml_read_file(const char *path, char **text, size_t *length);

/* Parse one YAML document. Refused: anchors, aliases, tags, a second document, duplicate keys, keys
   that are not plain text, depth above SDR_YAML_MAX_DEPTH, more than SDR_YAML_MAX_NODES values.
   `file` (kept, not copied) names the text in origins. SDR_BAD_INPUT: one line
   "file:line:column: ...". An empty text gives *root = NULL. */
sdr_status sdr_yaml_parse(sdr_store *store, const char *text, size_t length, const char *file,
                          sdr_node **root);

/* Write a tree as YAML that reads back the same; NULL: memory. From sdr_alloc, owned by the
   caller. */
char *sdr_yaml_write(const sdr_node *root);

#endif
