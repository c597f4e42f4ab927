#include "app/plot_gnuplot.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { PATH_ROOM = 4200, SAID_ROOM = 2000 };

static const double points_per_pixel = 0.75; /* of a font in gnuplot, to a pixel */

sdr_status sdr_picture_begin(sdr_picture *picture, int width, int height, double font)
{
  *picture = (sdr_picture){.width = width, .height = height, .font = font};
  picture->script = open_memstream(&picture->text, &picture->length);
  if (!picture->script) return sdr_fail(SDR_RUN_FAILED, "out of memory for a picture");
  fprintf(picture->script,
          "set encoding utf8\n"
          "set terminal pngcairo noenhanced background '#ffffff' size %d,%d font 'Sans,%.0f' "
          "linewidth %.2f\n"
          "set minussign\nset multiplot\n",
          width, height, points_per_pixel * font, font / 22.0);
  sdr_picture_clear_axes(picture);
  return SDR_OK;
}

void sdr_picture_drop(sdr_picture *picture)
{
  if (picture->script) fclose(picture->script);
  free(picture->text);
  *picture = (sdr_picture){0};
}

void sdr_picture_place(sdr_picture *picture, sdr_area area)
{
  fprintf(picture->script,
          "set lmargin at screen %.9f\nset rmargin at screen %.9f\n"
          "set bmargin at screen %.9f\nset tmargin at screen %.9f\n",
          area.left / picture->width, (area.left + area.width) / picture->width,
          area.bottom / picture->height, (area.bottom + area.height) / picture->height);
}

void sdr_picture_quote(sdr_picture *picture, const char *text, int characters)
{
  int total = 0, written = 0;
  for (const char *c = text; *c; ++c) total += ((unsigned char)*c & 0xC0) != 0x80;
  fputc('\'', picture->script);
  for (const char *c = text; *c; ++c) {
    const int starts = ((unsigned char)*c & 0xC0) != 0x80;
    if (starts && total > characters && written == characters - 1) {
      fputs("…", picture->script);
      break;
    }
    written += starts;
    if (*c == '\'') fputc('\'', picture->script);
    fputc((unsigned char)*c < 0x20 || *c == 0x7f ? ' ' : *c, picture->script);
  }
  fputc('\'', picture->script);
}

double sdr_picture_points(const sdr_picture *picture, double size)
{
  return points_per_pixel * size * picture->font;
}

static void write_text(sdr_picture *picture, double x, double y, const char *align, double size,
                       double width, const char *text)
{
  const double letter = 0.56 * size * picture->font;
  fputs("set label ", picture->script);
  sdr_picture_quote(picture, text, (int)(width / letter));
  fprintf(picture->script, " at screen %.6f,%.6f %s font ',%.1f' front\n", x / picture->width,
          y / picture->height, align, sdr_picture_points(picture, size));
}

void sdr_picture_text(sdr_picture *picture, double x, double y, const char *align, double size,
                      double width, const char *text)
{
  write_text(picture, x, y, align, size, width, text);
}

void sdr_picture_upright(sdr_picture *picture, double x, double y, double size, double width,
                         const char *text)
{
  write_text(picture, x, y, "center rotate by 90", size, width, text);
}

void sdr_picture_clear_axes(sdr_picture *picture)
{
  fputs("unset xlabel\nunset label\nunset arrow\nunset xtics\nunset ytics\nunset y2tics\n"
        "unset grid\nunset key\nset xrange [*:*]\nset yrange [*:*]\nset y2range [*:*]\n"
        "set border 15 lw 1.2 lc '#303030'\nset xtics format '% h'\nunset xtics\n",
        picture->script);
}

void sdr_picture_image(sdr_picture *picture, int width, int height, const double x[2],
                       const double y[2], const unsigned char *rgba)
{
  const double dx = (x[1] - x[0]) / width, dy = (y[1] - y[0]) / height;
  fprintf(picture->script,
          "plot [%.12g:%.12g][%.12g:%.12g] '-' binary array=(%d,%d) "
          "format='%%uchar%%uchar%%uchar%%uchar' origin=(%.12g,%.12g) dx=%.12g dy=%.12g "
          "using 1:2:3:4 with rgbalpha notitle\n",
          x[0], x[1], y[0], y[1], width, height, x[0] + 0.5 * dx, y[0] + 0.5 * dy, dx, dy);
  fwrite(rgba, 4, (size_t)width * (size_t)height, picture->script);
}

/* gnuplot with these three files as its own; 0 or the error number. A path without a file is
   searched for in PATH by posix_spawnp. */
static int start(int in, int out, int err, pid_t *child)
{
  char program[] = "gnuplot", defaults[] = "-d";
  char *arguments[] = {program, defaults, NULL};
  posix_spawn_file_actions_t files;
  int error = posix_spawn_file_actions_init(&files);
  if (error) return error;
  error = posix_spawn_file_actions_adddup2(&files, in, STDIN_FILENO);
  if (!error) error = posix_spawn_file_actions_adddup2(&files, out, STDOUT_FILENO);
  if (!error) error = posix_spawn_file_actions_adddup2(&files, err, STDERR_FILENO);
  if (!error) error = posix_spawnp(child, program, &files, NULL, arguments, environ);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

/* All of the script; a gnuplot that stops early shows in its exit status, not here. */
static void feed(int socket, const char *text, size_t length)
{
  while (length > 0) {
    const ssize_t sent = send(socket, text, length, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return;
    text += sent;
    length -= (size_t)sent;
  }
}

static int wait_for(pid_t child)
{
  int code = 0;
  while (waitpid(child, &code, 0) < 0)
    if (errno != EINTR) return -1;
  return code;
}

static sdr_status say_failure(int err, int code)
{
  char said[SAID_ROOM + 1];
  const ssize_t count = pread(err, said, SAID_ROOM, 0);
  size_t length = count > 0 ? (size_t)count : 0;
  while (length > 0 && strchr("\n\r \t", said[length - 1])) --length;
  said[length] = '\0';
  const char *text = said + strspn(said, "\n\r \t");
  if (WIFEXITED(code))
    return sdr_fail(SDR_IO_ERROR, "gnuplot failed with status %d: %s", WEXITSTATUS(code), text);
  return sdr_fail(SDR_IO_ERROR, "gnuplot was stopped by signal %d: %s", WTERMSIG(code), text);
}

static sdr_status converse(const char *text, size_t length, int out, int err)
{
  int ends[2];
  pid_t child = 0;
  /* a socket rather than a pipe: sending to a gnuplot that has stopped raises no signal */
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    return sdr_fail(SDR_IO_ERROR, "cannot talk to gnuplot: %s", strerror(errno));
  const int error = start(ends[1], out, err, &child);
  close(ends[1]);
  if (error == 0) feed(ends[0], text, length);
  close(ends[0]);
  if (error == ENOENT)
    return sdr_fail(SDR_IO_ERROR, "gnuplot is not installed, and pictures need it; install the "
                                  "Debian package gnuplot-nox");
  if (error) return sdr_fail(SDR_IO_ERROR, "cannot start gnuplot: %s", strerror(error));
  const int code = wait_for(child);
  return code == 0 ? SDR_OK : say_failure(err, code);
}

/* A gnuplot that ends well without a picture (a disk that is full) is a failure too. */
static sdr_status check_picture(int out, const char *path)
{
  unsigned char head[4], tail[8];
  const off_t size = lseek(out, 0, SEEK_END);
  if (size < 64 || pread(out, head, 4, 0) != 4 || memcmp(head, "\x89PNG", 4) != 0 ||
      pread(out, tail, 8, size - 8) != 8 || memcmp(tail, "IEND", 4) != 0)
    return sdr_fail(SDR_IO_ERROR, "%s: gnuplot wrote no whole picture; is the disk full?", path);
  return SDR_OK;
}

static sdr_status draw_to(sdr_picture *picture, const char *temporary, const char *path)
{
  const int out = open(temporary, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (out < 0) return sdr_fail(SDR_IO_ERROR, "%s: cannot be written: %s", path, strerror(errno));
  const int err = memfd_create("gnuplot-messages", MFD_CLOEXEC);
  sdr_status status = err < 0 ? sdr_fail(SDR_IO_ERROR, "cannot run gnuplot: %s", strerror(errno))
                              : converse(picture->text, picture->length, out, err);
  if (status == SDR_OK) status = check_picture(out, path);
  if (err >= 0) close(err);
  close(out);
  if (status == SDR_OK && rename(temporary, path) != 0)
    status = sdr_fail(SDR_IO_ERROR, "%s: cannot be written: %s", path, strerror(errno));
  if (status != SDR_OK) unlink(temporary);
  return status;
}

sdr_status sdr_picture_end(sdr_picture *picture, const char *path)
{
  char temporary[PATH_ROOM];
  fputs("unset multiplot\n", picture->script);
  const int broken = fclose(picture->script);
  picture->script = NULL;
  sdr_status status;
  if (broken)
    status = sdr_fail(SDR_RUN_FAILED, "out of memory for a picture");
  else if (snprintf(temporary, sizeof temporary, "%s.%ld.part", path, (long)getpid()) >=
           (int)sizeof temporary)
    status = sdr_fail(SDR_BAD_INPUT, "the picture's file name is too long");
  else
    status = draw_to(picture, temporary, path);
  sdr_picture_drop(picture);
  return status;
}
