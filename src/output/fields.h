/* What the fields of a scene are (design sec. 4): unit, kind, names of their components. */
#ifndef SDR_OUTPUT_FIELDS_H
#define SDR_OUTPUT_FIELDS_H

typedef enum { SDR_SCALAR_FIELD, SDR_VECTOR_FIELD, SDR_TENSOR_FIELD } sdr_field_kind;

typedef struct {
  const char *name, *unit; /* "1" for plain numbers */
  sdr_field_kind kind;
} sdr_field_info;

/* NULL if there is no such field. `fragment` is one (sdr_fragments_find makes it). */
const sdr_field_info *sdr_field_find(const char *name);

/* Values a point has in a body of `components` coordinates: 1; 1, 2, 3; or 1, 3, 6. */
int sdr_field_width(const sdr_field_info *field, int components);

/* Name of component k of such a field: "" for scalars, "x", or "xx" in the order of
   sdr_model_field. */
const char *sdr_field_part(const sdr_field_info *field, int components, int k);

#endif
