#include "app/compare.h"

#include "app/compare_parts.h"

enum { PATH_ROOM = 4200 };

static sdr_status compare(const sdr_rundata *a, const sdr_rundata *b, const char *png, FILE *out)
{
  char path[PATH_ROOM];
  const sdr_rundata *const runs[2] = {a, b};
  for (int k = 0; k < 2; ++k)
    if (!runs[k]->summary)
      fprintf(out, "%s: no summary.json, so this run has not finished; comparing what is there\n",
              runs[k]->directory);
  sdr_compare_table(a, b, out);
  SDR_TRY(sdr_compare_fields(a, b, out));
  fputc('\n', out);
  snprintf(path, sizeof path, "%s/compare.png", a->directory);
  return sdr_compare_picture(a, b, png ? png : path, out);
}

sdr_status sdr_compare(const char *dir_a, const char *dir_b, const char *png, FILE *out)
{
  sdr_rundata *a = NULL, *b = NULL;
  sdr_status status = sdr_rundata_open(dir_a, &a);
  if (status == SDR_OK) status = sdr_rundata_open(dir_b, &b);
  if (status == SDR_OK) {
    const sdr_frames frames = sdr_compare_frames(a, b);
    if (frames.frame[0] >= 0) status = sdr_rundata_use(a, frames.frame[0]);
    if (status == SDR_OK && frames.frame[1] >= 0) status = sdr_rundata_use(b, frames.frame[1]);
  }
  if (status == SDR_OK) status = compare(a, b, png, out);
  sdr_rundata_destroy(&a);
  sdr_rundata_destroy(&b);
  return status;
}
