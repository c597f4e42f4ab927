#include "output/fields.h"

#include <stddef.h>
#include <string.h>

static const sdr_field_info fields[] = {
    {"displacement", "m", SDR_VECTOR_FIELD},
    {"velocity", "m/s", SDR_VECTOR_FIELD},
    {"acceleration", "m/s^2", SDR_VECTOR_FIELD},
    {"damage", "1", SDR_SCALAR_FIELD},
    {"energy_density", "J/m^3", SDR_SCALAR_FIELD},
    {"dissipated", "J/m^3", SDR_SCALAR_FIELD},
    {"force", "N", SDR_VECTOR_FIELD},
    {"reaction", "N", SDR_VECTOR_FIELD},
    {"stress", "Pa", SDR_TENSOR_FIELD},
    {"strain", "1", SDR_TENSOR_FIELD},
    {"dilatation", "1", SDR_SCALAR_FIELD},
    {"material", "1", SDR_SCALAR_FIELD},
    {"horizon", "m", SDR_SCALAR_FIELD},
    {"spacing", "m", SDR_SCALAR_FIELD},
    {"level", "1", SDR_SCALAR_FIELD},
    {"fragment", "1", SDR_SCALAR_FIELD},
};

const sdr_field_info *sdr_field_find(const char *name)
{
  for (size_t k = 0; k < sizeof fields / sizeof *fields; ++k)
    if (strcmp(fields[k].name, name) == 0) return &fields[k];
  return NULL;
}

int sdr_field_width(const sdr_field_info *field, int components)
{
  if (field->kind == SDR_SCALAR_FIELD) return 1;
  if (field->kind == SDR_VECTOR_FIELD) return components;
  return components * (components + 1) / 2;
}

const char *sdr_field_part(const sdr_field_info *field, int components, int k)
{
  static const char *const vector[3] = {"x", "y", "z"};
  static const char *const plane[3] = {"xx", "yy", "xy"};
  static const char *const space[6] = {"xx", "yy", "zz", "yz", "xz", "xy"};
  if (field->kind == SDR_SCALAR_FIELD) return "";
  if (field->kind == SDR_VECTOR_FIELD) return vector[k];
  return components < 3 ? plane[k] : space[k];
}
