/* What a scene says and a run does not look at. It is no error: a variant or another integrator may
   want it. But it is told. */
#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* 1 if the user gave the value: defaults are in the tree too. */
static int is_given(const sdr_reading *rd, const sdr_node *node)
{
  char path[256];
  if (!node || sdr_node_is_null(node)) return 0;
  sdr_node_path(node, path, sizeof path);
  const size_t length = strlen(path);
  for (int k = 0; k < rd->reader->default_count; ++k) {
    const char *line = rd->reader->defaults[k];
    if (strncmp(line, path, length) == 0 && strncmp(line + length, " = ", 3) == 0) return 0;
  }
  return 1;
}

static void note_key(sdr_reading *rd, const sdr_node *map, const char *key, const char *why)
{
  char path[256];
  const sdr_node *node = map ? sdr_node_find(map, key) : NULL;
  if (!is_given(rd, node)) return;
  sdr_node_path(node, path, sizeof path);
  sdr_note_idle(rd->reader, "%s: %s", path, why);
}

/* ---- time ------------------------------------------------------------------------------------ */

/* The keys of some integrators only, each between blanks. */
static const struct {
  const char *key, *integrators;
} owned[] = {{"safety", " leapfrog "},
             {"allow_unstable", " leapfrog "},
             {"method", " cvode "},
             {"order", " cvode ida "},
             {"solver", " static cvode ida energy_momentum "},
             {"tolerance", " cvode ida energy_momentum "},
             {"tolerance_displacement", " cvode ida "},
             {"tolerance_velocity", " cvode ida "},
             {"viscosity", " ida "},
             {"linear", " static "},
             {"ends_at_collapse", " static "}};

static int owns(const char *integrators, const char *integrator)
{
  char padded[SDR_NAME_MAX + 2];
  snprintf(padded, sizeof padded, " %s ", integrator);
  return strstr(integrators, padded) != NULL;
}

/* A value that nothing looks at must be possible all the same. */
static void check_numbers(sdr_reading *rd, sdr_node *map)
{
  static const struct {
    const char *key;
    sdr_quantity quantity;
  } numbers[] = {{"safety", {{0, 0, 0, 0}, 0, 1, 1, 0}},
                 {"tolerance", {{0, 0, 0, 0}, 1e-15, 0.1, 0, 0}},
                 {"viscosity", {{0, 0, 1, 0}, 0, INFINITY, 0, 0}}};
  double unused;
  for (size_t n = 0; n < sizeof numbers / sizeof *numbers; ++n)
    for (size_t k = 0; k < sizeof owned / sizeof *owned; ++k)
      if (strcmp(owned[k].key, numbers[n].key) == 0 &&
          !owns(owned[k].integrators, rd->scene->time.integrator))
        sdr_read_number(rd->reader, map, numbers[n].key, numbers[n].quantity, SDR_OPTIONAL,
                        &unused);
}

static void look_at_time(sdr_reading *rd)
{
  const sdr_time_scene *time = &rd->scene->time;
  sdr_node *map = sdr_node_find(rd->root, "time");
  char why[128];
  if (!map || map->kind != SDR_MAPPING || !time->integrator[0]) return;
  check_numbers(rd, map);
  snprintf(why, sizeof why, "the integrator %s does not use it", time->integrator);
  for (size_t k = 0; k < sizeof owned / sizeof *owned; ++k)
    if (!owns(owned[k].integrators, time->integrator)) note_key(rd, map, owned[k].key, why);
  if (time->linear)
    note_key(rd, map, "ends_at_collapse", "a linear static solution does not use it");
}

/* ---- materials and damage -------------------------------------------------------------------- */

static void look_at_material(sdr_reading *rd, const sdr_node *map)
{
  const sdr_law law = rd->scene->damage.law;
  if (!map || map->kind != SDR_MAPPING) return;
  if (law == SDR_LAW_NONE) note_key(rd, map, "toughness", "there is no damage law");
  if (law != SDR_LAW_COHESIVE)
    note_key(rd, map, "strength", "only the damage law cohesive uses it");
}

static void look_at_damage(sdr_reading *rd)
{
  static const char *const keys[] = {"ell", "onset", "split", "protect"};
  const sdr_law law = rd->scene->damage.law;
  const sdr_node *list = sdr_node_find(rd->root, "materials");
  const sdr_node *map = sdr_node_find(rd->root, "damage");
  look_at_material(rd, sdr_node_find(rd->root, "material"));
  for (const sdr_node *item = list ? list->first : NULL; item; item = item->next)
    look_at_material(rd, item);
  for (size_t k = 0; law == SDR_LAW_NONE && k < sizeof keys / sizeof *keys; ++k)
    note_key(rd, map, keys[k], "there is no damage law");
  if (law == SDR_LAW_CRITICAL_STRETCH)
    note_key(rd, map, "ell", "the law critical_stretch does not use it");
}

/* ---- loads and supports ---------------------------------------------------------------------- */

static void look_at_schedule(sdr_reading *rd, const char *list, int index,
                             const sdr_schedule *schedule)
{
  if (!(schedule->from > rd->scene->time.end)) return;
  sdr_note_idle(rd->reader, "%s.%d: begins at %g s, after the end of the run at %g s", list, index,
                schedule->from, rd->scene->time.end);
}

void sdr_find_idle(sdr_reading *rd)
{
  const sdr_scene *scene = rd->scene;
  look_at_damage(rd);
  look_at_time(rd);
  for (int k = 0; k < scene->load_count; ++k)
    look_at_schedule(rd, "loads", k, &scene->load[k].schedule);
  for (int k = 0; k < scene->support_count; ++k)
    look_at_schedule(rd, "supports", k, &scene->support[k].schedule);
}
