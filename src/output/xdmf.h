/* snapshots.xdmf: tells ParaView what the frames of snapshots.h5 are. */
#ifndef SDR_OUTPUT_XDMF_H
#define SDR_OUTPUT_XDMF_H

#include "base/status.h"
#include "output/fields.h"

#include <stdint.h>

typedef struct {
  int components; /* of the body */
  int frame_count;
  const double *times;   /* s, one a frame */
  const int32_t *points; /* how many each frame has */
  const int *own_points; /* 1: a frame's are its own, else those of the file */
  int field_count;
  const sdr_field_info *const *fields; /* what each frame holds */
} sdr_xdmf;

/* Write DIRECTORY/snapshots.xdmf by rename. */
sdr_status sdr_xdmf_write(const char *directory, const sdr_xdmf *what);

#endif
