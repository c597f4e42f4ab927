#include "support/report.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#ifndef SUNDER_COMMIT
#define SUNDER_COMMIT "unknown"
#endif
#if defined(__clang__)
#define COMPILER "clang " __clang_version__
#else
#define COMPILER "gcc " __VERSION__
#endif

static sdr_status make(const char *path)
{
  if (mkdir(path, 0777) == 0 || errno == EEXIST) return SDR_OK;
  return sdr_fail(SDR_IO_ERROR, "%s: cannot make the directory: %s", path, strerror(errno));
}

sdr_status bench_directory(const char *name, char path[BENCH_PATH])
{
  SDR_TRY(make("out"));
  SDR_TRY(make("out/bench"));
  snprintf(path, BENCH_PATH, "out/bench/%s", name);
  return make(path);
}

/* The processor's name as Linux gives it. */
static void processor(char *name, size_t room)
{
  char line[256];
  FILE *file = fopen("/proc/cpuinfo", "r");
  snprintf(name, room, "unknown processor");
  while (file && fgets(line, sizeof line, file)) {
    const char *colon = strchr(line, ':');
    if (strncmp(line, "model name", 10) != 0 || !colon) continue;
    snprintf(name, room, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
    break;
  }
  if (file) fclose(file);
}

static const char *machine(void)
{
  static char text[200];
  char name[128];
  processor(name, sizeof name);
  snprintf(text, sizeof text, "%s (%ld cores)", name, sysconf(_SC_NPROCESSORS_ONLN));
  return text;
}

sdr_status bench_csv(const char *directory, const char *name, FILE **out)
{
  char path[2 * BENCH_PATH];
  snprintf(path, sizeof path, "%s/%s.csv", directory, name);
  FILE *file = fopen(path, "w");
  if (!file) return sdr_fail(SDR_IO_ERROR, "%s: %s", path, strerror(errno));
  fprintf(file, "# commit %s\n# compiler %s\n# machine %s\n", SUNDER_COMMIT, COMPILER, machine());
  *out = file;
  return SDR_OK;
}

const char *bench_origin(void)
{
  static char text[400];
  snprintf(text, sizeof text, "%s, %s, commit %s", machine(), COMPILER, SUNDER_COMMIT);
  return text;
}

static double read_clock(clockid_t which)
{
  struct timespec now;
  clock_gettime(which, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double bench_clock(void)
{
  return read_clock(CLOCK_MONOTONIC);
}

double bench_processor_clock(void)
{
  return read_clock(CLOCK_PROCESS_CPUTIME_ID);
}
