/* scene: YAML text to trees and back, merging and overriding. */
#include "base/memory.h"
#include "scene/yaml.h"
#include "support/cmocka_all.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static sdr_store *store;

static int open_store(void **state)
{
  (void)state;
  store = sdr_store_create();
  return store ? 0 : -1;
}

static int close_store(void **state)
{
  (void)state;
  sdr_store_destroy(&store);
  return 0;
}

static sdr_node *parse(const char *text)
{
  sdr_node *root = NULL;
  if (sdr_yaml_parse(store, text, strlen(text), "f", &root) != SDR_OK) {
    fail_msg("%s", sdr_error_message());
  }
  return root;
}

static void assert_refused(const char *text, const char *message)
{
  sdr_node *root = NULL;
  assert_int_equal(sdr_yaml_parse(store, text, strlen(text), "f", &root), SDR_BAD_INPUT);
  assert_null(root);
  assert_string_equal(sdr_error_message(), message);
}

static void assert_writes(const sdr_node *node, const char *expected)
{
  char *text = sdr_yaml_write(node);
  assert_non_null(text);
  assert_string_equal(text, expected);
  sdr_free(text);
}

static void nodes_know_line_and_column(void **state)
{
  (void)state;
  const sdr_node *root =
      parse("\xEF\xBB\xBF# first\r\na: 1\r\n\xC3\xBC: {c: 'two', d: [x, y]}\r\n");
  const sdr_node *map = sdr_node_item(root, 1), *d = sdr_node_find(map, "d");
  assert_int_equal(root->count, 2);
  assert_int_equal(sdr_node_find(root, "a")->origin.line, 2);
  assert_int_equal(sdr_node_find(root, "a")->origin.column, 4);
  assert_int_equal(map->key_origin.line, 3);
  assert_int_equal(sdr_node_find(map, "c")->key_origin.column, 5); /* code points, not bytes */
  assert_int_equal(sdr_node_find(map, "c")->text_column, 9);
  assert_string_equal(sdr_node_item(d, 1)->text, "y");
  assert_string_equal(sdr_origin_text(d->origin), "f:3:18");
  char path[64];
  sdr_node_path(sdr_node_item(d, 1), path, sizeof path);
  assert_string_equal(path, "\xC3\xBC.d.1");
}

static void what_scenes_do_not_need_is_refused(void **state)
{
  (void)state;
  assert_refused("a: &x 1", "f:1:4: anchors (&name) are not read; write the value out");
  assert_refused("a: &x [1]", "f:1:4: anchors (&name) are not read; write the value out");
  assert_refused("a: *x", "f:1:4: aliases (*name) are not read; write the value out (a text that "
                          "begins with * needs quotes)");
  assert_refused("a: !!str 1", "f:1:4: tags (!name) are not read; remove the tag");
  assert_refused("a: !t {b: 1}", "f:1:4: tags (!name) are not read; remove the tag");
  assert_refused("a: 1\nb: 2\na: 3\n",
                 "f:3:1: the key 'a' stands twice, first in line 1; keep one");
  assert_refused("a: 1\n---\nb: 2\n", "f:2:1: a second document begins (---); a scene is one");
  assert_refused("{[1]: 2}", "f:1:2: a key must be a plain word, not a list or a mapping");
  assert_refused("{? : 2}", "f:1:4: an empty key; write key: value");
  assert_refused("a: \"x\\0y\"", "f:1:4: a text with a zero byte (\\0) in it");
}

static void what_is_no_yaml_says_where_and_how_to_mend(void **state)
{
  (void)state;
  assert_refused("a:\n\tb: 1\n",
                 "f:2:1: not YAML: found character that cannot start any token (while scanning for "
                 "the next token); indent with blanks, not tabs");
  assert_refused("a: %x\n",
                 "f:1:4: not YAML: found character that cannot start any token (while scanning for "
                 "the next token); put a text that begins like this in quotes");
  assert_refused("a: b: c\n", "f:1:5: not YAML: mapping values are not allowed in this context; a "
                              "text with ': ' in it needs quotes, and a key must begin its line");
  assert_refused(
      "a: 1\nb:2\nc: 3\n",
      "f:2:1: not YAML: could not find expected ':' (while scanning a simple key); write "
      "key: value, with a blank after the colon");
  assert_refused("a: [1, 2\n", "f:2:1: not YAML: did not find expected ',' or ']' (while parsing a "
                               "flow sequence)");
  assert_refused("a: \x01\n",
                 "f:1:4: not a text file in UTF-8: control characters are not allowed");
  assert_refused("a: 1\nb: \xFF\n", "f:2:4: not a text file in UTF-8: invalid leading UTF-8 octet");
}

static void depth_and_number_of_values_are_limited(void **state)
{
  (void)state;
  char *text = malloc(1000001);
  memset(text, '[', 1000000);
  text[1000000] = '\0';
  assert_refused(text, "f:1:65: nested deeper than 64 levels");
  strcpy(text, "[");
  for (int k = 0; k < 200001; ++k) memcpy(text + 1 + 2 * k, "1,", 2);
  strcpy(text + 1 + 2 * 200001, "]");
  assert_refused(text, "f:1:400000: more than 200000 values; a scene file holds fewer");
  free(text);
}

static void an_empty_text_has_no_root(void **state)
{
  (void)state;
  assert_null(parse(""));
  assert_null(parse("# only a comment\n"));
}

static void what_is_written_reads_back_the_same(void **state)
{
  (void)state;
  const char *text = "a: 1 mm\nb: \"x: y # z\"\nc: \"null\"\nd: null\ne:\n  f: {g: []}\n"
                     "h:\n  - {i: \"a, b\", j: [1, -2.5e3]}\n  - []\nk: \"tab\\u0009 quote\\\" "
                     "back\\\\slash\"\nl: {}\nm: \"- x\"\nn: \"\xC3\xBC \xE2\x82\xAC\"\no: \"\"\n"
                     "p: \"yes \"\nq: [[1, 2], [3]]\n";
  sdr_node *once = parse(text);
  char *first = sdr_yaml_write(once);
  char *second = sdr_yaml_write(parse(first));
  assert_string_equal(first, second);
  assert_string_equal(sdr_node_find(parse(first), "k")->text, "tab\t quote\" back\\slash");
  assert_true(sdr_node_is_null(sdr_node_find(parse(first), "d")));
  assert_false(sdr_node_is_null(sdr_node_find(parse(first), "c")));
  assert_false(sdr_node_is_null(sdr_node_find(parse(first), "o")));
  assert_string_equal(sdr_node_find(parse(first), "p")->text, "yes ");
  sdr_free(first);
  sdr_free(second);
}

static int is_choice(const char *key)
{
  return strcmp(key, "disc") == 0 || strcmp(key, "box") == 0;
}

static void mappings_merge_deep_and_lists_are_replaced(void **state)
{
  (void)state;
  sdr_node *base = parse("{a: {b: 1, c: 2}, l: [1, 2], s: {disc: {r: 1}}, t: {disc: {r: 1}}}");
  const sdr_node *over = parse("{a: {c: 3, d: 4}, l: [9], s: {box: {w: 2}}, t: {disc: {q: 2}}}");
  assert_int_equal(sdr_node_merge(store, base, over, is_choice), SDR_OK);
  assert_writes(base, "a:\n  b: 1\n  c: 3\n  d: 4\nl: [9]\ns:\n  box:\n    w: 2\n"
                      "t:\n  disc:\n    r: 1\n    q: 2\n");
  assert_string_equal(sdr_node_find(over, "l")->key, "l");
  assert_int_equal(over->count, 4);
}

static void a_path_sets_what_it_names(void **state)
{
  (void)state;
  sdr_node *root = parse("{a: {b: 1}, l: [{v: 1}, {v: 2}], n: }");
  assert_int_equal(sdr_node_set(store, root, "a.b", parse("5")), SDR_OK);
  assert_int_equal(sdr_node_set(store, root, "l.1.v", parse("[1, 2]")), SDR_OK);
  assert_int_equal(sdr_node_set(store, root, "l.2", parse("end")), SDR_OK);
  assert_int_equal(sdr_node_set(store, root, "n.x.y", parse("new")), SDR_OK);
  assert_writes(root, "a:\n  b: 5\nl:\n  - {v: 1}\n  - {v: [1, 2]}\n  - end\n"
                      "n:\n  x:\n    y: new\n");
  static const char *const wrong[][2] = {
      {"a.b.c", "a.b is a single value and has no 'c' in it"},
      {"l.x", "l is a list: 'x' must be a number from 0 to 3"},
      {"l.7.v", "l has 3 entries; the index 7 is past its end (0 to 3)"},
      {"a..b", "the path has an empty part; write it like time.end=1 us"},
      {"", "the path has an empty part; write it like time.end=1 us"}};
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
    assert_int_equal(sdr_node_set(store, root, wrong[k][0], parse("1")), SDR_BAD_INPUT);
    assert_string_equal(sdr_error_message(), wrong[k][1]);
  }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, open_store, close_store)
  const struct CMUnitTest tests[] = {
      TEST(nodes_know_line_and_column),
      TEST(what_scenes_do_not_need_is_refused),
      TEST(what_is_no_yaml_says_where_and_how_to_mend),
      TEST(depth_and_number_of_values_are_limited),
      TEST(an_empty_text_has_no_root),
      TEST(what_is_written_reads_back_the_same),
      TEST(mappings_merge_deep_and_lists_are_replaced),
      TEST(a_path_sets_what_it_names),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
