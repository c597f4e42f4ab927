/* What a fallible function returns, and the one message that says why. */
#ifndef SDR_BASE_STATUS_H
#define SDR_BASE_STATUS_H

/* The values are the program's exit status (design: commands and files). */
typedef enum {
  SDR_OK = 0,
  SDR_BAD_INPUT = 1,  /* the scene, an option or a file's content is wrong */
  SDR_RUN_FAILED = 2, /* diverged, solver failed, out of memory */
  SDR_IO_ERROR = 3,   /* a file could not be read or written */
  SDR_STOPPED = 4     /* ended early at someone's wish; a checkpoint is written */
} sdr_status;

#if defined(__GNUC__)
#define SDR_PRINTF(format_index, first) __attribute__((format(printf, format_index, first)))
#else
#define SDR_PRINTF(format_index, first)
#endif

/* Record a message for this thread, replacing an earlier one, and return `status`.
   The text (UTF-8, no newline at its end; lines inside separate several errors) is kept up to
   16 KiB. Use: return sdr_fail(SDR_BAD_INPUT, "%s:%d: ...", file, line); */
sdr_status sdr_fail(sdr_status status, const char *format, ...) SDR_PRINTF(2, 3);

/* The message of the latest failure on this thread; "" if there was none. Owned by the library. */
const char *sdr_error_message(void);

/* Return from the calling function with the status of EXPRESSION unless it is SDR_OK; for
   functions that own nothing yet. */
#define SDR_TRY(expression)                                                                        \
  do {                                                                                             \
    const sdr_status sdr_try_status_ = (expression);                                               \
    if (sdr_try_status_ != SDR_OK) return sdr_try_status_;                                         \
  } while (0)

#endif
