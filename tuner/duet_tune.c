// SPDX-License-Identifier: MIT
#include "tuner/duet_tune.h"

#include "base/error.h"
#include "base/variable.h"
#include "gen/gen.h"
#include "runtime/broadphase/variant.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/scene/scene.h"
#include "runtime/selection/profile_subject.h"
#include "tuner/device_lock.h"
#include "tuner/level_costs.h"
#include "tuner/record.h"
#include "tuner/strategy.h"
#include "tuner/subject.h"
#include "tuner/terms.h"
#include "tuner/trial_budget.h"
#include "tuner/tune.h"
#include "tuner/tuning.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7006, REPEATS = 3, CHOICE_ROUNDS = 7, WAIT_SECONDS = 60 };

duet_tune_def duet_default_tune_def(void)
{
    return (duet_tune_def){.strategy = strategies[0]->name,
                           .objective = "time",
                           .keep = DUET_KEEP_DEFAULT,
                           .repeats = REPEATS,
                           .wait_seconds = -1,
                           .cookie = COOKIE};
}

// ---------------------------------------------------------------- checks

// Checks that a list is given if its number of rows is not 0, and its rows, too.
static bool check_lists(const duet_tune_def *def, duet_error *err)
{
    const char *call = "duet_tune_run";
    bool ok = (def->n_variants == 0 || error_given(def->variants, call, "variants", err)) &&
              (def->n_modes == 0 || error_given(def->modes, call, "modes", err)) &&
              (def->n_levels == 0 || error_given(def->levels, call, "levels", err));
    for (uint32_t i = 0; ok && i < def->n_variants; ++i)
        ok = error_given(def->variants[i], call, "a variant", err);
    for (uint32_t i = 0; ok && i < def->n_modes; ++i)
        ok = (duet_mode_name(def->modes[i]) && def->modes[i] != DUET_MODE_DEFAULT) ||
             bad_argument(err, "mode is %d; expected shared, own or slab", (int)def->modes[i]);
    return ok;
}

static bool check_levels(const duet_tune_def *def, duet_error *err)
{
    for (uint32_t i = 0; i < def->n_levels; ++i)
        if (!duet_level_get_info(def->levels[i]))
            return bad_argument(err, "level is %d; expected a duet_level", (int)def->levels[i]);
    if (def->n_levels > 1 && !def->has_accuracy)
        return bad_argument(err, "%u levels, but no accuracy that one of them is chosen by",
                            def->n_levels);
    return !def->has_accuracy || accuracy_check(&def->accuracy, "the tuning's", err);
}

static bool check_budget(const duet_tune_def *def, duet_error *err)
{
    uint32_t least = trial_budget_least(def);
    return def->budget_trials == 0 || def->budget_trials >= least ||
           bad_argument(err,
                        "a budget of %u %s ends before a verdict; expected at least %u, or fewer "
                        "variants or modes",
                        def->budget_trials, def->budget_trials == 1 ? "trial" : "trials", least);
}

// "kernels", or the name of one that there is.
static bool check_search(const char *what, duet_error *err)
{
    if (!what || strcmp(what, "kernels") == 0)
        return true;
    gen *g = gen_open(NULL, err);
    uint32_t i = 0;
    while (g && gen_kernel(g, i) && strcmp(gen_kernel(g, i), what) != 0)
        ++i;
    bool ok =
        g &&
        (gen_kernel(g, i) ||
         bad_argument(
             err,
             "search '%s': expected 'kernels' or a kernel's name; 'duet source --list' lists them",
             what));
    gen_close(g);
    return ok;
}

static bool check_times(const duet_tune_def *def, duet_error *err)
{
    if (isnan(def->wait_seconds) || isnan(def->budget_seconds))
        return bad_argument(err, "%s_seconds is nan; expected a number of seconds",
                            isnan(def->wait_seconds) ? "wait" : "budget");
    double wait;
    return def->wait_seconds >= 0 || variable_seconds("DUET_WAIT", WAIT_SECONDS, &wait, err);
}

static bool makes_energy_small(const duet_tune_def *def)
{
    return def->objective && strcmp(def->objective, "energy") == 0;
}

static bool check_objective(const duet_tune_def *def, duet_error *err)
{
    return !def->objective || makes_energy_small(def) || strcmp(def->objective, "time") == 0 ||
           bad_argument(err, "objective '%s': expected 'time' or 'energy'", def->objective);
}

// Fills in what the def leaves open, from the scene or the defaults.
static duet_tune_def complete_def(const duet_tune_def *def)
{
    duet_tune_def whole = *def;
    whole.repeats = def->repeats ? def->repeats : REPEATS;
    if (def->wait_seconds < 0) // check_times has read it
        variable_seconds("DUET_WAIT", WAIT_SECONDS, &whole.wait_seconds, NULL);
    whole.objective = def->objective ? def->objective : "time";
    const strategy *evens = makes_energy_small(def) ? strategy_find(def->strategy) : NULL;
    if (evens && evens->evened && evens->choice == STRATEGY_SHARE)
        whole.strategy = "annealing";
    subject_complete(&whole);
    return whole;
}

static bool check_def(const duet_tune_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE)
        return bad_argument(err, "the tuning's def does not come from duet_default_tune_def");
    if (!def->pair || (!def->scene && !def->task) || !def->strategy)
        return bad_argument(err, "the tuning's def lacks a pair, scene or strategy");
    if (def->repeats > MEASURE_REPEATS)
        return bad_argument(err, "%u launches a trial; expected at most %d", def->repeats,
                            MEASURE_REPEATS);
    if (def->n_variants > RACE_RIVALS)
        return bad_argument(err, "%u variants; expected at most %d", def->n_variants, RACE_RIVALS);
    if (!check_lists(def, err) || !check_times(def, err))
        return false;
    duet_tune_def whole = complete_def(def);
    for (uint32_t i = 0; i < def->n_variants; ++i) {
        variant v;
        if (!variant_parse(&v, def->variants[i], duet_device_pair_get_info(def->pair, 0), err))
            return false;
    }
    return check_objective(def, err) && check_levels(def, err) &&
           strategy_check(def->strategy, err) && (def->task || check_search(def->search, err)) &&
           subject_check(def, err) && check_budget(&whole, err);
}

// ---------------------------------------------------------------- a tuning

// Everything a tuning holds, given back in one place.
typedef struct tuning_resources {
    duet_tune_def def;
    subject subject;
    script *script;
    core_watch *cores;   // NULL: the system does not tell
    energy_meter *meter; // NULL: time is made small
    device_lock lock;
    profile_subject profile;
    record record; // without a store if nothing is kept
    trial_log state;
    char whole_name[80];          // the name of the device that A and B are parts of
    duet_device_pair *whole_pair; // that device, once it is raced
    duet_tune_def whole_def;
    subject whole;
    duet_level level; // the level that is tuned
    uint64_t hash;    // the right result's hash
} tuning_resources;

static void let_go(tuning_resources *h)
{
    record_close(&h->record);
    trial_log_free(&h->state);
    script_close(h->script);
    subject_release(&h->whole);
    duet_device_pair_destroy(h->whole_pair);
    subject_release(&h->subject);
    core_watch_close(h->cores);
    energy_meter_close(h->meter);
    device_lock_release(&h->lock);
}

static bool open_script(tuning_resources *h, duet_error *err)
{
    if (!h->def.strategy_lua)
        return true;
    h->script = strategy_lua_open(h->def.strategy_name ? h->def.strategy_name : "strategy",
                                  h->def.strategy_lua, err);
    return h->script;
}

static bool describe_subject(tuning_resources *h, duet_error *err)
{
    if (!h->subject.kind->describe(&h->subject, &h->profile, err))
        return false;
    if (h->def.scene)
        h->profile.workload.name = duet_scene_get_info(h->def.scene)->name;
    return true;
}

// Reads CPUs, and the GPUs of the pair by their names.
static bool open_meter(tuning_resources *h, duet_error *err)
{
    energy_meter_def def = energy_meter_default_def();
    for (int i = 0; i < 2; ++i) {
        const duet_device_info *d = duet_device_pair_get_info(h->def.pair, i);
        def.gpus[i] = d->kind == DUET_KIND_GPU ? d->name : NULL;
    }
    h->meter = makes_energy_small(&h->def) ? energy_meter_open(&def, err) : NULL;
    return h->meter || !makes_energy_small(&h->def);
}

static bool prepare(tuning_resources *h, const duet_tune_def *def, duet_error *err)
{
    h->def = complete_def(def);
    h->cores = core_watch_open();
    return open_meter(h, err) && device_lock_take(&h->lock, &h->def, err) &&
           subject_prepare(&h->subject, &h->def, h->def.pair, h->cores, err) &&
           open_script(h, err) && describe_subject(h, err) &&
           (def->keep == DUET_KEEP_NOTHING || record_open(&h->record, def->store, err));
}

// ---------------------------------------------------------------- the level

static bool measure_level_costs(tuning_resources *h, profile_level_cost *stored, uint32_t *n,
                                core_tally *cores, duet_error *err)
{
    level_costs_def def = {.pair = h->def.pair,
                           .scene = h->def.scene,
                           .rounds = CHOICE_ROUNDS,
                           .watch = h->def.watch,
                           .watch_context = h->def.watch_context};
    level_costs p;
    if (!level_costs_measure(&p, &def, err))
        return false;
    if (p.rounds < CHOICE_ROUNDS)
        return error_set(err, DUET_STATUS_INTERRUPTED, "stopped while the levels were measured");
    *cores = p.cores;
    for (*n = 0; *n < p.n; ++*n) {
        const level_cost *row = &p.rows[*n];
        stored[*n] = (profile_level_cost){.step_ns = row->step_ms * 1e6,
                                          .true_pairs = p.truth,
                                          .missed = row->missed,
                                          .invented = row->added};
        snprintf(stored[*n].level, sizeof stored[*n].level, "%s",
                 duet_level_get_info(row->level)->name);
    }
    return true;
}

// From the store, or measured and kept there: once known, the list does for
// every accuracy. Times that other programs disturbed are not kept.
static bool find_level_costs(tuning_resources *h, profile_level_cost *list, uint32_t *n,
                             duet_error *err)
{
    core_tally cores;
    *n = 0;
    if (!h->record.store)
        return measure_level_costs(h, list, n, &cores, err);
    profile_request request = profile_subject_request(&h->profile);
    if (!record_aim(&h->record, &request, err))
        return false;
    profile_level_cost_key key = record_cost_key(&h->record);
    if (!h->def.fresh && !profile_level_costs_get(h->record.store, &key, list, n, err))
        return false;
    if (*n > 0)
        return true;
    if (!measure_level_costs(h, list, n, &cores, err))
        return false;
    bool keeps = h->def.wait_seconds == 0 || 2 * cores.disturbed <= cores.launches;
    return !keeps || profile_level_costs_put(h->record.store, &key, list, *n, err);
}

static bool choose_level(tuning_resources *h, duet_error *err)
{
    static const duet_level all[DUET_LEVELS] = {DUET_LEVEL_CERTIFIED, DUET_LEVEL_AABB,
                                                DUET_LEVEL_SPHERE,    DUET_LEVEL_SAT6,
                                                DUET_LEVEL_SAT15,     DUET_LEVEL_DOUBLE};
    profile_level_cost list[PROFILE_LEVEL_COSTS];
    uint32_t n;
    duet_level level;
    bool any = h->def.n_levels == 0;
    return find_level_costs(h, list, &n, err) &&
           level_choose(list, n, any ? all : h->def.levels, any ? DUET_LEVELS : h->def.n_levels,
                        &h->def.accuracy, &level, err) &&
           h->subject.kind->set_level(&h->subject, level, err);
}

// From here on the tuning is of one level.
static bool settle_level(tuning_resources *h, duet_error *err)
{
    if (h->def.has_accuracy && !choose_level(h, err))
        return false;
    h->level = subject_level(&h->subject);
    profile_subject_settle(&h->profile, h->level);
    profile_request request = profile_subject_request(&h->profile);
    request.objective = h->meter ? "energy" : "time";
    return !h->record.store || record_aim(&h->record, &request, err);
}

// ---------------------------------------------------------------- measuring

// Finds "pocl:0" of "pocl:0[0-0]" and "pocl:0[1-1]"; false if A and B are not parts of one device,
// and no motion is tuned: its state is on one device, and A may be the better one for it.
static bool find_whole(const duet_device_pair *pair, bool moves, char selector[80])
{
    const char *a = duet_device_pair_get_info(pair, 0)->selector;
    const char *b = duet_device_pair_get_info(pair, 1)->selector;
    size_t n = strcspn(a, "[");
    snprintf(selector, 80, "%.*s", (int)n, a);
    return (a[n] && b[n] == '[' && strncmp(a, b, n) == 0) ||
           (moves && !duet_device_pair_is_one(pair));
}

// Takes the tuned kernels if the device is of their kind; else only their skin.
static void take_kernels(const tuning_resources *h, const char *kernels, duet_plan *plan)
{
    const char *tuned_on = duet_device_pair_get_info(h->def.pair, 1)->name;
    bool fit = strcmp(duet_device_pair_get_info(h->whole_pair, 1)->name, tuned_on) == 0;
    const char *skin = strstr(kernels, "motion.skin=");
    *plan = duet_default_plan(h->whole_pair);
    plan->share = 0;
    plan->mode = DUET_MODE_OWN;
    if (fit) {
        plan_set_variants(plan, kernels);
    } else if (skin) {
        size_t n = strlen(plan->variant_b);
        snprintf(plan->variant_b + n, sizeof plan->variant_b - n, " %.*s", (int)strcspn(skin, " "),
                 skin);
    }
}

// The subject on all of the device, at the level that is tuned.
static bool open_whole(void *context, const char *kernels, measure_machine *machine,
                       duet_plan *plan)
{
    tuning_resources *h = context;
    duet_device_pair_def devices = duet_default_device_pair_def();
    devices.a = devices.b = h->whole_name;
    h->whole_pair = duet_device_pair_create(&devices, NULL);
    if (!h->whole_pair)
        return false;
    take_kernels(h, kernels, plan);
    h->whole_def = h->def;
    if (h->subject.kind->set_level) {
        h->whole_def.levels = &h->level;
        h->whole_def.n_levels = 1;
        h->whole_def.has_accuracy = false;
    }
    bool ok = subject_prepare(&h->whole, &h->whole_def, h->whole_pair, h->cores, NULL);
    *machine = subject_machine(&h->whole, h->hash);
    return ok;
}

static bool run(tuning_resources *h, const profile_found *near, duet_tune_outcome *outcome,
                duet_error *err)
{
    subject *s = &h->subject;
    subject_truth truth = {0};
    if (s->kind->find_truth && !s->kind->find_truth(s, &truth, err))
        return false;
    h->hash = truth.hash;
    bool guessed = near->grade == PROFILE_INTERPOLATED || near->grade == PROFILE_TRANSFERRED ||
                   near->grade == PROFILE_OTHER_DRIVER || near->grade == PROFILE_STALE;
    duet_plan usual = duet_default_plan(h->def.pair); // share 0 if the devices differ
    tune_problem problem = {
        .def = &h->def,
        .machine = subject_machine(s, h->hash),
        .meter = h->meter,
        .one_device = s->one_device,
        .plan = s->plan,
        .start = guessed ? near->plan.share : usual.share,
        .fair = usual.share,
        .fair_mode = usual.mode,
        .script = h->script,
        .least_share = tune_least_share(s->units),
    };
    if (!h->meter && find_whole(h->def.pair, s->kind->lives_on_one, h->whole_name))
        problem.whole = (tune_whole){h, open_whole};
    if (h->record.store)
        problem.recorder = record_recorder(&h->record);
    bool looks = h->record.store && h->def.search && !h->def.fresh;
    for (int device = 0; looks && device < 2; ++device) {
        const profile_search before = {h->record.pair_id, device, h->record.workload_id,
                                       h->record.request.kernels, h->def.search};
        if (!profile_searched_variant(h->record.store, &before, problem.searched[device], err))
            return false;
    }
    bool ok = tune_run(&problem, &h->state, outcome, err);
    outcome->accuracy = truth.accuracy;
    outcome->true_pairs = truth.pairs;
    return ok;
}

// The session ends as the tuning did; an interrupted one can be resumed.
static bool run_recorded(tuning_resources *h, const profile_found *near, duet_tune_outcome *outcome,
                         duet_error *err)
{
    bool resumed;
    duet_error why = {0};
    if (!record_begin(&h->record, &h->def, &h->state, &resumed, err))
        return false;
    bool ok = run(h, near, outcome, &why);
    outcome->resumed = resumed;
    const char *how = ok && tune_gave_up(outcome)             ? "stopped"
                      : ok                                    ? "complete"
                      : why.status == DUET_STATUS_INTERRUPTED ? "stopped"
                                                              : "failed";
    ok = record_end(&h->record, how, &h->def, outcome, ok ? err : NULL) && ok;
    if (why.status != DUET_STATUS_OK)
        error_copy(err, &why);
    return ok;
}

bool duet_tune_run(const duet_tune_def *def, duet_tune_outcome *outcome, duet_error *err)
{
    PUBLIC_CALL(err);
    tuning_resources h = {0};
    profile_found found = {.grade = PROFILE_DEFAULT}, known = found;
    if (!error_given(outcome, __func__, "outcome", err))
        return false;
    *outcome = (duet_tune_outcome){0};
    bool ok = check_def(def, err) && prepare(&h, def, err) && settle_level(&h, err);
    if (ok && h.record.store && !def->fresh)
        ok = record_known(&h.record, &h.def, &known, err);
    if (ok && h.record.store)
        ok = profile_lookup(h.record.store, &h.record.request, &found, NULL, err);
    if (ok && known.grade == PROFILE_EXACT)
        ok = record_tell(&known, outcome, err);
    else if (ok && h.record.store)
        ok = run_recorded(&h, &found, outcome, err);
    else if (ok)
        ok = run(&h, &found, outcome, err);
    if (ok) {
        outcome->objects = def->scene ? duet_scene_get_info(def->scene)->n : 0;
        outcome->level = h.level;
    }
    let_go(&h);
    return ok;
}
