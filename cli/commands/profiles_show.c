// SPDX-License-Identifier: MIT
// duet profiles list: the profiles by device pair and size. duet profiles show: a profile with the
// session it comes from and all its trials. duet profiles diff: two profiles side by side, and
// which is the quicker.
#include "cli/commands/profiles.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/say.h"
#include "profiles/profile_view.h"

#include <stdio.h>

// The profile named by its first digits, with its session.
static cJSON *read_profile(store *s, const char *uid, char whole[PROFILE_ID], duet_error *err)
{
    cJSON *list = cJSON_CreateArray();
    cJSON *o = profile_find(s, uid, whole, err) && profile_view_add(s, whole, true, "", list, err)
                   ? cJSON_DetachItemFromArray(list, 0)
                   : NULL;
    cJSON_Delete(list);
    return o;
}

static bool show_text(const cJSON *o, duet_error *err)
{
    const cJSON *session = cJSON_GetObjectItem(o, "session");
    bool ok = rendering_print("cli/report/profile.lua", o, err);
    if (cJSON_HasObjectItem(session, "script")) {
        printf("script\n");
        say_lines(json_string(session, "script"));
        printf("\n");
    }
    return ok && (!session || rendering_print("cli/report/trials.lua", o, err));
}

bool profiles_show(store *s, const profiles_arguments *args, char **operands, duet_error *err)
{
    char whole[PROFILE_ID];
    cJSON *o = read_profile(s, operands[0], whole, err);
    bool ok = o && profile_view_add_trials(s, whole, o, err) &&
              profile_view_add_session(s, whole, o, err);
    if (ok && args->json)
        return say_json(o, err);
    ok = ok && show_text(o, err);
    cJSON_Delete(o);
    return ok;
}

// Adds strategy and options in the place of the session.
static bool add_compared(cJSON *o, const char *name, store *s, const char *uid, duet_error *err)
{
    static const char *const names[] = {"strategy", "options"};
    char whole[PROFILE_ID];
    cJSON *one = read_profile(s, uid, whole, err);
    bool ok = one && profile_view_add_session(s, whole, one, err);
    cJSON *session = cJSON_DetachItemFromObject(one, "session");
    for (int i = 0; i < 2; ++i)
        if (cJSON_HasObjectItem(session, names[i]))
            cJSON_AddItemToObject(one, names[i], cJSON_DetachItemFromObject(session, names[i]));
    cJSON_Delete(session);
    cJSON_AddItemToObject(o, name, one);
    return ok;
}

bool profiles_diff(store *s, const profiles_arguments *args, char **operands, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    if (add_compared(o, "first", s, operands[0], err) &&
        add_compared(o, "second", s, operands[1], err))
        return rendering_tell(o, args->json, "cli/report/diff.lua", err);
    cJSON_Delete(o);
    return false;
}

bool profiles_list(store *s, const profiles_arguments *args, char **operands, duet_error *err)
{
    (void)operands;
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("store", store_path(s)));
    cJSON *profiles = cJSON_AddArrayToObject(o, "profiles");
    cJSON *all = cJSON_CreateArray();
    bool ok = profile_view_add(s, "", args->dead, ", p.pair_id", profiles, err) &&
              (args->json || cJSON_GetArraySize(profiles) > 0 ||
               profile_view_add(s, "", true, "", all, err));
    if (!args->json)
        json_add(o, NUMBER("dead", cJSON_GetArraySize(all)));
    cJSON_Delete(all);
    if (ok)
        return rendering_tell(o, args->json, "cli/report/profiles.lua", err);
    cJSON_Delete(o);
    return false;
}
