// SPDX-License-Identifier: MIT
// What an application does at its start: finds the plan that was measured for
// such objects, queries, bodies or items, on such devices, and gives it to its world, tree, motion
// or task.
#define _POSIX_C_SOURCE 200809L // strdup
#include "runtime/selection/choose_profile.h"

#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion.h"
#include "runtime/selection/profile_subject.h"
#include "runtime/task/app_task.h"

#include <string.h>

_Static_assert((int)DUET_GRADE_EXACT == PROFILE_EXACT && (int)DUET_GRADE_STALE == PROFILE_STALE &&
                   (int)DUET_GRADE_DEFAULT == PROFILE_DEFAULT,
               "the public grades are the store's");

const char *duet_grade_name(duet_grade grade)
{
    return (unsigned)grade <= DUET_GRADE_DEFAULT ? profile_grade_name((profile_grade)grade) : NULL;
}

// A profile that was looked for.
typedef struct choice {
    profile_subject asked;
    profile_found found;
    duet_plan plan; // the found one's, if it is trusted
    bool read;      // whether the stores could be read
} choice;

// Says whether the found profile is good enough to be used.
static bool is_trusted(const choice *c)
{
    return c->found.grade < PROFILE_STALE;
}

// A store that cannot be read does not keep another's profile from being found.
static bool look(choice *c, const char *path, duet_error *err)
{
    profile_request request = profile_subject_request(&c->asked);
    c->read = profile_subject_look(path, &request, &c->found, NULL, err);
    return !is_trusted(c) || profile_subject_read_plan(&c->found.plan, &c->plan, err);
}

static bool tell(const choice *c, duet_profile *profile)
{
    const profile_found *found = &c->found;
    profile->grade = (duet_grade)found->grade;
    if (!is_trusted(c))
        return c->read;
    profile->accuracy = (duet_accuracy){found->missed_rate, found->false_rate};
    profile->true_pairs = found->true_pairs > 0 ? (uint64_t)found->true_pairs : 0;
    profile->step_ms = found->median_ns * 1e-6;
    profile->gain = found->gain;
    profile->gain_low = found->gain_low;
    profile->gain_high = found->gain_high;
    memcpy(profile->verdict, found->verdict, sizeof profile->verdict);
    profile->measured_s = found->created_ns / 1000000000;
    return c->read;
}

bool duet_world_load_profile(duet_world *world, const char *path, duet_profile *profile,
                             duet_error *err)
{
    PUBLIC_CALL(err);
    choice c;
    if (!world_is_idle(world, __func__, err) || !error_given(profile, __func__, "profile", err))
        return false;
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT,
                              .plan = *duet_world_get_plan(world),
                              .level = duet_world_get_level(world)};
    if (!profile_subject_read(world, &c.asked, err) || !look(&c, path, err))
        return false;
    if (is_trusted(&c)) {
        duet_level level;
        if (!profile_subject_read_level(c.found.plan.level, &level, err) ||
            !duet_world_set_plan(world, &c.plan, err))
            return false;
        world_change_level(world, level);
        profile->plan = c.plan;
        profile->level = level;
    }
    return tell(&c, profile);
}

bool duet_tree_load_profile(duet_tree *tree, const char *query, uint64_t n, const char *path,
                            duet_profile *profile, duet_error *err)
{
    PUBLIC_CALL(err);
    choice c;
    query_name name;
    if (!error_given(tree, __func__, "tree", err) || !error_given(query, __func__, "query", err) ||
        !error_given(profile, __func__, "profile", err) || !query_name_read(query, &name, err))
        return false;
    char canonical[QUERY_NAME];
    query_name_write(&name, canonical);
    *profile =
        (duet_profile){.grade = DUET_GRADE_DEFAULT,
                       .plan = {.share = tree_share_of(tree, canonical), .mode = DUET_MODE_OWN},
                       .level = DUET_LEVEL_CERTIFIED};
    if (!profile_subject_read_query(tree, &name, n, &c.asked, err) || !look(&c, path, err) ||
        (is_trusted(&c) && !tree_tune(tree, &name, c.plan.share, err)))
        return false;
    if (is_trusted(&c))
        profile->plan.share = c.plan.share;
    return tell(&c, profile);
}

// Looks for the plan of a motion by an objective; NULL: the time on one pair.
static bool look_for_motion(choice *c, const duet_motion *m, const char *objective,
                            const char *path, duet_profile *profile, duet_error *err)
{
    *profile = (duet_profile){
        .grade = DUET_GRADE_DEFAULT, .plan = m->def.plan, .level = DUET_LEVEL_CERTIFIED};
    if (!profile_subject_read_motion(m, &c->asked, err))
        return false;
    c->asked.objective = objective;
    return look(c, path, err);
}

bool duet_motion_load_profile(duet_motion *m, const char *path, duet_profile *profile,
                              duet_error *err)
{
    PUBLIC_CALL(err);
    choice c;
    if (!motion_is_whole(m, __func__, err) || !error_given(profile, __func__, "profile", err) ||
        !look_for_motion(&c, m, NULL, path, profile, err) ||
        (is_trusted(&c) && !duet_motion_set_plan(m, &c.plan, err)))
        return false;
    profile->plan = m->def.plan;
    return tell(&c, profile);
}

bool choose_over_ranks(const duet_motion *m, const char *objective, const char *path,
                       duet_profile *profile, duet_error *err)
{
    choice c;
    if (!look_for_motion(&c, m, objective, path, profile, err))
        return false;
    if (is_trusted(&c))
        profile->plan = c.plan;
    return tell(&c, profile);
}

bool duet_task_load_profile(duet_task *t, const char *path, duet_profile *profile, duet_error *err)
{
    PUBLIC_CALL(err);
    choice c;
    if (!error_given(t, __func__, "task", err) || !error_given(profile, __func__, "profile", err))
        return false;
    *profile =
        (duet_profile){.grade = DUET_GRADE_DEFAULT, .plan = t->plan, .level = DUET_LEVEL_CERTIFIED};
    if (!profile_subject_read_task(t->file, t->pair, &c.asked, err) || !look(&c, path, err) ||
        (is_trusted(&c) && !duet_task_set_plan(t, &c.plan, err)))
        return false;
    profile->plan = t->plan;
    return tell(&c, profile);
}

bool duet_world_explain_profile(duet_world *world, const char *path, char **why, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err) || !error_given(why, __func__, "why", err))
        return false;
    profile_subject asked;
    profile_found found;
    text lines = {0};
    *why = NULL;
    if (!profile_subject_read(world, &asked, err))
        return false;
    profile_request request = profile_subject_request(&asked);
    bool ok = profile_subject_look(path, &request, &found, &lines, err) && text_ok(&lines, err);
    *why = ok ? strdup(text_chars(&lines)) : NULL;
    text_free(&lines);
    return ok && (*why || no_memory(err, "the reasons for a profile"));
}
