#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

static _Thread_local char message[16384];

sdr_status sdr_fail(sdr_status status, const char *format, ...)
{
  va_list arguments;
  va_start(arguments, format);
  char text[sizeof message]; /* the arguments may contain the old message */
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  snprintf(message, sizeof message, "%s", text);
  return status;
}

const char *sdr_error_message(void)
{
  return message;
}
