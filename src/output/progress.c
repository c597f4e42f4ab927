#include "output/progress.h"

#include "base/memory.h"
#include "output/ledger.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

static const double redraw = 0.1, line_pause = 30.0; /* s */
static const double smoothing = 3.0;                 /* s: the rate's memory */
enum { BAR = 20, DEFAULT_WIDTH = 80, MOST_WIDTH = 400 };

typedef struct {
  sdr_observer head;
  const sdr_observer *ledger;
  int on_terminal, begun, open; /* open: a bar stands on an unfinished line */
  int tenth;                    /* the tenth of the run that was reported last */
  double shown;                 /* when the latest line was drawn, s */
  double marked;                /* when the rate was taken, s */
  int64_t marked_step;
  double rate; /* steps/s, smoothed; 0: not known */
} progress;

static progress *of(sdr_observer *observer)
{
  return (progress *)(void *)observer;
}

static double clock_now(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

char *sdr_prefixed(char text[SDR_PREFIXED_SIZE], double value, const char *unit)
{
  static const char *const prefixes[] = {"a", "f", "p", "n", "u", "m", "", "k", "M", "G", "T", "P"};
  const int plain = 6, most = sizeof prefixes / sizeof *prefixes - 1;
  const double size = fabs(value);
  if (!(size > 1e-18) || isinf(value)) {
    snprintf(text, SDR_PREFIXED_SIZE, "%.3g %s", size > 0.0 ? value : 0.0 * size, unit);
    return text;
  }
  int k = plain + (int)floor(log10(size * 1.0005) / 3.0);
  k = k < 0 ? 0 : k > most ? most : k;
  const double scaled = value / pow(1000.0, k - plain);
  const double digits = fabs(scaled);
  const int decimals = digits >= 99.95 ? 0 : digits >= 9.995 ? 1 : 2;
  snprintf(text, SDR_PREFIXED_SIZE, "%.*f %s%s", decimals, scaled, prefixes[k], unit);
  return text;
}

static double done_share(const sdr_moment *moment)
{
  if (moment->last) return 1.0;
  const double share = moment->end > 0.0 ? moment->time / moment->end : 0.0;
  return fmin(fmax(share + 1e-9, 0.0), 1.0); /* times are sums of rounded steps */
}

static void text_left(char *text, size_t size, double seconds)
{
  const long s = lround(fmin(seconds, 1e8));
  if (s < 60)
    snprintf(text, size, "%ld s left", s);
  else if (s < 3600)
    snprintf(text, size, "%ld min %02ld s left", s / 60, s % 60);
  else
    snprintf(text, size, "%ld h %02ld min left", s / 3600, s % 3600 / 60);
}

static void update_rate(progress *p, int64_t step, double now)
{
  const double passed = now - p->marked;
  if (step <= p->marked_step || passed <= 0.0 || (p->rate > 0.0 && passed < 0.05)) return;
  const double rate = (double)(step - p->marked_step) / passed;
  const double weight = p->rate > 0.0 ? 1.0 - exp(-passed / smoothing) : 1.0;
  p->rate += weight * (rate - p->rate);
  p->marked = now;
  p->marked_step = step;
}

/* The pieces of a line, the most wanted first; "" where there is nothing to say. */
enum { PIECES = 6, PIECE_SIZE = 96 };

static void make_pieces(const progress *p, const sdr_moment *moment,
                        char pieces[PIECES][PIECE_SIZE])
{
  char a[SDR_PREFIXED_SIZE], b[SDR_PREFIXED_SIZE], c[SDR_PREFIXED_SIZE];
  for (int k = 0; k < PIECES; ++k) pieces[k][0] = '\0';
  snprintf(pieces[0], PIECE_SIZE, "%s of %s", sdr_prefixed(a, moment->time, "s"),
           sdr_prefixed(b, moment->end, "s"));
  const double share = done_share(moment);
  const double left = moment->steps > 0 ? (double)(moment->steps - moment->step)
                      : share > 0.01    ? (double)moment->step * (1.0 / share - 1.0)
                                        : -1.0;
  if (p->rate > 0.0 && !moment->last && left >= 0.0)
    text_left(pieces[1], PIECE_SIZE, left / p->rate);
  if (moment->steps > 0)
    snprintf(pieces[2], PIECE_SIZE, "step %lld/%lld", (long long)moment->step,
             (long long)moment->steps);
  else
    snprintf(pieces[2], PIECE_SIZE, "step %lld", (long long)moment->step);
  const sdr_solve_record *solve = moment->system ? &moment->system->solve : NULL;
  if (solve && solve->cuts > 0) {
    const size_t used = strlen(pieces[2]);
    snprintf(pieces[2] + used, PIECE_SIZE - used, " (%lld cut, %lld by motion)",
             (long long)solve->cuts, (long long)solve->fallbacks);
  }
  if (p->rate > 0.0) snprintf(pieces[3], PIECE_SIZE, "%s", sdr_prefixed(a, p->rate, "steps/s"));
  if (!p->ledger) return;
  const sdr_books books = sdr_ledger_books(p->ledger);
  snprintf(pieces[4], PIECE_SIZE, "kinetic %s, stored %s, dissipated %s",
           sdr_prefixed(a, books.kinetic, "J"), sdr_prefixed(b, books.stored, "J"),
           sdr_prefixed(c, books.dissipated, "J"));
  snprintf(pieces[5], PIECE_SIZE, "imbalance %.1e", books.imbalance_relative);
}

/* Append what fits into `width` characters. */
static void append_pieces(char *line, size_t width, char pieces[PIECES][PIECE_SIZE])
{
  for (int k = 0; k < PIECES; ++k) {
    const size_t used = strlen(line);
    if (!pieces[k][0] || used + 2 + strlen(pieces[k]) > width) continue;
    snprintf(line + used, MOST_WIDTH + 1 - used, ", %s", pieces[k]);
  }
}

static size_t terminal_width(void)
{
  struct winsize size;
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return DEFAULT_WIDTH;
  return size.ws_col < MOST_WIDTH ? size.ws_col : MOST_WIDTH;
}

/* One character less than the width: some terminals wrap at a full line. */
static void draw_bar(progress *p, double share, char pieces[PIECES][PIECE_SIZE])
{
  char line[MOST_WIDTH + 1], bar[BAR + 1];
  const size_t width = terminal_width() - 1;
  const int filled = (int)(share * BAR);
  for (int k = 0; k < BAR; ++k) bar[k] = k < filled ? '#' : '.';
  bar[BAR] = '\0';
  const size_t length = (size_t)snprintf(line, sizeof line, "%3d %%", (int)(100.0 * share));
  if (width >= length + BAR + 3) snprintf(line + length, sizeof line - length, " [%s]", bar);
  append_pieces(line, width, pieces);
  fprintf(stderr, "\r%s\033[K", line);
  fflush(stderr);
  p->open = 1;
}

static void draw_line(double share, char pieces[PIECES][PIECE_SIZE])
{
  char line[MOST_WIDTH + 1];
  snprintf(line, sizeof line, "%3d %%", (int)(100.0 * share));
  append_pieces(line, MOST_WIDTH, pieces);
  fprintf(stderr, "%s\n", line);
}

static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  const progress *p = (const progress *)(const void *)observer;
  (void)wants_balance;
  if (moment->last || !p->begun) return 1;
  if (!p->on_terminal && (int)(10.0 * done_share(moment)) > p->tenth) return 1;
  return clock_now() - p->shown >= (p->on_terminal ? redraw : line_pause);
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  progress *p = of(observer);
  char pieces[PIECES][PIECE_SIZE];
  const double now = clock_now(), share = done_share(moment);
  if (!p->begun) {
    p->begun = 1;
    p->marked = now;
    p->marked_step = moment->step;
    p->tenth = (int)(10.0 * share);
    p->shown = now;
    if (!p->on_terminal) return SDR_OK;
  }
  update_rate(p, moment->step, now);
  make_pieces(p, moment, pieces);
  if (p->on_terminal)
    draw_bar(p, share, pieces);
  else
    draw_line(share, pieces);
  p->tenth = (int)(10.0 * share);
  p->shown = now;
  return SDR_OK;
}

static void end_bar(progress *p)
{
  if (p->open) fputc('\n', stderr);
  p->open = 0;
}

static sdr_status finish(sdr_observer *observer, const sdr_moment *moment)
{
  (void)moment;
  end_bar(of(observer));
  return SDR_OK;
}

static void destroy(sdr_observer *observer)
{
  end_bar(of(observer));
  sdr_free(observer);
}

static const sdr_observer_ops ops = {
    .name = "progress", .due = due, .look = look, .finish = finish, .destroy = destroy};

sdr_status sdr_progress_create(const sdr_observer *ledger, sdr_observer **out)
{
  progress *p = sdr_alloc(1, sizeof *p);
  if (!p) return SDR_RUN_FAILED;
  const char *kind = getenv("TERM");
  *p = (progress){.head.ops = &ops, .ledger = ledger};
  p->on_terminal = isatty(STDERR_FILENO) && !(kind && strcmp(kind, "dumb") == 0);
  *out = &p->head;
  return SDR_OK;
}
