/* Points from tables and meshes: what is read, what is refused and how that is said. */
#include "support/cmocka_all.h"

#include "base/memory.h"
#include "scene/import.h"
#include "scene/mesh.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define assert_near(value, wanted)                                                                 \
  do {                                                                                             \
    const double is = (value), should = (wanted);                                                  \
    if (!(fabs(is - should) <= 1e-12 * (1e-30 + fabs(should))))                                    \
      fail_msg(#value ": %.17g, wanted %.17g", is, should);                                        \
  } while (0)

static const sdr_import_how plane = {.components = 2, .unit = 1.0};

/* ---- tables ---------------------------------------------------------------------------------- */

static sdr_import *table(sdr_store *store, const char *text, const sdr_import_how *how)
{
  sdr_import *import = NULL;
  if (sdr_import_table(store, "p.csv", text, strlen(text), how, &import) != SDR_OK)
    fail_msg("%s", sdr_error_message());
  return import;
}

static void test_a_table_gives_points_in_si_by_the_names_and_units_of_its_columns(void **state)
{
  (void)state;
  static const char *const dropped[] = {"temperature"};
  sdr_import_how how = plane;
  how.unit = 0.01;
  how.ignored = dropped;
  how.ignored_count = 1;
  sdr_store *store = sdr_store_create();
  const sdr_import *p = table(store,
                              "\xef\xbb\xbf# a comment\r\n\r\n"
                              "y [mm] ,x,temperature,volume (mm^3),horizon,region\r\n"
                              " 2,3 ,300, 8,0.5,\n"
                              "\t-1e1,0.5,n/a,1, 0.25 ,left  rim\n",
                              &how);
  assert_int_equal(p->count, 2);
  assert_near(p->x[0][0], 0.03);
  assert_near(p->x[1][0], 0.002);
  assert_near(p->x[1][1], -0.01);
  assert_near(p->x[2][1], 0.0);
  assert_near(p->volume[0], 8e-9);
  assert_near(p->horizon[1], 0.0025);
  assert_null(p->spacing);
  assert_near(sdr_import_spacing(p, 0, 2e-3), 2e-3); /* of a plate 2 mm thick */
  assert_int_equal(p->line[1], 5);
  assert_int_equal(p->group_count, 2);
  assert_string_equal(p->group[0].name, "left");
  assert_int_equal(p->group[1].holds[0], 2);
  sdr_store_destroy(&store);
}

static void test_volume_follows_from_spacing(void **state)
{
  (void)state;
  const sdr_import_how how[3] = {{.components = 1, .unit = 1}, plane, {.components = 3, .unit = 1}};
  static const char *const text[3] = {"x,spacing\n0,0.5\n", "x,y,spacing\n0,0,0.5\n",
                                      "x,y,z,spacing\n0,0,0,0.5\n"};
  static const double volume[3] = {1.5, 0.75, 0.125};
  for (int k = 0; k < 3; ++k) {
    sdr_store *store = sdr_store_create();
    assert_near(sdr_import_volume(table(store, text[k], &how[k]), 0, k < 2 ? 3.0 : 1.0), volume[k]);
    sdr_store_destroy(&store);
  }
}

static void test_what_is_wrong_with_a_table_is_said_with_its_line(void **state)
{
  (void)state;
  static const char *const cases[][2] = {
      {"", "p.csv:1: the file is empty; its first line names the columns"},
      {"x,y\n1,2\n", "p.csv:1: there is no column 'volume' or 'spacing'; give one"},
      {"x,spacing\n1,2\n", "p.csv:1: there is no column 'y'; give it in the first line"},
      {"x,y,z,spacing\n", "p.csv:1: unknown column 'z'; columns here: x, y, volume, spacing, "
                          "horizon, region, with commas between them; name what is to be left out "
                          "in points.import.ignore"},
      {"x,y,x,spacing\n", "p.csv:1: two columns 'x'; leave one"},
      {"x [MPa],y,spacing\n",
       "p.csv:1: column 'x' is a pressure, wanted a length; write it as in 'x [mm]'"},
      {"x [foo],y,spacing\n",
       "p.csv:1: column 'x': no unit is known by 'foo]'; write it as in 'x [mm]'"},
      {"x,y,spacing\n", "p.csv:1: the table names columns and has no row; give points"},
      {"\nx,y,spacing\n\n1,2\n", "p.csv:4: 2 values, the first line names 3 columns; give each row "
                                 "a value for each"},
      {"x,y,spacing\n1,2,3,4\n", "p.csv:2: 4 values, the first line names 3 columns; give each row "
                                 "a value for each"},
      {"x,y,spacing\n1,2,3\n1,two,3\n",
       "p.csv:3: column 'y': 'two' is no number; give one, like 1.5e-3"},
      {"x,y,spacing\n1,,3\n", "p.csv:2: column 'y': '' is no number; give one, like 1.5e-3"},
      {"x,y,spacing\n1,nan,3\n", "p.csv:2: column 'y': 'nan' is no number; give one, like 1.5e-3"},
      {"x,y,spacing\n1,2,0\n", "p.csv:2: column 'spacing': 0 is out of range; allowed: above 0"},
      {"x,y,volume\n1,2,-3\n", "p.csv:2: column 'volume': -3 is out of range; allowed: above 0"},
      {"x,y,spacing,region\n1,2,3,body\n",
       "p.csv:2: 'body' is no name for a region; allowed: letters, digits, _ and -, but not body "
       "or all"},
      {"x,y,spacing,region\n1,2,3,a.b\n",
       "p.csv:2: 'a.b' is no name for a region; allowed: letters, digits, _ and -, but not body "
       "or all"},
  };
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    sdr_store *store = sdr_store_create();
    sdr_import *import;
    assert_int_equal(
        sdr_import_table(store, "p.csv", cases[k][0], strlen(cases[k][0]), &plane, &import),
        SDR_BAD_INPUT);
    assert_string_equal(sdr_error_message(), cases[k][1]);
    sdr_store_destroy(&store);
  }
}

/* ---- files ----------------------------------------------------------------------------------- */

/* A file in a folder of its own; the caller removes it. */
static void write_file(char path[64], const char *name, const char *text)
{
  char folder[] = "/tmp/sunder_import_XXXXXX";
  assert_non_null(mkdtemp(folder));
  snprintf(path, 64, "%s/%s", folder, name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
}

static void remove_file(char path[64])
{
  unlink(path);
  *strrchr(path, '/') = '\0';
  rmdir(path);
}

static void refuse_file(const char *name, const char *text, const char *message)
{
  char path[64];
  write_file(path, name, text);
  sdr_store *store = sdr_store_create();
  sdr_import *import;
  assert_int_equal(sdr_import_load(store, path, &plane, &import), SDR_BAD_INPUT);
  const char *said = sdr_error_message();
  assert_memory_equal(said, path, strlen(path));
  assert_string_equal(said + strlen(path), message);
  sdr_store_destroy(&store);
  remove_file(path);
}

static void test_files_that_hold_no_body_are_refused(void **state)
{
  (void)state;
  refuse_file("p.txt", "x",
              ": what the file holds is told by the end of its name: .csv for a table of points, "
              ".msh for a mesh of Gmsh");
  refuse_file("p.csv", "x,y,spacing\n0,0,1\n1,0,1\n0,0,1\n",
              ":4: the point lies where that of line 2 does, at (0, 0, 0) m; remove one of them");
  refuse_file("p.msh", "SystemCall \"true\";\n",
              ":1: the file does not begin with $MeshFormat: it is no mesh of Gmsh; save it by "
              "`gmsh -2 PART.geo -o PART.msh`");
  refuse_file("p.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n",
              ": there is no $EndNodes: the file is cut off or holds no mesh; save it again");
}

/* With Gmsh's library an empty mesh is told from a whole one, without it what to install is said.
 */
static void test_a_mesh_is_read_through_gmsh_or_it_is_said_what_is_missing(void **state)
{
  (void)state;
  const char *message =
      ": this build of Sunder cannot read meshes: Gmsh's library was missing; install it (Debian: "
      "apt-get install libgmsh-dev), remove the build folder and build again";
  refuse_file("p.msh",
              "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n0 0 0 0\n$EndNodes\n"
              "$Elements\n0 0 0 0\n$EndElements\n",
              sdr_import_has_gmsh() ? ": 0 nodes; allowed: 1 to 2147483639" : message);
}

static uint64_t hash_of(const char *name, const char *text)
{
  char path[64];
  write_file(path, name, text);
  sdr_scene *scene = NULL;
  char yaml[512];
  snprintf(yaml, sizeof yaml,
           "dimension: plane_stress\npoints: {import: %s}\nmaterial: {young: 1 Pa, density: 1 "
           "kg/m^3}\ntime: {end: 1 s}\n",
           path);
  if (sdr_scene_parse(yaml, "s", &scene) != SDR_OK) fail_msg("%s", sdr_error_message());
  const uint64_t hash = scene->hash;
  sdr_scene_destroy(&scene);
  remove_file(path);
  return hash;
}

static void test_a_scenes_hash_tells_what_the_file_holds_and_not_where_it_lies(void **state)
{
  (void)state;
  const uint64_t one = hash_of("a.csv", "x,y,spacing\n0,0,1\n1,0,1\n");
  assert_true(one == hash_of("b.csv", "x,y,spacing\n0,0,1\n1,0,1\n"));
  assert_true(one != hash_of("a.csv", "x,y,spacing\n0,0,1\n1,0,1.0\n"));
}

/* ---- scenes ---------------------------------------------------------------------------------- */

#define TABLE "x,y,spacing,region\n0,0,1,\n1,0,1,end\n2,0,1,end tip\n"

static void refuse_scene(const char *points, const char *rest, const char *message)
{
  char path[64], yaml[1024];
  sdr_scene *scene = NULL;
  write_file(path, "p.csv", TABLE);
  snprintf(yaml, sizeof yaml,
           "dimension: plane_stress\nmaterial: {young: 1 Pa, density: 1 kg/m^3}\n"
           "time: {end: 1 s}\npoints: {import: %s%s}\n%s\n",
           path, points, rest);
  assert_int_equal(sdr_scene_parse(yaml, "s", &scene), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), message);
  remove_file(path);
}

static void test_scenes_that_misname_imported_places_are_told_what_there_is(void **state)
{
  (void)state;
  refuse_scene(", spacing: 1 m", "",
               "s:4:51: points.spacing is for lattices, and these points are imported; remove one "
               "of the two keys (in a variant: spacing: null)");
  refuse_scene("", "supports: [{on: ende, velocity: {x: 0}}]",
               "s:5:17: unknown place 'ende'; allowed: body, a shape, a region: end, tip");
  refuse_scene("", "loads: [{pressure: {on: end, value: 1 Pa}}]",
               "s:5:25: loads.0.pressure.on: 'end' is a volume, a face is wanted; it has none with "
               "a name");
  refuse_scene("", "regions: {tip: {disc: {radius: 1 m}}}",
               "s:5:11: 'tip' is a group of the imported file too; give the region another name");
  refuse_scene("", "supports: [{on: body.left, velocity: {x: 0}}]",
               "s:5:17: 'body.left': an imported body has the faces that its file names only");
}

static void test_groups_of_a_table_are_regions(void **state)
{
  (void)state;
  char path[64], yaml[512];
  sdr_scene *scene = NULL;
  write_file(path, "p.csv", TABLE);
  snprintf(yaml, sizeof yaml,
           "dimension: plane_stress\nmaterial: {young: 1 Pa, density: 1 kg/m^3}\n"
           "time: {end: 1 s}\npoints: {import: %s}\n"
           "regions: {start: {difference: [end, tip]}}\n"
           "supports: [{on: tip, velocity: {x: 0}}]\n",
           path);
  if (sdr_scene_parse(yaml, "s", &scene) != SDR_OK) fail_msg("%s", sdr_error_message());
  const sdr_shape *tip = scene->support[0].on.shape;
  assert_int_equal(tip->kind, SDR_GROUP);
  assert_true(sdr_import_holds(tip->group, (double[3]){2, 0, 0}));
  assert_false(sdr_import_holds(tip->group, (double[3]){1, 0, 0}));
  assert_near(scene->points.spacing, 1.0);
  sdr_scene_destroy(&scene);
  remove_file(path);
}

static void test_a_mapping_says_unit_and_columns_to_leave_out(void **state)
{
  (void)state;
  char path[64], yaml[512];
  sdr_scene *scene = NULL;
  write_file(path, "p.csv", TABLE);
  snprintf(yaml, sizeof yaml,
           "dimension: plane_stress\nmaterial: {young: 1 Pa, density: 1 kg/m^3}\n"
           "time: {end: 1 s}\npoints: {import: {file: %s, unit: 1 mm, ignore: [region]}}\n",
           path);
  if (sdr_scene_parse(yaml, "s", &scene) != SDR_OK) fail_msg("%s", sdr_error_message());
  assert_near(scene->points.imported->x[0][2], 2e-3);
  assert_near(scene->points.spacing, 1e-3);
  assert_int_equal(scene->points.imported->group_count, 0);
  assert_non_null(strstr(scene->used_yaml, path)); /* so that the copy in a run's folder works */
  sdr_scene_destroy(&scene);
  remove_file(path);
}

static void test_a_column_of_horizons_takes_the_place_of_the_scenes(void **state)
{
  (void)state;
  static const char *const keys[] = {"", "horizon: 3 m\n"};
  char path[64], yaml[512];
  write_file(path, "p.csv", "x,y,spacing,horizon\n0,0,1,3\n1,0,1,4\n");
  for (int k = 0; k < 2; ++k) {
    sdr_scene *scene = NULL;
    snprintf(yaml, sizeof yaml,
             "dimension: plane_stress\nmaterial: {young: 1 Pa, density: 1 kg/m^3}\n"
             "time: {end: 1 s}\n%spoints: {import: %s}\n",
             keys[k], path);
    const sdr_status status = sdr_scene_parse(yaml, "s", &scene);
    assert_int_equal(status, k ? SDR_BAD_INPUT : SDR_OK);
    if (k)
      assert_string_equal(sdr_error_message(),
                          "s:4:1: the imported file has a column 'horizon'; remove this key, or "
                          "name the column in points.import.ignore");
    else
      assert_near(scene->points.imported->horizon[1], 4.0);
    sdr_scene_destroy(&scene);
  }
  remove_file(path);
}

/* ---- meshes ---------------------------------------------------------------------------------- */

/* Two triangles and a quadrilateral along x, 1 m high; the left edge and the elements have names.

     3---4---5
     | / |   |
     0---1---2 */
static double grid[6][3] = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {0, 1, 0}, {1, 1, 0}, {3, 1, 0}};
static sdr_mesh_element elements[] = {
    {2, 3, {0, 1, 4}}, {2, 3, {0, 4, 3}}, {2, 4, {1, 2, 5, 4}}, {1, 2, {3, 0}}, {1, 2, {2, 5}}};
static sdr_mesh_entity entities[] = {{2, 0, 2}, {2, 2, 3}, {1, 3, 4}, {1, 4, 5}};
static int triangles[] = {0}, both[] = {2, 3};
static sdr_mesh_group groups[] = {{"triangles", 2, 1, triangles}, {"sides", 1, 2, both}};

static sdr_mesh strip(void)
{
  return (sdr_mesh){.node_count = 6,
                    .x = &grid[0][0],
                    .element_count = 5,
                    .element = elements,
                    .entity_count = 4,
                    .entity = entities,
                    .group_count = 2,
                    .group = groups};
}

static void
test_a_mesh_gives_points_at_centroids_or_nodes_with_the_volume_of_its_elements(void **state)
{
  (void)state;
  const sdr_mesh mesh = strip();
  sdr_import_how how = {.components = 2, .unit = 0.1};
  sdr_store *store = sdr_store_create();
  sdr_import *at = NULL;
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_OK);
  assert_int_equal(at->count, 3);
  assert_near(at->measure[0], 0.005);
  assert_near(at->measure[2], 0.02);
  assert_near(at->x[0][0], 0.2 / 3);
  assert_near(at->x[0][2], 0.2);
  assert_int_equal(at->group[0].holds[0], 3);
  how.nodes = 1;
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_OK);
  assert_int_equal(at->count, 6);
  assert_near(at->measure[0], 0.01 / 3);
  assert_near(at->measure[1], 0.005 / 3 + 0.005);
  assert_int_equal(at->group[0].holds[0], 1 + 2 + 8 + 16);
  sdr_store_destroy(&store);
}

static void test_faces_of_a_mesh_have_normals_out_of_the_body(void **state)
{
  (void)state;
  const sdr_mesh mesh = strip();
  const sdr_import_how how = {.components = 2, .unit = 1.0};
  sdr_store *store = sdr_store_create();
  sdr_import *at = NULL;
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_OK);
  const sdr_tree *sides = at->group[1].facets;
  assert_null(at->group[1].holds);
  assert_int_equal(sides->count, 2);
  for (int k = 0; k < 2; ++k) {
    assert_near(sides->normal[3 * k], sides->piece[6 * k] > 1.0 ? 1.0 : -1.0);
    assert_near(sides->normal[3 * k + 1], 0.0);
  }
  assert_near(sdr_tree_nearest(sides, (double[3]){2.5, 0.5, 0}, NULL), 0.5);
  assert_near(sdr_tree_nearest(sides, (double[3]){4, 2, 0}, NULL), sqrt(2.0));
  sdr_store_destroy(&store);
}

static void test_meshes_that_make_no_body_are_refused(void **state)
{
  (void)state;
  sdr_mesh mesh = strip();
  sdr_import_how how = {.components = 3, .unit = 1.0};
  sdr_store *store = sdr_store_create();
  sdr_import *at = NULL;
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "p: the mesh holds no tetrahedra or other solid elements, of which a body in "
                      "3 dimensions is made; mesh it in that dimension");
  how.components = 2;
  grid[3][2] = 0.5;
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "p: the mesh does not lie in the x-y plane: z is 0 m at one node and 0.5 m "
                      "at another; choose another dimension or mesh");
  grid[3][2] = 0.0;
  elements[4].corner[1] = 3; /* an edge of no element */
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "p: the group 'sides' holds a face at (3, 0, 0) m that belongs to no element "
                      "of the body; mend the mesh");
  elements[4].corner[1] = 5;
  grid[4][0] = 0.5, grid[4][1] = 0.0; /* the first triangle has no area */
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "p: the element at (0.5, 0, 0) m has no volume; mend the mesh");
  grid[4][0] = 1.0, grid[4][1] = 1.0;
  sdr_store_destroy(&store);
}

static void test_solid_elements_measure_what_they_should(void **state)
{
  (void)state;
  static const double x[8][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0},
                                 {0, 0, 3}, {2, 0, 3}, {2, 1, 3}, {0, 1, 3}};
  const sdr_mesh_element hexahedron = {3, 8, {0, 1, 2, 3, 4, 5, 6, 7}};
  const sdr_mesh_element prism = {3, 6, {0, 1, 3, 4, 5, 7}};
  const sdr_mesh_element pyramid = {3, 5, {0, 1, 2, 3, 4}};
  const sdr_mesh_element tetrahedron = {3, 4, {0, 1, 3, 4}};
  double middle[3];
  assert_near(sdr_mesh_measure(&x[0][0], &hexahedron, middle), 6.0);
  assert_near(middle[2], 1.5);
  assert_near(sdr_mesh_measure(&x[0][0], &prism, middle), 3.0);
  assert_near(middle[0], 2.0 / 3.0);
  assert_near(middle[2], 1.5);
  assert_near(sdr_mesh_measure(&x[0][0], &pyramid, middle), 2.0);
  assert_near(middle[2], 0.75);
  assert_near(sdr_mesh_measure(&x[0][0], &tetrahedron, middle), 1.0);
  assert_near(middle[1], 0.25);
}

static void test_elements_that_a_file_repeats_count_once(void **state)
{
  (void)state;
  sdr_mesh_element list[] = {{2, 3, {9, 9, 9}},    {2, 3, {9, 9, 9}}, {2, 3, {0, 1, 4}},
                             {2, 4, {0, 1, 4, 3}}, {2, 3, {4, 0, 1}}, {2, 3, {0, 1, 3}},
                             {2, 4, {0, 1, 4, 3}}};
  sdr_mesh mesh = {.element_count = 7, .element = list};
  assert_int_equal(sdr_mesh_drop_doubles(&mesh, 2), SDR_OK);
  assert_int_equal(mesh.element_count, 5);
  assert_int_equal(list[2].corner[0], 0);
  assert_int_equal(list[3].corners, 4);
  assert_int_equal(list[4].corner[2], 3);
}

/* A cube of one hexahedron: its top is one quadrilateral, so two triangles. */
static void test_faces_of_solid_elements_are_triangles_with_normals_out_of_the_body(void **state)
{
  (void)state;
  static double x[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                           {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  sdr_mesh_element list[] = {{3, 8, {0, 1, 2, 3, 4, 5, 6, 7}}, {2, 4, {4, 7, 6, 5}}};
  sdr_mesh_entity parts[] = {{3, 0, 1}, {2, 1, 2}};
  int second[] = {1};
  sdr_mesh_group top[] = {{"top", 2, 1, second}};
  const sdr_mesh mesh = {8, &x[0][0], 2, list, 2, parts, 1, top};
  const sdr_import_how how = {.components = 3, .unit = 1.0};
  sdr_store *store = sdr_store_create();
  sdr_import *at = NULL;
  assert_int_equal(sdr_mesh_points(store, "p", &mesh, &how, &at), SDR_OK);
  const sdr_tree *facets = at->group[0].facets;
  assert_int_equal(facets->count, 2);
  for (int k = 0; k < 2; ++k) assert_near(facets->normal[3 * k + 2], 1.0);
  assert_near(sdr_tree_nearest(facets, (double[3]){0.3, 0.9, 0.5}, NULL), 0.5);
  sdr_store_destroy(&store);
}

/* ---- the tree -------------------------------------------------------------------------------- */

static void test_the_tree_finds_what_a_search_of_all_finds(void **state)
{
  (void)state;
  enum { PIECES = 203, PLACES = 100 };
  for (int corners = 1; corners <= 3; ++corners) {
    static double piece[9 * PIECES];
    sdr_store *store = sdr_store_create();
    sdr_tree *tree = NULL, *single = NULL;
    unsigned seed = 7;
    for (int k = 0; k < 9 * PIECES; ++k) piece[k] = rand_r(&seed) / (double)RAND_MAX;
    assert_int_equal(sdr_tree_create(store, corners, PIECES, piece, NULL, &tree), SDR_OK);
    for (int place = 0; place < PLACES; ++place) {
      double x[3], best = HUGE_VAL;
      int32_t nearest = -1;
      for (int c = 0; c < 3; ++c) x[c] = 2.0 * rand_r(&seed) / RAND_MAX - 0.5;
      for (int k = 0; k < PIECES && place < 20; ++k) { /* trees of one piece do not search */
        assert_int_equal(sdr_tree_create(store, corners, 1, piece + 3 * corners * k, NULL, &single),
                         SDR_OK);
        best = fmin(best, sdr_tree_nearest(single, x, NULL));
      }
      const double found = sdr_tree_nearest(tree, x, &nearest);
      assert_in_range(nearest, 0, PIECES - 1);
      if (place < 20) assert_near(found, best);
    }
    sdr_store_destroy(&store);
  }
}

static void test_distances_from_triangles_are_to_plane_edge_or_corner(void **state)
{
  (void)state;
  static const double t[9] = {0, 0, 0, 4, 0, 0, 0, 4, 0};
  static const double cases[][4] = {
      {1, 1, 2, 2}, {2, -3, 0, 3}, {-3, -4, 0, 5}, {4, 4, 0, 2.8284271247461903}, {7, -4, 0, 5}};
  sdr_store *store = sdr_store_create();
  sdr_tree *tree = NULL;
  assert_int_equal(sdr_tree_create(store, 3, 1, t, NULL, &tree), SDR_OK);
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k)
    assert_near(sdr_tree_nearest(tree, cases[k], NULL), cases[k][3]);
  sdr_store_destroy(&store);
}

static void test_memory_that_runs_out_leaves_nothing_behind(void **state)
{
  (void)state;
  char path[64];
  write_file(path, "p.csv", TABLE);
  const size_t before = sdr_memory_now();
  sdr_status status = SDR_RUN_FAILED;
  for (int allowed = 0; status != SDR_OK; ++allowed) {
    sdr_store *store = sdr_store_create();
    sdr_import *import;
    sdr_memory_fail_after(allowed);
    status = sdr_import_load(store, path, &plane, &import);
    sdr_memory_fail_after(-1);
    assert_true(status == SDR_OK || status == SDR_RUN_FAILED);
    assert_in_range(allowed, 0, 100);
    sdr_store_destroy(&store);
  }
  assert_int_equal(sdr_memory_now(), before);
  remove_file(path);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_table_gives_points_in_si_by_the_names_and_units_of_its_columns),
      cmocka_unit_test(test_volume_follows_from_spacing),
      cmocka_unit_test(test_what_is_wrong_with_a_table_is_said_with_its_line),
      cmocka_unit_test(test_files_that_hold_no_body_are_refused),
      cmocka_unit_test(test_a_mesh_is_read_through_gmsh_or_it_is_said_what_is_missing),
      cmocka_unit_test(test_a_scenes_hash_tells_what_the_file_holds_and_not_where_it_lies),
      cmocka_unit_test(test_scenes_that_misname_imported_places_are_told_what_there_is),
      cmocka_unit_test(test_groups_of_a_table_are_regions),
      cmocka_unit_test(test_a_mapping_says_unit_and_columns_to_leave_out),
      cmocka_unit_test(test_a_column_of_horizons_takes_the_place_of_the_scenes),
      cmocka_unit_test(
          test_a_mesh_gives_points_at_centroids_or_nodes_with_the_volume_of_its_elements),
      cmocka_unit_test(test_faces_of_a_mesh_have_normals_out_of_the_body),
      cmocka_unit_test(test_meshes_that_make_no_body_are_refused),
      cmocka_unit_test(test_solid_elements_measure_what_they_should),
      cmocka_unit_test(test_elements_that_a_file_repeats_count_once),
      cmocka_unit_test(test_faces_of_solid_elements_are_triangles_with_normals_out_of_the_body),
      cmocka_unit_test(test_the_tree_finds_what_a_search_of_all_finds),
      cmocka_unit_test(test_distances_from_triangles_are_to_plane_edge_or_corner),
      cmocka_unit_test(test_memory_that_runs_out_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
