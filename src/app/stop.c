#include "app/stop.h"

#include <signal.h>
#include <stddef.h>

enum { SIGNALS = 2 };
static const int signals[SIGNALS] = {SIGINT, SIGTERM};
static struct sigaction before[SIGNALS];
static volatile sig_atomic_t asked;

static void note(int signal)
{
  asked = signal;
}

void sdr_stop_watch(void)
{
  struct sigaction action = {.sa_flags = (int)SA_RESETHAND | SA_RESTART};
  action.sa_handler = note;
  sigemptyset(&action.sa_mask);
  asked = 0;
  for (int k = 0; k < SIGNALS; ++k) {
    sigaction(signals[k], NULL, &before[k]);
    if (before[k].sa_handler != SIG_IGN) sigaction(signals[k], &action, NULL);
  }
}

void sdr_stop_unwatch(void)
{
  for (int k = 0; k < SIGNALS; ++k) sigaction(signals[k], &before[k], NULL);
}

const char *sdr_stop_asked(void)
{
  return asked == SIGINT ? "SIGINT" : asked == SIGTERM ? "SIGTERM" : NULL;
}
