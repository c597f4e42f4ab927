/* Runs the program as a user does, in a folder of the test's own, and keeps what it says. */
#ifndef SDR_TESTS_PROGRAM_H
#define SDR_TESTS_PROGRAM_H

#include "support/cmocka_all.h"

#include <errno.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct {
  int code; /* exit status; 128 + the signal that ended it */
  char out[30000], err[30000];
} said;

/* For cmocka's group set-up: a new folder, in which `sunder` is the program. */
static inline int enter_folder(void **state)
{
  static char folder[] = "/tmp/sunder_app_XXXXXX";
  char program[] = SUNDER_PROGRAM, path[4000];
  const char *before = getenv("PATH");
  snprintf(path, sizeof path, "%s:%s", dirname(program), before ? before : "/usr/bin:/bin");
  unsetenv("SUNDER_PROBLEMS");
  if (setenv("PATH", path, 1) != 0 || !mkdtemp(folder) || chdir(folder) != 0) return -1;
  *state = folder;
  return 0;
}

static inline int leave_folder(void **state)
{
  char command[200];
  snprintf(command, sizeof command, "rm -rf '%s'", (const char *)*state);
  return chdir("/") != 0 || system(command) != 0;
}

static inline size_t read_whole(const char *path, char *text, size_t size)
{
  FILE *stream = fopen(path, "r");
  if (!stream) fail_msg("cannot read %s: %s", path, strerror(errno));
  const size_t length = fread(text, 1, size - 1, stream);
  text[length] = '\0';
  fclose(stream);
  return length;
}

static inline void write_text(const char *path, const char *text)
{
  FILE *stream = fopen(path, "w");
  assert_non_null(stream);
  fputs(text, stream);
  fclose(stream);
}

static inline int exists(const char *path)
{
  struct stat info;
  return lstat(path, &info) == 0;
}

/* What the shell makes of `command`. */
static inline void shell(said *s, const char *command)
{
  char line[8000];
  assert_true(snprintf(line, sizeof line, "{ %s\n} >said.out 2>said.err", command) <
              (int)sizeof line);
  const int ended = system(line);
  assert_true(WIFEXITED(ended));
  s->code = WEXITSTATUS(ended);
  read_whole("said.out", s->out, sizeof s->out);
  read_whole("said.err", s->err, sizeof s->err);
}

/* `command` must succeed and say nothing on stderr. */
static inline void succeed(said *s, const char *command)
{
  shell(s, command);
  if (s->code != 0 || s->err[0]) fail_msg("%s: exit status %d\n%s", command, s->code, s->err);
}

/* `command` must end with `code`, this text on stderr and nothing on stdout. */
static inline void refuse(said *s, const char *command, int code, const char *text)
{
  shell(s, command);
  if (s->code != code || strcmp(s->err, text) != 0)
    fail_msg("%s\n  wanted %d: %s  got %d:    %s", command, code, text, s->code, s->err);
  assert_string_equal(s->out, "");
}

/* Start `command` without waiting for it. */
static inline pid_t start(const char *command)
{
  char line[8000];
  snprintf(line, sizeof line, "exec %s >started.out 2>&1", command);
  const pid_t pid = fork();
  assert_true(pid >= 0);
  if (pid == 0) {
    execl("/bin/sh", "sh", "-c", line, (char *)NULL);
    _exit(127);
  }
  return pid;
}

#endif
