#include "base/memory.h"
#include "scene/yaml.h"

#include <stdio.h>
#include <string.h>

/* Text that grows; once memory runs out `bytes` is NULL and stays so. */
typedef struct {
  char *bytes;
  size_t used, size;
} writer;

static void put_bytes(writer *w, const char *bytes, size_t count)
{
  if (!w->bytes) return;
  if (w->used + count + 1 > w->size) {
    const size_t size = 2 * (w->used + count + 1);
    char *grown = sdr_realloc(w->bytes, size, 1);
    if (!grown) {
      sdr_free(w->bytes);
      w->bytes = NULL;
      return;
    }
    w->bytes = grown;
    w->size = size;
  }
  memcpy(w->bytes + w->used, bytes, count);
  w->used += count;
}

static void put(writer *w, const char *text)
{
  put_bytes(w, text, strlen(text));
}

/* 1 if the text reads back as the same plain scalar in block and in flow style. */
static int is_plain(const char *text)
{
  static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
  static const char inside[] = " _.+-*/^()<>=%";
  const sdr_node probe = {.kind = SDR_SCALAR, .text = text};
  const size_t length = strlen(text);
  if (sdr_node_is_null(&probe) || length > 200) return 0;
  const char *first = text[0] == '-' || text[0] == '.' ? text + 1 : text;
  if (*first == '\0' || !strchr(letters, *first)) return 0;
  if (strncmp(text, "---", 3) == 0 || strncmp(text, "...", 3) == 0) return 0;
  for (const char *c = text; *c; ++c) {
    if (!strchr(letters, *c) && !strchr(inside, *c)) return 0;
  }
  return text[length - 1] != ' ';
}

/* Code point of a valid UTF-8 sequence and its length in bytes. */
static unsigned decode(const char *text, size_t *length)
{
  const unsigned char first = (unsigned char)text[0];
  *length = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (*length == 1) return first;
  unsigned code = first & (0xFFu >> (*length + 1));
  for (size_t k = 1; k < *length && text[k]; ++k) {
    code = (code << 6) | ((unsigned char)text[k] & 0x3Fu);
  }
  return code;
}

static void put_quoted(writer *w, const char *text)
{
  put(w, "\"");
  while (*text) {
    size_t length;
    const unsigned code = decode(text, &length);
    if (code == '"' || code == '\\') put(w, "\\");
    if (code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x2028 || code == 0x2029 ||
        code == 0xFEFF) {
      char escape[16];
      snprintf(escape, sizeof escape, "\\u%04X", code);
      put(w, escape);
    } else {
      put_bytes(w, text, length);
    }
    text += length;
  }
  put(w, "\"");
}

static void put_text(writer *w, const char *text)
{
  if (is_plain(text)) {
    put(w, text);
  } else {
    put_quoted(w, text);
  }
}

/* In one line: {a: 1, b: [2, 3]}. The depth limit of reading bounds the recursion. */
static void put_flow(writer *w, const sdr_node *node)
{
  if (node->kind == SDR_SCALAR) {
    if (sdr_node_is_null(node)) {
      put(w, "null");
    } else {
      put_text(w, node->text);
    }
    return;
  }
  put(w, node->kind == SDR_MAPPING ? "{" : "[");
  for (const sdr_node *child = node->first; child; child = child->next) {
    if (node->kind == SDR_MAPPING) {
      put_text(w, child->key);
      put(w, ": ");
    }
    put_flow(w, child);
    if (child->next) put(w, ", ");
  }
  put(w, node->kind == SDR_MAPPING ? "}" : "]");
}

static int has_collections(const sdr_node *node)
{
  for (const sdr_node *child = node->first; child; child = child->next) {
    if (child->kind != SDR_SCALAR) return 1;
  }
  return 0;
}

/* The entries of a mapping a line each, indented; lists of collections an item a line. */
static void put_block(writer *w, const sdr_node *mapping, int indent)
{
  for (const sdr_node *child = mapping->first; child; child = child->next) {
    char blanks[SDR_YAML_MAX_DEPTH * 2 + 1];
    snprintf(blanks, sizeof blanks, "%*s", indent, "");
    put(w, blanks);
    put_text(w, child->key);
    put(w, ":");
    if (child->kind == SDR_MAPPING && child->count > 0 && indent < 4) {
      put(w, "\n");
      put_block(w, child, indent + 2);
    } else if (child->kind == SDR_SEQUENCE && has_collections(child)) {
      put(w, "\n");
      for (const sdr_node *item = child->first; item; item = item->next) {
        put(w, blanks);
        put(w, "  - ");
        put_flow(w, item);
        put(w, "\n");
      }
    } else {
      put(w, " ");
      put_flow(w, child);
      put(w, "\n");
    }
  }
}

char *sdr_yaml_write(const sdr_node *root)
{
  writer w = {.bytes = sdr_alloc(4096, 1), .size = 4096};
  if (root->kind == SDR_MAPPING && root->count > 0) {
    put_block(&w, root, 0);
  } else {
    put_flow(&w, root);
    put(&w, "\n");
  }
  return w.bytes;
}
