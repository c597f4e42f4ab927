/* The directory that a run's results go to. */
#ifndef SDR_APP_DIRECTORY_H
#define SDR_APP_DIRECTORY_H

#include "scene/scene.h"

enum { SDR_DIRECTORY = 600 };

/* `asked`, else that of the checkpoint, else the scene's, else out/SCENE[-VARIANT]; asked and
   checkpoint may be NULL. SDR_BAD_INPUT if it is too long. */
sdr_status sdr_name_directory(const sdr_scene *scene, const char *asked, const char *checkpoint,
                              char name[SDR_DIRECTORY]);

#endif
