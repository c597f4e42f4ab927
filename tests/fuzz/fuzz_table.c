/* Any bytes as a table of two columns: read with rising keys and finite values, or refused. */
#include "fuzz.h"

#include "scene/table.h"

#include <math.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char path[64];
  int rows = 0;
  double *keys = NULL, *values = NULL;
  const int file = fuzz_file(data, size, path);
  const size_t before = sdr_memory_now();
  sdr_store *store = sdr_store_create();
  const sdr_status status = sdr_table_read(store, path, "t", "u", &rows, &keys, &values);
  PROMISE(status == SDR_OK || status == SDR_BAD_INPUT);
  for (int k = 0; status == SDR_OK && k < rows; ++k) {
    PROMISE(isfinite(keys[k]) && isfinite(values[k]));
    PROMISE(k == 0 || keys[k] > keys[k - 1]);
  }
  if (status == SDR_OK) PROMISE(rows >= 2);
  sdr_store_destroy(&store);
  PROMISE(sdr_memory_now() == before);
  close(file);
  return 0;
}
