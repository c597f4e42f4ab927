/* Points from a table: a CSV file whose first line names its columns. */
#include "base/memory.h"
#include "scene/import.h"
#include "scene/units.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS_MAX = 64, CELL_MAX = 64 };
static const int64_t most_points = INT32_MAX - 8;

typedef enum { IGNORED = -1, X, Y, Z, VOLUME, SPACING, HORIZON, REGION, KINDS } column_kind;
static const char *const words[KINDS] = {"x", "y", "z", "volume", "spacing", "horizon", "region"};

typedef struct {
  column_kind kind;
  double multiply, divide; /* to SI */
} column;

typedef struct {
  const char *path, *at, *end;
  int32_t line;
  const char *row; /* the present line, without its end */
  size_t length;
  const sdr_import_how *how;
  int column_count;
  column columns[COLUMNS_MAX];
  sdr_import *import;
  sdr_store *store;
  sdr_import_group *group; /* the latest that was found */
} table;

/* ---- lines and cells ------------------------------------------------------------------------- */

/* The next line that says something; 0 after the last. */
static int next_line(table *t)
{
  while (t->at < t->end) {
    const char *stop = memchr(t->at, '\n', (size_t)(t->end - t->at));
    const char *row = t->at, *last = stop ? stop : t->end;
    t->at = stop ? stop + 1 : t->end;
    ++t->line;
    while (last > row && (last[-1] == ' ' || last[-1] == '\t' || last[-1] == '\r')) --last;
    while (row < last && (*row == ' ' || *row == '\t')) ++row;
    if (row == last || *row == '#') continue;
    t->row = row;
    t->length = (size_t)(last - row);
    return 1;
  }
  return 0;
}

/* The cell that begins at *at, without blanks around it; *at goes behind its comma, to NULL after
   the last. A cell too long for the buffer is cut: it is no number and no name anyway. */
static const char *next_cell(const table *t, const char **at, char cell[CELL_MAX])
{
  const char *end = t->row + t->length, *from = *at;
  const char *comma = memchr(from, ',', (size_t)(end - from));
  const char *last = comma ? comma : end;
  *at = comma ? comma + 1 : NULL;
  while (from < last && (*from == ' ' || *from == '\t')) ++from;
  while (last > from && (last[-1] == ' ' || last[-1] == '\t')) --last;
  const size_t length = (size_t)(last - from) < CELL_MAX - 1 ? (size_t)(last - from) : CELL_MAX - 1;
  for (size_t k = 0; k < length; ++k) /* control characters stay out of messages */
    cell[k] = (unsigned char)from[k] < ' ' ? '?' : from[k];
  cell[length] = '\0';
  return cell;
}

/* ---- the header ------------------------------------------------------------------------------ */

static int is_ignored(const table *t, const char *name)
{
  for (int k = 0; k < t->how->ignored_count; ++k)
    if (strcmp(t->how->ignored[k], name) == 0) return 1;
  return 0;
}

/* Coordinates that the scene does not have are no columns. */
static int is_wanted(const table *t, int kind)
{
  return kind > Z || kind < t->how->components;
}

static sdr_status unknown_column(const table *t, const char *name)
{
  char list[128] = "";
  for (int k = 0; k < KINDS; ++k) {
    const size_t used = strlen(list);
    if (is_wanted(t, k))
      snprintf(list + used, sizeof list - used, "%s%s", used ? ", " : "", words[k]);
  }
  return sdr_fail(SDR_BAD_INPUT,
                  "%s:%d: unknown column '%s'; columns here: %s, with commas between them; name "
                  "what is to be left out in points.import.ignore",
                  t->path, t->line, name, list);
}

static sdr_status read_unit(const table *t, const char *name, const char *text, column *out)
{
  sdr_measure measure;
  size_t used;
  const sdr_unit wanted = {out->kind == VOLUME ? 3 : 1, 0, 0, 0};
  const sdr_status status = sdr_units_scan(text, &used, &measure);
  if (status == SDR_BAD_INPUT)
    return sdr_fail(status, "%s:%d: column '%s': %s", t->path, t->line, name, sdr_error_message());
  SDR_TRY(status);
  const char *rest = text + used + strspn(text + used, " ");
  if (used == 0 || (strcmp(rest, "]") != 0 && strcmp(rest, ")") != 0))
    return sdr_fail(SDR_BAD_INPUT,
                    "%s:%d: column '%s': no unit is known by '%s'; write it as in 'x [mm]'",
                    t->path, t->line, name, text);
  if (!sdr_unit_equal(measure.dimension, wanted))
    return sdr_fail(SDR_BAD_INPUT, "%s:%d: column '%s' is %s, wanted %s; write it as in '%s [%s]'",
                    t->path, t->line, name, sdr_unit_name(measure.dimension), sdr_unit_name(wanted),
                    name, out->kind == VOLUME ? "mm^3" : "mm");
  out->multiply = measure.multiply;
  out->divide = measure.divide;
  return SDR_OK;
}

static sdr_status read_column(table *t, const char *cell)
{
  char name[CELL_MAX];
  if (t->column_count == COLUMNS_MAX)
    return sdr_fail(SDR_BAD_INPUT, "%s:%d: more than %d columns", t->path, t->line, COLUMNS_MAX);
  column *out = &t->columns[t->column_count++];
  size_t length = strcspn(cell, "[(");
  const char *unit = cell[length] ? cell + length + 1 : NULL;
  while (length > 0 && cell[length - 1] == ' ') --length;
  snprintf(name, sizeof name, "%.*s", (int)length, cell);
  *out = (column){IGNORED, 1.0, 1.0};
  if (is_ignored(t, name)) return SDR_OK;
  int kind = 0;
  while (kind < KINDS && !(is_wanted(t, kind) && strcmp(words[kind], name) == 0)) ++kind;
  if (kind == KINDS) return unknown_column(t, name);
  for (int k = 0; k < t->column_count - 1; ++k)
    if ((int)t->columns[k].kind == kind)
      return sdr_fail(SDR_BAD_INPUT, "%s:%d: two columns '%s'; leave one", t->path, t->line, name);
  out->kind = (column_kind)kind;
  if (kind == REGION) return SDR_OK;
  out->multiply = kind == VOLUME ? pow(t->how->unit, 3.0) : t->how->unit;
  return unit ? read_unit(t, name, unit, out) : SDR_OK;
}

static int has_column(const table *t, column_kind kind)
{
  for (int k = 0; k < t->column_count; ++k)
    if (t->columns[k].kind == kind) return 1;
  return 0;
}

static sdr_status read_header(table *t)
{
  char cell[CELL_MAX];
  if (t->end - t->at >= 3 && memcmp(t->at, "\xef\xbb\xbf", 3) == 0) t->at += 3;
  if (!next_line(t))
    return sdr_fail(SDR_BAD_INPUT, "%s:1: the file is empty; its first line names the columns",
                    t->path);
  for (const char *at = t->row; at;) SDR_TRY(read_column(t, next_cell(t, &at, cell)));
  for (int k = X; k < t->how->components; ++k)
    if (!has_column(t, (column_kind)k))
      return sdr_fail(SDR_BAD_INPUT, "%s:%d: there is no column '%s'; give it in the first line",
                      t->path, t->line, words[k]);
  if (!has_column(t, VOLUME) && !has_column(t, SPACING))
    return sdr_fail(SDR_BAD_INPUT, "%s:%d: there is no column 'volume' or 'spacing'; give one",
                    t->path, t->line);
  return SDR_OK;
}

/* ---- rows ------------------------------------------------------------------------------------ */

static sdr_status read_number(const table *t, const column *c, const char *cell, double *out)
{
  char *end;
  const double value = strtod(cell, &end);
  *out = value * c->multiply / c->divide;
  if (end == cell || *end != '\0' || !isfinite(*out))
    return sdr_fail(SDR_BAD_INPUT, "%s:%d: column '%s': '%s' is no number; give one, like 1.5e-3",
                    t->path, t->line, words[c->kind], cell);
  if (c->kind <= Z || *out > 0.0) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s:%d: column '%s': %s is out of range; allowed: above 0",
                  t->path, t->line, words[c->kind], cell);
}

static int is_name(const char *name)
{
  static const char *const letters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  return strspn(name, letters) == strlen(name) && strcmp(name, "body") != 0 &&
         strcmp(name, "all") != 0;
}

static sdr_status put_in_region(table *t, const char *name, int32_t point)
{
  if (!t->group || strcmp(t->group->name, name) != 0) t->group = sdr_import_find(t->import, name);
  if (!t->group && !is_name(name))
    return sdr_fail(SDR_BAD_INPUT,
                    "%s:%d: '%s' is no name for a region; allowed: letters, digits, _ and -, but "
                    "not body or all",
                    t->path, t->line, name);
  if (!t->group && t->import->group_count == SDR_GROUPS_MAX)
    return sdr_fail(SDR_BAD_INPUT, "%s:%d: more than %d regions; is 'region' the right column?",
                    t->path, t->line, SDR_GROUPS_MAX);
  if (!t->group) t->group = sdr_import_add_group(t->store, t->import, name);
  if (!t->group) return SDR_RUN_FAILED;
  sdr_import_put(t->group, point);
  return SDR_OK;
}

/* Names with blanks between them; none is allowed. */
static sdr_status read_regions(table *t, char *cell, int32_t point)
{
  char *rest = NULL;
  for (char *name = strtok_r(cell, " \t", &rest); name; name = strtok_r(NULL, " \t", &rest))
    SDR_TRY(put_in_region(t, name, point));
  return SDR_OK;
}

static sdr_status wrong_count(const table *t, int given)
{
  return sdr_fail(SDR_BAD_INPUT,
                  "%s:%d: %d values, the first line names %d columns; give each row "
                  "a value for each",
                  t->path, t->line, given, t->column_count);
}

static sdr_status read_row(table *t, int32_t point)
{
  char cell[CELL_MAX];
  sdr_import *import = t->import;
  double *const arrays[] = {import->x[0],   import->x[1],    import->x[2],
                            import->volume, import->spacing, import->horizon};
  int k = 0;
  for (const char *at = t->row; at; ++k) {
    next_cell(t, &at, cell);
    if (k >= t->column_count) continue;
    const column *c = &t->columns[k];
    if (c->kind == REGION) SDR_TRY(read_regions(t, cell, point));
    if (c->kind != REGION && c->kind != IGNORED)
      SDR_TRY(read_number(t, c, cell, &arrays[c->kind][point]));
  }
  import->line[point] = t->line;
  return k == t->column_count ? SDR_OK : wrong_count(t, k);
}

static sdr_status allocate(table *t, int64_t rows)
{
  sdr_import *import = t->import;
  double **const arrays[] = {&import->x[0],   &import->x[1],    &import->x[2],
                             &import->volume, &import->spacing, &import->horizon};
  import->count = (int32_t)rows;
  for (int k = X; k < REGION; ++k) {
    if (k > Z && !has_column(t, (column_kind)k)) continue;
    *arrays[k] = sdr_store_alloc(t->store, (size_t)rows, sizeof(double));
    if (!*arrays[k]) return SDR_RUN_FAILED;
  }
  import->line = sdr_store_alloc(t->store, (size_t)rows, sizeof *import->line);
  return import->line ? SDR_OK : SDR_RUN_FAILED;
}

static int64_t count_rows(const table *t)
{
  table ahead = *t;
  int64_t rows = 0;
  while (ahead.line < INT32_MAX && next_line(&ahead)) ++rows;
  return rows;
}

sdr_status sdr_import_table(sdr_store *store, const char *path, const char *text, size_t length,
                            const sdr_import_how *how, sdr_import **out)
{
  table t = {.path = path, .at = text, .end = text + length, .how = how, .store = store};
  t.import = sdr_store_alloc(store, 1, sizeof *t.import);
  if (!t.import) return SDR_RUN_FAILED;
  t.import->components = how->components;
  SDR_TRY(read_header(&t));
  const int64_t rows = count_rows(&t);
  if (rows < 1)
    return sdr_fail(SDR_BAD_INPUT, "%s:%d: the table names columns and has no row; give points",
                    path, t.line);
  if (rows > most_points)
    return sdr_fail(SDR_BAD_INPUT, "%s: %lld points; at most %lld are possible", path,
                    (long long)rows, (long long)most_points);
  SDR_TRY(allocate(&t, rows));
  for (int32_t k = 0; k < rows && next_line(&t); ++k) SDR_TRY(read_row(&t, k));
  *out = t.import;
  return SDR_OK;
}
