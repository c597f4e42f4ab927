#include "scene/reader.h"

#include "scene/yaml.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- errors ---------------------------------------------------------------------------------- */

void sdr_read_fatal(sdr_reader *reader, sdr_status status)
{
  if (reader->fatal != SDR_OK) return;
  reader->fatal = status;
  snprintf(reader->fatal_text, sizeof reader->fatal_text, "%s", sdr_error_message());
}

void sdr_read_error(sdr_reader *reader, sdr_origin origin, const char *format, ...)
{
  char text[600];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (reader->error_count++ >= SDR_READER_KEPT_ERRORS) return;
  const char *kept = sdr_store_copy(reader->store, text, strlen(text));
  if (!kept) sdr_read_fatal(reader, SDR_RUN_FAILED);
  reader->error[reader->error_count - 1] = (sdr_reader_error){origin, kept ? kept : ""};
}

/* Errors of the file by line and column, then those of --set in their order. */
static int is_before(const sdr_reader *reader, const sdr_reader_error *a, const sdr_reader_error *b)
{
  const int a_inside = a->origin.file == reader->file, b_inside = b->origin.file == reader->file;
  if (a_inside != b_inside) return a_inside;
  if (!a_inside) return 0;
  if (a->origin.line != b->origin.line) return a->origin.line < b->origin.line;
  return a->origin.column < b->origin.column;
}

static void sort_errors(sdr_reader *reader, int count)
{
  for (int k = 1; k < count; ++k) { /* insertion keeps the order of equals */
    const sdr_reader_error moved = reader->error[k];
    int at = k;
    for (; at > 0 && is_before(reader, &moved, &reader->error[at - 1]); --at) {
      reader->error[at] = reader->error[at - 1];
    }
    reader->error[at] = moved;
  }
}

sdr_status sdr_read_finish(sdr_reader *reader)
{
  if (reader->fatal != SDR_OK) {
    return sdr_fail(reader->fatal, "%s: %s", reader->file, reader->fatal_text);
  }
  if (reader->error_count == 0) return SDR_OK;
  const int kept =
      reader->error_count < SDR_READER_KEPT_ERRORS ? reader->error_count : SDR_READER_KEPT_ERRORS;
  sort_errors(reader, kept);
  const int shown = kept < SDR_READER_SHOWN_ERRORS ? kept : SDR_READER_SHOWN_ERRORS;
  char text[SDR_READER_SHOWN_ERRORS * 760];
  size_t used = 0;
  for (int k = 0; k < shown && used < sizeof text; ++k) {
    used += (size_t)snprintf(text + used, sizeof text - used, "%s%s: %s", k ? "\n" : "",
                             sdr_origin_text(reader->error[k].origin), reader->error[k].text);
  }
  if (reader->error_count > shown && used < sizeof text) {
    snprintf(text + used, sizeof text - used, "\nand %d more", reader->error_count - shown);
  }
  return sdr_fail(SDR_BAD_INPUT, "%s", text);
}

/* ---- nearest names --------------------------------------------------------------------------- */

enum { WORD_MAX = 40 };

/* Edits (insert, delete, change, swap neighbours) from a to b, both shorter than WORD_MAX. */
static int distance(const char *a, const char *b)
{
  int row[3][WORD_MAX + 1];
  const int la = (int)strlen(a), lb = (int)strlen(b);
  for (int j = 0; j <= lb; ++j) row[0][j] = j;
  for (int i = 1; i <= la; ++i) {
    int *now = row[i % 3];
    const int *above = row[(i + 2) % 3], *two_above = row[(i + 1) % 3];
    now[0] = i;
    for (int j = 1; j <= lb; ++j) {
      int least = above[j - 1] + (a[i - 1] != b[j - 1]);
      if (above[j] + 1 < least) least = above[j] + 1;
      if (now[j - 1] + 1 < least) least = now[j - 1] + 1;
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
          two_above[j - 2] + 1 < least) {
        least = two_above[j - 2] + 1;
      }
      now[j] = least;
    }
  }
  return row[la % 3][lb];
}

const char *sdr_read_nearest(const char *word, const char *const *names, int count)
{
  const char *nearest = NULL;
  const int length = (int)strlen(word);
  int least = length <= 4 ? 2 : length <= 8 ? 3 : 4; /* below this it is a likely slip */
  if (length >= WORD_MAX) return NULL;
  for (int k = 0; k < count; ++k) {
    if (strlen(names[k]) >= WORD_MAX) continue;
    const int d = distance(word, names[k]);
    if (d < least) {
      least = d;
      nearest = names[k];
    }
  }
  return nearest;
}

/* ---- keys ------------------------------------------------------------------------------------ */

void sdr_read_allow(sdr_reader *reader, sdr_node *map, const char *key)
{
  for (const sdr_known_key *k = map->known; k; k = k->next) {
    if (strcmp(k->key, key) == 0) return;
  }
  sdr_known_key *fresh = sdr_store_alloc(reader->store, 1, sizeof *fresh);
  if (!fresh) {
    sdr_read_fatal(reader, SDR_RUN_FAILED);
    return;
  }
  fresh->key = key;
  if (map->last_key) {
    map->last_key->next = fresh;
  } else {
    map->known = fresh;
  }
  map->last_key = fresh;
}

int sdr_read_has(sdr_reader *reader, sdr_node *map, const char *key)
{
  sdr_read_allow(reader, map, key);
  return sdr_node_find(map, key) != NULL;
}

static int is_known(const sdr_node *map, const char *key)
{
  for (const sdr_known_key *k = map->known; k; k = k->next) {
    if (strcmp(k->key, key) == 0) return 1;
  }
  return 0;
}

/* The usual ways to write what YAML takes for another key. */
static const char *key_hint(const char *key)
{
  if (strchr(key, ':')) return " write a blank after the colon;";
  if (strchr(key, '(') || strchr(key, ')')) return " a formula with a comma needs quotes here;";
  return "";
}

static void unknown_key(sdr_reader *reader, const sdr_node *map, const sdr_node *child)
{
  enum { MOST = 64 };
  const char *names[MOST];
  int count = 0;
  char known[400] = "";
  size_t used = 0;
  for (const sdr_known_key *k = map->known; k && count < MOST; k = k->next) {
    if (used < sizeof known) {
      used +=
          (size_t)snprintf(known + used, sizeof known - used, "%s%s", count ? ", " : "", k->key);
    }
    names[count++] = k->key;
  }
  const char *nearest = sdr_read_nearest(child->key, names, count);
  if (nearest) {
    sdr_read_error(reader, child->key_origin,
                   "unknown key '%.60s'; did you mean '%s'? known here: %s", child->key, nearest,
                   known);
  } else {
    sdr_read_error(reader, child->key_origin, "unknown key '%.60s';%s known here: %s", child->key,
                   key_hint(child->key), known);
  }
}

void sdr_read_done(sdr_reader *reader, sdr_node *map)
{
  for (const sdr_node *child = map->first; child; child = child->next) {
    if (!is_known(map, child->key)) unknown_key(reader, map, child);
  }
}

/* Add a line of the store (NULL: memory ran out) to a list of them. */
static void list_line(sdr_reader *reader, char *line, char ***list, int *count, int *room)
{
  char **grown = *list;
  if (line && *count == *room) {
    *room = 2 * *room + 32;
    grown = sdr_store_alloc(reader->store, (size_t)*room, sizeof *grown);
    if (grown && *count > 0) memcpy(grown, *list, (size_t)*count * sizeof *grown);
  }
  if (!line || !grown) {
    sdr_read_fatal(reader, SDR_RUN_FAILED);
    return;
  }
  *list = grown;
  grown[(*count)++] = line;
}

static void list_default(sdr_reader *reader, const sdr_node *node, const char *text)
{
  char path[256];
  sdr_node_path(node, path, sizeof path);
  list_line(reader, sdr_store_format(reader->store, "%s = %s", path, text), &reader->defaults,
            &reader->default_count, &reader->default_room);
}

void sdr_note_idle(sdr_reader *reader, const char *format, ...)
{
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  list_line(reader, sdr_store_copy(reader->store, text, strlen(text)), &reader->idle,
            &reader->idle_count, &reader->idle_room);
}

/* Hang the default's own tree into the mapping; its origin is the mapping's. */
static sdr_node *fill_in(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback)
{
  sdr_node *node = NULL;
  char *text = sdr_store_copy(reader->store, fallback, strlen(fallback));
  char *name = sdr_store_copy(reader->store, key, strlen(key));
  if (!text || !name ||
      sdr_yaml_parse(reader->store, text, strlen(text), "default", &node) != SDR_OK || !node) {
    sdr_read_fatal(reader, SDR_RUN_FAILED);
    return NULL;
  }
  node->key = name;
  node->origin = node->key_origin = map->origin;
  node->text_column = 0;
  sdr_node_append(map, node);
  if (strcmp(fallback, "{}") != 0) list_default(reader, node, fallback);
  return node;
}

sdr_node *sdr_read_value(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                         const char *what)
{
  char path[256];
  sdr_read_allow(reader, map, key);
  sdr_node *node = sdr_node_find(map, key);
  if (!node && !fallback) {
    sdr_node_path(map, path, sizeof path);
    sdr_read_error(reader, map->origin, "%s lacks the key '%s': %s", path, key, what);
    return NULL;
  }
  if (!node) return *fallback ? fill_in(reader, map, key, fallback) : NULL;
  if (!sdr_node_is_null(node)) return node;
  sdr_node_path(node, path, sizeof path);
  sdr_read_error(reader, node->origin, "%s has no value; give %s%s", path, what,
                 fallback ? " or remove the key" : "");
  return NULL;
}

int sdr_read_is(sdr_reader *reader, const sdr_node *node, sdr_node_kind kind, const char *what)
{
  if (node->kind == kind) return 1;
  char path[256];
  sdr_node_path(node, path, sizeof path);
  sdr_read_error(reader, node->origin, "%s is %s; wanted %s", path, sdr_node_kind_name(node->kind),
                 what);
  return 0;
}

sdr_node *sdr_read_map(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback)
{
  const char *what = "a mapping (key: value)";
  sdr_node *node = sdr_read_value(reader, map, key, fallback, what);
  return node && sdr_read_is(reader, node, SDR_MAPPING, what) ? node : NULL;
}

sdr_node *sdr_read_list(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback)
{
  const char *what = "a list ([a, b] or lines that begin with '- ')";
  sdr_node *node = sdr_read_value(reader, map, key, fallback, what);
  return node && sdr_read_is(reader, node, SDR_SEQUENCE, what) ? node : NULL;
}
