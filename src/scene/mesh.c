#include "scene/mesh.h"

#include "base/memory.h"
#include "base/small.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void sdr_mesh_clear(sdr_mesh *mesh)
{
  for (int k = 0; k < mesh->group_count; ++k) sdr_free(mesh->group[k].entity);
  sdr_free(mesh->group);
  sdr_free(mesh->entity);
  sdr_free(mesh->element);
  sdr_free(mesh->x);
  *mesh = (sdr_mesh){0};
}

/* ---- doubles --------------------------------------------------------------------------------- */

/* An element's corners in rising order, and which element it is. */
typedef struct {
  int32_t corner[8];
  int64_t element;
} sorted;

static int by_corners(const void *left, const void *right)
{
  const sorted *a = left, *b = right;
  for (int k = 0; k < 8; ++k)
    if (a->corner[k] != b->corner[k]) return a->corner[k] < b->corner[k] ? -1 : 1;
  return a->element < b->element ? -1 : a->element > b->element;
}

static void sort_corners(const sdr_mesh_element *element, int64_t index, sorted *out)
{
  out->element = index;
  for (int k = 0; k < 8; ++k) {
    const int32_t node = k < element->corners ? element->corner[k] : INT32_MAX;
    int place = k;
    for (; place > 0 && out->corner[place - 1] > node; --place)
      out->corner[place] = out->corner[place - 1];
    out->corner[place] = node;
  }
}

sdr_status sdr_mesh_drop_doubles(sdr_mesh *mesh, int64_t first)
{
  const int64_t count = mesh->element_count - first;
  sorted *list = sdr_alloc((size_t)count, sizeof *list);
  if (!list) return SDR_RUN_FAILED;
  for (int64_t k = 0; k < count; ++k) sort_corners(&mesh->element[first + k], k, &list[k]);
  qsort(list, (size_t)count, sizeof *list, by_corners);
  for (int64_t k = 1; k < count; ++k)
    if (memcmp(list[k].corner, list[k - 1].corner, sizeof list[k].corner) == 0)
      mesh->element[first + list[k].element].corners = 0;
  mesh->element_count = first;
  for (int64_t k = 0; k < count; ++k) {
    const sdr_mesh_element element = mesh->element[first + k];
    if (element.corners > 0) mesh->element[mesh->element_count++] = element;
  }
  sdr_free(list);
  return SDR_OK;
}

/* ---- elements -------------------------------------------------------------------------------- */

/* Faces of the elements in space, -1 after the last corner. */
static const signed char tetrahedron[4][4] = {
    {0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {0, 3, 2, -1}};
static const signed char pyramid[5][4] = {
    {0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}};
static const signed char prism[5][4] = {
    {0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
static const signed char hexahedron[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                             {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

static int faces_of(int corners, const signed char (**faces)[4])
{
  *faces = corners == 4 ? tetrahedron : corners == 5 ? pyramid : corners == 6 ? prism : hexahedron;
  return corners == 4 ? 4 : corners == 8 ? 6 : 5;
}

static const double *corner_of(const double *x, const sdr_mesh_element *element, int k)
{
  return x + 3 * (size_t)element->corner[k];
}

static void middle_of(const double *x, const sdr_mesh_element *element, double middle[3])
{
  for (int c = 0; c < 3; ++c) {
    double sum = 0.0;
    for (int k = 0; k < element->corners; ++k) sum += corner_of(x, element, k)[c];
    middle[c] = sum / element->corners;
  }
}

/* Sums of what the parts of an element hold, about its middle. */
typedef struct {
  double middle[3], measure, moment[3];
} parts;

static void add_part(parts *sum, double measure, const double centroid[3])
{
  sum->measure += measure;
  for (int c = 0; c < 3; ++c) sum->moment[c] += measure * centroid[c];
}

/* Triangles from the middle to each edge, in the plane. */
static void add_plane(const double *x, const sdr_mesh_element *element, parts *sum)
{
  for (int k = 0; k < element->corners; ++k) {
    double a[3], b[3], centroid[3] = {0.0};
    for (int c = 0; c < 3; ++c) {
      a[c] = corner_of(x, element, k)[c] - sum->middle[c];
      b[c] = corner_of(x, element, (k + 1) % element->corners)[c] - sum->middle[c];
      centroid[c] = (a[c] + b[c]) / 3.0;
    }
    add_part(sum, 0.5 * (a[0] * b[1] - a[1] * b[0]), centroid);
  }
}

/* Tetrahedra from the middle to the triangles between a face's middle and its edges, so that
   elements with curved or skewed faces fit together without gaps. */
static void add_face(const double *x, const sdr_mesh_element *element, const signed char face[4],
                     parts *sum)
{
  const int corners = face[3] < 0 ? 3 : 4;
  double f[3] = {0.0};
  for (int k = 0; k < corners; ++k)
    for (int c = 0; c < 3; ++c)
      f[c] += (corner_of(x, element, face[k])[c] - sum->middle[c]) / corners;
  for (int k = 0; k < corners; ++k) {
    double a[3], b[3], cross[3], centroid[3];
    for (int c = 0; c < 3; ++c) {
      a[c] = corner_of(x, element, face[k])[c] - sum->middle[c];
      b[c] = corner_of(x, element, face[(k + 1) % corners])[c] - sum->middle[c];
      centroid[c] = 0.25 * (a[c] + b[c] + f[c]);
    }
    sdr_cross3(a, b, cross);
    add_part(sum, sdr_dot3(cross, f) / 6.0, centroid);
  }
}

double sdr_mesh_measure(const double *x, const sdr_mesh_element *element, double centroid[3])
{
  parts sum = {.measure = 0.0};
  middle_of(x, element, sum.middle);
  memcpy(centroid, sum.middle, 3 * sizeof *centroid);
  if (element->dimension == 1) {
    const double *a = corner_of(x, element, 0), *b = corner_of(x, element, 1);
    const double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    return sdr_norm3(d);
  }
  if (element->dimension == 2) {
    add_plane(x, element, &sum);
  } else {
    const signed char(*faces)[4];
    const int count = faces_of(element->corners, &faces);
    for (int k = 0; k < count; ++k) add_face(x, element, faces[k], &sum);
  }
  if (sum.measure != 0.0)
    for (int c = 0; c < 3; ++c) centroid[c] += sum.moment[c] / sum.measure;
  return fabs(sum.measure);
}
