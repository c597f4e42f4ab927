#include "nom/multi_index.h"

#include <string.h>

static double factorial(int n)
{
  double product = 1.0;
  for (int k = 2; k <= n; ++k) product *= k;
  return product;
}

static void append(sdr_multi_indices *set, const int power[3])
{
  const int k = set->count++;
  set->factorial[k] = 1.0;
  int letters = 0;
  for (int a = 0; a < 3; ++a) {
    set->power[k][a] = power[a];
    set->degree[k] += power[a];
    set->factorial[k] *= factorial(power[a]);
    for (int c = 0; c < power[a]; ++c) set->name[k][letters++] = "xyz"[a];
  }
}

sdr_status sdr_multi_indices_of(int components, int order, sdr_multi_indices *out)
{
  if (components < 1 || components > 3)
    return sdr_fail(SDR_BAD_INPUT, "operators exist in 1, 2 and 3 dimensions, not in %d",
                    components);
  if (order < 1 || order > SDR_MOST_ORDER)
    return sdr_fail(SDR_BAD_INPUT, "operators of order %d: give 1 to %d", order, SDR_MOST_ORDER);
  sdr_multi_indices set = {.components = components, .order = order};
  for (int degree = 1; degree <= order; ++degree)
    for (int x = degree; x >= 0; --x)
      for (int y = degree - x; y >= 0; --y) {
        const int power[3] = {x, y, degree - x - y};
        if ((components < 3 && power[2] > 0) || (components < 2 && y > 0)) continue;
        append(&set, power);
      }
  *out = set;
  return SDR_OK;
}

static sdr_status unknown_name(const sdr_multi_indices *set, const char *name)
{
  char names[SDR_MOST_TERMS * (SDR_MOST_ORDER + 2) + 1] = "";
  size_t length = 0;
  for (int k = 0; k < set->count; ++k) {
    names[length++] = ' ';
    for (const char *c = set->name[k]; *c; ++c) names[length++] = *c;
  }
  names[length] = '\0';
  return sdr_fail(SDR_BAD_INPUT,
                  "no derivative '%.40s' among operators of order %d in %d-D: 1 (the value)%s",
                  name, set->order, set->components, names);
}

sdr_status sdr_multi_index_find(const sdr_multi_indices *set, const char *name, int *out)
{
  if (strcmp(name, "1") == 0) {
    *out = SDR_VALUE;
    return SDR_OK;
  }
  int power[3] = {0};
  for (const char *c = name; *c; ++c) {
    if (*c < 'x' || *c > 'z') return unknown_name(set, name);
    ++power[*c - 'x'];
  }
  for (int k = 0; k < set->count; ++k)
    if (memcmp(power, set->power[k], sizeof power) == 0) {
      *out = k;
      return SDR_OK;
    }
  return unknown_name(set, name);
}

void sdr_monomials(const sdr_multi_indices *set, const double r[3], double h, double *p)
{
  double along[3][SDR_MOST_ORDER + 1];
  for (int a = 0; a < set->components; ++a) {
    const double q = r[a] / h;
    along[a][0] = 1.0;
    for (int n = 1; n <= set->order; ++n) along[a][n] = along[a][n - 1] * q;
  }
  for (int k = 0; k < set->count; ++k) {
    double value = along[0][set->power[k][0]];
    for (int a = 1; a < set->components; ++a) value *= along[a][set->power[k][a]];
    p[k] = value;
  }
}
