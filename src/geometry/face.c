#include "geometry/face_internal.h"

#include "base/small.h"
#include "geometry/shape.h"
#include "scene/import.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static const char *const *face_names(sdr_shape_kind kind)
{
  static const char *const box[FACE_NAMES] = {"left", "right", "bottom", "top", "back", "front"};
  static const char *const round[FACE_NAMES] = {"inner", "outer"};
  static const char *const cylinder[FACE_NAMES] = {"inner", "outer", "bottom", "top", "ends"};
  static const char *const rim[FACE_NAMES] = {"rim"};
  static const char *const facets[FACE_NAMES] = {"surface"};
  static const char *const none[FACE_NAMES] = {NULL};
  switch (kind) {
  case SDR_BOX:
    return box;
  case SDR_ANNULUS:
  case SDR_SPHERE:
    return round;
  case SDR_CYLINDER:
    return cylinder;
  case SDR_DISC:
  case SDR_POLYGON:
    return rim;
  case SDR_FACETS:
    return facets;
  case SDR_HALF_SPACE:
  case SDR_GROUP:
  case SDR_UNION:
  case SDR_INTERSECTION:
  case SDR_DIFFERENCE:
    break;
  }
  return none;
}

static int has_extent(const sdr_shape *shape, int index)
{
  const int c = index / 2;
  switch (shape->kind) {
  case SDR_BOX:
    return c == 0 || shape->high[c] > shape->low[c];
  case SDR_ANNULUS:
  case SDR_SPHERE:
  case SDR_CYLINDER:
    return index != ROUND_INNER || shape->inner > 0.0;
  default:
    return 1;
  }
}

int sdr_face_find(const sdr_shape *shape, const char *name, int flip, sdr_found_face *found)
{
  int count = 0;
  const char *const *names = face_names(shape->kind);
  for (int k = 0; k < FACE_NAMES && names[k]; ++k) {
    if (strcmp(names[k], name) == 0 && has_extent(shape, k)) {
      *found = (sdr_found_face){shape, k, flip};
      return 1;
    }
  }
  for (int k = 0; k < shape->part_count; ++k) {
    sdr_found_face inside;
    const int away = shape->kind == SDR_DIFFERENCE && k > 0;
    const int more = sdr_face_find(&shape->parts[k], name, away ? !flip : flip, &inside);
    if (more > 0 && count == 0) *found = inside;
    count += more;
  }
  return count;
}

int sdr_shape_has_face(const sdr_shape *shape, const char *name)
{
  sdr_found_face found;
  return shape && sdr_face_find(shape, name, 0, &found) == 1;
}

/* Whether the list "a, b" holds the word. */
static int listed(const char *list, const char *word)
{
  const size_t length = strlen(word);
  for (const char *at = strstr(list, word); at; at = strstr(at + 1, word)) {
    const int starts = at == list || at[-1] == ' ';
    if (starts && (at[length] == ',' || at[length] == '\0')) return 1;
  }
  return 0;
}

static void list_faces(const sdr_shape *shape, char *text, size_t size)
{
  const char *const *names = face_names(shape->kind);
  for (int k = 0; k < FACE_NAMES && names[k]; ++k) {
    const size_t used = strlen(text);
    if (!has_extent(shape, k) || listed(text, names[k])) continue;
    snprintf(text + used, size - used, "%s%s", used ? ", " : "", names[k]);
  }
  for (int k = 0; k < shape->part_count; ++k) list_faces(&shape->parts[k], text, size);
}

const char *sdr_shape_faces(const sdr_shape *shape, char *text, int size)
{
  text[0] = '\0';
  if (shape) list_faces(shape, text, (size_t)size);
  if (!text[0]) snprintf(text, (size_t)size, "none");
  return text;
}

/* What the cutting of one face needs to know. */
typedef struct {
  sdr_found_face face;
  const sdr_shape *whole;
  double size;
  sdr_piece_visitor visit;
  void *context;
} cutter;

/* On the surface of a combination: inside on one side, outside on the other. */
static int on_surface(const cutter *cut, const sdr_piece *piece)
{
  if (cut->whole == cut->face.shape) return 1;
  double in[3], out[3];
  for (int c = 0; c < 3; ++c) {
    const double step = 1e-6 * cut->size * piece->normal[c];
    in[c] = piece->x[c] - step;
    out[c] = piece->x[c] + step;
  }
  return sdr_shape_contains(cut->whole, in, 0.0) && !sdr_shape_contains(cut->whole, out, 0.0);
}

static void emit(const cutter *cut, const double x[3], const double normal[3], double measure)
{
  sdr_piece piece = {{x[0], x[1], x[2]}, {normal[0], normal[1], normal[2]}, measure};
  if (cut->face.flip) {
    for (int c = 0; c < 3; ++c) piece.normal[c] = 0.0 - normal[c];
  }
  if (on_surface(cut, &piece)) cut->visit(cut->context, &piece);
}

static int64_t parts_of(double length, double size)
{
  const double parts = ceil(length / size * (1.0 - 1e-12));
  return parts > 1.0 ? (int64_t)parts : 1;
}

/* Parts of a circle: a multiple of 8, so that the pieces have a square lattice's symmetry. */
static int64_t parts_of_circle(double radius, double size)
{
  return 8 * parts_of(2.0 * pi * radius / 8.0, size);
}

/* Middle of part k of n of the unit circle, n a multiple of 8, mirrored from the first octant so
   that the parts' middles are symmetric to the last bit. */
static void circle_middle(int64_t k, int64_t n, double unit[3])
{
  static const signed char sign_x[8] = {1, 1, -1, -1, -1, -1, 1, 1};
  static const signed char sign_y[8] = {1, 1, 1, 1, -1, -1, -1, -1};
  const int64_t each = n / 8;
  const int octant = (int)(k / each);
  const int64_t step = octant % 2 ? each - 1 - k % each : k % each;
  const double angle = 2.0 * pi * ((double)step + 0.5) / (double)n;
  const int steep = (octant + 1) / 2 % 2;
  unit[0] = sign_x[octant] * (steep ? sin(angle) : cos(angle));
  unit[1] = sign_y[octant] * (steep ? cos(angle) : sin(angle));
  unit[2] = 0.0;
}

/* A ring of pieces at height z and radius r, each of the same measure; the normal has the part
   `outward` along the radius and `up` along z. */
static void cut_ring(const cutter *cut, int64_t n, const double middle[3], double r, double outward,
                     double up, double measure)
{
  for (int64_t k = 0; k < n; ++k) {
    double unit[3];
    circle_middle(k, n, unit);
    const double x[3] = {middle[0] + r * unit[0], middle[1] + r * unit[1], middle[2]};
    const double normal[3] = {outward * unit[0], outward * unit[1], up};
    emit(cut, x, normal, measure);
  }
}

/* inner: 1 if the face bounds a hole, so that its normal points to the centre. */
static void cut_circle(const cutter *cut, double radius, int inner)
{
  const int64_t n = parts_of_circle(radius, cut->size);
  const double *centre = cut->face.shape->centre;
  const double middle[3] = {centre[0], centre[1], 0.0};
  cut_ring(cut, n, middle, radius, inner ? -1.0 : 1.0, 0.0, 2.0 * pi * radius / (double)n);
}

static void cut_cylinder_side(const cutter *cut, double radius, int inner)
{
  const sdr_shape *shape = cut->face.shape;
  const double height = shape->high[2] - shape->low[2];
  const int64_t layers = parts_of(height, cut->size), n = parts_of_circle(radius, cut->size);
  const double area = 2.0 * pi * radius * height / ((double)n * (double)layers);
  for (int64_t k = 0; k < layers; ++k) {
    const double share = ((double)k + 0.5) / (double)layers;
    const double middle[3] = {shape->centre[0], shape->centre[1], shape->low[2] + share * height};
    cut_ring(cut, n, middle, radius, inner ? -1.0 : 1.0, 0.0, area);
  }
}

static void cut_cylinder_end(const cutter *cut, int top)
{
  const sdr_shape *shape = cut->face.shape;
  const double width = shape->outer - shape->inner;
  const int64_t rings = parts_of(width, cut->size);
  const double middle[3] = {shape->centre[0], shape->centre[1],
                            top ? shape->high[2] : shape->low[2]};
  for (int64_t k = 0; k < rings; ++k) {
    const double a = shape->inner + width * (double)k / (double)rings;
    const double b = shape->inner + width * (double)(k + 1) / (double)rings;
    const int64_t n = parts_of_circle(b, cut->size);
    const double centroid = 2.0 / 3.0 * (a * a + a * b + b * b) / (a + b);
    cut_ring(cut, n, middle, centroid, 0.0, top ? 1.0 : -1.0, pi * (b * b - a * a) / (double)n);
  }
}

static void cut_sphere(const cutter *cut, double radius, int inner)
{
  const double *centre = cut->face.shape->centre;
  const int64_t bands = 2 * parts_of(0.5 * pi * radius, cut->size);
  for (int64_t k = 0; k < bands; ++k) {
    const double from = pi * (double)k / (double)bands, to = pi * (double)(k + 1) / (double)bands;
    const double s = sin(0.5 * (from + to)), z = cos(0.5 * (from + to));
    const double widest = to <= 0.5 * pi * (1.0 + 1e-12) ? sin(to) : sin(from);
    const int64_t n = parts_of_circle(radius * widest, cut->size);
    /* cos(from) - cos(to), without cancellation */
    const double area = 4.0 * pi * radius * radius * s * sin(0.5 * (to - from));
    const double middle[3] = {centre[0], centre[1], centre[2] + radius * z};
    const double sign = inner ? -1.0 : 1.0;
    cut_ring(cut, n, middle, radius * s, sign * s, sign * z, area / (double)n);
  }
}

static void cut_box(const cutter *cut, sdr_dimension dimension)
{
  const sdr_shape *box = cut->face.shape;
  const int across = cut->face.index / 2, high = cut->face.index % 2;
  const int components = sdr_components(dimension);
  int64_t parts[3] = {1, 1, 1};
  double measure = 1.0, normal[3] = {0.0}, local[3] = {0.0};
  const double origin[3] = {0.5 * (box->low[0] + box->high[0]), 0.5 * (box->low[1] + box->high[1]),
                            0.0};
  for (int c = 0; c < components; ++c) {
    if (c == across) continue;
    const double length = box->high[c] - box->low[c];
    parts[c] = parts_of(length, cut->size);
    measure *= length / (double)parts[c];
  }
  for (int c = 0; c < 2; ++c) local[c] = origin[c];
  local[across] += high ? 1.0 : -1.0;
  sdr_box_to_space(box, local, normal);
  for (int c = 0; c < 2; ++c) normal[c] -= origin[c];
  const int64_t total = parts[0] * parts[1] * parts[2];
  for (int64_t k = 0; k < total; ++k) {
    const int64_t at[3] = {k % parts[0], k / parts[0] % parts[1], k / parts[0] / parts[1]};
    double x[3];
    for (int c = 0; c < 3; ++c) {
      const double share = ((double)at[c] + 0.5) / (double)parts[c];
      local[c] = c < components ? box->low[c] + share * (box->high[c] - box->low[c]) : 0.0;
    }
    local[across] = high ? box->high[across] : box->low[across];
    sdr_box_to_space(box, local, x);
    emit(cut, x, normal, measure);
  }
}

static double twice_signed_area(const sdr_shape *polygon)
{
  double sum = 0.0;
  for (int k = 0, last = polygon->vertex_count - 1; k < polygon->vertex_count; last = k++) {
    const double *a = &polygon->vertices[2 * last], *b = &polygon->vertices[2 * k];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum;
}

static void cut_polygon(const cutter *cut)
{
  const sdr_shape *polygon = cut->face.shape;
  const double turn = twice_signed_area(polygon) < 0.0 ? -1.0 : 1.0;
  for (int k = 0; k < polygon->vertex_count; ++k) {
    const double *a = &polygon->vertices[2 * k];
    const double *b = &polygon->vertices[2 * ((k + 1) % polygon->vertex_count)];
    const double e[2] = {b[0] - a[0], b[1] - a[1]}, length = hypot(e[0], e[1]);
    if (!(length > 0.0)) continue;
    const int64_t parts = parts_of(length, cut->size);
    const double normal[3] = {turn * e[1] / length, -turn * e[0] / length, 0.0};
    for (int64_t p = 0; p < parts; ++p) {
      const double share = ((double)p + 0.5) / (double)parts;
      const double x[3] = {a[0] + share * e[0], a[1] + share * e[1], 0.0};
      emit(cut, x, normal, length / (double)parts);
    }
  }
}

/* The triangle's pieces: a triangle of n rows, in each row triangles that stand and that hang. */
static void cut_triangle(const cutter *cut, const double *t, const double normal[3])
{
  double e[3], f[3], g[3], cross[3];
  for (int c = 0; c < 3; ++c) {
    e[c] = t[3 + c] - t[c];
    f[c] = t[6 + c] - t[c];
    g[c] = f[c] - e[c];
  }
  sdr_cross3(e, f, cross);
  const double longest = fmax(sdr_norm3(e), fmax(sdr_norm3(f), sdr_norm3(g)));
  const int64_t n = parts_of(longest, cut->size);
  const double area = 0.5 * sdr_norm3(cross) / (double)(n * n);
  for (int64_t row = 0; row < n; ++row) {
    for (int64_t k = 0; k < 2 * (n - row) - 1; ++k) {
      const double third = k % 2 ? 2.0 / 3.0 : 1.0 / 3.0;
      const double p = ((double)(k / 2) + third) / (double)n, q = ((double)row + third) / (double)n;
      double x[3];
      for (int c = 0; c < 3; ++c) x[c] = t[c] + p * e[c] + q * f[c];
      emit(cut, x, normal, area);
    }
  }
}

static void cut_edge(const cutter *cut, const double *edge, const double normal[3])
{
  const double e[3] = {edge[3] - edge[0], edge[4] - edge[1], edge[5] - edge[2]};
  const double length = sdr_norm3(e);
  const int64_t parts = parts_of(length, cut->size);
  for (int64_t p = 0; p < parts; ++p) {
    const double share = ((double)p + 0.5) / (double)parts;
    const double x[3] = {edge[0] + share * e[0], edge[1] + share * e[1], edge[2] + share * e[2]};
    emit(cut, x, normal, length / (double)parts);
  }
}

static void cut_facets(const cutter *cut)
{
  const sdr_tree *facets = cut->face.shape->group->facets;
  for (int32_t k = 0; k < facets->count; ++k) {
    const double *piece = facets->piece + (size_t)(3 * facets->corners) * (size_t)k;
    const double *normal = facets->normal + 3 * (size_t)k;
    if (facets->corners == 1) emit(cut, piece, normal, 1.0);
    if (facets->corners == 2) cut_edge(cut, piece, normal);
    if (facets->corners == 3) cut_triangle(cut, piece, normal);
  }
}

static void cut_cylinder(const cutter *cut)
{
  const sdr_shape *shape = cut->face.shape;
  const int index = cut->face.index;
  if (index == ROUND_INNER) cut_cylinder_side(cut, shape->inner, 1);
  if (index == ROUND_OUTER) cut_cylinder_side(cut, shape->outer, 0);
  if (index == ROUND_BOTTOM || index == ROUND_ENDS) cut_cylinder_end(cut, 0);
  if (index == ROUND_TOP || index == ROUND_ENDS) cut_cylinder_end(cut, 1);
}

static void cut_face(const cutter *cut, sdr_dimension dimension)
{
  const sdr_shape *shape = cut->face.shape;
  const int inner = cut->face.index == ROUND_INNER;
  switch (shape->kind) {
  case SDR_BOX:
    cut_box(cut, dimension);
    return;
  case SDR_DISC:
    cut_circle(cut, shape->outer, 0);
    return;
  case SDR_ANNULUS:
    cut_circle(cut, inner ? shape->inner : shape->outer, inner);
    return;
  case SDR_SPHERE:
    cut_sphere(cut, inner ? shape->inner : shape->outer, inner);
    return;
  case SDR_CYLINDER:
    cut_cylinder(cut);
    return;
  case SDR_POLYGON:
    cut_polygon(cut);
    return;
  case SDR_FACETS:
    cut_facets(cut);
    return;
  default:
    return;
  }
}

sdr_status sdr_face_pieces(const sdr_shape *shape, const char *name, sdr_dimension dimension,
                           double size, sdr_piece_visitor visit, void *context)
{
  char names[128];
  cutter cut = {.whole = shape, .size = size, .visit = visit, .context = context};
  const int count = shape ? sdr_face_find(shape, name, 0, &cut.face) : 0;
  if (count == 0) {
    return sdr_fail(SDR_BAD_INPUT, "no face '%s'; the faces here are: %s", name,
                    sdr_shape_faces(shape, names, (int)sizeof names));
  }
  if (count > 1) {
    return sdr_fail(SDR_BAD_INPUT,
                    "%d parts have a face '%s'; make the meant part a region and write REGION.%s",
                    count, name, name);
  }
  if (!(size > 0.0)) return sdr_fail(SDR_BAD_INPUT, "a face's pieces need a size above 0");
  cut_face(&cut, dimension);
  return SDR_OK;
}

static void box_plane(const sdr_found_face *of, double x[3], double normal[3])
{
  const sdr_shape *box = of->shape;
  const int across = of->index / 2, high = of->index % 2;
  double local[3];
  for (int c = 0; c < 3; ++c) local[c] = 0.5 * (box->low[c] + box->high[c]);
  local[across] = high ? box->high[across] : box->low[across];
  sdr_box_to_space(box, local, x);
  normal[0] = normal[1] = normal[2] = 0.0;
  const double sign = high ? 1.0 : -1.0;
  if (across == 2 || box->angle == 0.0) {
    normal[across] = sign;
    return;
  }
  normal[across] = sign * cos(box->angle);
  normal[1 - across] = (across == 0 ? sign : -sign) * sin(box->angle);
}

static void end_plane(const sdr_found_face *of, double x[3], double normal[3])
{
  const sdr_shape *shape = of->shape;
  const int top = of->index == ROUND_TOP;
  for (int c = 0; c < 2; ++c) x[c] = shape->centre[c];
  x[2] = top ? shape->high[2] : shape->low[2];
  normal[0] = normal[1] = 0.0;
  normal[2] = top ? 1.0 : -1.0;
}

int sdr_face_plane(const sdr_shape *shape, const char *name, double x[3], double normal[3])
{
  sdr_found_face of;
  if (!shape || sdr_face_find(shape, name, 0, &of) != 1) return 0;
  const int end =
      of.shape->kind == SDR_CYLINDER && (of.index == ROUND_BOTTOM || of.index == ROUND_TOP);
  if (of.shape->kind != SDR_BOX && !end) return 0;
  (end ? end_plane : box_plane)(&of, x, normal);
  for (int c = 0; of.flip && c < 3; ++c) normal[c] = 0.0 - normal[c];
  return 1;
}
