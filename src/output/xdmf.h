/* snapshots.xdmf: tells ParaView what the frames of snapshots.h5 are. */
#ifndef SDR_OUTPUT_XDMF_H
#define SDR_OUTPUT_XDMF_H

#include "base/status.h"
#include "output/fields.h"

#include <stdint.h>

typedef struct {
  int32_t points;
  int components; /* of the body */
  int frame_count;
  const double *times; /* s, one a frame */
  int field_count;
  const sdr_field_info *const *fields; /* what each frame holds */
} sdr_xdmf;

/* Write DIRECTORY/snapshots.xdmf by rename. */
sdr_status sdr_xdmf_write(const char *directory, const sdr_xdmf *what);

#endif
