#include "output/record.h"

#include "output/rundir.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

sdr_record sdr_record_begin(void)
{
  json_t *object = json_object();
  return (sdr_record){object, object == NULL};
}

void sdr_record_put(sdr_record *r, const char *key, json_t *value)
{
  if (!value || json_object_set_new(r->object, key, value) != 0) r->failed = 1;
}

void sdr_record_part(sdr_record *r, const char *key, sdr_record part)
{
  r->failed |= part.failed;
  sdr_record_put(r, key, part.object);
}

void sdr_record_real(sdr_record *r, const char *key, double value)
{
  sdr_record_put(r, key, isfinite(value) ? json_real(value) : json_null());
}

void sdr_record_whole(sdr_record *r, const char *key, int64_t value)
{
  sdr_record_put(r, key, json_integer((json_int_t)value));
}

void sdr_record_text(sdr_record *r, const char *key, const char *text)
{
  json_t *value = text ? json_string(text) : NULL;
  sdr_record_put(r, key, value ? value : json_null());
}

sdr_status sdr_record_write(sdr_record *r, const char *directory)
{
  char *text = NULL;
  size_t size = 0;
  FILE *to = r->failed ? NULL : open_memstream(&text, &size);
  int failed = !to || json_dumpf(r->object, to, JSON_INDENT(2)) != 0 || fputc('\n', to) == EOF;
  if (to && fclose(to) != 0) failed = 1;
  json_decref(r->object);
  r->object = NULL;
  const sdr_status status = failed ? sdr_fail(SDR_RUN_FAILED, "out of memory for summary.json")
                                   : sdr_rundir_write(directory, "summary.json", text);
  free(text);
  return status;
}
