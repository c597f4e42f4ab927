#include "app/check_material.h"

#include "app/constants.h"
#include "damage/bond_law.h"
#include "damage/calibration.h"
#include "damage/strength.h"
#include "output/crack_path.h"

#include <math.h>

/* ---- bond-based ------------------------------------------------------------------------------ */

/* Where the constants come from. */
static const char *source_name(sdr_calibration_kind calibration, sdr_moments_source source)
{
  if (calibration == SDR_CALIBRATE_PRINTED) return "the printed formula";
  switch (source) {
  case SDR_MOMENTS_STENCIL:
    return "family sums of the lattice's full stencil";
  case SDR_MOMENTS_MEAN:
    return "mean family sums of the points with complete families";
  default:
    return "integrals over the ball, since no family is complete";
  }
}

static void print_stiffness(const sdr_built *built, const sdr_family *family,
                            const sdr_material *material, FILE *out)
{
  const sdr_dimension dimension = built->scene->dimension;
  const double c = sdr_micromodulus(dimension, built->scene->calibration, family, material->young);
  const sdr_effective_stiffness s = sdr_stiffness_of(dimension, family, c, material->young);
  fprintf(out, "  micromodulus      %.6g N/m^6 (half), from %s\n", c,
          source_name(built->scene->calibration, family->source));
  fprintf(out, "  c11               %.5g GPa (%+.2f %%)", s.c11 * 1e-9,
          100.0 * (s.c11 / s.exact_c11 - 1.0));
  if (dimension != SDR_1D)
    fprintf(out, ", c12 %.5g GPa (%+.2f %%), shear %.5g GPa (%+.2f %%)", s.c12 * 1e-9,
            100.0 * (s.c12 / s.exact_c12 - 1.0), s.c66 * 1e-9, 100.0 * (s.c66 / s.exact_c66 - 1.0));
  fprintf(out, " of the isotropic body\n");
}

/* Strength in uniaxial tension of a homogeneous body, over directions in the plane of the lattice's
   first two axes. */
static sdr_status print_strength(const sdr_built *built, const sdr_family *family,
                                 const sdr_strength_law *law, double unit, FILE *out)
{
  const sdr_points *points = built->points;
  const char *separator = "";
  fprintf(out, "  strength          ");
  for (int degree = 0; degree <= (points->components == 1 ? 0 : 45); degree += 15) {
    const double angle = degree * 3.14159265358979323846 / 180.0;
    double n[3], stress, strain;
    for (int a = 0; a < 3; ++a)
      n[a] = cos(angle) * points->axes[0][a] + sin(angle) * points->axes[1][a];
    SDR_TRY(sdr_strength_along(built->families, family, law, n, &stress, &strain));
    fprintf(out, "%s%.4g MPa (%.3f E %s)", separator, stress * 1e-6, stress / unit,
            law->law == SDR_LAW_COHESIVE ? "s_e" : "s_c");
    separator = ", ";
  }
  fprintf(out, "%s\n", points->components == 1 ? "" : " at 0, 15, 30, 45 degrees to the lattice");
  return SDR_OK;
}

/* Constants of `cohesive` and its strength; q is s0^2. */
static sdr_status print_cohesive(const sdr_built *built, const sdr_family *family,
                                 const sdr_material *material, double c, double q, FILE *out)
{
  sdr_strength_law law = {.law = SDR_LAW_COHESIVE, .c = c};
  double beta;
  SDR_TRY(sdr_cohesive_beta(built->families, family, c, material->young, &beta));
  SDR_TRY(sdr_cohesive_constants(family->horizon, material->young, q, material->strength, beta,
                                 &law.q, &law.r));
  const double a = q / (law.q * law.q);
  fprintf(out, "  stretches         yields at s_e %.4g (beta %.4f), lost at %.4g, a = %.4g\n",
          law.q, beta, law.q * (SDR_COHESIVE_MU + SDR_COHESIVE_GAMMA / law.r), a);
  fprintf(out, "  largest horizon   %.4g mm for this strength and toughness\n",
          family->horizon * a / SDR_COHESIVE_LEAST * 1e3);
  return print_strength(built, family, &law, material->young * law.q, out);
}

/* Energy of a plane cut over directions in x-y. */
static sdr_status print_separation(const sdr_built *built, const sdr_family *family,
                                   const sdr_material *material, FILE *out)
{
  const sdr_scene *scene = built->scene;
  const sdr_damage_scene *damage = &scene->damage;
  if (damage->law == SDR_LAW_NONE) return SDR_OK;
  const double c = sdr_micromodulus(scene->dimension, scene->calibration, family, material->young);
  double q = sdr_critical_stretch_squared(scene->dimension, scene->calibration, family,
                                          material->young, material->toughness);
  double share = 1.0;
  const int has_ell = damage->law == SDR_LAW_VARIATIONAL || damage->law == SDR_LAW_AT1;
  if (has_ell)
    share = damage->ell.relative ? 1.0 / damage->ell.value : family->horizon / damage->ell.value;
  q *= share;
  double least = INFINITY, most = 0.0;
  for (int degree = 0; degree <= (scene->dimension == SDR_1D ? 0 : 45); ++degree) {
    const double angle = degree * 3.14159265358979323846 / 180.0;
    const double n[3] = {cos(angle), sin(angle), 0.0};
    double energy;
    SDR_TRY(sdr_separation_energy(built->families, family, c, q, n, &energy));
    least = fmin(least, energy);
    most = fmax(most, energy);
  }
  fprintf(out, "  %-17s %.4g\n",
          damage->law == SDR_LAW_CRITICAL_STRETCH ? "stretch s0" : "stretch s_c", sqrt(q));
  fprintf(out, "  separation        %.5g J/m^2 = toughness x %.4g; over directions %.5g to %.5g\n",
          material->toughness * share, share, least, most);
  if (damage->law == SDR_LAW_COHESIVE) return print_cohesive(built, family, material, c, q, out);
  if (!has_ell) return SDR_OK;
  const sdr_strength_law law = {(int)damage->law, c, q, 1.0};
  return print_strength(built, family, &law, material->young * sqrt(q), out);
}

static sdr_status print_bond_based(const sdr_built *built, const sdr_material *material, FILE *out)
{
  const sdr_family *family = &built->families->family[0];
  const double nu = sdr_bond_poisson(built->scene->dimension);
  if (isnan(material->poisson))
    fprintf(out, "  poisson_used      %.4g, the law's own\n", nu);
  else
    fprintf(out, "  poisson_used      %.4g, the law's own (given %g)\n", nu, material->poisson);
  print_stiffness(built, family, material, out);
  return print_separation(built, family, material, out);
}

/* ---- state-based ----------------------------------------------------------------------------- */

static void print_control(const sdr_scene *scene, const sdr_material_constants *c, FILE *out)
{
  static const char *const laws[] = {"linear", "saint_venant_kirchhoff", "neo_hookean"};
  fprintf(out, "  elasticity        %s\n", laws[scene->elasticity]);
  fprintf(out, "  control           P_s %.5g GPa%s, P_n %.5g GPa%s, of the first point\n",
          c->control_shear * 1e-9, isnan(scene->control_shear) ? "" : " (given)",
          c->control_normal * 1e-9, isnan(scene->control_normal) ? "" : " (given)");
  fprintf(out, "  shape tensors     condition up to %.4g\n", c->condition);
}

static void print_state_based(const sdr_built *built, int index, FILE *out)
{
  static const char *const forms[] = {"standard", "madenci_oterkus"};
  static const char *const splits[] = {"dilatation", "spectral"};
  const sdr_scene *scene = built->scene;
  const sdr_material_constants c = sdr_constants_of(built, index);
  if (scene->dimension != SDR_1D) fprintf(out, "  poisson           %g\n", c.poisson);
  fprintf(out, "  K, G              %.5g GPa (of %d dimensions), %.5g GPa\n", c.bulk * 1e-9,
          sdr_components(scene->dimension), c.shear * 1e-9);
  if (scene->model == SDR_ORDINARY)
    fprintf(out, "  form              %s\n", forms[scene->form]);
  else
    print_control(scene, &c, out);
  if (scene->damage.law == SDR_LAW_VARIATIONAL)
    fprintf(out, "  damage            ell %.5g m, Gc/ell %.5g J/m^3, split %s\n", c.ell,
            scene->material[index].toughness / c.ell, splits[scene->split]);
  if (scene->damage.law == SDR_LAW_CRITICAL_STRETCH)
    fprintf(out, "  %-17s %.4g\n", "stretch s0", c.critical_stretch);
}

/* Of long waves in the isotropic body. */
static void print_waves(const sdr_scene *scene, const sdr_material *material, FILE *out)
{
  const double own =
      scene->model == SDR_BOND_BASED ? sdr_bond_poisson(scene->dimension) : material->poisson;
  const double nu = scene->dimension == SDR_1D ? 0.0 : own;
  const double shear = 0.5 * material->young / (1.0 + nu);
  const double plane = scene->dimension == SDR_PLANE_STRESS ? nu * nu : 2.0 * nu * nu / (1.0 - nu);
  if (!(material->density > 0.0)) return;
  fprintf(out, "  waves             longitudinal %.4g m/s",
          sqrt(material->young / (1.0 - plane) / material->density));
  if (scene->dimension != SDR_1D)
    fprintf(out, ", shear %.4g m/s, Rayleigh %.4g m/s", sqrt(shear / material->density),
            sdr_rayleigh_speed(material->young, nu, material->density));
  fputc('\n', out);
}

/* ---- all ------------------------------------------------------------------------------------- */

static void print_weight(const sdr_scene *scene, FILE *out)
{
  static const char *const functions[] = {"constant", "inverse", "inverse_square",
                                          "linear",   "cubic",   "gaussian"};
  static const char *const corrections[] = {"", ", iso", ", surface_iso", ", madenci_oterkus"};
  fprintf(out, "weights             %s%s%s%s\n", functions[scene->weight.function],
          scene->weight.partial_volume ? ", partial_volume" : "",
          corrections[scene->weight.correction], scene->one_sided ? "; no dual horizon" : "");
}

sdr_status sdr_check_materials(const sdr_built *built, FILE *out)
{
  const sdr_scene *scene = built->scene;
  print_weight(scene, out);
  if (built->families->count > 1)
    fprintf(out, "families            %d kinds (spacing and horizon); constants of the first:\n",
            built->families->count);
  for (int m = 0; m < scene->material_count; ++m) {
    const sdr_material *material = &scene->material[m];
    fprintf(out, "material            %s: E %g GPa, density %g kg/m^3", material->name,
            material->young * 1e-9, material->density);
    if (material->scatter_young > 0.0)
      fprintf(out, ", E scattered by %g %%", 100.0 * material->scatter_young);
    fputc('\n', out);
    print_waves(scene, material, out);
    if (scene->model == SDR_BOND_BASED)
      SDR_TRY(print_bond_based(built, material, out));
    else
      print_state_based(built, m, out);
  }
  return SDR_OK;
}
