#include "app/plot_columns.h"

#include "base/memory.h"
#include "mechanics/schedule.h"
#include "output/fields.h"
#include "scene/expression.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PATH_ROOM = 4200 };

/* NAME.FIELD or NAME.FIELD.PART. */
typedef struct {
  char name[SDR_PANEL_NAME], part[4];
  const sdr_field_info *field;
} parts;

/* The words behind the last two dots; NULL where there is no second dot. */
static int split(const char *column, parts *out)
{
  char text[2 * SDR_PANEL_NAME];
  if (strlen(column) >= SDR_PANEL_NAME) return 0;
  snprintf(text, sizeof text, "%s", column);
  char *dot = strrchr(text, '.');
  if (!dot) return 0;
  out->part[0] = '\0';
  out->field = sdr_field_find(dot + 1);
  if (!out->field) {
    if (strlen(dot + 1) >= sizeof out->part) return 0;
    memcpy(out->part, dot + 1, strlen(dot + 1) + 1);
    *dot = '\0';
    dot = strrchr(text, '.');
    if (!dot) return 0;
    out->field = sdr_field_find(dot + 1);
  }
  *dot = '\0';
  snprintf(out->name, sizeof out->name, "%.*s", SDR_PANEL_NAME - 1, text);
  return out->field != NULL;
}

static sdr_status add_panel(sdr_column_panels *panels, const parts *of)
{
  sdr_column_panel *grown =
      sdr_realloc(panels->panel, (size_t)panels->count + 1, sizeof *panels->panel);
  if (!grown) return SDR_RUN_FAILED;
  panels->panel = grown;
  sdr_column_panel *panel = &grown[panels->count++];
  *panel = (sdr_column_panel){.field = of->field->name,
                              .unit = strcmp(of->field->unit, "1") == 0 ? "" : of->field->unit};
  memcpy(panel->name, of->name, sizeof panel->name);
  return SDR_OK;
}

static void add_curve(sdr_column_panel *panel, const char part[4], const double *value)
{
  if (panel->count == SDR_PANEL_CURVES) return;
  memcpy(panel->part[panel->count], part, sizeof panel->part[0]);
  panel->value[panel->count++] = value;
}

/* ---- how far supports have moved ------------------------------------------------------------- */

static const sdr_support_scene *find_support(const sdr_scene *scene, const char *name)
{
  for (int k = 0; scene && k < scene->support_count; ++k)
    if (strcmp(scene->support[k].name, name) == 0) return &scene->support[k];
  return NULL;
}

/* Prescribed velocities are summed by the trapezoid over the rows. 0: it is not the same everywhere
   or does not move. */
static int find_motion(const sdr_support_scene *support, int c, const double *time, int rows,
                       double *moved)
{
  static const double nowhere[3] = {0.0};
  const int is_velocity = support->kind[c] == SDR_PRESCRIBED_VELOCITY;
  sdr_expression *formula = support->value[c];
  double sum = 0.0, before = 0.0, reach = 0.0;
  if (!formula || support->layer || sdr_expression_uses(formula) & ~SDR_USES_TIME) return 0;
  for (int row = 0; row < rows; ++row) {
    double value;
    if (sdr_expression_value(formula, nowhere, time[row], &value) != SDR_OK) return 0;
    const double share = sdr_schedule_share(&support->schedule, time[row]);
    const double now = value * (is_velocity && isnan(share) ? 0.0 : share);
    if (row > 0) sum += 0.5 * (before + now) * (time[row] - time[row - 1]);
    before = now;
    moved[row] = is_velocity ? (isnan(share) ? (double)NAN : sum) : now;
    if (fabs(moved[row]) > reach) reach = fabs(moved[row]);
  }
  return reach > 0.0;
}

/* Panels over displacement for the reaction's components, behind the panel number `of`. */
static sdr_status add_moved(const sdr_rundata *run, const sdr_scene *scene, int of,
                            sdr_column_panels *panels)
{
  const sdr_column_panel base = panels->panel[of];
  const double *time = sdr_rundata_column(run, "time");
  const sdr_support_scene *support = find_support(scene, base.name);
  if (!support || !time || strcmp(base.field, "reaction") != 0) return SDR_OK;
  for (int k = 0; k < base.count; ++k) {
    const int c = base.part[k][0] ? base.part[k][0] - 'x' : 0;
    const parts like = {.field = sdr_field_find("reaction")};
    if (c < 0 || c > 2) continue;
    double *moved = sdr_alloc((size_t)run->history.row_count, sizeof *moved);
    if (!moved) return SDR_RUN_FAILED;
    if (!find_motion(support, c, time, run->history.row_count, moved)) {
      sdr_free(moved);
      continue;
    }
    if (add_panel(panels, &like) != SDR_OK) {
      sdr_free(moved);
      return SDR_RUN_FAILED;
    }
    sdr_column_panel *panel = &panels->panel[panels->count - 1];
    memcpy(panel->name, base.name, sizeof panel->name);
    add_curve(panel, base.part[k], base.value[k]);
    panel->moved = moved;
  }
  return SDR_OK;
}

static sdr_scene *load_scene(const sdr_rundata *run)
{
  char path[PATH_ROOM];
  sdr_scene *scene = NULL;
  snprintf(path, sizeof path, "%s/used.yaml", run->directory);
  return sdr_scene_load(path, NULL, 0, NULL, &scene) == SDR_OK ? scene : NULL;
}

/* ---- panels ---------------------------------------------------------------------------------- */

static sdr_status find(const sdr_rundata *run, const sdr_scene *scene, sdr_column_panels *panels)
{
  int open = -1; /* the panel that the columns go to */
  for (int c = 0; c < run->history.column_count; ++c) {
    parts of;
    if (!split(run->history.name[c], &of)) continue;
    const sdr_column_panel *last = open < 0 ? NULL : &panels->panel[open];
    if (!last || strcmp(last->name, of.name) != 0 || strcmp(last->field, of.field->name) != 0) {
      if (last) SDR_TRY(add_moved(run, scene, open, panels));
      open = panels->count;
      SDR_TRY(add_panel(panels, &of));
    }
    add_curve(&panels->panel[open], of.part,
              run->history.value + (size_t)c * (size_t)run->history.row_count);
  }
  return open < 0 ? SDR_OK : add_moved(run, scene, open, panels);
}

sdr_status sdr_column_panels_find(const sdr_rundata *run, sdr_column_panels *out)
{
  sdr_column_panels panels = {0};
  sdr_scene *scene = load_scene(run);
  const sdr_status status = find(run, scene, &panels);
  sdr_scene_destroy(&scene);
  if (status == SDR_OK)
    *out = panels;
  else
    sdr_column_panels_clear(&panels);
  return status;
}

void sdr_column_panels_clear(sdr_column_panels *panels)
{
  for (int k = 0; k < panels->count; ++k) sdr_free(panels->panel[k].moved);
  sdr_free(panels->panel);
  *panels = (sdr_column_panels){0};
}
