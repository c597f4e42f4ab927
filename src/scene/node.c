#include "scene/node.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

sdr_node *sdr_node_create(sdr_store *store, sdr_node_kind kind, sdr_origin origin)
{
  sdr_node *node = sdr_store_alloc(store, 1, sizeof *node);
  if (!node) return NULL;
  node->kind = kind;
  node->origin = node->key_origin = origin;
  if (kind == SDR_SCALAR) node->text = "";
  return node;
}

void sdr_node_append(sdr_node *parent, sdr_node *child)
{
  child->parent = parent;
  child->next = NULL;
  if (parent->last) {
    parent->last->next = child;
  } else {
    parent->first = child;
  }
  parent->last = child;
  ++parent->count;
}

/* The pointer that points to `node` in its parent's list, and the node before it. */
static sdr_node **link_to(const sdr_node *node, sdr_node **before)
{
  sdr_node **link = &node->parent->first;
  *before = NULL;
  while (*link != node) {
    *before = *link;
    link = &(*link)->next;
  }
  return link;
}

void sdr_node_replace(sdr_node *old, sdr_node *fresh)
{
  sdr_node *before;
  sdr_node **link = link_to(old, &before);
  fresh->parent = old->parent;
  fresh->key = old->key;
  fresh->next = old->next;
  *link = fresh;
  if (old->parent->last == old) old->parent->last = fresh;
}

void sdr_node_remove(sdr_node *child)
{
  sdr_node *before;
  sdr_node **link = link_to(child, &before);
  *link = child->next;
  if (child->parent->last == child) child->parent->last = before;
  --child->parent->count;
}

sdr_node *sdr_node_find(const sdr_node *mapping, const char *key)
{
  if (!mapping || mapping->kind != SDR_MAPPING) return NULL;
  for (sdr_node *child = mapping->first; child; child = child->next) {
    if (strcmp(child->key, key) == 0) return child;
  }
  return NULL;
}

sdr_node *sdr_node_item(const sdr_node *node, int index)
{
  sdr_node *child = node->first;
  while (child && index-- > 0) child = child->next;
  return child;
}

int sdr_node_is_null(const sdr_node *node)
{
  static const char *const nulls[] = {"", "~", "null", "Null", "NULL"};
  if (node->kind != SDR_SCALAR || node->quoted) return 0;
  for (size_t k = 0; k < sizeof nulls / sizeof *nulls; ++k) {
    if (strcmp(node->text, nulls[k]) == 0) return 1;
  }
  return 0;
}

const char *sdr_node_kind_name(sdr_node_kind kind)
{
  return kind == SDR_MAPPING ? "a mapping" : kind == SDR_SEQUENCE ? "a list" : "a single value";
}

/* The reader's depth limit bounds the recursion. */
sdr_node *sdr_node_copy(sdr_store *store, const sdr_node *node)
{
  sdr_node *copy = sdr_store_alloc(store, 1, sizeof *copy);
  if (!copy) return NULL;
  *copy = *node;
  copy->first = copy->last = copy->next = copy->parent = NULL;
  copy->known = copy->last_key = NULL;
  copy->count = 0;
  for (const sdr_node *child = node->first; child; child = child->next) {
    sdr_node *child_copy = sdr_node_copy(store, child);
    if (!child_copy) return NULL;
    sdr_node_append(copy, child_copy);
  }
  return copy;
}

static int are_alternatives(const sdr_node *base, const sdr_node *over,
                            int (*is_choice)(const char *key))
{
  return is_choice && base->count == 1 && over->count == 1 && is_choice(base->first->key) &&
         is_choice(over->first->key) && strcmp(base->first->key, over->first->key) != 0;
}

static sdr_status merge_entry(sdr_store *store, sdr_node *base, const sdr_node *over,
                              int (*is_choice)(const char *key))
{
  sdr_node *mine = sdr_node_find(base, over->key);
  if (mine && mine->kind == SDR_MAPPING && over->kind == SDR_MAPPING &&
      !are_alternatives(mine, over, is_choice)) {
    return sdr_node_merge(store, mine, over, is_choice);
  }
  sdr_node *copy = sdr_node_copy(store, over);
  if (!copy) return SDR_RUN_FAILED;
  if (mine) {
    sdr_node_replace(mine, copy);
  } else {
    sdr_node_append(base, copy);
  }
  return SDR_OK;
}

sdr_status sdr_node_merge(sdr_store *store, sdr_node *base, const sdr_node *over,
                          int (*is_choice)(const char *key))
{
  for (const sdr_node *child = over->first; child; child = child->next) {
    SDR_TRY(merge_entry(store, base, child, is_choice));
  }
  return SDR_OK;
}

/* The child of `at` that one part of a path names. *index: where it is or would be in a list. */
static sdr_status path_child(const sdr_node *at, const char *part, sdr_node **child)
{
  *child = NULL;
  if (at->kind == SDR_MAPPING) {
    *child = sdr_node_find(at, part);
    return SDR_OK;
  }
  char path[256];
  sdr_node_path(at, path, sizeof path);
  if (at->kind == SDR_SCALAR) {
    return sdr_fail(SDR_BAD_INPUT, "%s is a single value and has no '%s' in it", path, part);
  }
  char *end;
  const long index = strtol(part, &end, 10);
  if (*part < '0' || *part > '9' || *end != '\0') {
    return sdr_fail(SDR_BAD_INPUT, "%s is a list: '%s' must be a number from 0 to %d", path, part,
                    at->count);
  }
  if (index > at->count) {
    return sdr_fail(SDR_BAD_INPUT, "%s has %d entr%s; the index %ld is past its end (0 to %d)",
                    path, at->count, at->count == 1 ? "y" : "ies", index, at->count);
  }
  *child = sdr_node_item(at, (int)index);
  return SDR_OK;
}

static sdr_status add_child(sdr_store *store, sdr_node *at, const char *part, sdr_node *child)
{
  child->key = NULL;
  if (at->kind == SDR_MAPPING) {
    child->key = sdr_store_copy(store, part, strlen(part));
    if (!child->key) return SDR_RUN_FAILED;
  }
  sdr_node_append(at, child);
  return SDR_OK;
}

/* One step along the path: *at moves to the child named `part`; at the last part `value` takes its
   place. */
static sdr_status set_step(sdr_store *store, sdr_node **at, const char *part, int is_last,
                           sdr_node *value)
{
  sdr_node *child;
  SDR_TRY(path_child(*at, part, &child));
  sdr_node *fresh = is_last ? value : NULL;
  if (!is_last && (!child || sdr_node_is_null(child))) {
    fresh = sdr_node_create(store, SDR_MAPPING, value->origin);
    if (!fresh) return SDR_RUN_FAILED;
  }
  if (fresh && child) {
    sdr_node_replace(child, fresh);
  } else if (fresh) {
    SDR_TRY(add_child(store, *at, part, fresh));
  }
  *at = fresh ? fresh : child;
  return SDR_OK;
}

sdr_status sdr_node_set(sdr_store *store, sdr_node *root, const char *path, sdr_node *value)
{
  char *parts = sdr_store_copy(store, path, strlen(path));
  if (!parts) return SDR_RUN_FAILED;
  sdr_node *at = root;
  int depth = 0;
  for (char *part = parts; part;) {
    char *dot = strchr(part, '.');
    if (dot) *dot = '\0';
    if (*part == '\0') {
      return sdr_fail(SDR_BAD_INPUT, "the path has an empty part; write it like time.end=1 us");
    }
    if (++depth > 32) return sdr_fail(SDR_BAD_INPUT, "the path has more than 32 parts");
    SDR_TRY(set_step(store, &at, part, !dot, value));
    part = dot ? dot + 1 : NULL;
  }
  return SDR_OK;
}

void sdr_node_path(const sdr_node *node, char *path, size_t size)
{
  const sdr_node *chain[128];
  int depth = 0;
  for (; node && node->parent && depth < 128; node = node->parent) chain[depth++] = node;
  path[0] = '\0';
  for (size_t used = 0; depth > 0 && used < size;) {
    const sdr_node *at = chain[--depth];
    const char *dot = used ? "." : "";
    int index = 0;
    for (const sdr_node *k = at->parent->first; k != at; k = k->next) ++index;
    const int wrote = at->key ? snprintf(path + used, size - used, "%s%s", dot, at->key)
                              : snprintf(path + used, size - used, "%s%d", dot, index);
    used += (size_t)wrote;
  }
  if (path[0] == '\0') snprintf(path, size, "the scene");
}
