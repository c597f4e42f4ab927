/* What a scene points to lives in one store and is released with it. */
#ifndef SDR_SCENE_STORE_H
#define SDR_SCENE_STORE_H

#include "base/status.h"

#include <stddef.h>

typedef struct sdr_store sdr_store;

/* NULL if memory runs out (error record set). */
sdr_store *sdr_store_create(void);
void sdr_store_destroy(sdr_store **store); /* NULL-safe; releases what was kept, latest first */

/* `count` zeroed elements of `size` bytes, aligned to 16; NULL if memory runs out. */
void *sdr_store_alloc(sdr_store *store, size_t count, size_t size);

/* `length` bytes of text and a final NUL; NULL if memory runs out. */
char *sdr_store_copy(sdr_store *store, const char *text, size_t length);
char *sdr_store_format(sdr_store *store, const char *format, ...) SDR_PRINTF(2, 3);

/* Call release(object) when the store is destroyed. If memory runs out it is released at once and
   SDR_RUN_FAILED returned. */
sdr_status sdr_store_keep(sdr_store *store, void *object, void (*release)(void *));

#endif
