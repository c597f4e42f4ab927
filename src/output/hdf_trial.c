#include "output/hdf_trial.h"

#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

enum { DEEPEST = 3 }; /* frame_0000/points/index */

typedef struct {
  int depth;
  hssize_t file_bytes;
} place;

/* A group or dataset has another second of processor time. SIGPROF ends the process. */
static void renew_time(void)
{
  const struct itimerval second = {.it_value = {1, 0}};
  setitimer(ITIMER_PROF, &second, NULL);
}

/* In the child: handlers of the program are not for it, nor is its standard error. */
static void limit_child(void)
{
  static const int deadly[] = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGPROF};
  for (size_t k = 0; k < sizeof deadly / sizeof *deadly; ++k) signal(deadly[k], SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, NULL);
  const int nowhere = open("/dev/null", O_WRONLY);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
  unsigned long pages = 0;
  FILE *now = fopen("/proc/self/statm", "r");
  if (now && fscanf(now, "%lu", &pages) != 1) pages = 0;
  if (now) fclose(now);
  struct rlimit space;
  const rlim_t most = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + ((rlim_t)1 << 30);
  if (pages > 0 && getrlimit(RLIMIT_AS, &space) == 0 && most < space.rlim_cur) {
    space.rlim_cur = most;
    setrlimit(RLIMIT_AS, &space);
  }
  renew_time();
}

static herr_t look_at_attribute(hid_t object, const char *name, const H5A_info_t *info,
                                void *context)
{
  (void)info;
  (void)context;
  const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  if (attribute < 0) return 0;
  H5Tclose(H5Aget_type(attribute));
  H5Sclose(H5Aget_space(attribute));
  H5Aclose(attribute);
  return 0;
}

/* Damage may make chunks of values that were in one piece, or billions of them. */
static void look_at_dataset(hid_t dataset, hssize_t file_bytes)
{
  const hid_t how = H5Dget_create_plist(dataset), space = H5Dget_space(dataset),
              type = H5Dget_type(dataset);
  const H5D_layout_t layout = H5Pget_layout(how);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  const hssize_t bytes = (hssize_t)H5Tget_size(type);
  if (layout == H5D_CHUNKED || layout == H5D_VIRTUAL) _exit(1);
  if (bytes > 0 && count > file_bytes / bytes) _exit(1);
  H5Pclose(how);
  H5Sclose(space);
  H5Tclose(type);
}

/* What cannot be opened is left to the reader, who is told so in order. */
static herr_t look_at(hid_t group, const char *name, const H5L_info_t *info, void *context)
{
  place here = *(const place *)context;
  renew_time();
  if (info->type != H5L_TYPE_HARD) return 0;
  const hid_t object = H5Oopen(group, name, H5P_DEFAULT);
  if (object < 0) return 0;
  const H5I_type_t kind = H5Iget_type(object);
  H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, look_at_attribute, NULL);
  if (kind == H5I_DATASET) look_at_dataset(object, here.file_bytes);
  if (kind == H5I_GROUP && here.depth++ < DEEPEST)
    H5Literate(object, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, look_at, &here);
  H5Oclose(object);
  return 0;
}

/* The child: ends with status 0 if nothing stopped it. */
static void read_structure(const char *path, hssize_t file_bytes)
{
  place root = {0, file_bytes};
  limit_child();
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  const hid_t list = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_file_locking(list, 0, 1);
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, list);
  if (file >= 0) {
    H5Literate(file, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, look_at, &root);
    H5Fclose(file);
  }
  _exit(0);
}

sdr_status sdr_hdf_trial(const char *path)
{
  struct stat info;
  int ended = 0;
  if (stat(path, &info) != 0) return sdr_fail(SDR_IO_ERROR, "%s: %s", path, strerror(errno));
  const pid_t child = fork();
  if (child < 0)
    return sdr_fail(SDR_RUN_FAILED, "no process to try %s in: %s", path, strerror(errno));
  if (child == 0) read_structure(path, (hssize_t)info.st_size);
  while (waitpid(child, &ended, 0) < 0)
    if (errno != EINTR)
      return sdr_fail(SDR_RUN_FAILED, "lost the process that tried %s: %s", path, strerror(errno));
  if (WIFEXITED(ended) && WEXITSTATUS(ended) == 0) return SDR_OK;
  return sdr_fail(SDR_IO_ERROR,
                  "%s: damaged, HDF5 does not get through it; move it away to go on without it",
                  path);
}
