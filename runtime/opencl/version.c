// SPDX-License-Identifier: MIT
#include "runtime/duet.h"

const char *duet_version(void)
{
    return DUET_VERSION;
}
