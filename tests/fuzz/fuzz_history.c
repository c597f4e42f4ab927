/* Any bytes as the history of a run: read as a table of numbers, or refused. */
#include "fuzz.h"

#include "app/rundata.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char path[64];
  sdr_history history = {0};
  const int file = fuzz_file(data, size, path);
  const size_t before = sdr_memory_now();
  const sdr_status status = sdr_history_read(path, &history);
  PROMISE(status == SDR_OK || status == SDR_BAD_INPUT);
  double sum = 0.0;
  for (int k = 0; status == SDR_OK && k < history.row_count * history.column_count; ++k)
    sum += history.value[k];
  volatile double kept = sum;
  (void)kept;
  sdr_history_clear(&history);
  PROMISE(sdr_memory_now() == before);
  close(file);
  return 0;
}
