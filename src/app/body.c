#include "app/body.h"

#include "base/memory.h"
#include "mechanics/bond_based.h"
#include "mechanics/state_based.h"
#include "time/integrator.h"

#include <gsl/gsl_rng.h>
#include <math.h>
#include <string.h>

/* Young's modulus of each point; random numbers are drawn in the order of generation, one stream a
   material, so that they do not depend on how points are stored. */
sdr_status sdr_body_young(const sdr_scene *scene, const sdr_points *points, double *young)
{
  int32_t *stored = sdr_alloc((size_t)points->count, sizeof *stored); /* by order of generation */
  if (!stored) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i)
    stored[points->generated ? points->generated[i] : i] = i;
  sdr_status status = SDR_OK;
  for (int m = 0; m < scene->material_count && status == SDR_OK; ++m) {
    const sdr_material *material = &scene->material[m];
    gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
    if (!random) status = sdr_fail(SDR_RUN_FAILED, "out of memory: no random numbers");
    if (random) gsl_rng_set(random, (unsigned long)material->scatter_seed);
    for (int32_t k = 0; random && k < points->count; ++k) {
      const int32_t i = stored[k];
      if (points->material[i] != m) continue;
      const double noise =
          material->scatter_young > 0.0 ? 2.0 * gsl_rng_uniform(random) - 1.0 : 0.0;
      young[i] = material->young * (1.0 + material->scatter_young * noise);
    }
    if (random) gsl_rng_free(random);
  }
  sdr_free(stored);
  return status;
}

/* ---- families and bonds ---------------------------------------------------------------------- */

/* By default bodies at rest: waves pass a border of plain weights with a smaller echo. */
static int balances_borders(const sdr_scene *scene)
{
  const int is_static = strcmp(scene->time.integrator, "static") == 0;
  if (scene->model != SDR_BOND_BASED || scene->one_sided) return 0;
  return scene->balance == SDR_BORDER_AUTO ? is_static : scene->balance == SDR_BORDER_BALANCED;
}

static sdr_families_how families_how(const sdr_scene *scene)
{
  static const sdr_influence influences[] = {[SDR_WEIGHT_CONSTANT] = SDR_INFLUENCE_CONSTANT,
                                             [SDR_WEIGHT_INVERSE] = SDR_INFLUENCE_INVERSE,
                                             [SDR_WEIGHT_INVERSE_SQUARE] =
                                                 SDR_INFLUENCE_INVERSE_SQUARE,
                                             [SDR_WEIGHT_LINEAR] = SDR_INFLUENCE_LINEAR,
                                             [SDR_WEIGHT_CUBIC] = SDR_INFLUENCE_CUBIC,
                                             [SDR_WEIGHT_GAUSSIAN] = SDR_INFLUENCE_GAUSSIAN};
  static const sdr_correction corrections[] = {
      [SDR_CORRECT_NOTHING] = SDR_CORRECTION_NONE,
      [SDR_CORRECT_ISO] = SDR_CORRECTION_ISO,
      [SDR_CORRECT_SURFACE_ISO] = SDR_CORRECTION_SURFACE_ISO,
      [SDR_CORRECT_MADENCI_OTERKUS] = SDR_CORRECTION_MADENCI_OTERKUS};
  const sdr_weight *weight = &scene->weight;
  return (sdr_families_how){.influence = influences[weight->function],
                            .partial_volume = weight->partial_volume,
                            .correction = corrections[weight->correction],
                            .state_based = scene->model != SDR_BOND_BASED,
                            .balance = balances_borders(scene),
                            .printed = scene->calibration == SDR_CALIBRATE_PRINTED};
}

/* Families and bonds fail for bad horizons only, and do not know the scene. */
static sdr_status make_bonds(const sdr_scene *scene, const sdr_points *points,
                             sdr_families **families, sdr_bonds **bonds)
{
  const sdr_families_how how = families_how(scene);
  sdr_status status = sdr_families_create(points, &how, families);
  if (status == SDR_OK) {
    const sdr_bonds_how bonds_how = {.weight = sdr_families_weight,
                                     .context = *families,
                                     .bulk = (*families)->bulk,
                                     .border = (*families)->border,
                                     .levels = scene->model == SDR_BOND_BASED,
                                     .one_sided = scene->one_sided,
                                     .in_order = scene->model == SDR_NONORDINARY};
    status = sdr_bonds_create(points, &bonds_how, bonds);
  }
  if (status != SDR_BAD_INPUT) return status;
  return sdr_fail(SDR_BAD_INPUT, "%s: %s", sdr_origin_text(scene->horizon_origin),
                  sdr_error_message());
}

/* ---- models ---------------------------------------------------------------------------------- */

/* What a model is made from; values a material index. */
typedef struct {
  const sdr_scene *scene;
  const sdr_points *points;
  const sdr_families *families;
  const double *young; /* Pa, a point */
  const double *share; /* a point, or NULL */
  double poisson[256], toughness[256], strength[256];
} parts;

static int is_implicit(const sdr_scene *scene)
{
  const sdr_integrator *integrator = sdr_integrator_find(scene->time.integrator);
  return integrator && !integrator->is_explicit;
}

static sdr_status make_bond_based(const parts *p, sdr_bonds *bonds, sdr_model **out)
{
  const sdr_bond_based_how how = {.dimension = p->scene->dimension,
                                  .law = p->scene->damage.law,
                                  .calibration = p->scene->calibration,
                                  .ell = p->scene->damage.ell,
                                  .mixed = p->scene->mixed,
                                  .precise = is_implicit(p->scene),
                                  .young = p->young,
                                  .share = p->share,
                                  .toughness = p->toughness,
                                  .strength = p->strength};
  const sdr_status status = sdr_bond_based_create(p->points, bonds, p->families, &how, out);
  if (status != SDR_BAD_INPUT) return status;
  /* It knows no scene, and refuses horizons only. */
  return sdr_fail(SDR_BAD_INPUT, "%s: %s", sdr_origin_text(p->scene->horizon_origin),
                  sdr_error_message());
}

static sdr_state_based_how state_based_how(const parts *p)
{
  const sdr_scene *scene = p->scene;
  return (sdr_state_based_how){.dimension = scene->dimension,
                               .law = scene->damage.law,
                               .ell = scene->damage.ell,
                               .elasticity = scene->elasticity,
                               .split = scene->split,
                               .form = scene->form,
                               .precise = is_implicit(scene),
                               .control_shear = scene->control_shear,
                               .control_normal = scene->control_normal,
                               .young = p->young,
                               .poisson = p->poisson,
                               .toughness = p->toughness};
}

static sdr_status make_ordinary(const parts *p, sdr_bonds *bonds, sdr_model **out)
{
  const sdr_state_based_how how = state_based_how(p);
  return sdr_ordinary_create(p->points, bonds, &how, out);
}

static sdr_status make_nonordinary(const parts *p, sdr_bonds *bonds, sdr_model **out)
{
  const sdr_state_based_how how = state_based_how(p);
  return sdr_nonordinary_create(p->points, bonds, &how, out);
}

/* Each takes the bonds over. */
typedef sdr_status (*maker)(const parts *p, sdr_bonds *bonds, sdr_model **out);
static const maker makers[] = {[SDR_BOND_BASED] = make_bond_based,
                               [SDR_ORDINARY] = make_ordinary,
                               [SDR_NONORDINARY] = make_nonordinary};

sdr_status sdr_body_create(const sdr_scene *scene, const sdr_points *points, const double *young,
                           const double *share, sdr_families **families, sdr_model **model)
{
  sdr_bonds *bonds = NULL;
  SDR_TRY(make_bonds(scene, points, families, &bonds));
  parts p = {.scene = scene, .points = points, .families = *families};
  for (int m = 0; m < scene->material_count; ++m) {
    const sdr_material *material = &scene->material[m];
    p.toughness[m] = material->toughness;
    p.strength[m] = material->strength;
    p.poisson[m] = isnan(material->poisson) ? 0.0 : material->poisson; /* a bar has no use for it */
  }
  p.young = young;
  p.share = share;
  return makers[scene->model](&p, bonds, model);
}
