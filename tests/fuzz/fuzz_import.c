/* Any bytes as a table of points: read with finite places and volumes above zero, or refused. */
#include "fuzz.h"

#include "scene/import.h"

#include <math.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  static const char *const ignored[] = {"note"};
  const sdr_import_how how = {1 + (int)(size % 3), 0.001, 0, 1, ignored};
  const size_t before = sdr_memory_now();
  sdr_store *store = sdr_store_create();
  sdr_import *import = NULL;
  const sdr_status status =
      sdr_import_table(store, "p.csv", (const char *)data, size, &how, &import);
  PROMISE(status == SDR_OK || status == SDR_BAD_INPUT);
  for (int32_t i = 0; status == SDR_OK && i < import->count; ++i) {
    for (int c = 0; c < 3; ++c) PROMISE(isfinite(import->x[c][i]));
    PROMISE(!import->volume || import->volume[i] > 0.0);
    PROMISE(!import->spacing || import->spacing[i] > 0.0);
    PROMISE(import->volume || import->spacing);
  }
  sdr_store_destroy(&store);
  PROMISE(sdr_memory_now() == before);
  return 0;
}
