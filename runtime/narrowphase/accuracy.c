// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/accuracy.h"

#include "base/error.h"
#include "gen/field.h"

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
    return !fault ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s accuracy is missed %g, false_rate %g: %s",
                     whose, accuracy->missed, accuracy->false_rate, fault);
}

// Lua unwinds past C, so what is built for the message must not need freeing.
static void raise_unknown(lua_State *L, const char *name)
{
    lua_pushstring(L, "");
    for (int l = 0; l < DUET_LEVELS; ++l) {
        lua_pushfstring(L, "%s%s", l ? ", " : "", duet_level_get_info((duet_level)l)->name);
        lua_concat(L, 2);
    }
    field_raise(L, "level", "there is no level '%s': there are %s", name, lua_tostring(L, -1));
}

void accuracy_read_level(lua_State *L, int table, duet_level *level)
{
    const char *name = field_string(L, table, "level", NULL);
    if (name && !duet_level_from_name(name, level))
        raise_unknown(L, name);
}

bool accuracy_read(lua_State *L, int table, duet_accuracy *accuracy)
{
    static const char *const names[] = {"missed", "false_rate", NULL};
    if (!field_push(L, table, "accuracy", LUA_TTABLE))
        return false;
    int at = lua_gettop(L);
    field_only(L, at, "accuracy", names);
    accuracy->missed = field_number(L, at, "missed", 0);
    accuracy->false_rate = field_number(L, at, "false_rate", 0);
    const char *fault = fault_of(accuracy);
    if (fault)
        field_raise(L, "accuracy", "%s", fault);
    lua_pop(L, 1);
    return true;
}
