// SPDX-License-Identifier: MIT
// Scripts under test end early: the linker leads script_open here. An input may
// take a thousandth of what a user's script may, so that thousands of
// inputs are tried in a second; an endless loop is ended by the same code.
#include "gen/script.h"

script *__wrap_script_open(const script_limits *limits, duet_error *err);
script *__real_script_open(const script_limits *limits, duet_error *err);

script *__wrap_script_open(const script_limits *limits, duet_error *err)
{
    script_limits less = limits ? *limits : script_default_limits();
    less.memory_bytes = (size_t)8 << 20;
    less.instructions = 100000;
    less.seconds = 1;
    return __real_script_open(&less, err);
}
