// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/accuracy.h"

#include "base/error.h"
#include <float.h>
#include <math.h>

// Returns what is wrong with it; NULL: nothing.
static const char *fault_of(const duet_accuracy *a)
{
    if (!(a->missed >= 0 && a->missed <= 1))
        return "missed is a part of the pairs that collide, from 0 to 1";
    if (!(a->false_rate >= 0) || isinf(a->false_rate))
        return "false_rate is pairs by pairs that collide, 0 or more";
    return NULL;
}

bool accuracy_check(const duet_accuracy *accuracy, const char *whose, duet_error *err)
{
    const char *fault = fault_of(accuracy);
    return !fault || bad_argument(err, "%s accuracy is missed %g, false_rate %g: %s", whose,
                                  accuracy->missed, accuracy->false_rate, fault);
}

const char *level_name(int level)
{
    const duet_level_info *info = duet_level_get_info((duet_level)level);
    return info ? info->name : NULL;
}

static const field accuracy_fields[] = {
    FIELD_WITHIN(duet_accuracy, , missed, 0, 1, "a part of the pairs that collide, from 0 to 1"),
    FIELD_WITHIN(duet_accuracy, , false_rate, 0, DBL_MAX, "pairs by pairs that collide, 0 or more"),
    {0},
};

static void read_accuracy(lua_State *L, const field *f, void *at)
{
    *(duet_accuracy *)at = (duet_accuracy){0};
    (void)f;
    field_read_row(L, -1, (field_table){"accuracy", -1, NULL}, accuracy_fields, at);
}

const field_type field_accuracy = {
    .read = read_accuracy, .push = field_push_struct, .fields = accuracy_fields};
