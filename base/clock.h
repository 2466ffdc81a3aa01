// SPDX-License-Identifier: MIT
// Time: steady for durations, of the calendar for records, and of the processor.
#ifndef BASE_CLOCK_H
#define BASE_CLOCK_H

#include <stdint.h>

uint64_t clock_steady_ns(void);           // since some fixed moment; never goes back
double clock_ms_since(uint64_t begun_ns); // milliseconds since begun_ns
int64_t clock_calendar_ns(void);          // since 1970-01-01 UTC
uint64_t clock_process_ns(void);          // processor time of this process
uint64_t clock_thread_ns(void);           // and of the calling thread
void clock_sleep_ns(uint64_t ns);

#endif
