/* Scenes by path or by the name of a folder in problems/. */
#ifndef SDR_APP_FIND_SCENE_H
#define SDR_APP_FIND_SCENE_H

#include "base/status.h"

#include <stdio.h>

enum { SDR_SCENE_PATH = 1024 };

/* Path of the scene that `name` means: a file, the scene.yaml in a folder, or
   problems/NAME/scene.yaml, looked for in the current folder, in $SUNDER_PROBLEMS and in the source
   tree of this build. Else the message lists the problems, and names what may be meant:
   SDR_IO_ERROR of a path, SDR_BAD_INPUT of a name. */
sdr_status sdr_find_scene(const char *name, char path[SDR_SCENE_PATH]);

/* What it is, where, and its variants. */
sdr_status sdr_tell_problem(const char *name, FILE *out);

/* One line a problem: name, title. */
sdr_status sdr_list_problems(FILE *out);

#endif
