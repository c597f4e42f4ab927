/* Objects of summary.json: JSON that remembers whether anything could not be put into it. */
#ifndef SDR_OUTPUT_RECORD_H
#define SDR_OUTPUT_RECORD_H

#include "base/status.h"

#include <stdint.h>

struct json_t;

typedef struct {
  struct json_t *object;
  int failed;
} sdr_record;

sdr_record sdr_record_begin(void);

/* Numbers that are not finite, missing texts and such as are not UTF-8 become null. */
void sdr_record_real(sdr_record *r, const char *key, double value);
void sdr_record_whole(sdr_record *r, const char *key, int64_t value);
void sdr_record_text(sdr_record *r, const char *key, const char *text);

/* Take over a value (NULL: it failed), or another record. */
void sdr_record_put(sdr_record *r, const char *key, struct json_t *value);
void sdr_record_part(sdr_record *r, const char *key, sdr_record part);

/* Write DIRECTORY/summary.json by rename, and release the record. */
sdr_status sdr_record_write(sdr_record *r, const char *directory);

#endif
