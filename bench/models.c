/* what the state-based models cost beside the bond-based one */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/state_based.h"
#include "support/body.h"
#include "support/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One line a model that is measured: name, non-ordinary or not, law of elasticity, and the most
   that it may cost over the bond-based model. */
typedef struct {
  const char *name;
  int nonordinary;
  sdr_elasticity elasticity;
  double limit;
} entry;
static const entry entries[] = {{"ordinary", 0, SDR_LINEAR, 2.5},
                                {"nonordinary, linear", 1, SDR_LINEAR, 4.0},
                                {"nonordinary, SVK", 1, SDR_SAINT_VENANT_KIRCHHOFF, 4.0},
                                {"nonordinary, neo-Hookean", 1, SDR_NEO_HOOKEAN, 4.0}};
enum { ENTRIES = sizeof entries / sizeof *entries, ROUNDS = 9, MODELS = ENTRIES + 1 };

typedef struct {
  const char *name;
  bench_how how;
} shape;
static const shape shapes[] = {{"ring, 2-D", {.dimension = 2, .spacing = 0.5e-3}},
                               {"ring, 2-D, loose", {.dimension = 2, .spacing = 1e-3, .loose = 1}},
                               {"cube, 3-D", {.dimension = 3, .edge = 36}}};
enum { SHAPES = sizeof shapes / sizeof *shapes };
static const char *const law_names[] = {"none", "variational", "critical_stretch"};

static sdr_status make_model(const bench_body *body, const bench_how *how, const entry *e,
                             sdr_split split, sdr_model **out)
{
  static const double poisson[1] = {1.0 / 3.0}, toughness[1] = {2e4};
  const sdr_bonds_how bonds_how = {.force_loose = how->loose};
  sdr_bonds *bonds;
  double *young = sdr_alloc(sdr_points_padded(body->points), sizeof *young);
  if (!young) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < body->points->count; ++i) young[i] = 210e9;
  sdr_status status = sdr_bonds_create(body->points, &bonds_how, &bonds);
  const sdr_state_based_how model_how = {.dimension =
                                             how->dimension == 3 ? SDR_3D : SDR_PLANE_STRESS,
                                         .law = how->law,
                                         .elasticity = e->elasticity,
                                         .split = split,
                                         .control_shear = (double)NAN,
                                         .control_normal = (double)NAN,
                                         .young = young,
                                         .poisson = poisson,
                                         .toughness = toughness};
  if (status == SDR_OK)
    status = (e->nonordinary ? sdr_nonordinary_create : sdr_ordinary_create)(body->points, bonds,
                                                                             &model_how, out);
  sdr_free(young);
  return status;
}

static double seconds_a_bond(sdr_model *model, const bench_body *body, int steps)
{
  const double from = bench_processor_clock();
  for (int k = 0; k < steps; ++k)
    model->ops->force_commit(model, body->system->u, body->system->v, body->step, body->system->f);
  return (bench_processor_clock() - from) / steps / (double)model->bonds;
}

static double least(const double values[ROUNDS])
{
  double found = values[0];
  for (int k = 1; k < ROUNDS; ++k) found = fmin(found, values[k]);
  return found;
}

static int by_size(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

/* Median over the rounds of the quotient: both were measured one after the other. */
static double ratio(const double values[ROUNDS], const double base[ROUNDS])
{
  double quotient[ROUNDS];
  for (int k = 0; k < ROUNDS; ++k) quotient[k] = values[k] / base[k];
  qsort(quotient, ROUNDS, sizeof *quotient, by_size);
  return quotient[ROUNDS / 2];
}

static void print_case(const shape *s, sdr_law law, sdr_split split, double seconds[MODELS][ROUNDS],
                       FILE *csv)
{
  const char *split_name = split == SDR_SPLIT_SPECTRAL ? "spectral" : "dilatation";
  for (int k = 0; k < MODELS; ++k) {
    const char *name = k == 0 ? "bond_based" : entries[k - 1].name;
    const double ns = least(seconds[k]) * 1e9, times = ratio(seconds[k], seconds[0]);
    const double limit = k == 0 ? 1.0 : entries[k - 1].limit;
    printf("  %-17s %-16s %-10s %-25s %7.2f %7.2f %6.1f %s\n", s->name, law_names[law],
           law == SDR_LAW_VARIATIONAL ? split_name : "", name, ns, times, limit,
           k > 0 && times > limit ? "above" : "");
    fprintf(csv, "\"%s\",%s,%s,\"%s\",%.4f,%.4f,%.1f\n", s->name, law_names[law],
            law == SDR_LAW_VARIATIONAL ? split_name : "", name, ns, times, limit);
  }
}

/* All models on one body, turn by turn. */
static sdr_status measure(const shape *s, sdr_law law, sdr_split split, FILE *csv)
{
  bench_how how = s->how;
  how.law = law;
  bench_body body = {0};
  sdr_model *models[MODELS] = {NULL};
  double seconds[MODELS][ROUNDS];
  sdr_status status = bench_body_create(&how, &body);
  for (int k = 0; k < ENTRIES && status == SDR_OK; ++k)
    status = make_model(&body, &how, &entries[k], split, &models[k + 1]);
  models[0] = body.model;
  for (int round = -1; round < ROUNDS && status == SDR_OK; ++round)
    for (int k = 0; k < MODELS; ++k) {
      const double once = seconds_a_bond(models[k], &body, 2);
      if (round >= 0) seconds[k][round] = once;
    }
  if (status == SDR_OK) print_case(s, law, split, seconds, csv);
  for (int k = 1; k < MODELS; ++k)
    if (models[k]) models[k]->ops->destroy(models[k]);
  bench_body_destroy(&body);
  return status;
}

int main(int count, char **words)
{
  char directory[BENCH_PATH];
  FILE *csv = NULL;
  const char *const only = count > 1 ? words[1] : "";
  if (count > 2) {
    fputs("usage: bench_models [WORD of the body, like cube]\n", stderr);
    return SDR_BAD_INPUT;
  }
  sdr_set_threads(1);
  sdr_status status = bench_directory("models", directory);
  if (status == SDR_OK) status = bench_csv(directory, "models", &csv);
  if (status == SDR_OK) {
    fputs("body,law,split,model,ns_a_bond,ratio,limit\n", csv);
    printf(
        "\nForces of one step, one core, processor time a directed bond: least of %d rounds, and\n"
        "median ratio to the bond-based model in the same round\n\n  %-17s %-16s %-10s %-25s "
        "%7s %7s %6s\n",
        ROUNDS, "body", "law", "split", "model", "ns", "ratio", "limit");
  }
  for (int k = 0; k < SHAPES && status == SDR_OK; ++k) {
    if (!strstr(shapes[k].name, only)) continue;
    status = measure(&shapes[k], SDR_LAW_NONE, SDR_SPLIT_DILATATION, csv);
    for (int split = 0; split < 2 && status == SDR_OK; ++split)
      status = measure(&shapes[k], SDR_LAW_VARIATIONAL, (sdr_split)split, csv);
    if (status == SDR_OK)
      status = measure(&shapes[k], SDR_LAW_CRITICAL_STRETCH, SDR_SPLIT_DILATATION, csv);
  }
  if (csv && fclose(csv) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "%s: disk full", directory);
  if (status == SDR_OK)
    printf("\n%s\n%s/models.csv\n", bench_origin(), directory);
  else
    fprintf(stderr, "models: %s\n", sdr_error_message());
  return (int)status;
}
