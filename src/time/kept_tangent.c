#include "time/kept_tangent.h"

#include "base/memory.h"

#include <string.h>

struct sdr_kept_tangent {
  sdr_model *model;
  const sdr_constraints *constraints;
  int32_t size;
  int32_t *home;      /* of entry k of q: where it stands in `way` and `pull` */
  double *way, *pull; /* component arrays, one behind the other; what is not free of `way` is 0 */
  double *block;      /* the points' diagonal blocks */
};

int sdr_kept_tangent_fits(const sdr_model *model, const sdr_constraints *constraints)
{
  return model->ops->tangent_keep && constraints->symmetric &&
         constraints->map.row[constraints->unknowns] == constraints->free;
}

void sdr_kept_tangent_destroy(sdr_kept_tangent **kept)
{
  sdr_kept_tangent *k = *kept;
  if (!k) return;
  sdr_free(k->home);
  sdr_free(k->way);
  sdr_free(k->pull);
  sdr_free(k->block);
  sdr_free(k);
  *kept = NULL;
}

sdr_status sdr_kept_tangent_create(sdr_model *model, sdr_kept_tangent **out)
{
  sdr_kept_tangent *k = sdr_alloc(1, sizeof *k);
  if (!k) return SDR_RUN_FAILED;
  const size_t m = (size_t)model->points->components, count = (size_t)model->points->count;
  const size_t padded = sdr_points_padded(model->points);
  k->model = model;
  k->home = sdr_alloc(m * count, sizeof *k->home);
  k->way = sdr_alloc(m * padded, sizeof(double));
  k->pull = sdr_alloc(m * padded, sizeof(double));
  k->block = sdr_alloc(m * m * count, sizeof(double));
  if (k->home && k->way && k->pull && k->block)
    *out = k;
  else
    sdr_kept_tangent_destroy(&k);
  return k ? SDR_OK : SDR_RUN_FAILED;
}

static void clear(sdr_kept_tangent *kept)
{
  const sdr_points *points = kept->model->points;
  memset(kept->way, 0, (size_t)points->components * sdr_points_padded(points) * sizeof(double));
}

sdr_status sdr_kept_tangent_take(sdr_kept_tangent *kept, const sdr_constraints *constraints,
                                 double *const u[3])
{
  const int m = kept->model->points->components;
  const int32_t padded = (int32_t)sdr_points_padded(kept->model->points);
  kept->constraints = constraints;
  kept->size = constraints->free;
  for (int32_t k = 0; k < kept->size; ++k)
    kept->home[k] = constraints->unknown[k] % m * padded + constraints->unknown[k] / m;
  clear(kept);
  SDR_TRY(kept->model->ops->tangent_keep(kept->model, u));
  kept->model->ops->kept_diagonal(kept->model, kept->block);
  return SDR_OK;
}

/* pull = K way */
static void multiply(sdr_kept_tangent *kept)
{
  const sdr_points *points = kept->model->points;
  const size_t padded = sdr_points_padded(points);
  double *way[3] = {NULL}, *pull[3] = {NULL};
  for (int a = 0; a < points->components; ++a) {
    way[a] = kept->way + (size_t)a * padded;
    pull[a] = kept->pull + (size_t)a * padded;
  }
  kept->model->ops->kept_times(kept->model, way, pull);
}

void sdr_kept_tangent_times(sdr_kept_tangent *kept, const double *d, const double *x, double *y)
{
  const int32_t *home = kept->home;
  for (int32_t k = 0; k < kept->size; ++k) kept->way[home[k]] = x[k];
  multiply(kept);
  for (int32_t k = 0; k < kept->size; ++k) y[k] = d[k] * x[k] + kept->pull[home[k]];
}

void sdr_kept_tangent_pull(sdr_kept_tangent *kept, const double *z, double *out)
{
  const sdr_points *points = kept->model->points;
  const size_t padded = sdr_points_padded(points);
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i)
      kept->way[(size_t)a * padded + (size_t)i] = z[i * points->components + a];
  multiply(kept);
  for (int32_t k = 0; k < kept->size; ++k) out[k] = kept->pull[kept->home[k]];
  clear(kept);
}

double sdr_kept_tangent_entry(const sdr_kept_tangent *kept, int32_t k, int32_t l)
{
  const int m = kept->model->points->components;
  const int32_t r = kept->constraints->unknown[k], c = kept->constraints->unknown[l] % m;
  return kept->block[r / m * m * m + r % m * m + c];
}
