/* Damage that HDF5 1.10 does not get through, to the first group (the root) of a file of its
   default format. */
#ifndef SDR_TESTS_DAMAGED_H5_H
#define SDR_TESTS_DAMAGED_H5_H

#include "support/cmocka_all.h"

#include <fcntl.h>
#include <string.h>
#include <unistd.h>

/* Where `signature`, of four letters, stands first. */
static inline off_t place_of_signature(int file, const char *signature)
{
  char start[4096];
  const ssize_t size = pread(file, start, sizeof start, 0);
  for (ssize_t k = 0; k + 4 <= size; ++k)
    if (memcmp(start + k, signature, 4) == 0) return k;
  fail_msg("no %s in the file", signature);
  return 0;
}

/* The free blocks of the heap of names follow each other for ever: HDF5 hangs. A heap's header
   holds, from byte 16 on, the place of the first free block and the address of the names; a free
   block starts with the place of the next. */
static inline void loop_the_names(const char *path)
{
  uint64_t place[2];
  const int file = open(path, O_RDWR);
  const off_t heap = place_of_signature(file, "HEAP");
  assert_int_equal(pread(file, place, sizeof place, heap + 16), sizeof place);
  assert_int_equal(pwrite(file, &place[0], 8, (off_t)(place[1] + place[0])), 8);
  close(file);
}

/* The tree of members is its own branch: HDF5 follows it until its stack overflows. A node holds
   its level in byte 5 and its first branch from byte 32 on. */
static inline void loop_the_members(const char *path)
{
  const int file = open(path, O_RDWR);
  const off_t node = place_of_signature(file, "TREE");
  const uint64_t itself = (uint64_t)node;
  assert_int_equal(pwrite(file, "\1", 1, node + 5), 1);
  assert_int_equal(pwrite(file, &itself, 8, node + 32), 8);
  close(file);
}

#endif
