#include "output/rundir.h"

#include "output/fields.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* summary.json is the mark of a complete run. */
static const char *const names[] = {"summary.json",   "history.csv",   "snapshots.h5",
                                    "snapshots.xdmf", "checkpoint.h5", "used.yaml",
                                    "cracks.csv",     "fragments.csv"};
enum { NAMES = sizeof names / sizeof *names };

static sdr_status join(const char *directory, const char *name, const char *ending, char *path)
{
  const int length = snprintf(path, PATH_MAX, "%s/%s%s", directory, name, ending);
  if (length < PATH_MAX) return SDR_OK;
  return sdr_fail(SDR_IO_ERROR, "cannot write %s/%s: %s", directory, name, strerror(ENAMETOOLONG));
}

/* mkdir -p; *made: how many characters of the path name the first one made, 0: none was. */
static sdr_status make_directory(const char *directory, size_t *made)
{
  char path[PATH_MAX];
  *made = 0;
  if (snprintf(path, sizeof path, "%s", directory) >= PATH_MAX)
    return sdr_fail(SDR_IO_ERROR, "cannot make the directory %s: %s", directory,
                    strerror(ENAMETOOLONG));
  for (char *slash = path + 1; *path; ++slash) {
    const char kept = *slash;
    if (kept != '/' && kept != '\0') continue;
    *slash = '\0';
    const int failed = mkdir(path, 0777) == 0 ? 0 : errno;
    if (!failed && *made == 0) *made = strlen(path);
    if (failed && failed != EEXIST)
      return sdr_fail(SDR_IO_ERROR, "cannot make the directory %s: %s", path, strerror(failed));
    *slash = kept;
    if (kept == '\0') break;
  }
  struct stat status;
  if (stat(directory, &status) != 0)
    return sdr_fail(SDR_IO_ERROR, "cannot use the directory %s: %s", directory, strerror(errno));
  if (!S_ISDIR(status.st_mode))
    return sdr_fail(SDR_IO_ERROR, "cannot use %s as the run's directory: it is a file", directory);
  return SDR_OK;
}

/* Take away what make_directory made. */
static void remove_directories(const char *directory, size_t made)
{
  char path[PATH_MAX];
  snprintf(path, sizeof path, "%s", directory);
  for (size_t length = strlen(path); made > 0 && length >= made; --length) {
    if (path[length] != '\0' && path[length] != '/') continue;
    path[length] = '\0';
    rmdir(path);
  }
}

sdr_status sdr_rundir_try(const char *directory)
{
  size_t made;
  sdr_status status = make_directory(directory, &made);
  if (status == SDR_OK && access(directory, W_OK | X_OK) != 0)
    status =
        sdr_fail(SDR_IO_ERROR, "cannot write in the directory %s: %s", directory, strerror(errno));
  remove_directories(directory, made);
  return status;
}

static sdr_status held_by_another(const char *directory, int lock)
{
  char pid[32] = "";
  const ssize_t length = pread(lock, pid, sizeof pid - 1, 0);
  if (length > 0) pid[strcspn(pid, "\n")] = '\0';
  return sdr_fail(SDR_BAD_INPUT,
                  "the directory %s is in use by process %s; wait until it is done or give another "
                  "directory with -o",
                  directory, *pid ? pid : "(starting)");
}

/* *taken = 0 if the file was removed by its last owner between open and flock: try again. */
static sdr_status try_lock(const char *directory, const char *path, int *lock, int *taken)
{
  sdr_status status = SDR_OK;
  struct stat ours, present;
  const int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, strerror(errno));
  *taken = 0;
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    status = errno == EWOULDBLOCK
                 ? held_by_another(directory, file)
                 : sdr_fail(SDR_IO_ERROR, "cannot lock %s: %s", path, strerror(errno));
  } else if (fstat(file, &ours) == 0 && stat(path, &present) == 0 &&
             ours.st_ino == present.st_ino && ours.st_dev == present.st_dev) {
    *lock = file;
    *taken = 1;
    return SDR_OK;
  }
  close(file);
  return status;
}

static sdr_status take_lock(const char *directory, int *lock)
{
  char path[PATH_MAX], pid[32];
  int file = -1, taken = 0;
  SDR_TRY(join(directory, ".lock", "", path));
  while (!taken) SDR_TRY(try_lock(directory, path, &file, &taken));
  const int length = snprintf(pid, sizeof pid, "%ld\n", (long)getpid());
  if (ftruncate(file, 0) != 0 || pwrite(file, pid, (size_t)length, 0) != length) {
    const sdr_status status = sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, strerror(errno));
    unlink(path);
    close(file);
    return status;
  }
  *lock = file;
  return SDR_OK;
}

static sdr_status remove_one(const char *directory, const char *name, const char *ending)
{
  char path[PATH_MAX];
  SDR_TRY(join(directory, name, ending, path));
  if (unlink(path) == 0 || errno == ENOENT) return SDR_OK;
  return sdr_fail(SDR_IO_ERROR, "cannot remove %s: %s", path, strerror(errno));
}

/* FIELD.png and FIELD.COMPONENT.png of `plot` (movies .mp4 or .gif), with _at_TIME at the end of
   the stem or without, its ledger.png and reactions.png, compare.png of `compare`. */
static int is_our_picture(const char *name)
{
  char stem[32];
  const size_t length = strlen(name), dot = strcspn(name, ".");
  const char *at = strstr(name, "_at_");
  const size_t first = at && (size_t)(at - name) < dot ? (size_t)(at - name) : dot;
  const char *ending = length < 4 ? "" : name + length - 4;
  const int is_movie = strcmp(ending, ".mp4") == 0 || strcmp(ending, ".gif") == 0;
  if ((!is_movie && strcmp(ending, ".png") != 0) || first >= sizeof stem) return 0;
  memcpy(stem, name, first);
  stem[first] = '\0';
  const int whole = first == length - 4 && !is_movie;
  if (whole && (strcmp(stem, "ledger") == 0 || strcmp(stem, "compare") == 0 ||
                strcmp(stem, "reactions") == 0))
    return 1;
  return sdr_field_find(stem) != NULL;
}

static sdr_status remove_pictures(const char *directory)
{
  DIR *list = opendir(directory);
  if (!list)
    return sdr_fail(SDR_IO_ERROR, "cannot read the directory %s: %s", directory, strerror(errno));
  sdr_status status = SDR_OK;
  for (const struct dirent *entry; status == SDR_OK && (entry = readdir(list)) != NULL;)
    if (is_our_picture(entry->d_name)) status = remove_one(directory, entry->d_name, "");
  closedir(list);
  return status;
}

sdr_status sdr_rundir_reopen(const char *directory)
{
  SDR_TRY(remove_one(directory, names[0], ""));
  return remove_pictures(directory);
}

static sdr_status remove_old(const char *directory)
{
  SDR_TRY(sdr_rundir_reopen(directory));
  for (int k = 0; k < NAMES; ++k) {
    SDR_TRY(remove_one(directory, names[k], ""));
    SDR_TRY(remove_one(directory, names[k], ".part"));
  }
  return SDR_OK;
}

sdr_status sdr_rundir_open(const char *directory, int resume, int *lock)
{
  int file = -1;
  size_t made;
  SDR_TRY(make_directory(directory, &made));
  SDR_TRY(take_lock(directory, &file));
  const sdr_status status = resume ? SDR_OK : remove_old(directory);
  if (status == SDR_OK)
    *lock = file;
  else
    sdr_rundir_close(directory, file);
  return status;
}

void sdr_rundir_close(const char *directory, int lock)
{
  char path[PATH_MAX];
  if (lock < 0) return;
  if (join(directory, ".lock", "", path) == SDR_OK) unlink(path);
  close(lock);
}

/* 0, or the errno of what failed. */
static int write_whole(const char *path, const char *text)
{
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) return errno;
  int failed = 0;
  size_t left = strlen(text);
  while (left > 0 && !failed) {
    const ssize_t written = write(file, text, left);
    if (written < 0 && errno != EINTR) failed = errno;
    if (written > 0) {
      text += written;
      left -= (size_t)written;
    }
  }
  if (close(file) != 0 && !failed) failed = errno;
  return failed;
}

/* 0, or the errno of what failed. Synchronising by name: who wrote the file need not be asked. */
static int synchronise(const char *path)
{
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno;
  int failed = fsync(file) == 0 ? 0 : errno;
  if (failed == EINVAL || failed == EROFS) failed = 0; /* nothing to synchronise there */
  close(file);
  return failed;
}

sdr_status sdr_rundir_settle(const char *temporary, const char *path)
{
  int failed = synchronise(temporary);
  if (!failed && rename(temporary, path) != 0) failed = errno;
  if (!failed) return SDR_OK;
  unlink(temporary);
  return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, strerror(failed));
}

sdr_status sdr_rundir_write(const char *directory, const char *name, const char *text)
{
  char path[PATH_MAX], temporary[PATH_MAX];
  SDR_TRY(join(directory, name, "", path));
  SDR_TRY(join(directory, name, ".part", temporary));
  const int failed = write_whole(temporary, text);
  if (!failed) return sdr_rundir_settle(temporary, path);
  unlink(temporary);
  return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, strerror(failed));
}
