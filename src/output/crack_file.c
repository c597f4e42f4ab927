#include "output/crack_file.h"

#include "base/memory.h"
#include "output/crack_path.h"
#include "output/rundir.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void put(FILE *out, double value, char after)
{
  if (!isnan(value)) fprintf(out, "%.17g", value);
  fputc(after, out);
}

static void put_row(FILE *out, const char *name, int32_t arm, int32_t parent,
                    const sdr_crack_node *path, int32_t run, int32_t k, double window)
{
  fprintf(out, "%s,%d,%d,", name, (int)arm, (int)parent);
  put(out, path[k].time, ',');
  put(out, path[k].distance, ',');
  for (int c = 0; c < 3; ++c) put(out, path[k].x[c], ',');
  const double smooth = sdr_crack_speed_at(path, run, k, window);
  put(out, isnan(smooth) ? smooth : sdr_crack_step_speed(path, run, k), ',');
  put(out, smooth, '\n');
}

static sdr_status put_crack(FILE *out, const char *name, const sdr_crack_tree *tree, double window)
{
  sdr_crack_node *path = sdr_alloc((size_t)tree->node_count, sizeof *path);
  if (!path) return SDR_RUN_FAILED;
  for (int32_t a = 0; a < tree->arm_count; ++a) {
    const int32_t count = sdr_crack_path(tree, a, path);
    const int32_t run = sdr_crack_run_up(path, count, window);
    for (int32_t k = count - tree->arm[a].count; k < count; ++k)
      put_row(out, name, a, tree->arm[a].parent, path, run, k, window);
  }
  sdr_free(path);
  return SDR_OK;
}

sdr_status sdr_crack_file_write(const char *directory, const sdr_cracks_output *cracks,
                                const sdr_crack_report *reports, double window)
{
  char *text = NULL;
  size_t size = 0;
  sdr_status status = SDR_OK;
  FILE *out = open_memstream(&text, &size);
  if (!out) return sdr_fail(SDR_RUN_FAILED, "out of memory for cracks.csv");
  fputs("crack,arm,parent,time,distance,x,y,z,speed,smooth_speed\n", out);
  for (int k = 0; k < cracks->tip_count && status == SDR_OK; ++k)
    status = put_crack(out, cracks->tip[k].name, &reports[k].tree, window);
  if (fclose(out) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_RUN_FAILED, "out of memory for cracks.csv");
  if (status == SDR_OK) status = sdr_rundir_write(directory, "cracks.csv", text);
  free(text);
  return status;
}
