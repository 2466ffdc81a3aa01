// SPDX-License-Identifier: MIT
// Built programs, kept in a folder between runs: one file for each text, build
// options, device and driver.
//
// Whatever is in the folder, a program is right: a file that is cut, damaged,
// another user's, a link or not a file is as if it were not there, and so is
// every file of a folder that another user owns or can write. Several processes
// and threads may use one folder at once. It may be deleted at any time, and where it
// outgrows CACHE_MOST_BYTES what was not used for longest goes.
#ifndef RUNTIME_CACHE_H
#define RUNTIME_CACHE_H

#include "base/text.h"
#include "runtime/duet.h"

#define CACHE_MOST_BYTES ((uint64_t)256 << 20)

// The SHA-256 of everything that a binary depends on, in hex.
void cache_key(const char *source, const char *build_options, const duet_device_info *device,
               char key[65]);

// false, with a line, where the folder is there and kernels in it may come from
// somebody else. One that is missing, or cannot be made or read, is no failure.
bool cache_check(const char *dir, duet_error *err);

// false, with a line, where entries cannot be written. Makes the folder where it is
// missing, and the one above it.
bool cache_check_writable(const char *dir, duet_error *err);

// Puts the binary into an empty text; false where there is none that fits.
bool cache_get(const char *dir, const char key[65], text *binary);

// Keeps the binary, makes the folder where it is missing; false where that
// cannot be done, which is no failure of the program.
bool cache_put(const char *dir, const char key[65], const char *bytes, size_t n);

#endif
