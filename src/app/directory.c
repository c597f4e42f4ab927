#include "app/directory.h"

#include <stdio.h>
#include <string.h>

/* Length of the folder's name if the run resumes from the checkpoint.h5 of a directory; 0: not. */
static int length_of_folder(const char *checkpoint)
{
  const char *slash = checkpoint ? strrchr(checkpoint, '/') : NULL;
  return slash && strcmp(slash, "/checkpoint.h5") == 0 ? (int)(slash - checkpoint) : 0;
}

sdr_status sdr_name_directory(const sdr_scene *scene, const char *asked, const char *checkpoint,
                              char name[SDR_DIRECTORY])
{
  const int folder = length_of_folder(checkpoint);
  int length;
  if (asked)
    length = snprintf(name, SDR_DIRECTORY, "%s", asked);
  else if (folder > 0)
    length = snprintf(name, SDR_DIRECTORY, "%.*s", folder, checkpoint);
  else if (scene->output.directory[0])
    length = snprintf(name, SDR_DIRECTORY, "%s", scene->output.directory);
  else
    length = snprintf(name, SDR_DIRECTORY, "out/%s%s%s", scene->name, scene->variant[0] ? "-" : "",
                      scene->variant);
  if (length < SDR_DIRECTORY) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "the name of the run's directory is longer than %d characters",
                  SDR_DIRECTORY - 1);
}
