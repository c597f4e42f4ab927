#include "base/memory.h"

#include "base/status.h"

#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

/* Sits in the 64 bytes before each block. `base` is what calloc gave: glibc's aligned_alloc does
   not find its own freed blocks again, and a run that takes and frees fields grew by 200 MB. */
typedef struct {
  size_t bytes;
  void *base;
} header;

static header *header_of(void *block)
{
  return (header *)(void *)((char *)block - ALIGNMENT);
}

static atomic_size_t held, most_held;
static atomic_long successes_left = -1;
static atomic_int fails_once;

static int injected_failure(void)
{
  long left = atomic_load(&successes_left);
  if (left < 0) return 0;
  if (left == 0) {
    if (atomic_load(&fails_once)) atomic_store(&successes_left, -1);
    return 1;
  }
  atomic_store(&successes_left, left - 1);
  return 0;
}

static void count_bytes(size_t bytes)
{
  const size_t now = atomic_fetch_add(&held, bytes) + bytes;
  size_t most = atomic_load(&most_held);
  while (now > most && !atomic_compare_exchange_weak(&most_held, &most, now)) {
  }
}

void *sdr_alloc(size_t count, size_t size)
{
  if (size != 0 && count > (SIZE_MAX - 4 * (size_t)ALIGNMENT) / size) {
    sdr_fail(SDR_RUN_FAILED, "out of memory: %zu elements of %zu bytes overflow", count, size);
    return NULL;
  }
  const size_t wanted = count * size;
  const size_t padded = (wanted / ALIGNMENT + 2) * ALIGNMENT;
  char *base = injected_failure() ? NULL : calloc(1, padded + 2 * (size_t)ALIGNMENT);
  if (!base) {
    sdr_fail(SDR_RUN_FAILED, "out of memory: %zu bytes were asked for, %zu are in use", wanted,
             sdr_memory_now());
    return NULL;
  }
  const size_t beyond = (size_t)((uintptr_t)base % ALIGNMENT);
  char *block = base + (2 * (size_t)ALIGNMENT - beyond);
  *header_of(block) = (header){wanted, base};
  count_bytes(wanted);
  return block;
}

void *sdr_realloc(void *block, size_t count, size_t size)
{
  void *grown = sdr_alloc(count, size);
  if (!grown || !block) return grown;
  const size_t old = header_of(block)->bytes;
  const size_t kept = old < count * size ? old : count * size;
  memcpy(grown, block, kept);
  sdr_free(block);
  return grown;
}

char *sdr_strdup(const char *text)
{
  const size_t length = strlen(text) + 1;
  char *copy = sdr_alloc(length, 1);
  if (copy) memcpy(copy, text, length);
  return copy;
}

void sdr_free(void *block)
{
  if (!block) return;
  atomic_fetch_sub(&held, header_of(block)->bytes);
  free(header_of(block)->base);
}

size_t sdr_memory_now(void)
{
  return atomic_load(&held);
}
size_t sdr_memory_peak(void)
{
  return atomic_load(&most_held);
}

static void fail(long successes, int once)
{
  atomic_store(&fails_once, once);
  atomic_store(&successes_left, successes);
}

void sdr_memory_fail_after(long successes)
{
  fail(successes, 0);
}

void sdr_memory_fail_once(long successes)
{
  fail(successes, 1);
}
