/* Any bytes as a checkpoint: taken over whole, or refused with nothing changed, and HDF5 never sees
   a file that is not as it was written. Inputs grow out of a good checkpoint of the same body. */
#include "fuzz.h"

#include "app/build.h"
#include "output/checkpoint.h"
#include "output/ledger.h"
#include "output/onset.h"

#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);

enum { MOST_BYTES = 1 << 17 };

static struct {
  sdr_built built;
  char directory[64];
  sdr_observer *observers[2];
  sdr_moment moment;
  uint8_t good[MOST_BYTES];
  size_t size;
} run;

static const char scene[] =
    "dimension: plane_stress\n"
    "points: {shape: {box: {size: [5 mm, 4 mm]}}, spacing: 1 mm, align: cell}\n"
    "material: {young: 1 GPa, density: 1000 kg/m^3, toughness: 10 J/m^2}\n"
    "damage: {law: variational}\n"
    "time: {step: 0.1 us, end: 10 us}\n"
    "output: {snapshots: 0, checkpoint: {every: 1 us}}\n";

static void write_good(void)
{
  char path[96];
  const sdr_built *built = &run.built;
  for (int k = 0; k < 10; ++k)
    PROMISE(built->integrator->step(built->system, built->step) == SDR_OK);
  run.moment.time = built->system->time;
  run.moment.step = built->system->step;
  PROMISE(sdr_checkpoint_write(run.directory, &run.moment, "any", run.observers, 2) == SDR_OK);
  snprintf(path, sizeof path, "%s/checkpoint.h5", run.directory);
  FILE *file = fopen(path, "rb");
  PROMISE(file);
  run.size = fread(run.good, 1, sizeof run.good, file);
  PROMISE(run.size > 1000 && run.size < sizeof run.good);
  fclose(file);
  unlink(path);
}

int LLVMFuzzerInitialize(int *count, char ***words)
{
  char path[64];
  sdr_built *built = &run.built;
  (void)count;
  (void)words;
  const int file = fuzz_file(scene, strlen(scene), path);
  PROMISE(sdr_build(path, NULL, 0, NULL, built) == SDR_OK);
  close(file);
  snprintf(run.directory, sizeof run.directory, "/tmp/sunder_fuzz_XXXXXX");
  PROMISE(mkdtemp(run.directory));
  run.moment = (sdr_moment){.system = built->system,
                            .scene = built->scene,
                            .directory = run.directory,
                            .step_size = built->step,
                            .end = built->scene->time.end,
                            .steps = built->steps};
  PROMISE(sdr_ledger_create(built->scene, built->points, &run.observers[0]) == SDR_OK);
  PROMISE(sdr_onset_create(built->points, built->onset, &run.observers[1]) == SDR_OK);
  PROMISE(built->integrator->start(built->system, built->step) == SDR_OK);
  write_good();
  return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
  if (size < 1000 && run.size <= most) {
    memcpy(data, run.good, run.size);
    if (seed % 4 == 0) return seed % run.size;
    size = run.size;
  }
  return LLVMFuzzerMutate(data, size, most);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char path[64];
  const sdr_system *system = run.built.system;
  const int64_t step = system->step;
  const double first = system->u[0][0];
  const int file = fuzz_file(data, size, path);
  const size_t before = sdr_memory_now();
  sdr_fail(SDR_OK, "%s", "");
  const sdr_status status = sdr_checkpoint_read(path, &run.moment, "any", run.observers, 2);
  if (status == SDR_OK) {
    PROMISE(system->step == run.moment.step && system->step <= run.moment.steps);
  } else {
    PROMISE(sdr_error_message()[0]);
    PROMISE(system->step == step && memcmp(&system->u[0][0], &first, sizeof first) == 0);
    PROMISE(sdr_memory_now() == before);
  }
  close(file);
  return 0;
}
