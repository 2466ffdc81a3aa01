// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE
#include "profiles/key.h"

#include <errno.h>
#include <sha256.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

bool profile_new_id(char id[PROFILE_ID], duet_error *err)
{
    uint8_t bytes[16];
    if (getentropy(bytes, sizeof bytes) != 0)
        return error_set(err, DUET_STATUS_IO_FAILED, "random bytes: %s", strerror(errno));
    for (size_t i = 0; i < sizeof bytes; ++i)
        snprintf(id + 2 * i, 3, "%02x", bytes[i]);
    return true;
}

void profile_sha(const char *chars, size_t n, char key[PROFILE_SHA])
{
    SHA256Data((const uint8_t *)chars, n, key);
}
