/* Bodies from files behave as the same points made by a lattice do. */
#include "support/scene_text.h"

#include "scene/import.h"

/* A plate with a hole under pressure, with a crack, a clamped part that moves, a stronger part and
   a velocity to begin with; `tip` and `hard` are regions. */
static const char *const plate =
    "dimension: plane_stress\n"
    "points: {%s, thickness: 2 mm}\n"
    "family: {calibration: printed}\n" /* no means over families: those count surfaces otherwise */
    "materials:\n"
    "  - {young: 70 GPa, density: 2500 kg/m^3, toughness: 0.5 J/m^2}\n"
    "  - {name: hard, where: %s, young: 140 GPa, density: 2500 kg/m^3, toughness: 5 J/m^2}\n"
    "damage: {law: variational, protect: [%s]}\n"
    "cracks: [{segment: {from: [9.5 mm, 5 mm], to: [9.5 mm, 9.5 mm]}}]\n"
    "regions: {bore: {disc: {centre: [10 mm, 20 mm], radius: 4 mm}},\n"
    "  sheet: {box: {from: [-0.5 mm, -0.5 mm], to: [20.5 mm, 40.5 mm]}}%s}\n"
    "loads: [{pressure: {on: bore.rim, value: 60 MPa}}, {traction: {on: sheet.top, value: [0, 10 "
    "MPa]}}]\n"
    "initial: {velocity: [{on: %s, value: [1 m/s, 0]}]}\n"
    "supports: [{on: %s, velocity: {y: -2 m/s}}]\n"
    "time: {step: 0.1 us, end: 20 us}\n";

#define END "{box: {from: [-1 mm, -1 mm], to: [21 mm, 3 mm]}}"
#define CORE "{box: {from: [-1 mm, 27.5 mm], to: [21 mm, 33.5 mm]}}"

static void near(double value, double wanted, double tolerance)
{
  if (!(fabs(value - wanted) <= tolerance)) fail_msg("%.17g is not %.17g", value, wanted);
}

static void build_lattice(sdr_built *out)
{
  scene_build(out, plate, "shape: {difference: [sheet, bore]}, spacing: 1 mm", "core", "end",
              ", end: " END ", core: " CORE, "core", "end");
}

/* The lattice's points as a table in any order, with the regions that shapes name there. */
static void build_table(const sdr_points *points, sdr_built *out)
{
  char path[] = "/tmp/sunder_verify_XXXXXX.csv", text[100];
  const int descriptor = mkstemps(path, 4);
  assert_true(descriptor >= 0);
  FILE *file = fdopen(descriptor, "w");
  fputs("x,y,spacing [mm],region\n", file);
  for (int32_t k = points->count - 1; k >= 0; --k) {
    const double y = points->x[1][k];
    fprintf(file, "%.17g,%.17g,1,%s %s\n", points->x[0][k], y, y <= 3e-3 ? "end" : "",
            y > 27.5e-3 && y < 33.5e-3 ? "core" : "");
  }
  fclose(file);
  snprintf(text, sizeof text, "import: %s", path);
  scene_build(out, plate, text, "core", "end", "", "core", "end");
  unlink(path);
}

static void the_same_points_from_a_table_move_and_break_as_the_lattice_does(void **state)
{
  (void)state;
  sdr_built lattice, table;
  sdr_balance a, b;
  build_lattice(&lattice);
  build_table(lattice.points, &table);
  assert_int_equal(table.points->count, lattice.points->count);
  assert_int_equal(table.bonds->directed, lattice.bonds->directed);
  assert_int_equal(table.bonds->loose_pairs, table.bonds->pairs);
  assert_int_equal(table.cut_bonds, lattice.cut_bonds);
  run_start(&lattice);
  run_start(&table);
  for (int n = 0; n < 200; ++n) {
    run_step(&lattice);
    run_step(&table);
  }
  sdr_system_balance(lattice.system, &a);
  sdr_system_balance(table.system, &b);
  assert_true(a.model.max_damage > 0.3 && a.model.dissipated > 0.01 * a.model.stored);
  near(b.kinetic, a.kinetic, 1e-6 * a.kinetic);
  near(b.model.stored, a.model.stored, 1e-6 * a.model.stored);
  near(b.model.dissipated, a.model.dissipated, 1e-6 * a.model.dissipated);
  near(table.system->external_work, lattice.system->external_work,
       1e-6 * fabs(lattice.system->external_work));
  sdr_built_destroy(&lattice);
  sdr_built_destroy(&table);
}

/* ---- the mesh of problems/hole_plate --------------------------------------------------------- */

static const sdr_import *load(sdr_store *store, const char *name, int nodes)
{
  char path[512];
  const sdr_import_how how = {.components = 2, .unit = 1e-3, .nodes = nodes};
  sdr_import *import;
  snprintf(path, sizeof path, "%s/problems/hole_plate/%s", SUNDER_SOURCE_DIR, name);
  if (sdr_import_load(store, path, &how, &import) != SDR_OK) fail_msg("%s", sdr_error_message());
  return import;
}

static double area_of(const sdr_import *import)
{
  double sum = 0.0;
  for (int32_t i = 0; i < import->count; ++i) sum += sdr_import_volume(import, i, 1.0);
  return sum;
}

static void the_table_of_hole_plate_holds_the_centroids_of_its_mesh(void **state)
{
  (void)state;
  if (!sdr_import_has_gmsh()) skip();
  sdr_store *store = sdr_store_create();
  const sdr_import *mesh = load(store, "plate.msh", 0), *table = load(store, "points.csv", 0);
  const sdr_import_group *around = sdr_import_find(mesh, "around_hole");
  assert_int_equal(mesh->count, table->count);
  near(area_of(mesh), area_of(table), 1e-7 * area_of(mesh));
  for (int32_t i = 0; i < mesh->count; ++i) {
    for (int c = 0; c < 2; ++c) near(mesh->x[c][i], table->x[c][i], 1e-8);
    const double x[3] = {table->x[0][i], table->x[1][i], 0.0};
    assert_int_equal(sdr_import_holds(around, x), hypot(x[0], x[1]) < 15e-3);
  }
  sdr_store_destroy(&store);
}

static void nodes_of_a_mesh_share_its_area_and_faces_its_length(void **state)
{
  (void)state;
  if (!sdr_import_has_gmsh()) skip();
  sdr_store *store = sdr_store_create();
  const sdr_import *mesh = load(store, "plate.msh", 1);
  const sdr_tree *hole = sdr_import_find(mesh, "hole")->facets;
  double length = 0.0;
  near(area_of(mesh), area_of(load(store, "plate.msh", 0)), 1e-12 * area_of(mesh));
  for (int32_t k = 0; k < hole->count; ++k) {
    const double *edge = hole->piece + 6 * k, *n = hole->normal + 3 * k;
    length += hypot(edge[3] - edge[0], edge[4] - edge[1]);
    assert_true(n[0] * edge[0] + n[1] * edge[1] < 0.0); /* into the hole */
  }
  near(length, 2.0 * 3.14159265358979324 * 5e-3, 2e-5);
  sdr_store_destroy(&store);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_same_points_from_a_table_move_and_break_as_the_lattice_does),
      cmocka_unit_test(the_table_of_hole_plate_holds_the_centroids_of_its_mesh),
      cmocka_unit_test(nodes_of_a_mesh_share_its_area_and_faces_its_length),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
