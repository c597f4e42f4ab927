#include "scene/sections.h"

#include <math.h>
#include <string.h>

/* Penalty forces would make implicit equations stiff and jumpy; none of their solvers knows them.
 */
static void check_integrator(sdr_reading *rd, const sdr_node *map)
{
  const char *integrator = rd->scene->time.integrator;
  if (!*integrator || strcmp(integrator, "leapfrog") == 0) return;
  sdr_read_error(rd->reader, map->key_origin,
                 "contact needs the integrator leapfrog; the integrator here is %s, so leave "
                 "contact out",
                 integrator);
}

/* Off unless the section is there; null turns it off again in a variant. */
void sdr_read_contact(sdr_reading *rd)
{
  sdr_reader *r = rd->reader;
  sdr_length range = {1.0, 1};
  const sdr_node *node = sdr_node_find(rd->root, "contact");
  if (!node || sdr_node_is_null(node)) return;
  sdr_node *map = sdr_read_map(r, rd->root, "contact", "{}");
  if (!map) return;
  rd->scene->contact.on = 1;
  check_integrator(rd, map);
  sdr_read_length(r, map, "range", "spacing", SDR_ABOVE_ZERO(SDR_LENGTH), "1 spacing", &range);
  if (!range.relative)
    sdr_read_error(r, sdr_node_find(map, "range")->origin,
                   "the range of contact is a multiple of the spacing, like 1 spacing");
  else if (range.value > 1.0)
    sdr_read_error(r, sdr_node_find(map, "range")->origin,
                   "the range of contact is at most 1 spacing: nearest points of a body are no "
                   "farther apart");
  rd->scene->contact.range = range.value;
  sdr_read_number(r, map, "penalty", (sdr_quantity){SDR_PLAIN, 0, INFINITY, 1, 0}, "0.1",
                  &rd->scene->contact.penalty);
  sdr_read_done(r, map);
}
