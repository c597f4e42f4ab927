/* A body from a file, key `points.import`: points from a table, or those of a mesh. */
#ifndef SDR_SCENE_IMPORT_H
#define SDR_SCENE_IMPORT_H

#include "scene/scene.h"
#include "scene/store.h"
#include "scene/tree.h"

enum { SDR_GROUPS_MAX = 1024 };

/* A part of the file that has a name: a set of points (a region of a table, a physical group of a
   mesh's elements), or a face (a physical group one dimension lower). */
typedef struct sdr_import_group {
  char name[SDR_NAME_MAX];
  uint8_t *holds;         /* a bit per point, in the file's order; NULL: a face */
  sdr_tree *facets;       /* edges or triangles with normals out of the body; NULL: points */
  const sdr_tree *points; /* all of the body's */
  sdr_shape shape;        /* by which places name it: SDR_GROUP or SDR_FACETS */
} sdr_import_group;

typedef struct sdr_import {
  int components;
  int32_t count;
  double *x[3];    /* m; all three, 0 beyond the components */
  double *measure; /* m, m^2 or m^3 in 1-D, 2-D, 3-D: of a mesh; else NULL */
  double *volume;  /* m^3, thickness or area included; NULL: not given */
  double *spacing; /* m; NULL: not given. One of the three is given */
  double *horizon; /* m; NULL: not given */
  int32_t *line;   /* of the file; NULL: a mesh */
  int group_count;
  sdr_import_group *group;
  sdr_tree *points;
  uint64_t hash; /* of the file's bytes, FNV-1a */
} sdr_import;

/* How a file is to be read. */
typedef struct {
  int components;
  double unit; /* m: what 1 is in the file, where it names no unit */
  int nodes;   /* mesh: points at its nodes, 0: at the centroids of its elements */
  int ignored_count;
  const char *const *ignored; /* table: columns that are left out */
} sdr_import_how;

/* Read the file. It belongs to the store. SDR_BAD_INPUT (also for a file that cannot be read): the
   message begins with FILE:LINE or FILE. */
sdr_status sdr_import_load(sdr_store *store, const char *path, const sdr_import_how *how,
                           sdr_import **out);

/* The same of `length` bytes of a table in memory; `path` stands in messages. */
sdr_status sdr_import_table(sdr_store *store, const char *path, const char *text, size_t length,
                            const sdr_import_how *how, sdr_import **out);

/* 1 if meshes can be read: Gmsh's library was there when Sunder was built, and is now. */
int sdr_import_has_gmsh(void);

/* The group of that name; NULL: none. */
sdr_import_group *sdr_import_find(const sdr_import *import, const char *name);

/* 1 if the group of points holds the point nearest to x[3]. */
int sdr_import_holds(const sdr_import_group *group, const double x[3]);

/* Spacing (m) and volume (m^3) of point i; `across` is the thickness (2-D, m), the area (1-D, m^2)
   or 1 (3-D). What the file does not give follows from the other: volume = spacing^n across. */
double sdr_import_spacing(const sdr_import *import, int32_t i, double across);
double sdr_import_volume(const sdr_import *import, int32_t i, double across);

/* For the readers: an empty group of points of that name, whose bits are set by sdr_import_put.
   NULL: memory, or too many (error record set). */
sdr_import_group *sdr_import_add_group(sdr_store *store, sdr_import *import, const char *name);
void sdr_import_put(sdr_import_group *group, int32_t point);

#endif
