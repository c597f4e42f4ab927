/* What the fuzzing targets share: bytes as a file, and a stop where a promise is broken. */
#ifndef SDR_TESTS_FUZZ_H
#define SDR_TESTS_FUZZ_H

#include "base/memory.h"
#include "base/status.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define PROMISE(holds)                                                                             \
  do {                                                                                             \
    if (!(holds)) {                                                                                \
      fprintf(stderr, "%s:%d: broken: %s\n", __FILE__, __LINE__, #holds);                          \
      abort();                                                                                     \
    }                                                                                              \
  } while (0)

/* A file in memory that holds the bytes; its path goes to `path`. Closed by close(). */
static inline int fuzz_file(const void *data, size_t size, char path[64])
{
  const int file = memfd_create("fuzz", MFD_CLOEXEC);
  PROMISE(file >= 0 && write(file, data, size) == (ssize_t)size);
  snprintf(path, 64, "/proc/self/fd/%d", file);
  return file;
}

#endif
