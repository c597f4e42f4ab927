/* Any bytes as a scene: it is read, or refused with a message; what was read, written out with its
   defaults, reads back as the same scene. */
#include "fuzz.h"

#include "scene/scene.h"

#include <string.h>

static void read_back(const sdr_scene *scene)
{
  char path[64];
  sdr_scene *again = NULL;
  const int file = fuzz_file(scene->used_yaml, strlen(scene->used_yaml), path);
  const sdr_status status = sdr_scene_load(path, NULL, 0, NULL, &again);
  if (status != SDR_OK) fprintf(stderr, "%s\n%s\n", sdr_error_message(), scene->used_yaml);
  PROMISE(status == SDR_OK);
  PROMISE(again->hash == scene->hash);
  sdr_scene_destroy(&again);
  close(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char path[64];
  sdr_scene *scene = NULL;
  const int file = fuzz_file(data, size, path);
  sdr_fail(SDR_OK, "%s", "");
  const size_t before = sdr_memory_now();
  const sdr_status status = sdr_scene_load(path, NULL, 0, NULL, &scene);
  PROMISE(status == SDR_OK || (status == SDR_BAD_INPUT && sdr_error_message()[0]));
  PROMISE((status == SDR_OK) == (scene != NULL));
  if (scene) read_back(scene);
  sdr_scene_destroy(&scene);
  PROMISE(sdr_memory_now() == before);
  close(file);
  return 0;
}
