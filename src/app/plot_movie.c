#include "app/plot_movie.h"

#include "app/plot_frame.h"
#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { PATH_ROOM = 4200, FIXED_WORDS = 16 };

/* Where things go. */
typedef struct {
  char frames[PATH_ROOM]; /* directory */
  char movie[PATH_ROOM];  /* without its ending, unless `given` */
  int given;
} places;

static sdr_status frame_name(const places *p, int frame, char path[PATH_ROOM])
{
  if (snprintf(path, PATH_ROOM, "%s/%04d.png", p->frames, frame) < PATH_ROOM) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "the frames' file names are too long");
}

/* ---- programs -------------------------------------------------------------------------------- */

/* Run a program, silent; its exit status, 127 if it is not there, 126 if it could not be run. */
static int run_program(char *const words[])
{
  posix_spawn_file_actions_t files;
  pid_t child = 0;
  int code = 0;
  if (posix_spawn_file_actions_init(&files) != 0) return 126;
  int error = posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (!error)
    error = posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (!error)
    error = posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  if (!error) error = posix_spawnp(&child, words[0], &files, NULL, words, environ);
  posix_spawn_file_actions_destroy(&files);
  if (error) return error == ENOENT ? 127 : 126;
  while (waitpid(child, &code, 0) < 0)
    if (errno != EINTR) return 126;
  return WIFEXITED(code) ? WEXITSTATUS(code) : 126;
}

/* Ten frames a second; sides of mp4 must be even. */
static int by_ffmpeg(const places *p, int is_mp4, char *target)
{
  char pattern[PATH_ROOM + 16], filter[] = "pad=ceil(iw/2)*2:ceil(ih/2)*2";
  char program[] = "ffmpeg", yes[] = "-y", rate_key[] = "-framerate", rate[] = "10", in[] = "-i";
  char filter_key[] = "-vf", format_key[] = "-pix_fmt", format[] = "yuv420p";
  snprintf(pattern, sizeof pattern, "%s/%%04d.png", p->frames);
  char *const mp4[] = {program,    yes,    rate_key,   rate,   in,     pattern,
                       filter_key, filter, format_key, format, target, NULL};
  char *const gif[] = {program, yes, rate_key, rate, in, pattern, target, NULL};
  return run_program(is_mp4 ? mp4 : gif);
}

static int by_convert(const places *p, int frames, char *target)
{
  char program[] = "convert", delay_key[] = "-delay", delay[] = "10", loop[] = "-loop";
  char forever[] = "0";
  char **words = sdr_alloc((size_t)frames + FIXED_WORDS, sizeof *words);
  char(*paths)[PATH_ROOM] = sdr_alloc((size_t)frames, sizeof *paths);
  int count = 0, code = 126;
  if (words && paths) {
    char *const head[] = {program, delay_key, delay, loop, forever};
    for (size_t k = 0; k < sizeof head / sizeof *head; ++k) words[count++] = head[k];
    for (int k = 0; k < frames; ++k) {
      if (frame_name(p, k, paths[k]) != SDR_OK) break;
      words[count++] = paths[k];
    }
    words[count] = target;
    code = run_program(words);
  }
  sdr_free(words);
  sdr_free(paths);
  return code;
}

static int ends_with(const char *text, const char *end)
{
  const size_t length = strlen(text), tail = strlen(end);
  return length >= tail && strcmp(text + length - tail, end) == 0;
}

/* A movie that is there and holds something, where it belongs; 0: there is none. */
static int settle(const char *made, const char *path)
{
  struct stat status;
  if (stat(made, &status) == 0 && status.st_size > 0 && rename(made, path) == 0) return 1;
  unlink(made);
  return 0;
}

/* Try one program. `ending`: of what it makes. */
static int try_program(const places *p, int frames, int ffmpeg, const char *ending, char *path)
{
  char made[PATH_ROOM + 16];
  if (p->given && !ends_with(p->movie, ending)) return 0;
  snprintf(path, PATH_ROOM, "%s%s", p->movie, p->given ? "" : ending);
  snprintf(made, sizeof made, "%s/movie%s", p->frames, ending);
  const int code =
      ffmpeg ? by_ffmpeg(p, strcmp(ending, ".mp4") == 0, made) : by_convert(p, frames, made);
  if (code == 0) return settle(made, path);
  unlink(made);
  return 0;
}

static void make_movie(const places *p, int frames, FILE *out)
{
  char path[PATH_ROOM];
  if (try_program(p, frames, 1, ".mp4", path) || try_program(p, frames, 1, ".gif", path) ||
      try_program(p, frames, 0, ".gif", path))
    fprintf(out, "%s: %d frames, which are in %s\n", path, frames, p->frames);
  else
    fprintf(out,
            "%s: %d frames; no movie of them, since neither ffmpeg nor ImageMagick's convert "
            "could make one (Debian packages ffmpeg, imagemagick)\n",
            p->frames, frames);
}

/* ---- frames ---------------------------------------------------------------------------------- */

static sdr_status name_places(const sdr_rundata *run, const char *field, const char *path,
                              places *p)
{
  p->given = path != NULL;
  if (path && !ends_with(path, ".mp4") && !ends_with(path, ".gif"))
    return sdr_fail(SDR_BAD_INPUT, "%s: a movie's name ends with .mp4 or .gif", path);
  const int frames = snprintf(p->frames, sizeof p->frames, "%s/%s_frames", run->directory, field);
  const int movie = path ? snprintf(p->movie, sizeof p->movie, "%s", path)
                         : snprintf(p->movie, sizeof p->movie, "%s/%s", run->directory, field);
  if (frames < PATH_ROOM - 16 && movie < PATH_ROOM - 16) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "the movie's file name is too long");
}

/* Frames of an earlier movie beyond those of this one would be played after them. */
static void remove_later(const places *p, int from)
{
  char path[PATH_ROOM];
  for (int k = from; frame_name(p, k, path) == SDR_OK && unlink(path) == 0; ++k) {
  }
}

sdr_status sdr_plot_movie(sdr_rundata *run, const char *field, const sdr_view_how *how,
                          const char *path, FILE *out)
{
  places p;
  sdr_frame_scale scale = {.film = 1};
  SDR_TRY(name_places(run, field, path, &p));
  for (int k = 0; k < run->frame_count; ++k) SDR_TRY(sdr_frame_measure(run, k, field, how, &scale));
  if (mkdir(p.frames, 0777) != 0 && errno != EEXIST)
    return sdr_fail(SDR_IO_ERROR, "%s: cannot be made: %s", p.frames, strerror(errno));
  for (int k = 0; k < run->frame_count; ++k) {
    char png[PATH_ROOM];
    SDR_TRY(frame_name(&p, k, png));
    SDR_TRY(sdr_frame_draw(run, k, field, how, &scale, png));
  }
  remove_later(&p, run->frame_count);
  make_movie(&p, run->frame_count, out);
  return SDR_OK;
}
