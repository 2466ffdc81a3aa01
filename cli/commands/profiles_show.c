// SPDX-License-Identifier: MIT
// duet profiles show: a profile with the session it comes from and all its trials, or a run of a
// cluster. duet profiles diff: two profiles side by side, and which is the quicker.
#include "cli/commands/profiles.h"
#include "cli/report/profile_report.h"
#include "cli/report/rendering.h"
#include "cli/say.h"

#include <stdio.h>

static bool show_text(cJSON *o, const profile_entry *e, duet_error *err)
{
    bool ok = rendering_print("cli/report/profile.lua", o, err);
    if (e->session.id && e->session.script) {
        printf("script\n");
        say_lines(e->session.script);
        printf("\n");
    }
    ok = ok && (!e->session.id || rendering_print("cli/report/trials.lua", o, err));
    cJSON_Delete(o);
    return ok;
}

static bool show_entry(void *context, const profile_entry *e)
{
    profile_showing *show = context;
    cJSON *o = profile_report_json(e);
    show->ok = profile_report_add_trials(o, show->s, e->session.id, show->err);
    profile_report_add_session(o, &e->session);
    if (show->ok)
        show->ok = show->json ? say_json(o, show->err) : show_text(o, e, show->err);
    else
        cJSON_Delete(o);
    return false;
}

bool profiles_show(store *s, const char *uid, bool json, duet_error *err)
{
    char whole[PROFILE_ID];
    profile_showing sh = {.s = s, .json = json, .err = err};
    return profile_find(s, uid, whole, err) &&
           profile_entry_each(s, whole, true, show_entry, &sh, err) && sh.ok;
}

// ------------------------------------------------------------------- two of them

static bool keep_json(void *context, const profile_entry *e)
{
    cJSON *o = profile_report_json(e);
    if (e->session.strategy)
        json_add(o, STRING("strategy", e->session.strategy));
    if (e->session.options)
        json_add_object(o, "options", e->session.options);
    *(cJSON **)context = o;
    return false;
}

static cJSON *read_entry(store *s, const char *uid, duet_error *err)
{
    char whole[PROFILE_ID];
    cJSON *o = NULL;
    if (profile_find(s, uid, whole, err))
        profile_entry_each(s, whole, true, keep_json, &o, err);
    return o;
}

bool profiles_diff(store *s, const char *first, const char *second, bool json, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    cJSON *one = read_entry(s, first, err);
    cJSON *other = one ? read_entry(s, second, err) : NULL;
    cJSON_AddItemToObject(o, "first", one);
    cJSON_AddItemToObject(o, "second", other);
    if (other)
        return rendering_tell(o, json, "cli/report/diff.lua", err);
    cJSON_Delete(o);
    return false;
}
