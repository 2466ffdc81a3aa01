// SPDX-License-Identifier: MIT
// What a test program says if it crashes, in any of its threads: the signal, the address, the
// thread, the test and the calls that led there. Every test program says it.
#ifndef TESTS_CRASH_H
#define TESTS_CRASH_H

// The test that runs, for what a crash says; NULL: not known. test.c says it.
extern const char *crash_test;

#endif
