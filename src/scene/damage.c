#include "scene/sections.h"

#include <math.h>
#include <string.h>

static void read_protect(sdr_reading *rd, sdr_node *map)
{
  sdr_damage_scene *damage = &rd->scene->damage;
  sdr_node *list = sdr_read_list(rd->reader, map, "protect", "[]");
  if (!list || list->count == 0) return;
  damage->protect = sdr_reading_room(rd, list, sizeof *damage->protect);
  if (!damage->protect) return;
  for (sdr_node *item = list->first; item; item = item->next) {
    sdr_read_place_node(rd, item, SDR_VOLUME_PLACE, &damage->protect[damage->protect_count++]);
  }
}

/* Bond-based: 1 horizon, but none for cohesive; state-based: "auto". */
static void read_ell(sdr_reading *rd, sdr_node *map)
{
  sdr_length *ell = &rd->scene->damage.ell;
  const int bonds = rd->scene->model == SDR_BOND_BASED;
  const sdr_node *node = sdr_node_find(map, "ell");
  const int is_auto = node && node->kind == SDR_SCALAR && strcmp(node->text, "auto") == 0;
  *ell = (sdr_length){bonds ? 1 : 0, 1};
  if (bonds && is_auto) {
    sdr_read_allow(rd->reader, map, "ell");
    sdr_read_error(rd->reader, node->origin,
                   "damage.ell 'auto' belongs to the models ordinary and nonordinary; the model "
                   "here is bond_based, so give a length");
    return;
  }
  if (rd->scene->damage.law == SDR_LAW_COHESIVE) {
    if (!node) return;
    sdr_read_allow(rd->reader, map, "ell");
    sdr_read_error(rd->reader, node->key_origin,
                   "'ell' has no place in the law cohesive, which takes strength and toughness; "
                   "leave it out");
    return;
  }
  if (!bonds && (!node || is_auto)) {
    sdr_read_value(rd->reader, map, "ell", "auto", "a length");
    return;
  }
  sdr_read_length(rd->reader, map, "ell", "horizon", SDR_ABOVE_ZERO(SDR_LENGTH), "1 horizon", ell);
}

/* Which part of the energy at a point drives its damage. */
static void read_split(sdr_reading *rd, sdr_node *map)
{
  static const char *const splits[] = {"dilatation", "spectral", NULL};
  sdr_scene *scene = rd->scene;
  const sdr_node *node = sdr_node_find(map, "split");
  int split = SDR_SPLIT_DILATATION;
  if (scene->model == SDR_BOND_BASED) {
    if (!node) return;
    sdr_read_allow(rd->reader, map, "split");
    sdr_read_error(rd->reader, node->key_origin,
                   "'split' belongs to the models ordinary and nonordinary; the model here is "
                   "bond_based, whose bonds are split by the sign of their stretch");
    return;
  }
  if (!sdr_read_word(rd->reader, map, "split", splits, NULL, "dilatation", &split)) return;
  scene->split = (sdr_split)split;
  if (split == SDR_SPLIT_SPECTRAL && scene->model == SDR_ORDINARY) {
    sdr_read_error(rd->reader, node->origin,
                   "the split 'spectral' belongs to the model nonordinary; the model here is "
                   "ordinary, so take dilatation");
  }
}

/* Laws of bonds only, without float kernels. */
static void check_model(sdr_reading *rd, sdr_node *map)
{
  const sdr_law law = rd->scene->damage.law;
  if (law != SDR_LAW_AT1 && law != SDR_LAW_COHESIVE) return;
  const sdr_node *node = sdr_node_find(map, "law");
  if (rd->scene->mixed)
    sdr_read_error(rd->reader, node->origin,
                   "the law '%s' needs precision double; the precision here is mixed", node->text);
  if (rd->scene->model == SDR_BOND_BASED) return;
  sdr_read_error(rd->reader, node->origin,
                 "the law '%s' belongs to the model bond_based; the model here is %s, so take "
                 "variational or critical_stretch",
                 node->text, sdr_model_words[rd->scene->model]);
}

int sdr_is_lawless(const sdr_reading *rd)
{
  const sdr_node *map = sdr_node_find(rd->root, "damage");
  const sdr_node *law = map && map->kind == SDR_MAPPING ? sdr_node_find(map, "law") : NULL;
  const int in_error = law && (law->kind != SDR_SCALAR || strcmp(law->text, "none") != 0);
  return rd->scene->damage.law == SDR_LAW_NONE && !in_error;
}

/* Without the section there is no damage; a section must name its law. */
void sdr_read_damage(sdr_reading *rd)
{
  static const char *const laws[] = {[SDR_LAW_NONE] = "none",
                                     [SDR_LAW_VARIATIONAL] = "variational",
                                     [SDR_LAW_CRITICAL_STRETCH] = "critical_stretch",
                                     [SDR_LAW_AT1] = "at1",
                                     [SDR_LAW_COHESIVE] = "cohesive",
                                     NULL};
  sdr_reader *r = rd->reader;
  sdr_damage_scene *damage = &rd->scene->damage;
  const int is_given = sdr_read_has(r, rd->root, "damage");
  sdr_node *map = sdr_read_map(r, rd->root, "damage", "{}");
  int law = SDR_LAW_NONE;
  damage->onset = NAN;
  if (!map) return;
  sdr_read_word(r, map, "law", laws, NULL, is_given ? NULL : "none", &law);
  damage->law = (sdr_law)law;
  check_model(rd, map);
  read_ell(rd, map);
  read_split(rd, map);
  sdr_read_number_or(r, map, "onset", "auto", NAN, (sdr_quantity){SDR_PLAIN, 0, 1, 1, 0}, "auto",
                     &damage->onset);
  read_protect(rd, map);
  sdr_read_done(r, map);
}
