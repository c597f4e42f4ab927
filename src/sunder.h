/* Sunder as a library. A scene comes from a file (sdr_scene_load) or from text (sdr_scene_parse);
   sdr_build_scene makes its body, sdr_built.integrator moves it step by step, and what is in
   sdr_built.system (positions, forces, energies by sdr_system_balance, fields) may be read between
   steps. sdr_run is what the program's `sunder run` does. Functions that can fail return an
   sdr_status; sdr_error_message tells why. */
#ifndef SUNDER_H
#define SUNDER_H

#include "app/build.h"
#include "app/run.h"
#include "base/status.h"
#include "mechanics/system.h"
#include "scene/scene.h"
#include "time/integrator.h"

#endif
