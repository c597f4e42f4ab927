/* XDMF 3. Its readers show no points without a topology, so one with a vertex a point is named. */
#include "output/xdmf.h"

#include "output/frames.h"
#include "output/rundir.h"

#include <stdio.h>
#include <stdlib.h>

static void write_mesh(FILE *to, const sdr_xdmf *what, int frame)
{
  char group[SDR_FRAME_PATH] = "points";
  const int count = (int)what->points[frame];
  if (what->own_points[frame]) sdr_frame_path(group, frame, "points");
  fprintf(to,
          "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%d\" "
          "NodesPerElement=\"1\">\n"
          "          <DataItem NumberType=\"Int\" Precision=\"4\" Dimensions=\"%d\" "
          "Format=\"HDF\">snapshots.h5:/%s/index</DataItem>\n"
          "        </Topology>\n"
          "        <Geometry GeometryType=\"XYZ\">\n"
          "          <DataItem NumberType=\"Float\" Precision=\"8\" Dimensions=\"%d 3\" "
          "Format=\"HDF\">snapshots.h5:/%s/position</DataItem>\n"
          "        </Geometry>\n",
          count, count, group, count, group);
}

static void write_field(FILE *to, const sdr_xdmf *what, int frame, const sdr_field_info *field)
{
  char path[SDR_FRAME_PATH], width_text[16] = "";
  const int width = sdr_field_width(field, what->components);
  const char *type = width == 1                                      ? "Scalar"
                     : width == 3 && field->kind == SDR_VECTOR_FIELD ? "Vector"
                                                                     : "Matrix";
  if (width > 1) snprintf(width_text, sizeof width_text, " %d", width);
  sdr_frame_path(path, frame, field->name);
  fprintf(to,
          "        <Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">\n"
          "          <DataItem NumberType=\"Float\" Precision=\"4\" Dimensions=\"%d%s\" "
          "Format=\"HDF\">snapshots.h5:/%s</DataItem>\n"
          "        </Attribute>\n",
          field->name, type, (int)what->points[frame], width_text, path);
}

static void write_all(FILE *to, const sdr_xdmf *what)
{
  fputs("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
        "    <Grid Name=\"frames\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
        to);
  for (int k = 0; k < what->frame_count; ++k) {
    char name[SDR_FRAME_PATH];
    sdr_frame_path(name, k, "");
    fprintf(to, "      <Grid Name=\"%s\" GridType=\"Uniform\">\n        <Time Value=\"%.17g\"/>\n",
            name, what->times[k]);
    write_mesh(to, what, k);
    for (int f = 0; f < what->field_count; ++f) write_field(to, what, k, what->fields[f]);
    fputs("      </Grid>\n", to);
  }
  fputs("    </Grid>\n  </Domain>\n</Xdmf>\n", to);
}

sdr_status sdr_xdmf_write(const char *directory, const sdr_xdmf *what)
{
  char *text = NULL;
  size_t size = 0;
  FILE *to = open_memstream(&text, &size);
  if (!to) return sdr_fail(SDR_RUN_FAILED, "out of memory for snapshots.xdmf");
  write_all(to, what);
  const sdr_status status = fclose(to) == 0
                                ? sdr_rundir_write(directory, "snapshots.xdmf", text)
                                : sdr_fail(SDR_RUN_FAILED, "out of memory for snapshots.xdmf");
  free(text);
  return status;
}
