/* Any bytes as a run's snapshots: read, or refused in time, whatever HDF5 makes of them. Inputs
   grow out of a good file of a small body. */
#include "fuzz.h"

#include "app/build.h"
#include "app/rundata.h"
#include "output/snapshots.h"

#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);

enum { MOST_BYTES = 1 << 16 };

static struct {
  char directory[64], path[96];
  uint8_t good[MOST_BYTES];
  size_t size;
} run;

static const char scene[] =
    "dimension: plane_stress\n"
    "points: {shape: {box: {size: [5 mm, 4 mm]}}, spacing: 1 mm, align: cell}\n"
    "material: {young: 1 GPa, density: 1000 kg/m^3, toughness: 10 J/m^2}\n"
    "damage: {law: variational}\n"
    "time: {step: 0.1 us, end: 0.3 us}\n"
    "output: {snapshots: 3}\n";

static void write_frames(const sdr_built *built)
{
  sdr_observer *observer;
  sdr_moment moment = {.system = built->system,
                       .scene = built->scene,
                       .directory = run.directory,
                       .step_size = built->step,
                       .end = built->scene->time.end,
                       .steps = built->steps};
  PROMISE(sdr_snapshots_create(built->scene, run.directory, built->points, &observer) == SDR_OK);
  PROMISE(built->integrator->start(built->system, built->step) == SDR_OK);
  for (int k = 0; k < 4; ++k) {
    moment.time = built->system->time;
    moment.step = built->system->step;
    PROMISE(observer->ops->look(observer, &moment) == SDR_OK);
    PROMISE(built->integrator->step(built->system, built->step) == SDR_OK);
  }
  observer->ops->destroy(observer);
}

int LLVMFuzzerInitialize(int *count, char ***words)
{
  char path[64];
  sdr_built built;
  (void)count;
  (void)words;
  snprintf(run.directory, sizeof run.directory, "/tmp/sunder_fuzz_XXXXXX");
  PROMISE(mkdtemp(run.directory));
  snprintf(run.path, sizeof run.path, "%s/snapshots.h5", run.directory);
  const int file = fuzz_file(scene, strlen(scene), path);
  PROMISE(sdr_build(path, NULL, 0, NULL, &built) == SDR_OK);
  close(file);
  write_frames(&built);
  sdr_built_destroy(&built);
  FILE *good = fopen(run.path, "rb");
  PROMISE(good);
  run.size = fread(run.good, 1, sizeof run.good, good);
  PROMISE(run.size > 1000 && run.size < sizeof run.good);
  fclose(good);
  return 0;
}

/* One of the tables of the file, from the place `from` on. */
static size_t table_from(size_t from)
{
  for (size_t k = 0; k < run.size; ++k) {
    const size_t at = (from + k) % run.size;
    if (at + 4 <= run.size &&
        (memcmp(run.good + at, "HEAP", 4) == 0 || memcmp(run.good + at, "TREE", 4) == 0 ||
         memcmp(run.good + at, "SNOD", 4) == 0))
      return at;
  }
  return 0;
}

/* Half of all changes are to the numbers in a table's first 48 bytes: small ones, or the addresses
   of other tables, by which structures bite their tails. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
  if (size < 1000 && run.size <= most) {
    memcpy(data, run.good, run.size);
    size = run.size;
  }
  if (seed % 2 || size < run.size) return LLVMFuzzerMutate(data, size, most);
  const size_t table = table_from(seed / 64 % run.size), word = table + 8 * (seed / 2 % 6);
  uint64_t number = seed / 2 % 3 == 0 ? seed % 129 : table_from(seed / 7 % run.size);
  if (seed / 2 % 5 == 0) data[table + 5] = (uint8_t)(seed % 3);
  if (word + 8 <= size) memcpy(data + word, &number, 8);
  return size;
}

static void read_frames(sdr_rundata *data)
{
  for (int k = 0; k < data->frame_count; ++k) {
    float *values = NULL;
    int components;
    if (sdr_rundata_use(data, k) != SDR_OK) return;
    if (sdr_rundata_field(data, k, "displacement", &values, &components) == SDR_OK)
      sdr_free(values);
    char *fields = sdr_rundata_fields(data, k);
    PROMISE(fields);
    sdr_free(fields);
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  sdr_rundata *read = NULL;
  FILE *file = fopen(run.path, "wb");
  PROMISE(file && fwrite(data, 1, size, file) == size && fclose(file) == 0);
  const size_t before = sdr_memory_now();
  sdr_fail(SDR_OK, "%s", "");
  const sdr_status status = sdr_rundata_open(run.directory, &read);
  PROMISE(status == SDR_OK || sdr_error_message()[0]);
  PROMISE((status == SDR_OK) == (read != NULL));
  if (read) read_frames(read);
  sdr_rundata_destroy(&read);
  PROMISE(sdr_memory_now() == before);
  return 0;
}
