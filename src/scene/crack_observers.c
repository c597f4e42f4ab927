#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *const sdr_crack_figure_words[SDR_CRACK_FIGURES + 1] = {
    "first_time",      "start_time", "mean_speed", "max_speed",
    "rayleigh_share",  "angle",      "tips",       "branches",
    "branch_time",     "branch_x",   "branch_y",   "branch_distance",
    "branch_speed",    "length",     "area",       "energy",
    "toughness_share", "path_share", NULL};

enum { LONGEST_NAME = 40 }; /* a figure's name is longer by its word */

static int read_spacings(sdr_reading *rd, sdr_node *item, const char *key, const char *fallback,
                         sdr_length *out)
{
  return sdr_read_length(rd->reader, item, key, "spacing", SDR_FROM_ZERO(SDR_LENGTH), fallback,
                         out);
}

static void read_direction(sdr_reading *rd, sdr_node *item, sdr_crack_tip *tip)
{
  const int in_space = sdr_components(rd->reader->dimension) > 2;
  double square = 0.0;
  if (!sdr_read_vector(rd->reader, item, "direction", SDR_ANY_VALUE(SDR_PLAIN),
                       in_space ? "[1, 0, 0]" : "[1, 0]", tip->direction))
    return;
  for (int c = 0; c < 3; ++c) square += tip->direction[c] * tip->direction[c];
  if (!(square > 0.0) || isinf(square))
    sdr_read_error(rd->reader, sdr_node_find(item, "direction")->origin,
                   "the direction must have a length above 0");
  for (int c = 0; c < 3; ++c) tip->direction[c] /= sqrt(square);
}

static void read_fit(sdr_reading *rd, sdr_node *item, sdr_crack_tip *tip)
{
  sdr_reader *r = rd->reader;
  tip->fit[1] = (sdr_length){(double)INFINITY, 0};
  sdr_node *map = sdr_read_map(r, item, "fit", "{}");
  if (!map) return;
  int good = read_spacings(rd, map, "from", "0 spacing", &tip->fit[0]);
  const sdr_node *to = sdr_read_value(r, map, "to", "end", "a length, like 60 mm, or end");
  if (to && !(to->kind == SDR_SCALAR && strcmp(to->text, "end") == 0))
    good = read_spacings(rd, map, "to", NULL, &tip->fit[1]) && good;
  if (good && tip->fit[0].relative == tip->fit[1].relative &&
      !(tip->fit[0].value < tip->fit[1].value))
    sdr_read_error(r, sdr_node_find(map, "to")->origin, "'to' must be farther than 'from'");
  sdr_read_done(r, map);
}

static void read_tip(sdr_reading *rd, sdr_node *item, sdr_crack_tip *tip)
{
  sdr_reader *r = rd->reader;
  tip->origin = item->key_origin;
  if (!sdr_read_is_name(r, item->key, item->key_origin, "a tip")) return;
  if (strlen(item->key) > LONGEST_NAME)
    sdr_read_error(r, item->key_origin, "the name of a tip has at most %d letters", LONGEST_NAME);
  snprintf(tip->name, sizeof tip->name, "%s", item->key);
  for (int k = 0; k < SDR_CRACK_FIGURES; ++k)
    snprintf(tip->figure[k], sizeof tip->figure[k], "%.*s_%s", LONGEST_NAME, item->key,
             sdr_crack_figure_words[k]);
  if (!sdr_read_is(r, item, SDR_MAPPING, "the tip of a notch, {start: [50 mm, 0]}")) return;
  sdr_read_vector(r, item, "start", SDR_ANY_VALUE(SDR_LENGTH), NULL, tip->start);
  read_direction(rd, item, tip);
  read_fit(rd, item, tip);
  sdr_read_done(r, item);
}

static void read_tips(sdr_reading *rd, sdr_node *map, sdr_cracks_output *cracks)
{
  sdr_node *all = sdr_read_map(rd->reader, map, "tips", NULL);
  if (!all || all->count == 0) return;
  cracks->tip = sdr_reading_room(rd, all, sizeof *cracks->tip);
  if (!cracks->tip) return;
  for (sdr_node *item = all->first; item; item = item->next) {
    if (sdr_node_is_null(item)) continue; /* a variant may drop one */
    read_tip(rd, item, &cracks->tip[cracks->tip_count++]);
  }
}

static int have_cracks(sdr_reading *rd, const sdr_node *map)
{
  const char *why = NULL;
  if (sdr_components(rd->reader->dimension) < 2)
    why = "tips of cracks are followed in 2-D and 3-D only";
  else if (sdr_is_lawless(rd))
    why = "without a damage law no crack grows; give damage.law, or leave this out";
  if (why) sdr_read_error(rd->reader, map->key_origin, "%s", why);
  return !why;
}

void sdr_read_crack_tips(sdr_reading *rd, sdr_node *output)
{
  sdr_reader *r = rd->reader;
  sdr_cracks_output *cracks = &rd->scene->output.cracks;
  const sdr_quantity share = {SDR_PLAIN, 0, 1, 1, 0};
  sdr_node *map =
      sdr_read_has(r, output, "cracks") ? sdr_read_map(r, output, "cracks", NULL) : NULL;
  if (!map || !have_cracks(rd, map)) return;
  read_tips(rd, map, cracks);
  sdr_read_number_or(r, map, "threshold", "auto", (double)NAN, share, "auto", &cracks->threshold);
  sdr_read_number_or(r, map, "every", "auto", (double)NAN, SDR_ABOVE_ZERO(SDR_TIME), "auto",
                     &cracks->every);
  sdr_read_number_or(r, map, "count_at", "end", (double)INFINITY, SDR_FROM_ZERO(SDR_TIME), "end",
                     &cracks->count_at);
  read_spacings(rd, map, "moved", "4.5 spacing", &cracks->moved);
  read_spacings(rd, map, "window", "6 spacing", &cracks->window);
  read_spacings(rd, map, "shortest_arm", "8 spacing", &cracks->shortest);
  sdr_read_done(r, map);
}
