#include "app/check_body.h"

#include "geometry/shape.h"

#include <math.h>

/* ---- size and mass --------------------------------------------------------------------------- */

/* Length, area or volume of the shape by the middles of fine cells of a box around it (exact for
   boxes); NAN where there is no shape, or no box. */
static double measure_of(const sdr_shape *shape, int components)
{
  static const int cells[] = {0, 100000, 1000, 120}; /* in each direction */
  const int n = cells[components];
  double low[3], high[3], x[3] = {0.0}, cell = 1.0;
  int64_t inside = 0, all = 1;
  if (!shape) return (double)NAN;
  sdr_shape_bounds(shape, low, high);
  for (int a = 0; a < components; ++a) {
    if (!isfinite(low[a]) || !isfinite(high[a])) return (double)NAN;
    cell *= (high[a] - low[a]) / n;
    all *= n;
  }
  for (int64_t k = 0; k < all; ++k) {
    int64_t rest = k;
    for (int a = 0; a < components; ++a, rest /= n)
      x[a] = low[a] + (high[a] - low[a]) * ((double)(rest % n) + 0.5) / n;
    inside += sdr_shape_contains(shape, x, 0.0);
  }
  return (double)inside * cell;
}

/* Thickness or area that the volumes of points include. */
static double across(const sdr_scene *scene)
{
  return scene->dimension == SDR_3D ? 1.0 : scene->points.thickness;
}

static void print_size(const sdr_built *built, FILE *out)
{
  static const char *const names[] = {"", "length", "area", "volume"};
  static const char *const units[] = {"", "m", "m^2", "m^3"};
  const sdr_scene *scene = built->scene;
  const sdr_points *points = built->points;
  const int m = points->components;
  double volume = 0.0, mass = 0.0;
  int corners = 1; /* of four cells at the lattice's origin, in every direction */
  for (int32_t i = 0; i < points->count; ++i) {
    if (!sdr_in_body(points, i)) continue;
    volume += points->volume[i];
    mass += points->volume[i] * scene->material[points->material[i]].density;
  }
  for (int a = 0; a < m; ++a) corners &= scene->points.cell_centred[a];
  const double size = volume / across(scene), wanted = measure_of(scene->points.shape, m);
  const double off = size / wanted - 1.0;
  fprintf(out, "body                %s of the points %.4g %s", names[m], size, units[m]);
  if (isfinite(off))
    fprintf(out, ", of the shape %.4g %s (%+.1f %%)", wanted, units[m],
            100.0 * (fabs(off) < 5e-4 ? 0.0 : off));
  fprintf(out, "; mass %.4g kg\n", mass);
  if (!(fabs(off) > 0.02)) return;
  if (!scene->points.imported && !corners)
    fprintf(out, "hint                points.align: cell puts the edges of cells, not points, on "
                 "the shape's; or take a finer spacing\n");
  else
    fprintf(out, "hint                a finer spacing meets the shape better\n");
}

/* ---- supports and loads ---------------------------------------------------------------------- */

static void print_support(const sdr_built *built, int index, FILE *out)
{
  const sdr_support_scene *support = &built->scene->support[index];
  const sdr_prescribed *list = sdr_supports_list(built->supports);
  int32_t gripped = 0, last = -1;
  for (int32_t k = 0; k < sdr_supports_count(built->supports); ++k) {
    if (list[k].support != index || list[k].point == last) continue; /* by point */
    last = list[k].point;
    ++gripped;
  }
  fprintf(out, "support             %s on %s: ", support->name, support->on.text);
  if (support->layer) {
    fprintf(out, "a layer outside\n");
    return;
  }
  fprintf(out, "%d point%s (", (int)gripped, gripped == 1 ? "" : "s");
  for (int a = 0; a < built->points->components; ++a)
    if (support->kind[a] != SDR_FREE) fputc("xyz"[a], out);
  fprintf(out, "%s)\n", support->mean ? ", their mean" : "");
}

static void print_load(const sdr_built *built, int index, FILE *out)
{
  static const char *const kinds[] = {"pressure", "traction", "body force", "point force"};
  const sdr_load *load = &built->scene->load[index];
  const int32_t moved = sdr_loads_points_of(built->loads, index);
  fprintf(out, "load                %s", kinds[load->kind]);
  if (load->kind != SDR_POINT_FORCE) fprintf(out, " on %s", load->on.text);
  if (load->layer)
    fprintf(out, ": through a layer outside\n");
  else
    fprintf(out, ": acts on %d point%s\n", (int)moved, moved == 1 ? "" : "s");
}

void sdr_check_body(const sdr_built *built, FILE *out)
{
  print_size(built, out);
  for (int k = 0; k < built->scene->support_count; ++k) print_support(built, k, out);
  for (int k = 0; k < built->scene->load_count; ++k) print_load(built, k, out);
}
