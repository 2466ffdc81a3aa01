// SPDX-License-Identifier: MIT
#include "support/any_strategy.h"

#include "base/text_file.h"

const char *const any_strategies[] = {"balance", "fig12",  "bisect", "golden",
                                      "grid",    "chunks", NULL};

static script *open_experiment(const char *name, duet_error *err)
{
    text path = {0}, chars = {0};
    text_add(&path, "%s/%s.lua", DUET_EXPERIMENTS, name);
    bool ok = text_ok(&path, err) && text_read_file(&chars, path.chars, err);
    script *opened = ok ? strategy_lua_open(path.chars, chars.chars, err) : NULL;
    text_free(&path);
    text_free(&chars);
    return opened;
}

bool any_strategy_begin(search *s, const char *name, duet_error *err)
{
    if (strategy_find(name))
        return search_begin(s, name, NULL, err);
    if (!search_begin(s, "lua", NULL, err))
        return false;
    s->script = open_experiment(name, err);
    return s->script;
}

void any_strategy_end(search *s)
{
    script_close(s->script);
    search_end(s);
}
