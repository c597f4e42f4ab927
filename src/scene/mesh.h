/* A mesh as it stands in a file, and the points that a body gets from it. */
#ifndef SDR_SCENE_MESH_H
#define SDR_SCENE_MESH_H

#include "scene/import.h"

/* An edge, triangle, quadrilateral, tetrahedron, pyramid, prism or hexahedron: its dimension and
   the number of its corners tell which. Corners in Gmsh's order; middle nodes are left out. */
typedef struct {
  int dimension, corners;
  int32_t corner[8]; /* nodes */
} sdr_mesh_element;

/* A part of the geometry: its elements first .. last - 1, all of its dimension. */
typedef struct {
  int dimension;
  int64_t first, last;
} sdr_mesh_entity;

/* A physical group: some entities of its dimension. */
typedef struct {
  char name[SDR_NAME_MAX];
  int dimension, entity_count;
  int *entity;
} sdr_mesh_group;

/* Arrays from sdr_alloc. */
typedef struct {
  int32_t node_count;
  double *x; /* 3 a node, in the file's unit */
  int64_t element_count;
  sdr_mesh_element *element;
  int entity_count;
  sdr_mesh_entity *entity; /* those of the body's dimension and of one less */
  int group_count;
  sdr_mesh_group *group; /* likewise */
} sdr_mesh;

/* Read a mesh of Gmsh, of which `text` are the bytes, through Gmsh's library. Call sdr_mesh_clear
   in any case. */
sdr_status sdr_mesh_read(const char *path, const char *text, size_t length,
                         const sdr_import_how *how, sdr_mesh *mesh);
void sdr_mesh_clear(sdr_mesh *mesh);

/* Of elements from `first` on with the same corners leave the first one only: older files repeat
   an element for each group that holds it. */
sdr_status sdr_mesh_drop_doubles(sdr_mesh *mesh, int64_t first);

/* The points at the centroids of the body's elements, each with its element's measure; or at the
   nodes, among whose corners each element's measure is divided equally. Groups of the body's
   dimension hold the points of their elements, those of one less are faces. */
sdr_status sdr_mesh_points(sdr_store *store, const char *path, const sdr_mesh *mesh,
                           const sdr_import_how *how, sdr_import **out);

/* Measure (m, m^2, m^3 for x in m) of an element and its centroid. */
double sdr_mesh_measure(const double *x, const sdr_mesh_element *element, double centroid[3]);

#endif
