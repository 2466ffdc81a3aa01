// SPDX-License-Identifier: MIT
// Time, of the steady kind for durations and of the calendar for records.
#ifndef BASE_CLOCK_H
#define BASE_CLOCK_H

#include <stdint.h>

uint64_t clock_steady_ns(void);           // since some fixed moment; never goes back
double clock_ms_since(uint64_t begun_ns); // milliseconds since begun_ns
int64_t clock_calendar_ns(void);          // since 1970-01-01 UTC
void clock_sleep_ns(uint64_t ns);

#endif
