#include "scene/store.h"

#include "base/memory.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { ALIGNMENT = 16, BLOCK_BYTES = 65536 };

typedef struct block {
  struct block *next;
  size_t used, size;
  char *bytes;
} block;

typedef struct kept {
  struct kept *next;
  void *object;
  void (*release)(void *);
} kept;

struct sdr_store {
  block *blocks; /* the newest first */
  kept *objects;
};

sdr_store *sdr_store_create(void)
{
  return sdr_alloc(1, sizeof(sdr_store));
}

void sdr_store_destroy(sdr_store **store)
{
  if (!store || !*store) return;
  for (kept *k = (*store)->objects; k; k = k->next) k->release(k->object);
  for (block *b = (*store)->blocks; b;) {
    block *next = b->next;
    sdr_free(b->bytes);
    sdr_free(b);
    b = next;
  }
  sdr_free(*store);
  *store = NULL;
}

static block *add_block(sdr_store *store, size_t bytes)
{
  block *fresh = sdr_alloc(1, sizeof *fresh);
  if (!fresh) return NULL;
  fresh->size = bytes > BLOCK_BYTES ? bytes : BLOCK_BYTES;
  fresh->bytes = sdr_alloc(fresh->size, 1);
  if (!fresh->bytes) {
    sdr_free(fresh);
    return NULL;
  }
  fresh->next = store->blocks;
  store->blocks = fresh;
  return fresh;
}

void *sdr_store_alloc(sdr_store *store, size_t count, size_t size)
{
  if (size != 0 && count > (SIZE_MAX / 2) / size) {
    sdr_fail(SDR_RUN_FAILED, "out of memory: %zu elements of %zu bytes overflow", count, size);
    return NULL;
  }
  const size_t bytes = (count * size + ALIGNMENT) / ALIGNMENT * ALIGNMENT;
  block *b = store->blocks;
  if (!b || b->size - b->used < bytes) b = add_block(store, bytes);
  if (!b) return NULL;
  void *room = b->bytes + b->used;
  b->used += bytes;
  return room;
}

char *sdr_store_copy(sdr_store *store, const char *text, size_t length)
{
  char *copy = sdr_store_alloc(store, length + 1, 1);
  if (copy) memcpy(copy, text, length);
  return copy;
}

char *sdr_store_format(sdr_store *store, const char *format, ...)
{
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(NULL, 0, format, arguments);
  va_end(arguments);
  char *text = sdr_store_alloc(store, (size_t)length + 1, 1);
  if (!text) return NULL;
  va_start(arguments, format);
  vsnprintf(text, (size_t)length + 1, format, arguments);
  va_end(arguments);
  return text;
}

sdr_status sdr_store_keep(sdr_store *store, void *object, void (*release)(void *))
{
  kept *entry = sdr_store_alloc(store, 1, sizeof *entry);
  if (!entry) {
    release(object);
    return SDR_RUN_FAILED;
  }
  *entry = (kept){.next = store->objects, .object = object, .release = release};
  store->objects = entry;
  return SDR_OK;
}
