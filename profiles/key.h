// SPDX-License-Identifier: MIT
// How a row is known in every store: by random bits, or by the sha256 of what it says.
#ifndef PROFILES_KEY_H
#define PROFILES_KEY_H

#include "base/error.h"

#include <stddef.h>

#define PROFILE_ID 33  // 32 hex digits and a NUL
#define PROFILE_SHA 65 // 64 hex digits and a NUL

// 128 random bits as hex.
bool profile_new_id(char id[PROFILE_ID], duet_error *err);

void profile_sha(const char *chars, size_t n, char key[PROFILE_SHA]);

#endif
