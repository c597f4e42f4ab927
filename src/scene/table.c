#include "scene/table.h"

#include "base/memory.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROWS = 1000000 };

/* A file being read. */
typedef struct {
  const char *path;
  FILE *stream;
  char *text; /* the present line, from getline */
  size_t room;
  int line;
} source;

typedef struct {
  int count, room;
  double *key, *value; /* from sdr_alloc */
} rows;

/* The next line that says something, without its end; 0 after the last. */
static int next_line(source *s)
{
  ssize_t length;
  while ((length = getline(&s->text, &s->room, s->stream)) >= 0) {
    ++s->line;
    while (length > 0 && strchr("\r\n", s->text[length - 1])) s->text[--length] = '\0';
    const size_t blanks = strspn(s->text, " \t");
    if (s->text[blanks] != '\0' && s->text[blanks] != '#') return 1;
  }
  return 0;
}

/* Cell `index` of the line, without blanks around it; its length, -1 if there is none. */
static int cell(const char *line, int index, const char **out)
{
  for (; index > 0; --index) {
    line = strchr(line, ',');
    if (!line) return -1;
    ++line;
  }
  line += strspn(line, " \t");
  size_t length = strcspn(line, ",");
  while (length > 0 && strchr(" \t", line[length - 1])) --length;
  *out = line;
  return (int)length;
}

static sdr_status find_column(const source *s, const char *name, int *out)
{
  const char *text;
  for (int k = 0, length; (length = cell(s->text, k, &text)) >= 0; ++k) {
    if ((size_t)length != strlen(name) || strncmp(text, name, (size_t)length) != 0) continue;
    *out = k;
    return SDR_OK;
  }
  return sdr_fail(SDR_BAD_INPUT, "%s:%d: there is no column '%s' in '%.200s'", s->path, s->line,
                  name, s->text);
}

static sdr_status read_cell(const source *s, int column, double *out)
{
  const char *text = "";
  char *end;
  const int length = cell(s->text, column, &text);
  *out = strtod(text, &end);
  if (length > 0 && end == text + length && isfinite(*out)) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s:%d: '%.*s' is no number", s->path, s->line,
                  length > 60  ? 60
                  : length > 0 ? length
                               : 0,
                  text);
}

static sdr_status add_row(const source *s, rows *r, double key, double value)
{
  if (r->count > 0 && !(key > r->key[r->count - 1]))
    return sdr_fail(SDR_BAD_INPUT, "%s:%d: %g does not lie above %g, the row before", s->path,
                    s->line, key, r->key[r->count - 1]);
  if (r->count == MOST_ROWS)
    return sdr_fail(SDR_BAD_INPUT, "%s: more than %d rows", s->path, MOST_ROWS);
  if (r->count == r->room) {
    const int room = 2 * r->room + 256;
    double *more_keys = sdr_realloc(r->key, (size_t)room, sizeof *more_keys);
    if (more_keys) r->key = more_keys;
    double *more_values = sdr_realloc(r->value, (size_t)room, sizeof *more_values);
    if (more_values) r->value = more_values;
    if (!more_keys || !more_values) return SDR_RUN_FAILED;
    r->room = room;
  }
  r->key[r->count] = key;
  r->value[r->count++] = value;
  return SDR_OK;
}

static sdr_status read_rows(source *s, const char *key, const char *value, rows *r)
{
  int key_column, value_column;
  if (!next_line(s)) return sdr_fail(SDR_BAD_INPUT, "%s: the file is empty", s->path);
  SDR_TRY(find_column(s, key, &key_column));
  SDR_TRY(find_column(s, value, &value_column));
  while (next_line(s)) {
    double k, v;
    SDR_TRY(read_cell(s, key_column, &k));
    SDR_TRY(read_cell(s, value_column, &v));
    SDR_TRY(add_row(s, r, k, v));
  }
  if (r->count >= 2) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s: a table needs at least 2 rows", s->path);
}

static double *keep(sdr_store *store, const double *values, int count)
{
  double *kept = sdr_store_alloc(store, (size_t)count, sizeof *kept);
  for (int k = 0; kept && k < count; ++k) kept[k] = values[k];
  return kept;
}

sdr_status sdr_table_read(sdr_store *store, const char *path, const char *key, const char *value,
                          int *row_count, double **keys, double **values)
{
  source s = {.path = path, .stream = fopen(path, "r")};
  rows r = {0};
  if (!s.stream) return sdr_fail(SDR_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
  sdr_status status = read_rows(&s, key, value, &r);
  if (status == SDR_OK) {
    double *kept_keys = keep(store, r.key, r.count);
    double *kept_values = keep(store, r.value, r.count);
    if (kept_keys && kept_values) {
      *row_count = r.count;
      *keys = kept_keys;
      *values = kept_values;
    } else {
      status = SDR_RUN_FAILED;
    }
  }
  fclose(s.stream);
  free(s.text);
  sdr_free(r.key);
  sdr_free(r.value);
  return status;
}
