// SPDX-License-Identifier: MIT
// Buffers exactly as large as asked for, between guard words.
//
// A program that is linked with guard.c has its calls to runtime/opencl/buffer.h led
// here: the library is as it is shipped. Devices that are told to have memory of
// their own get host memory all the same, without knowing it.
#ifndef TESTS_GUARD_H
#define TESTS_GUARD_H

// Fails the test where something was written beside a buffer that has been
// released since the last call, and names what ran.
void guard_assert_whole(const char *what);

#endif
