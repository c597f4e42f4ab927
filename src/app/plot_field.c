#include "app/plot_field.h"

#include "base/memory.h"
#include "output/fields.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAME_ROOM = 256, MAGNITUDE = -1 };

static const char *unit_of(const char *field)
{
  static const char *const units[][2] = {
      {"displacement", "m"},      {"velocity", "m/s"},    {"acceleration", "m/s²"},
      {"energy_density", "J/m³"}, {"dissipated", "J/m³"}, {"force", "N"},
      {"reaction", "N"},          {"stress", "Pa"},       {"horizon", "m"},
      {"spacing", "m"},           {"deflection", "m"},    {"moment", "N"}};
  for (size_t k = 0; k < sizeof units / sizeof units[0]; ++k)
    if (strcmp(field, units[k][0]) == 0) return units[k][1];
  return "";
}

static int one_of(const char *field, const char *const *names)
{
  for (; *names; ++names)
    if (strcmp(field, *names) == 0) return 1;
  return 0;
}

static int is_tensor(const char *field)
{
  static const char *const names[] = {"stress", "strain", NULL};
  return one_of(field, names);
}

/* Names of a field's components in their order, separated by blanks; "" if they have none. */
static const char *component_names(const char *field, int components)
{
  if (is_tensor(field))
    return components == 1   ? "xx"
           : components == 3 ? "xx yy xy"
           : components == 6 ? "xx yy zz yz xz xy"
           : components == 9 ? "xx xy xz yx yy yz zx zy zz"
                             : "";
  return components == 1 ? "" : components == 2 ? "x y" : components == 3 ? "x y z" : "";
}

/* Position of `word` in a list with blanks between; negative: not there. */
static int position_in(const char *list, const char *word)
{
  const size_t length = strlen(word);
  for (int k = 0; *list; ++k) {
    const size_t here = strcspn(list, " ");
    if (here == length && memcmp(list, word, length) == 0) return k;
    list += here + (list[here] == ' ');
  }
  return -1;
}

static double magnitude(const float *v, int components, int tensor)
{
  double sum = 0.0;
  const int diagonal = components == 3 ? 2 : 3;
  for (int c = 0; c < components; ++c) {
    const double weight = tensor && components != 9 && c >= diagonal ? 2.0 : 1.0;
    sum += weight * (double)v[c] * (double)v[c];
  }
  return sqrt(sum);
}

static sdr_status pick(const char *field, const char *component, int components, int *out)
{
  const sdr_field_info *info = sdr_field_find(field);
  *out = components == 1 ? 0 : MAGNITUDE;
  if (!*component || (strcmp(component, "magnitude") == 0 && components > 1)) return SDR_OK;
  const char *names = component_names(field, components);
  if (components == 1 && info && info->kind == SDR_VECTOR_FIELD && strcmp(component, "x") == 0)
    return SDR_OK;
  *out = position_in(names, component);
  if (*out >= 0) return SDR_OK;
  if (!*names)
    return sdr_fail(SDR_BAD_INPUT, "field \"%s\" has no named components; give \"%s\" alone", field,
                    field);
  return sdr_fail(SDR_BAD_INPUT, "field \"%s\" has no component \"%s\"; it has: %s", field,
                  component, names);
}

static int rising(const void *a, const void *b)
{
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

/* Range of the values, and the range without the few (2 in 1000 at each end) that would leave no
   colour for the rest: points that fly off, stress at one loaded point. */
static sdr_status measure(const sdr_rundata *run, sdr_plot_field *field)
{
  float *sorted = sdr_alloc((size_t)run->point_count, sizeof *sorted);
  if (!sorted) return SDR_RUN_FAILED;
  int32_t count = 0;
  for (int32_t i = 0; i < run->point_count; ++i)
    if (isfinite(field->value[i])) sorted[count++] = field->value[i];
  qsort(sorted, (size_t)count, sizeof *sorted, rising);
  if (count > 0) {
    const int32_t few = count / 500;
    field->least = (double)sorted[0];
    field->most = (double)sorted[count - 1];
    field->low = (double)sorted[few];
    field->high = (double)sorted[count - 1 - few];
  }
  sdr_free(sorted);
  const double inner = fmax(fabs(field->low), fabs(field->high));
  if (inner > 0.0 && fmax(fabs(field->least), fabs(field->most)) > 2.0 * inner) return SDR_OK;
  field->low = field->least;
  field->high = field->most;
  return SDR_OK;
}

/* Colour scale by the values: both signs share one centred on zero. */
static void scale(const char *name, sdr_plot_field *field)
{
  const double low = field->low, high = field->high;
  field->palette = &sdr_palette_sequential;
  if (strcmp(name, "damage") == 0) {
    field->palette = &sdr_palette_damage;
    field->low = 0.0;
    field->high = 1.0;
  } else if (low < 0.0 && high > 0.0) {
    field->palette = &sdr_palette_diverging;
    field->high = fmax(-low, high);
    field->low = -field->high;
  } else if (low < 0.0) {
    field->palette = &sdr_palette_reversed;
  }
  field->flat = !(field->high > field->low);
  if (field->flat) {
    const double room = field->high != 0.0 ? 0.5 * fabs(field->high) : 0.5;
    field->low -= room;
    field->high += room;
  }
}

static void name_it(const char *name, const char *component, int components, int chosen,
                    sdr_plot_field *field)
{
  char words[NAME_ROOM];
  snprintf(words, sizeof words, "%s", name);
  for (char *c = words; *c; ++c)
    if (*c == '_') *c = ' ';
  const char *part = chosen == MAGNITUDE ? "magnitude" : components > 1 ? component : "";
  snprintf(field->label, sizeof field->label, "%s%s%.32s", words, *part ? " " : "", part);
  field->unit = unit_of(name);
  static const char *const numbered[] = {"fragment", "material", "level", NULL};
  field->pieces = one_of(name, numbered);
}

sdr_status sdr_plot_field_read(const sdr_rundata *run, int frame, const char *name,
                               sdr_plot_field *out)
{
  char base[NAME_ROOM];
  const size_t length = strcspn(name, ".");
  snprintf(base, sizeof base, "%.*s", (int)(length < NAME_ROOM ? length : NAME_ROOM - 1), name);
  const char *component = name[length] ? name + length + 1 : "";
  float *all = NULL;
  int components = 0, chosen = 0;
  SDR_TRY(sdr_rundata_field(run, frame, base, &all, &components));
  sdr_plot_field field = {0};
  sdr_status status = pick(base, component, components, &chosen);
  if (status == SDR_OK) {
    field.value = sdr_alloc((size_t)run->point_count, sizeof *field.value);
    if (!field.value) status = SDR_RUN_FAILED;
  }
  if (status == SDR_OK) {
    for (int32_t i = 0; i < run->point_count; ++i) {
      const float *v = all + (size_t)i * (size_t)components;
      field.value[i] =
          chosen == MAGNITUDE ? (float)magnitude(v, components, is_tensor(base)) : v[chosen];
    }
    name_it(base, component, components, chosen, &field);
    status = measure(run, &field);
  }
  if (status == SDR_OK) {
    scale(base, &field);
    *out = field;
  } else {
    sdr_plot_field_clear(&field);
  }
  sdr_free(all);
  return status;
}

void sdr_plot_field_clear(sdr_plot_field *field)
{
  sdr_free(field->value);
  *field = (sdr_plot_field){0};
}

void sdr_plot_field_share(sdr_plot_field *a, sdr_plot_field *b)
{
  /* Of a flat one the value counts, not the room: frames at rest would pale all others. */
  double low = fmin(a->flat ? a->least : a->low, b->flat ? b->least : b->low);
  double high = fmax(a->flat ? a->most : a->high, b->flat ? b->most : b->high);
  if (!(high > low)) { /* both, and alike */
    low = a->low;
    high = a->high;
  } else if (a->flat || b->flat) {
    const sdr_palette *palette = a->flat ? b->palette : a->palette;
    a->palette = b->palette = palette;
    a->flat = b->flat = 0;
  }
  a->low = b->low = low;
  a->high = b->high = high;
  a->least = b->least = fmin(a->least, b->least);
  a->most = b->most = fmax(a->most, b->most);
  if (a->palette == b->palette) return;
  const double both = fmax(fabs(low), fabs(high));
  if (low < 0.0 && high > 0.0) {
    a->low = b->low = -both;
    a->high = b->high = both;
  }
  a->palette = b->palette =
      low < 0.0 && high > 0.0 ? &sdr_palette_diverging : &sdr_palette_sequential;
}

void sdr_plot_field_colour(const sdr_plot_field *field, double value, unsigned char rgb[3])
{
  if (field->pieces)
    sdr_palette_piece((int)fmin(fmax(value, 0.0), 1e9), rgb);
  else
    sdr_palette_colour(field->palette, (value - field->low) / (field->high - field->low), rgb);
}
