/* history.csv: a header line of names, then rows of numbers. */
#include "app/rundata.h"

#include "base/memory.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS_MAX = 4096 };

/* The next line without its end, NULL at the end of the file; a last line without a newline is
   still being written and does not count. */
static char *next_line(FILE *file, char **buffer, size_t *room)
{
  const ssize_t length = getline(buffer, room, file);
  if (length <= 0 || (*buffer)[length - 1] != '\n') return NULL;
  (*buffer)[strcspn(*buffer, "\r\n")] = '\0';
  return *buffer;
}

static sdr_status read_header(const char *path, const char *line, sdr_history *out)
{
  int count = 1;
  for (const char *c = line; *c; ++c) count += *c == ',';
  if (count > COLUMNS_MAX)
    return sdr_fail(SDR_BAD_INPUT, "%s:1: %d columns; at most %d are read", path, count,
                    COLUMNS_MAX);
  out->name = sdr_alloc((size_t)count, sizeof *out->name);
  if (!out->name) return SDR_RUN_FAILED;
  for (; out->column_count < count; ++out->column_count) {
    const size_t length = strcspn(line, ",");
    char *name = sdr_alloc(length + 1, 1);
    if (!name) return SDR_RUN_FAILED;
    memcpy(name, line, length);
    out->name[out->column_count] = name;
    line += length + (line[length] == ',');
  }
  return SDR_OK;
}

/* One row into values[0..columns). */
static sdr_status read_row(const char *path, int line_number, const char *line, int columns,
                           double *values)
{
  for (int c = 0; c < columns; ++c) {
    char *end = NULL;
    values[c] = strtod(line, &end);
    const int last = c == columns - 1;
    if (end == line || *end != (last ? '\0' : ','))
      return sdr_fail(SDR_BAD_INPUT, "%s:%d: column %d of %d is not a number", path, line_number,
                      c + 1, columns);
    line = end + 1;
  }
  return SDR_OK;
}

/* Rows as they stand in the file, row after row. */
static sdr_status read_rows(const char *path, FILE *file, char **buffer, size_t *room,
                            sdr_history *out, double **rows)
{
  const size_t columns = (size_t)out->column_count;
  int capacity = 0;
  for (char *line; (line = next_line(file, buffer, room)); ++out->row_count) {
    if (out->row_count == capacity) {
      capacity = capacity ? 2 * capacity : 256;
      double *grown = sdr_realloc(*rows, (size_t)capacity * columns, sizeof **rows);
      if (!grown) return SDR_RUN_FAILED;
      *rows = grown;
    }
    SDR_TRY(read_row(path, out->row_count + 2, line, out->column_count,
                     *rows + (size_t)out->row_count * columns));
  }
  return SDR_OK;
}

static sdr_status turn(const double *rows, sdr_history *out)
{
  const size_t count = (size_t)out->row_count, columns = (size_t)out->column_count;
  out->value = sdr_alloc(count * columns, sizeof *out->value);
  if (!out->value) return SDR_RUN_FAILED;
  for (size_t row = 0; row < count; ++row)
    for (size_t c = 0; c < columns; ++c) out->value[c * count + row] = rows[row * columns + c];
  return SDR_OK;
}

sdr_status sdr_history_read(const char *path, sdr_history *out)
{
  sdr_history history = {0};
  char *buffer = NULL;
  size_t room = 0;
  double *rows = NULL;
  FILE *file = fopen(path, "r");
  if (!file) return sdr_fail(SDR_IO_ERROR, "%s: %s", path, strerror(errno));
  sdr_status status = SDR_OK;
  const char *header = next_line(file, &buffer, &room);
  if (header) {
    status = read_header(path, header, &history);
    if (status == SDR_OK) status = read_rows(path, file, &buffer, &room, &history, &rows);
    if (status == SDR_OK) status = turn(rows, &history);
  }
  if (status == SDR_OK && ferror(file)) status = sdr_fail(SDR_IO_ERROR, "%s: cannot be read", path);
  sdr_free(rows);
  free(buffer);
  fclose(file);
  if (status != SDR_OK)
    sdr_history_clear(&history);
  else
    *out = history;
  return status;
}

void sdr_history_clear(sdr_history *history)
{
  for (int c = 0; c < history->column_count; ++c) sdr_free(history->name[c]);
  sdr_free(history->name);
  sdr_free(history->value);
  *history = (sdr_history){0};
}

const double *sdr_rundata_column(const sdr_rundata *run, const char *name)
{
  const sdr_history *history = &run->history;
  for (int c = 0; c < history->column_count; ++c)
    if (strcmp(history->name[c], name) == 0)
      return history->value + (size_t)c * (size_t)history->row_count;
  return NULL;
}

double sdr_rundata_last(const sdr_rundata *run, const char *name)
{
  const double *column = sdr_rundata_column(run, name);
  return column && run->history.row_count > 0 ? column[run->history.row_count - 1] : (double)NAN;
}
