// SPDX-License-Identifier: MIT
// A table of grades, tried from the best down.
#include "profiles/lookup_steps.h"

#include <math.h>
#include <string.h>

// A forecast that is less certain than this (one standard deviation of a
// step's time, relative) is no ground for a plan.
#define MOST_DOUBT 0.2

const char *profile_grade_name(profile_grade grade)
{
    static const char *const names[] = {"exact",       "other driver", "interpolated",
                                        "transferred", "stale",        "default"};
    return names[grade];
}

profile_request profile_default_request(void)
{
    profile_request request = {
        .objective = "time",
        .max_missed_rate = INFINITY,
        .max_false_rate = INFINITY,
    };
    profile_host(request.host);
    return request;
}

static bool prepare(lookup *l)
{
    const profile_pair *pair = l->request->pair;
    profile_env_keys(&pair->a, l->env[0], l->seat[0]);
    profile_env_keys(&pair->b, l->env[1], l->seat[1]);
    return rows_find_pair(l);
}

static bool turn_to_level(lookup *l, const char *level)
{
    l->at = *l->request->workload;
    l->at.level = level;
    text_free(&l->family);
    profile_workload_family(&l->at, &l->family);
    return profile_workload_key(&l->at, l->workload, l->err) && text_ok(&l->family, l->err);
}

// ---------------------------------------------------------- grades that are rows

static bool look_exact(lookup *l, bool *held)
{
    return (l->pair_id == 0 || rows_take_exact(l, held)) && (*held || !l->why || why_not_exact(l));
}

static bool look_other_driver(lookup *l, bool *held)
{
    return rows_take_other_driver(l, held) &&
           (*held || why_not(l, "nor under another version of a driver"));
}

static bool look_stale(lookup *l, bool *held)
{
    return rows_take_stale(l, held) && (*held || why_not(l, "nor with other kernels"));
}

// ---------------------------------------------------------- grades of neighbours

// Rates of another size say nothing; certified misses none.
static bool is_accurate_anywhere(const lookup *l)
{
    bool asked = isfinite(l->request->max_missed_rate) || isfinite(l->request->max_false_rate);
    return !asked || strcmp(l->at.level, "certified") == 0;
}

enum { MOTION_REACH = 4 }; // kernels suit a motion of as many times more or fewer bodies

// The time of one motion's step says nothing of another's, whose bodies may meet at another time:
// only the plan is taken, and no figure.
static bool transfer_to_motion(lookup *l, const neighbour *near, bool *held)
{
    double n = near->quantities[NEIGHBOUR_OBJECTS], at = l->near.at[NEIGHBOUR_OBJECTS];
    *held = fmax(n, at) <= MOTION_REACH * fmin(n, at);
    if (*held)
        neighbour_copy_plan(&near->found, l->found);
    why_motion(l, n, *held);
    return true;
}

static bool look_interpolated(lookup *l, bool *held)
{
    const neighbours *all = &l->near;
    if (!rows_find_neighbours(l))
        return false;
    if (!neighbour_is_there(&all->nearest))
        return why_not(l, "no like workload was measured on these two devices");
    if (profile_workload_moves(&l->at))
        return transfer_to_motion(l, &all->nearest, held);
    bool next = neighbour_is_next(all->nearest.quantities, all->at);
    if (!next && !is_accurate_anywhere(l))
        return why_not(l, "accuracy is asked for, which rates of other sizes say nothing about");
    *held = neighbour_is_there(&all->below) && neighbour_is_there(&all->above) &&
            neighbour_between(&all->below, &all->above, all->at, l->found);
    if (*held) {
        why_between(l);
    } else if (next) {
        *held = true;
        neighbour_scale(&all->nearest, all->at, l->found);
        why_next(l);
    } else {
        why_not_between(l);
    }
    return true;
}

// ---------------------------------------------------------- transferred plans

// The nearest neighbour's plan, if what it gains lasts as far as this.
static bool transfer(lookup *l, const neighbour *near, double ratio, bool *held)
{
    *held = ratio <= neighbour_safe_ratio(&near->found);
    if (*held)
        neighbour_copy_plan(&near->found, l->found);
    why_transferred(l, near, ratio, *held);
    return true;
}

// Whatever is not sure is left to the default plan.
static bool use_forecast(lookup *l, const forecast *f, bool *held)
{
    *held = f->doubt <= MOST_DOUBT && forecast_take(f, l->found);
    why_forecast(l, f, *held);
    return true;
}

static bool look_at_fits(lookup *l, bool *held)
{
    forecast_ask ask = {
        .env_a = l->env[0],
        .env_b = l->env[1],
        .family = text_chars(&l->family),
        .kernels = l->request->kernels,
        .host = l->request->host,
        .n = (double)l->at.n,
        .occupancy = l->at.occ_mean,
    };
    forecast f;
    bool found = false;
    if (strcmp(l->env[0], l->env[1]) == 0)
        return why_not(l, "not applicable: the pair is a single device");
    if (!forecast_best(l->s, &ask, &f, &found, l->err))
        return false;
    return found ? use_forecast(l, &f, held)
                 : why_not(l, "one of the devices was never measured on a like workload");
}

static bool look_transferred(lookup *l, bool *held)
{
    const neighbours *all = &l->near;
    if (!is_accurate_anywhere(l))
        return why_not(l, "accuracy is asked for, which times of other sizes say nothing about");
    if (profile_workload_moves(&l->at))
        return why_not(l, "a motion's plan is that of its own pair of devices");
    if (!neighbour_is_there(&all->nearest))
        return look_at_fits(l, held);
    return transfer(l, &all->nearest, neighbour_ratio(all->nearest.quantities, all->at, NULL),
                    held);
}

// -------------------------------------------------------------------- the grades

static const struct {
    profile_grade grade;
    bool (*look)(lookup *l, bool *held);
} grades[] = {
    {PROFILE_EXACT, look_exact},
    {PROFILE_OTHER_DRIVER, look_other_driver},
    {PROFILE_INTERPOLATED, look_interpolated},
    {PROFILE_TRANSFERRED, look_transferred},
    {PROFILE_STALE, look_stale},
};

static bool try_grades(lookup *l)
{
    for (size_t i = 0; i < sizeof grades / sizeof grades[0]; ++i) {
        bool held = false;
        text_add(l->why, "  %-12s ", profile_grade_name(grades[i].grade));
        if (!grades[i].look(l, &held))
            return false;
        text_add(l->why, "\n");
        if (held) {
            l->found->grade = grades[i].grade;
            return true;
        }
    }
    return true;
}

static bool is_better(const profile_found *a, const profile_found *b)
{
    return a->grade != b->grade ? a->grade < b->grade
                                : a->grade != PROFILE_DEFAULT && a->median_ns < b->median_ns;
}

// The best that any of the levels has.
static bool try_levels(lookup *l, profile_found *best)
{
    const profile_request *request = l->request;
    for (uint32_t i = 0; i < request->n_levels; ++i) {
        profile_found found = {.grade = PROFILE_DEFAULT};
        bool measured = false;
        l->found = &found;
        if (!turn_to_level(l, request->levels[i]) || !rows_are_measured(l, &measured))
            return false;
        text_add(l->why, " level %s%s\n", request->levels[i],
                 measured ? "" : ": no like workload was measured at it");
        if (measured && !try_grades(l))
            return false;
        if (is_better(&found, best))
            *best = found;
    }
    return true;
}

bool profile_lookup(store *s, const profile_request *request, profile_found *found, text *why,
                    duet_error *err)
{
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    lookup l = {.s = s, .request = request, .found = found, .why = why, .err = err};
    bool ok = prepare(&l);
    if (ok && request->n_levels > 0)
        ok = try_levels(&l, found);
    else if (ok)
        ok = turn_to_level(&l, request->workload->level) && try_grades(&l);
    if (!ok)
        *found = (profile_found){.grade = PROFILE_DEFAULT};
    text_free(&l.family);
    return ok && (!why || text_ok(why, err));
}

// ---------------------------------------------------------------------- two files

static bool look_once(const char *path, const profile_request *request, profile_found *found,
                      text *why, bool *disturbed, duet_error *err)
{
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    store *s = store_open_look(path, err);
    bool ok = s && profile_lookup(s, request, found, why, err);
    *disturbed = s && !store_undisturbed(s);
    store_close(s);
    return ok;
}

// A writer that came in between may have shown half of its work, so the look
// is taken again; then it is seen to write, and read in step with it.
static bool look_in_file(const char *path, const profile_request *request, profile_found *found,
                         text *why, duet_error *err)
{
    enum { MAX_LOOKS = 3 };
    for (int i = 0;; ++i) {
        text told = {0};
        duet_error failure = {0};
        bool disturbed = false;
        bool ok = look_once(path, request, found, why ? &told : NULL, &disturbed, &failure);
        bool final = !disturbed || i == MAX_LOOKS;
        if (final && !ok)
            error_copy(err, &failure);
        if (final && why)
            text_add(why, "%s%s%s", ok ? path : failure.text, ok ? ":\n" : "\n", text_chars(&told));
        text_free(&told);
        if (final)
            return ok;
    }
}

bool profile_lookup_files(const char *user_path, const char *system_path,
                          const profile_request *request, profile_found *found, text *why,
                          duet_error *err)
{
    const char *paths[] = {user_path, system_path};
    bool ok = true;
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    for (int i = 0; i < 2 && found->grade != PROFILE_EXACT; ++i) {
        profile_found here;
        duet_error failure = {0};
        if (!paths[i])
            continue;
        if (!look_in_file(paths[i], request, &here, why, &failure) &&
            failure.status != DUET_STATUS_NOT_FOUND)
            ok = error_copy(err, &failure);
        if (here.grade < found->grade)
            *found = here;
    }
    return ok && (!why || text_ok(why, err));
}
