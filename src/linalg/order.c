/* Fill-reducing order of symmetric matrices, found on the graph of the points, not of all
   unknowns: the same order for a quarter (2-D) or a ninth (3-D) of the edges. */
#include "base/memory.h"
#include "linalg/solver_ops.h"

#include <metis.h>
#include <string.h>

/* ---- groups ---------------------------------------------------------------------------------- */

static int same_columns(const sdr_csr *a, int32_t r, int32_t s)
{
  const int64_t length = a->row[r + 1] - a->row[r];
  if (length != a->row[s + 1] - a->row[s]) return 0;
  return memcmp(a->column + a->row[r], a->column + a->row[s], (size_t)length * sizeof *a->column) ==
         0;
}

sdr_status sdr_csr_groups_find(const sdr_csr *matrix, sdr_csr_groups *out)
{
  sdr_csr_groups g = {.group = sdr_alloc((size_t)matrix->rows, sizeof(int32_t)),
                      .first = sdr_alloc((size_t)matrix->rows + 1, sizeof(int32_t))};
  if (!g.group || !g.first) {
    sdr_csr_groups_destroy(&g);
    return SDR_RUN_FAILED;
  }
  for (int32_t r = 0; r < matrix->rows; ++r) {
    if (r == 0 || !same_columns(matrix, r - 1, r)) g.first[g.count++] = r;
    g.group[r] = g.count - 1;
  }
  g.first[g.count] = matrix->rows;
  *out = g;
  return SDR_OK;
}

void sdr_csr_groups_destroy(sdr_csr_groups *groups)
{
  sdr_free(groups->group);
  sdr_free(groups->first);
  *groups = (sdr_csr_groups){0};
}

/* ---- nested dissection ----------------------------------------------------------------------- */

typedef struct {
  idx_t count, *start, *next, *weight, *order, *inverse;
} graph;

static void graph_destroy(graph *g)
{
  sdr_free(g->start);
  sdr_free(g->next);
  sdr_free(g->weight);
  sdr_free(g->order);
  sdr_free(g->inverse);
}

/* Edges of group g into `next` from `at` on (next NULL: only counted); their number. */
static int64_t edges_of(const sdr_csr *a, const sdr_csr_groups *groups, int32_t g, int64_t at,
                        idx_t *next)
{
  const int32_t r = groups->first[g];
  int64_t count = 0;
  int32_t last = -1;
  for (int64_t k = a->row[r]; k < a->row[r + 1]; ++k) {
    const int32_t other = groups->group[a->column[k]];
    if (other == g || other == last) continue;
    last = other;
    if (next) next[at + count] = (idx_t)other;
    ++count;
  }
  return count;
}

static sdr_status graph_create(const sdr_csr *a, const sdr_csr_groups *groups, graph *g)
{
  const size_t n = (size_t)groups->count;
  int64_t edges = 0;
  for (int32_t k = 0; k < groups->count; ++k) edges += edges_of(a, groups, k, 0, NULL);
  if (edges > INT32_MAX)
    return sdr_fail(SDR_RUN_FAILED,
                    "a matrix with %lld pairs of points is too large for METIS to order; take the "
                    "solver 'pcg'",
                    (long long)edges);
  g->count = (idx_t)n;
  g->start = sdr_alloc(n + 1, sizeof(idx_t));
  g->next = sdr_alloc((size_t)edges, sizeof(idx_t));
  g->weight = sdr_alloc(n, sizeof(idx_t));
  g->order = sdr_alloc(n, sizeof(idx_t));
  g->inverse = sdr_alloc(n, sizeof(idx_t));
  if (!g->start || !g->next || !g->weight || !g->order || !g->inverse) return SDR_RUN_FAILED;
  for (int32_t k = 0; k < groups->count; ++k) {
    g->start[k + 1] = g->start[k] + (idx_t)edges_of(a, groups, k, g->start[k], g->next);
    g->weight[k] = groups->first[k + 1] - groups->first[k];
  }
  return SDR_OK;
}

static sdr_status dissect(graph *g)
{
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_NUMBERING] = 0;
  if (g->start[g->count] == 0) { /* METIS wants an edge */
    for (idx_t k = 0; k < g->count; ++k) g->order[k] = k;
    return SDR_OK;
  }
  const int result =
      METIS_NodeND(&g->count, g->start, g->next, g->weight, options, g->order, g->inverse);
  if (result == METIS_OK) return SDR_OK;
  return sdr_fail(SDR_RUN_FAILED, "METIS could not order a matrix of %d points (its code %d)",
                  (int)g->count, result);
}

static void expand(const graph *g, const sdr_csr_groups *groups, int64_t *order)
{
  int64_t at = 0;
  for (idx_t k = 0; k < g->count; ++k)
    for (int32_t r = groups->first[g->order[k]]; r < groups->first[g->order[k] + 1]; ++r)
      order[at++] = r;
}

sdr_status sdr_csr_dissect(const sdr_csr *matrix, int64_t *order)
{
  sdr_csr_groups groups = {0};
  graph g = {0};
  sdr_status status = sdr_csr_groups_find(matrix, &groups);
  if (status == SDR_OK) status = graph_create(matrix, &groups, &g);
  if (status == SDR_OK) status = dissect(&g);
  if (status == SDR_OK) expand(&g, &groups, order);
  graph_destroy(&g);
  sdr_csr_groups_destroy(&groups);
  return status;
}
