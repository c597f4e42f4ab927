/* The one allocator: zeroed, 64-byte aligned, overflow-checked, counted. */
#ifndef SDR_BASE_MEMORY_H
#define SDR_BASE_MEMORY_H

#include <stddef.h>

/* `count` elements of `size` bytes, zeroed, 64-byte aligned and padded to a multiple of 64 bytes,
   so that a vector kernel may read past the last element. count = 0 gives a valid block.
   NULL on overflow or exhaustion, with the error record set (status SDR_RUN_FAILED is meant).
   Release with sdr_free. */
void *sdr_alloc(size_t count, size_t size);

/* Grow or shrink a block of sdr_alloc (or NULL) to `count` elements; the old content is kept and
   new bytes are zero. NULL on failure, the old block then stays valid. */
void *sdr_realloc(void *block, size_t count, size_t size);

/* A copy of a string, from sdr_alloc; NULL on failure. */
char *sdr_strdup(const char *text);

void sdr_free(void *block); /* NULL-safe */

/* Bytes held now, and the most that were ever held at once. */
size_t sdr_memory_now(void);
size_t sdr_memory_peak(void);

/* For tests: let the next `successes` allocations pass and fail all after; negative: never fail. */
void sdr_memory_fail_after(long successes);
/* The same, but only the one after them fails: a failure that nobody looks at goes on unseen. */
void sdr_memory_fail_once(long successes);

#endif
