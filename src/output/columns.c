#include "output/columns.h"

#include "base/memory.h"
#include "output/fields.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* One column: component `part` of a field at a point, or of the reaction summed over a support. */
typedef struct {
  char name[2 * SDR_NAME_MAX];
  const sdr_field_info *field;
  int part, support;
  int32_t point;
} column;

struct sdr_columns {
  int count, room;
  int probe_columns; /* the first ones; the rest are reactions */
  column *columns;
  int components;
  double *field; /* scratch: the widest field, component-major; NULL without probes */
};

static sdr_status add(sdr_columns *columns, const column *added)
{
  if (columns->count == columns->room) {
    const int room = 2 * columns->room + 8;
    column *grown = sdr_realloc(columns->columns, (size_t)room, sizeof *grown);
    if (!grown) return SDR_RUN_FAILED;
    columns->columns = grown;
    columns->room = room;
  }
  columns->columns[columns->count++] = *added;
  return SDR_OK;
}

static sdr_status add_named(sdr_columns *columns, const char *prefix, column added)
{
  const char *part = sdr_field_part(added.field, columns->components, added.part);
  snprintf(added.name, sizeof added.name, "%s.%s%s%s", prefix, added.field->name, *part ? "." : "",
           part);
  return add(columns, &added);
}

/* A probe shows the nearest point; one beyond its horizon is a mistake, of units mostly. */
static sdr_status check_distance(const sdr_probe *probe, const sdr_points *points, int32_t point)
{
  double square = 0.0;
  for (int c = 0; c < points->components; ++c) {
    const double way = points->x[c][point] - probe->at[c];
    square += way * way;
  }
  if (sqrt(square) <= points->horizon[point]) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: probe %s lies outside the body: the nearest point is %.4g mm away, beyond "
                  "its horizon of %.4g mm; give a place in the body",
                  sdr_origin_text(probe->origin), probe->name, 1e3 * sqrt(square),
                  1e3 * points->horizon[point]);
}

static sdr_status add_probe(sdr_columns *columns, const sdr_probe *probe, const sdr_points *points)
{
  const int32_t point = sdr_points_nearest(points, probe->at);
  SDR_TRY(check_distance(probe, points, point));
  for (int f = 0; f < probe->field_count; ++f) {
    const sdr_field_info *field = sdr_field_find(probe->field[f]);
    if (!field || strcmp(field->name, "fragment") == 0)
      return sdr_fail(SDR_BAD_INPUT, "%s: probe %s cannot show '%s'; name another field",
                      sdr_origin_text(probe->origin), probe->name, probe->field[f]);
    for (int k = 0; k < sdr_field_width(field, columns->components); ++k)
      SDR_TRY(add_named(columns, probe->name, (column){.field = field, .part = k, .point = point}));
  }
  return SDR_OK;
}

static sdr_status add_reactions(sdr_columns *columns, const sdr_scene *scene)
{
  const sdr_field_info *reaction = sdr_field_find("reaction");
  for (int s = 0; s < scene->support_count; ++s)
    for (int c = 0; c < columns->components; ++c)
      if (scene->support[s].kind[c] != SDR_FREE)
        SDR_TRY(add_named(columns, scene->support[s].name,
                          (column){.field = reaction, .part = c, .support = s}));
  return SDR_OK;
}

static sdr_status add_all(sdr_columns *columns, const sdr_scene *scene, const sdr_points *points)
{
  int widest = 0;
  for (int p = 0; p < scene->output.probe_count; ++p)
    SDR_TRY(add_probe(columns, &scene->output.probe[p], points));
  columns->probe_columns = columns->count;
  SDR_TRY(add_reactions(columns, scene));
  for (int k = 0; k < columns->probe_columns; ++k) {
    const int width = sdr_field_width(columns->columns[k].field, columns->components);
    if (width > widest) widest = width;
  }
  if (widest == 0) return SDR_OK;
  columns->field = sdr_alloc((size_t)points->count * (size_t)widest, sizeof(double));
  return columns->field ? SDR_OK : SDR_RUN_FAILED;
}

sdr_status sdr_columns_create(const sdr_scene *scene, const sdr_points *points, sdr_columns **out)
{
  sdr_columns *columns = sdr_alloc(1, sizeof *columns);
  if (!columns) return SDR_RUN_FAILED;
  columns->components = points->components;
  const sdr_status status = add_all(columns, scene, points);
  if (status == SDR_OK)
    *out = columns;
  else
    sdr_columns_destroy(&columns);
  return status;
}

void sdr_columns_destroy(sdr_columns **columns)
{
  if (!*columns) return;
  sdr_free((*columns)->columns);
  sdr_free((*columns)->field);
  sdr_free(*columns);
  *columns = NULL;
}

int sdr_columns_count(const sdr_columns *columns)
{
  return columns->count;
}

const char *sdr_columns_name(const sdr_columns *columns, int k)
{
  return columns->columns[k].name;
}

/* Column k is the first that shows its field. */
static int first_of_field(const sdr_columns *columns, int k)
{
  for (int earlier = 0; earlier < k; ++earlier)
    if (columns->columns[earlier].field == columns->columns[k].field) return 0;
  return 1;
}

sdr_status sdr_columns_values(sdr_columns *columns, sdr_system *system, double *values)
{
  const size_t count = (size_t)system->count;
  for (int k = 0; k < columns->probe_columns; ++k) {
    const sdr_field_info *field = columns->columns[k].field;
    if (!first_of_field(columns, k)) continue;
    SDR_TRY(sdr_system_field(system, field->name, columns->field));
    for (int j = k; j < columns->probe_columns; ++j) {
      const column *c = &columns->columns[j];
      if (c->field == field) values[j] = columns->field[(size_t)c->part * count + (size_t)c->point];
    }
  }
  for (int k = columns->probe_columns; k < columns->count; ++k)
    values[k] = sdr_system_reaction(system, columns->columns[k].support, columns->columns[k].part);
  return SDR_OK;
}
