#include "output/history.h"

#include "base/memory.h"
#include "output/rundir.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct sdr_history_file {
  int file;
  off_t length; /* bytes of whole lines */
  char path[PATH_MAX];
};

/* Append `text` whole or not at all. */
static sdr_status append(sdr_history_file *history, const char *text, size_t size)
{
  size_t done = 0;
  while (done < size) {
    const ssize_t written = write(history->file, text + done, size - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int failed = errno;
      if (ftruncate(history->file, history->length) != 0) {
        /* The torn line is then left; a resumed run cuts it. */
      }
      return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", history->path, strerror(failed));
    }
    done += (size_t)written;
  }
  history->length += (off_t)size;
  return SDR_OK;
}

static sdr_status open_at_end(const char *directory, int flags, sdr_history_file **out)
{
  sdr_history_file *history = sdr_alloc(1, sizeof *history);
  if (!history) return SDR_RUN_FAILED;
  snprintf(history->path, sizeof history->path, "%s/history.csv", directory);
  history->file = open(history->path, O_WRONLY | O_APPEND | O_CLOEXEC | flags, 0666);
  history->length = history->file < 0 ? -1 : lseek(history->file, 0, SEEK_END);
  if (history->length < 0) {
    sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", history->path, strerror(errno));
    sdr_history_file_close(&history);
    return SDR_IO_ERROR;
  }
  *out = history;
  return SDR_OK;
}

sdr_status sdr_history_file_create(const char *directory, const char *header,
                                   sdr_history_file **out)
{
  sdr_history_file *history = NULL;
  SDR_TRY(open_at_end(directory, O_CREAT | O_TRUNC, &history));
  sdr_status status = append(history, header, strlen(header));
  if (status == SDR_OK) status = append(history, "\n", 1);
  if (status == SDR_OK) {
    *out = history;
    return SDR_OK;
  }
  unlink(history->path);
  sdr_history_file_close(&history);
  return status;
}

static sdr_status check_header(const char *path, const char *line, const char *header)
{
  const size_t length = strlen(header);
  if (line && strncmp(line, header, length) == 0 && line[length] == '\n') return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s has other columns than this run writes, so it cannot be continued; give the "
                  "same probes and supports, or another directory with -o",
                  path);
}

/* Copy header and rows up to `time`. */
static sdr_status copy_rows(FILE *from, const char *path, const char *header, FILE *to, double time,
                            double *last)
{
  char *line = NULL;
  size_t room = 0;
  ssize_t length = getline(&line, &room, from);
  sdr_status status = check_header(path, length > 0 ? line : NULL, header);
  while (status == SDR_OK && length > 0) {
    if (fwrite(line, 1, (size_t)length, to) != (size_t)length)
      status = sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, strerror(errno));
    length = getline(&line, &room, from);
    if (length <= 0 || line[length - 1] != '\n') break;
    const double row = strtod(line, NULL);
    if (!(row <= time)) break;
    *last = row;
  }
  free(line);
  return status;
}

static sdr_status cut(FILE *from, const char *path, const char *header, double time, double *last)
{
  char temporary[PATH_MAX + 8];
  snprintf(temporary, sizeof temporary, "%s.part", path);
  FILE *to = fopen(temporary, "w");
  if (!to) return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", temporary, strerror(errno));
  sdr_status status = copy_rows(from, path, header, to, time, last);
  if (fclose(to) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, strerror(errno));
  if (status == SDR_OK) return sdr_rundir_settle(temporary, path);
  unlink(temporary);
  return status;
}

sdr_status sdr_history_file_continue(const char *directory, const char *header, double time,
                                     double *last, sdr_history_file **out)
{
  char path[PATH_MAX];
  double kept = NAN;
  snprintf(path, sizeof path, "%s/history.csv", directory);
  FILE *from = fopen(path, "r");
  if (!from && errno != ENOENT)
    return sdr_fail(SDR_IO_ERROR, "cannot read %s: %s", path, strerror(errno));
  if (from) {
    const sdr_status status = cut(from, path, header, time, &kept);
    fclose(from);
    if (status != SDR_OK) return status;
    SDR_TRY(open_at_end(directory, 0, out));
  } else {
    SDR_TRY(sdr_history_file_create(directory, header, out));
  }
  *last = kept;
  return SDR_OK;
}

sdr_status sdr_history_file_row(sdr_history_file *history, const double *values, int count)
{
  char *text = NULL;
  size_t size = 0;
  FILE *row = open_memstream(&text, &size);
  if (!row) return sdr_fail(SDR_RUN_FAILED, "out of memory for a row of %s", history->path);
  for (int k = 0; k < count; ++k) fprintf(row, "%.17g%c", values[k], k + 1 < count ? ',' : '\n');
  const int whole = fclose(row) == 0;
  const sdr_status status =
      whole ? append(history, text, size)
            : sdr_fail(SDR_RUN_FAILED, "out of memory for a row of %s", history->path);
  free(text);
  return status;
}

void sdr_history_file_close(sdr_history_file **history)
{
  if (!*history) return;
  if ((*history)->file >= 0) close((*history)->file);
  sdr_free(*history);
  *history = NULL;
}
