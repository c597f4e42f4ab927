#include "scene/hash.h"

#include <stdlib.h>
#include <string.h>

static void add(uint64_t *hash, const char *text)
{
  for (; *text; ++text) *hash = (*hash ^ (unsigned char)*text) * UINT64_C(1099511628211);
}

/* 1 if the key at this place does not affect the state. */
static int is_left_out(const sdr_node *mapping, const char *key)
{
  static const char *const paths[][2] = {
      {NULL, "title"},   {NULL, "output"}, {NULL, "figures"},          {NULL, "variants"},
      {NULL, "threads"}, {"time", "end"},  {"time", "allow_unstable"}, {"damage", "onset"}};
  const int is_root = !mapping->parent;
  const char *parent = !is_root && !mapping->parent->parent ? mapping->key : NULL;
  for (size_t k = 0; k < sizeof paths / sizeof *paths; ++k) {
    if (strcmp(paths[k][1], key) != 0) continue;
    if (paths[k][0] ? parent && strcmp(parent, paths[k][0]) == 0 : is_root) return 1;
  }
  return 0;
}

/* The child with the smallest key above `key` (NULL: the smallest of all). */
static const sdr_node *next_in_order(const sdr_node *mapping, const char *key)
{
  const sdr_node *best = NULL;
  for (const sdr_node *child = mapping->first; child; child = child->next) {
    if (key && strcmp(child->key, key) <= 0) continue;
    if (!best || strcmp(child->key, best->key) < 0) best = child;
  }
  return best;
}

static void add_node(uint64_t *hash, const sdr_node *node)
{
  if (node->kind == SDR_SCALAR) {
    add(hash, node->canonical ? node->canonical : node->text);
    return;
  }
  if (node->kind == SDR_SEQUENCE) {
    add(hash, "[");
    for (const sdr_node *child = node->first; child; child = child->next) {
      add_node(hash, child);
      add(hash, ",");
    }
    add(hash, "]");
    return;
  }
  add(hash, "{");
  for (const sdr_node *child = next_in_order(node, NULL); child;
       child = next_in_order(node, child->key)) {
    if (is_left_out(node, child->key)) continue;
    add(hash, child->key);
    add(hash, ":");
    add_node(hash, child);
    add(hash, ";");
  }
  add(hash, "}");
}

uint64_t sdr_scene_tree_hash(const sdr_node *root)
{
  uint64_t hash = UINT64_C(14695981039346656037);
  add_node(&hash, root);
  return hash;
}
