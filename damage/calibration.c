#include "damage/calibration.h"

#include "nom/stencil.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

double sdr_bond_poisson(sdr_dimension dimension)
{
  switch (dimension) {
  case SDR_PLANE_STRESS:
    return 1.0 / 3.0;
  case SDR_PLANE_STRAIN:
  case SDR_3D:
    return 0.25;
  default:
    return 0.0;
  }
}

/* Area of a bar, thickness of a plate; 1 in 3-D. */
static double across(sdr_dimension dimension, const sdr_family *family)
{
  return family->volume / pow(family->spacing, sdr_components(dimension));
}

static double printed_micromodulus(sdr_dimension dimension, const sdr_family *family, double young)
{
  const double d = family->horizon, nu = sdr_bond_poisson(dimension), h = across(dimension, family);
  switch (dimension) {
  case SDR_1D:
    return young / (h * d * d);
  case SDR_PLANE_STRESS:
    return 3.0 * young / (pi * h * d * d * d * (1.0 - nu));
  case SDR_PLANE_STRAIN:
    return 3.0 * young / (pi * h * d * d * d * (1.0 + nu) * (1.0 - 2.0 * nu));
  default:
    return 3.0 * young / (pi * d * d * d * d * (1.0 - 2.0 * nu));
  }
}

double sdr_micromodulus(sdr_dimension dimension, sdr_calibration_kind kind,
                        const sdr_family *family, double young)
{
  if (kind == SDR_CALIBRATE_PRINTED) return printed_micromodulus(dimension, family, young);
  const double nu = sdr_bond_poisson(dimension), first = family->first;
  switch (dimension) {
  case SDR_1D:
    return young / first;
  case SDR_PLANE_STRESS:
    return 2.0 * young / ((1.0 - nu) * first);
  case SDR_PLANE_STRAIN:
    return 2.0 * young / ((1.0 + nu) * (1.0 - 2.0 * nu) * first);
  default:
    return 3.0 * young / ((1.0 - 2.0 * nu) * first);
  }
}

double sdr_critical_stretch_squared(sdr_dimension dimension, sdr_calibration_kind kind,
                                    const sdr_family *family, double young, double toughness)
{
  if (kind == SDR_CALIBRATE_PRINTED) {
    static const double factor[4] = {3.0, 4.0 * 3.14159265358979323846 / 9.0,
                                     5.0 * 3.14159265358979323846 / 12.0, 5.0 / 6.0};
    return factor[dimension] * toughness / (young * family->horizon);
  }
  const double c = sdr_micromodulus(dimension, kind, family, young);
  const double factor = dimension == SDR_1D ? 2.0 : dimension == SDR_3D ? 4.0 : pi;
  return factor * toughness / (c * family->second);
}

sdr_effective_stiffness sdr_stiffness_of(sdr_dimension dimension, const sdr_family *family,
                                         double micromodulus, double young)
{
  sdr_effective_stiffness out = {0};
  const double nu = sdr_bond_poisson(dimension);
  out.c11 = micromodulus * family->quartic[0];
  if (dimension == SDR_1D) {
    out.exact_c11 = young;
    return out;
  }
  /* Quartic moments: x^4 is first, x^2 y^2 third in 2-D and fourth in 3-D (x^4 x^3y x^3z x^2y^2).
   */
  out.c12 = micromodulus * family->quartic[dimension == SDR_3D ? 3 : 2];
  out.c66 = out.c12; /* central forces: the Cauchy relation */
  if (dimension == SDR_PLANE_STRESS) {
    out.exact_c11 = young / (1.0 - nu * nu);
    out.exact_c12 = nu * out.exact_c11;
  } else {
    out.exact_c11 = young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
    out.exact_c12 = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  }
  out.exact_c66 = young / (2.0 * (1.0 + nu));
  return out;
}

sdr_status sdr_separation_energy(const sdr_families *families, const sdr_family *family,
                                 double micromodulus, double threshold, const double n[3],
                                 double *energy)
{
  const sdr_points *points = families->points;
  sdr_stencil stencil;
  SDR_TRY(sdr_stencil_create(points->components, family->spacing, family->horizon, &stencil));
  double sum = 0.0;
  for (int k = 0; k < stencil.count; ++k) {
    double xi[3], crossing = 0.0, square = 0.0;
    sdr_stencil_vector(points, family->spacing, stencil.step + 3 * k, xi);
    for (int a = 0; a < 3; ++a) {
      crossing += xi[a] * n[a];
      square += xi[a] * xi[a];
    }
    const double b = sdr_family_bond_weight(families, family, xi);
    sum += b * sqrt(square) * fabs(crossing) * family->volume;
  }
  sdr_stencil_destroy(&stencil);
  *energy = 0.5 * micromodulus * threshold * sum;
  return SDR_OK;
}
