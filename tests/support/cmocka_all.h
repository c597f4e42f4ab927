/* cmocka with the headers that it wants before itself. */
#ifndef SDR_TESTS_CMOCKA_ALL_H
#define SDR_TESTS_CMOCKA_ALL_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>

#include <cmocka.h>

#endif
