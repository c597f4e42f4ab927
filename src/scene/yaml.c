#include "scene/yaml.h"

#include "base/memory.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <yaml.h>

/* A tree under construction. */
typedef struct {
  sdr_store *store;
  const char *file;
  sdr_node *open[SDR_YAML_MAX_DEPTH]; /* collections not yet closed, the innermost last */
  int depth, nodes, documents;
  const char *key; /* of the entry whose value comes next, NULL: a key comes next */
  sdr_origin key_origin;
  sdr_node *root;
} builder;

static sdr_origin origin_at(const builder *b, yaml_mark_t mark)
{
  return (sdr_origin){b->file, (int)mark.line + 1, (int)mark.column + 1};
}

static sdr_status refuse(const builder *b, yaml_mark_t mark, const char *what)
{
  return sdr_fail(SDR_BAD_INPUT, "%s: %s", sdr_origin_text(origin_at(b, mark)), what);
}

/* ---- reading a file -------------------------------------------------------------------------- */

static sdr_status read_stream(FILE *stream, const char *path, char **text, size_t *length)
{
  char *bytes = sdr_alloc(SDR_YAML_MAX_BYTES + 2, 1);
  if (!bytes) return SDR_RUN_FAILED;
  const size_t got = fread(bytes, 1, SDR_YAML_MAX_BYTES + 1, stream);
  if (!ferror(stream) && got <= SDR_YAML_MAX_BYTES) {
    *text = bytes;
    *length = got;
    return SDR_OK;
  }
  const int failed = ferror(stream);
  sdr_free(bytes);
  if (failed) return sdr_fail(SDR_IO_ERROR, "%s: cannot be read: %s", path, strerror(errno));
  return sdr_fail(SDR_BAD_INPUT, "%s: larger than 4 MB, so it is no scene file", path);
}

sdr_status sdr_yaml_read_file(const char *path, char **text, size_t *length)
{
  struct stat info;
  if (stat(path, &info) != 0) {
    return sdr_fail(SDR_IO_ERROR, "%s: cannot be read: %s", path, strerror(errno));
  }
  if (S_ISDIR(info.st_mode)) {
    return sdr_fail(SDR_IO_ERROR, "%s: is a directory; give the scene file in it", path);
  }
  if (!S_ISREG(info.st_mode) && !S_ISFIFO(info.st_mode)) {
    return sdr_fail(SDR_IO_ERROR, "%s: is not a file", path);
  }
  if (info.st_size > SDR_YAML_MAX_BYTES) {
    return sdr_fail(SDR_BAD_INPUT, "%s: larger than 4 MB, so it is no scene file", path);
  }
  FILE *stream = fopen(path, "rb");
  if (!stream) return sdr_fail(SDR_IO_ERROR, "%s: cannot be read: %s", path, strerror(errno));
  const sdr_status status = read_stream(stream, path, text, length);
  fclose(stream);
  return status;
}

/* ---- events to nodes ------------------------------------------------------------------------- */

/* Hang a node into the innermost open collection, or make it the root. */
static void place_node(builder *b, sdr_node *node)
{
  if (b->depth == 0) {
    b->root = node;
    return;
  }
  if (b->key) {
    node->key = b->key;
    node->key_origin = b->key_origin;
    b->key = NULL;
  }
  sdr_node_append(b->open[b->depth - 1], node);
}

static sdr_status new_node(builder *b, sdr_node_kind kind, yaml_mark_t mark, sdr_node **node)
{
  if (++b->nodes > SDR_YAML_MAX_NODES) {
    return refuse(b, mark, "more than 200000 values; a scene file holds fewer");
  }
  *node = sdr_node_create(b->store, kind, origin_at(b, mark));
  return *node ? SDR_OK : SDR_RUN_FAILED;
}

static int expects_key(const builder *b)
{
  return b->depth > 0 && b->open[b->depth - 1]->kind == SDR_MAPPING && !b->key;
}

static sdr_status take_key(builder *b, const yaml_event_t *event)
{
  const char *text = (const char *)event->data.scalar.value;
  const size_t length = event->data.scalar.length;
  const sdr_node *mapping = b->open[b->depth - 1];
  if (length == 0) return refuse(b, event->start_mark, "an empty key; write key: value");
  const sdr_node *twin = sdr_node_find(mapping, text);
  if (twin) {
    return sdr_fail(SDR_BAD_INPUT, "%s: the key '%s' stands twice, first in line %d; keep one",
                    sdr_origin_text(origin_at(b, event->start_mark)), text, twin->key_origin.line);
  }
  if (mapping->count >= SDR_YAML_MAX_KEYS) {
    return refuse(b, event->start_mark, "more than 1000 keys in one mapping");
  }
  b->key = sdr_store_copy(b->store, text, length);
  b->key_origin = origin_at(b, event->start_mark);
  return b->key ? SDR_OK : SDR_RUN_FAILED;
}

/* The column where the text of a scalar begins, 0 if it does not stand as it is in one line. */
static int text_column(const yaml_event_t *event)
{
  const size_t width = event->end_mark.column - event->start_mark.column;
  const size_t length = event->data.scalar.length;
  if (event->end_mark.line != event->start_mark.line) return 0;
  if (width == length) return (int)event->start_mark.column + 1;
  return width == length + 2 ? (int)event->start_mark.column + 2 : 0;
}

static sdr_status take_scalar(builder *b, const yaml_event_t *event)
{
  if (event->data.scalar.anchor) {
    return refuse(b, event->start_mark, "anchors (&name) are not read; write the value out");
  }
  if (event->data.scalar.tag) {
    return refuse(b, event->start_mark, "tags (!name) are not read; remove the tag");
  }
  if (strlen((const char *)event->data.scalar.value) != event->data.scalar.length) {
    return refuse(b, event->start_mark, "a text with a zero byte (\\0) in it");
  }
  if (expects_key(b)) return take_key(b, event);
  sdr_node *node = NULL;
  SDR_TRY(new_node(b, SDR_SCALAR, event->start_mark, &node));
  node->text =
      sdr_store_copy(b->store, (const char *)event->data.scalar.value, event->data.scalar.length);
  if (!node->text) return SDR_RUN_FAILED;
  node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
  node->text_column = text_column(event);
  place_node(b, node);
  return SDR_OK;
}

static sdr_status open_collection(builder *b, sdr_node_kind kind, const yaml_event_t *event,
                                  const unsigned char *anchor, const unsigned char *tag)
{
  if (anchor) {
    return refuse(b, event->start_mark, "anchors (&name) are not read; write the value out");
  }
  if (tag) return refuse(b, event->start_mark, "tags (!name) are not read; remove the tag");
  if (expects_key(b)) {
    return refuse(b, event->start_mark, "a key must be a plain word, not a list or a mapping");
  }
  if (b->depth == SDR_YAML_MAX_DEPTH) {
    return refuse(b, event->start_mark, "nested deeper than 64 levels");
  }
  sdr_node *node = NULL;
  SDR_TRY(new_node(b, kind, event->start_mark, &node));
  place_node(b, node);
  b->open[b->depth++] = node;
  return SDR_OK;
}

static sdr_status take_event(builder *b, const yaml_event_t *event)
{
  switch (event->type) {
  case YAML_DOCUMENT_START_EVENT:
    if (++b->documents > 1) {
      return refuse(b, event->start_mark, "a second document begins (---); a scene is one");
    }
    return SDR_OK;
  case YAML_ALIAS_EVENT:
    return refuse(b, event->start_mark,
                  "aliases (*name) are not read; write the value out (a text that begins with * "
                  "needs quotes)");
  case YAML_SCALAR_EVENT:
    return take_scalar(b, event);
  case YAML_SEQUENCE_START_EVENT:
    return open_collection(b, SDR_SEQUENCE, event, event->data.sequence_start.anchor,
                           event->data.sequence_start.tag);
  case YAML_MAPPING_START_EVENT:
    return open_collection(b, SDR_MAPPING, event, event->data.mapping_start.anchor,
                           event->data.mapping_start.tag);
  case YAML_SEQUENCE_END_EVENT:
  case YAML_MAPPING_END_EVENT:
    --b->depth;
    return SDR_OK;
  default:
    return SDR_OK;
  }
}

/* ---- syntax errors --------------------------------------------------------------------------- */

/* libyaml gives only a byte offset for bytes that are no text. */
static yaml_mark_t mark_of_offset(const char *text, size_t length, size_t offset)
{
  yaml_mark_t mark = {offset, 0, 0};
  for (size_t k = 0; k < offset && k < length; ++k) {
    if (text[k] == '\n') {
      ++mark.line;
      mark.column = 0;
    } else if (((unsigned char)text[k] & 0xC0) != 0x80) {
      ++mark.column;
    }
  }
  return mark;
}

/* The byte at libyaml's index, which counts code points. */
static char byte_at(const char *text, size_t length, size_t index)
{
  size_t k = 0;
  for (; k < length; ++k) {
    if (((unsigned char)text[k] & 0xC0) == 0x80) continue;
    if (index-- == 0) return text[k];
  }
  return '\0';
}

static const char *hint_for(const char *text, size_t length, const yaml_parser_t *parser)
{
  const char at = byte_at(text, length, parser->problem_mark.index);
  if (at == '\t') return "; indent with blanks, not tabs";
  if (at != '\0' && strchr("%@`", at)) return "; put a text that begins like this in quotes";
  if (strstr(parser->problem, "mapping values are not allowed")) {
    return "; a text with ': ' in it needs quotes, and a key must begin its line";
  }
  if (parser->context && strstr(parser->context, "simple key")) {
    return "; write key: value, with a blank after the colon";
  }
  if (strstr(parser->problem, "block end")) return "; check the indentation";
  return "";
}

static sdr_status syntax_error(const builder *b, const yaml_parser_t *parser, const char *text,
                               size_t length)
{
  if (parser->error == YAML_MEMORY_ERROR) {
    return sdr_fail(SDR_RUN_FAILED, "%s: out of memory while reading", b->file);
  }
  if (parser->error == YAML_READER_ERROR) {
    const yaml_mark_t mark = mark_of_offset(text, length, parser->problem_offset);
    return sdr_fail(SDR_BAD_INPUT, "%s: not a text file in UTF-8: %s",
                    sdr_origin_text(origin_at(b, mark)), parser->problem);
  }
  /* Where a simple key lacks its colon, the key's own line is the one to mend. */
  const int at_context = parser->context && strstr(parser->context, "simple key") != NULL;
  const yaml_mark_t mark = at_context ? parser->context_mark : parser->problem_mark;
  return sdr_fail(SDR_BAD_INPUT, "%s: not YAML: %s%s%s%s%s", sdr_origin_text(origin_at(b, mark)),
                  parser->problem, parser->context ? " (" : "",
                  parser->context ? parser->context : "", parser->context ? ")" : "",
                  hint_for(text, length, parser));
}

sdr_status sdr_yaml_parse(sdr_store *store, const char *text, size_t length, const char *file,
                          sdr_node **root)
{
  if (length >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) {
    text += 3;
    length -= 3;
  }
  builder b = {.store = store, .file = file};
  yaml_parser_t parser;
  if (!yaml_parser_initialize(&parser)) {
    return sdr_fail(SDR_RUN_FAILED, "%s: out of memory while reading", file);
  }
  yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
  yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
  sdr_status status = SDR_OK;
  for (int done = 0; status == SDR_OK && !done;) {
    yaml_event_t event;
    if (!yaml_parser_parse(&parser, &event)) {
      status = syntax_error(&b, &parser, text, length);
      break;
    }
    status = take_event(&b, &event);
    done = event.type == YAML_STREAM_END_EVENT;
    yaml_event_delete(&event);
  }
  yaml_parser_delete(&parser);
  if (status == SDR_OK) *root = b.root;
  return status;
}
