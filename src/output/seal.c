#include "output/seal.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { PIECE = 1 << 15 }; /* a whole number of words */

/* FNV-1a by words of 8 bytes; the shift brings high bits down again, which bytes would not need. */
static uint64_t add(uint64_t sum, const char *data, size_t bytes)
{
  for (size_t k = 0; k < bytes; k += 8) {
    uint64_t word = 0;
    memcpy(&word, data + k, bytes - k < 8 ? bytes - k : 8);
    sum = (sum ^ word) * UINT64_C(0x100000001b3);
    sum ^= sum >> 29;
  }
  return sum;
}

/* Read until `size` bytes are there or the file ends; what there was, negative on failure. */
static ssize_t read_piece(int file, char *to, size_t size, off_t at)
{
  size_t done = 0;
  while (done < size) {
    const ssize_t got = pread(file, to + done, size - done, at + (off_t)done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) break;
    done += (size_t)got;
  }
  return (ssize_t)done;
}

/* The seal that fits the file, a line of text; 0, or the errno of what failed. */
static int make_seal(int file, char seal[SDR_SEAL_BYTES])
{
  char piece[PIECE];
  uint64_t sum = UINT64_C(0xcbf29ce484222325);
  int64_t length = 0;
  ssize_t got;
  while ((got = read_piece(file, piece, PIECE, SDR_SEAL_BYTES + (off_t)length)) > 0) {
    sum = add(sum, piece, (size_t)got);
    length += got;
  }
  const int failed = got < 0 ? errno : 0;
  memset(seal, 0, SDR_SEAL_BYTES);
  snprintf(seal, SDR_SEAL_BYTES, "sunder: %" PRId64 " bytes follow, seal %016" PRIx64 "\n", length,
           sum);
  return failed;
}

sdr_status sdr_seal_write(const char *path)
{
  char seal[SDR_SEAL_BYTES];
  const int file = open(path, O_RDWR | O_CLOEXEC);
  int failed = file < 0 ? errno : make_seal(file, seal);
  if (!failed && pwrite(file, seal, sizeof seal, 0) != (ssize_t)sizeof seal)
    failed = errno ? errno : ENOSPC;
  if (file >= 0 && close(file) != 0 && !failed) failed = errno;
  if (!failed) return SDR_OK;
  return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, strerror(failed));
}

int sdr_seal_holds(const char *path)
{
  char there[SDR_SEAL_BYTES], wanted[SDR_SEAL_BYTES];
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const int holds = read_piece(file, there, sizeof there, 0) == (ssize_t)sizeof there &&
                    make_seal(file, wanted) == 0 && memcmp(there, wanted, sizeof there) == 0;
  close(file);
  return holds;
}
