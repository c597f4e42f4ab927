/* A program outside the tree: a cylinder under pressure from text, run without any file. */
#include <stdio.h>
#include <sunder.h>

static const char text[] =
    "dimension: plane_stress\n"
    "points:\n"
    "  shape: {annulus: {inner: 80 mm, outer: 150 mm}}\n"
    "  spacing: 4 mm\n"
    "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2}\n"
    "damage: {law: variational}\n"
    "loads:\n"
    "  - pressure: {on: inner, value: 400 MPa * exp(-t/(100 us))}\n"
    "time: {end: 50 us}\n";

static sdr_status run(sdr_built *cylinder)
{
  SDR_TRY(sdr_built_start(cylinder));
  while (!sdr_built_is_over(cylinder)) SDR_TRY(sdr_built_step(cylinder));
  return SDR_OK;
}

int main(void)
{
  sdr_scene *scene = NULL;
  sdr_built cylinder = {0};
  sdr_balance now = {0};
  sdr_status status = sdr_scene_parse(text, "cylinder", &scene);
  if (status == SDR_OK) status = sdr_build_scene(&scene, &cylinder);
  if (status == SDR_OK) status = run(&cylinder);
  if (status == SDR_OK) {
    sdr_system_balance(cylinder.system, &now);
    const double energy = now.kinetic + now.model.stored + now.model.dissipated;
    printf("%d points: kinetic %g J, stored %g J, dissipated %g J, work %g J, imbalance %.1e\n",
           cylinder.system->count, now.kinetic, now.model.stored, now.model.dissipated,
           cylinder.system->external_work, energy / cylinder.system->external_work - 1.0);
  } else {
    fprintf(stderr, "%s\n", sdr_error_message());
  }
  sdr_built_destroy(&cylinder);
  return (int)status;
}
