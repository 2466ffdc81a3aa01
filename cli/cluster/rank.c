// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // CPU_COUNT
#include "cli/cluster/rank.h"

#include "base/compare.h"
#include "base/error.h"
#include "base/output.h"
#include "base/variable.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/report/run_report.h"
#include "cli/say.h"
#include "cluster/cluster.h"
#include "cluster/ghost_traffic.h"
#include "cluster/rank_watch.h"

#include <inttypes.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A run on this rank.
typedef struct run_state {
    const cluster_arguments *args;
    const simulation *simulation;       // NULL: the ranks are real
    const duet_stored_profile *profile; // gives the times of the ranks; NULL: their own
    duet_cluster *cluster;
    duet_scene *scene; // rank 0's
    int rank;
    int n_ranks;
    duet_cluster_result result;
    double *total_ms; // [args.repeat], of which n_steps were taken; ascending at the end
    uint64_t n_steps;
    bool is_stopped;                   // a rank was asked to stop, so all did
    double traffic_ms[GHOST_TRAFFICS]; // that a step takes if ghosts come so often
    duet_cluster_rank *ranks;
    reference_check check;
} run_state;

// ---------------------------------------------------------------- the work

// "1,1,2.5": the number for this rank.
static bool read_weight(const run_state *r, double *weight, duet_error *err)
{
    const char *at = r->args->weights;
    int n = 0;
    for (bool more = at; more; ++n) {
        char *end = NULL;
        double number = strtod(at, &end);
        if (end == at || (*end && *end != ',') || !(number > 0) || isinf(number))
            return bad_argument(err, "--weights '%s': give numbers above 0, as 1,1,2",
                                r->args->weights);
        *weight = n == r->rank ? number : *weight;
        more = *end == ',';
        at = end + 1;
    }
    return n == 0 || n == r->n_ranks ||
           bad_argument(err, "--weights '%s': %d numbers for %d ranks", r->args->weights, n,
                        r->n_ranks);
}

// A CPU device has a thread for each of its cores, and a launcher may have put all of them on
// one.
static void tell_binding(const run_state *r)
{
    const duet_device_pair *pair = r->cluster->def.world.pair;
    cpu_set_t allowed;
    uint32_t units = 0;
    for (int i = duet_device_pair_is_one(pair); pair && i < 2; ++i) {
        const duet_device_info *info = duet_device_pair_get_info(pair, i);
        units += info->kind == DUET_KIND_CPU ? info->units : 0;
    }
    if (r->rank > 0 || sched_getaffinity(0, sizeof allowed, &allowed) != 0 ||
        (uint32_t)CPU_COUNT(&allowed) >= units)
        return;
    fprintf(stderr,
            "duet: rank 0 may use %d of the %u cores of its devices; expected 'mpirun --bind-to "
            "none'\n",
            CPU_COUNT(&allowed), units);
}

static bool open_cluster(run_state *r, duet_error *err)
{
    duet_cluster_def def = duet_default_cluster_def();
    def.pair = r->args->pair;
    def.plain = r->args->plain || r->simulation;
    def.parts = (uint32_t)r->args->parts;
    def.drops_pairs = !r->args->pairs_path;
    def.on_compile = inputs_show_compiling;
    if (!read_weight(r, &def.weight, err) ||
        !inputs_change_plan(&r->args->plan, NULL, NULL, &def.world.plan, err))
        return false;
    r->cluster = cluster_create(&def, r->simulation, err);
    if (r->cluster)
        tell_binding(r);
    return r->cluster;
}

// Rank 0 opens the file of pairs; what cannot be written is refused before the work.
static bool check_output(const run_state *r, duet_error *err)
{
    const char *path = r->args->pairs_path;
    return ranks_agree(&r->cluster->ranks, r->rank > 0 || !path || output_check(path, err), err);
}

static bool read_scene(run_state *r, const char *path, duet_error *err)
{
    scene_settings settings;
    inputs_make_settings(&settings, &r->args->scene);
    progress p = inputs_begin_reading(path);
    if (r->rank == 0)
        progress_follow(&p);
    bool ok = cluster_load_scene(r->cluster, path, settings.list, settings.n,
                                 r->args->check ? &r->scene : NULL, err);
    progress_end(&p);
    return ok;
}

static bool load(run_state *r, const char *path, duet_error *err)
{
    if (!read_scene(r, path, err))
        return false;
    if (r->rank == 0)
        inputs_tell_empty(duet_cluster_get_scene_info(r->cluster));
    duet_level level;
    if (!r->args->level)
        return true;
    return inputs_read_level(r->args->level, &level, err) &&
           duet_cluster_set_level(r->cluster, level, err);
}

// The stored times hold only for the same dimensions and level.
static bool check_profile(const run_state *r, duet_error *err)
{
    const duet_stored_profile *p = r->profile;
    const duet_scene_info *info = duet_cluster_get_scene_info(r->cluster);
    const char *level = duet_level_get_info(r->cluster->def.world.level)->name;
    if (!p)
        return true;
    if (info->dims != p->dims)
        return bad_argument(err,
                            "--profile '%s': a profile in %uD, and %s is in %uD; expected the same",
                            r->args->profile, p->dims, info->name, info->dims);
    return strcmp(level, p->level) == 0 ||
           bad_argument(
               err,
               "--profile '%s': a profile at level %s, and this is at level %s; expected the same",
               r->args->profile, p->level, level);
}

// A given plan is kept, as in duet run; else each rank loads its profile.
static bool choose_plan(run_state *r, duet_error *err)
{
    duet_profile profile;
    duet_error failure = {0};
    if (inputs_plan_given(&r->args->plan) || r->cluster->def.plain)
        return true;
    if (!duet_cluster_load_profile(r->cluster, NULL, &profile, &failure, err))
        return false;
    if (failure.status != DUET_STATUS_OK && r->rank == 0)
        say_failed(&failure);
    return true;
}

static bool step(run_state *r, duet_error *err)
{
    const uint64_t *ids;
    uint32_t n;
    uint64_t hash = r->result.hash;
    bool first = r->result.total_ms == 0;
    duet_object_kind kind = object_form_kind(&r->cluster->owned.form);
    if (!first && !r->args->resident && !duet_cluster_map_owned(r->cluster, kind, &ids, &n, err))
        return false;
    return duet_cluster_step(r->cluster, &r->result, err) &&
           (first || hash == r->result.hash ||
            error_set(err, DUET_STATUS_WRONG_RESULT, "a step found other pairs than the first"));
}

static bool reserve(run_state *r, duet_error *err)
{
    uint64_t repeat = r->args->repeat;
    r->total_ms = calloc(repeat, sizeof *r->total_ms);
    r->ranks = calloc((size_t)r->n_ranks, sizeof *r->ranks);
    return (r->total_ms && r->ranks) || no_memory(err, "the times of %" PRIu64 " steps", repeat);
}

// All ranks know it, and a launcher waits for each of them.
static bool tell_stop(const run_state *r, duet_error *err)
{
    return !r->is_stopped || error_set(err, DUET_STATUS_INTERRUPTED, "stopped");
}

// The colours that a tuning over ranks found; 0: it was none.
static unsigned long stored_colours(const duet_stored_profile *p)
{
    static const char setting[] = "motion.colours=";
    const char *at = p ? strstr(p->variant_b, setting) : NULL;
    return at ? strtoul(at + strlen(setting), NULL, 10) : 0;
}

// Simulated bodies get ghosts as often as the profile says, else as makes a step short.
static bool choose_traffic(run_state *r, duet_error *err)
{
    const ghost_traffic **now = &r->cluster->ranks.traffic;
    const unsigned long stored = stored_colours(r->profile);
    uint32_t best = 0;
    bool ok = true;
    if (!*now)
        return true;
    for (uint32_t i = 0; ok && i < GHOST_TRAFFICS; ++i) {
        *now = &ghost_traffics[i];
        ok = step(r, err);
        r->traffic_ms[i] = r->result.total_ms;
        best = r->traffic_ms[i] < r->traffic_ms[best] ? i : best;
    }
    *now = stored > 0 ? ghost_traffic_of((uint32_t)stored) : &ghost_traffics[best];
    return ok;
}

// A signal ends it with what was timed until then.
static bool run_steps(run_state *r, duet_error *err)
{
    uint64_t repeat = r->args->repeat;
    bool ok = ranks_agree(&r->cluster->ranks, reserve(r, err), err);
    interrupt_react(INTERRUPT_AWAITED);
    ok = ok && step(r, err) && choose_traffic(r, err);
    progress p = progress_begin("step", repeat);
    while (ok && r->n_steps < repeat && r->cluster->step != STEP_STOPPED) {
        ok = step(r, err);
        r->total_ms[r->n_steps++] = r->result.total_ms;
        if (r->rank == 0)
            progress_show(&p, r->n_steps);
    }
    progress_end(&p);
    r->is_stopped = ok && r->cluster->step == STEP_STOPPED;
    if (ok && r->n_steps == 0)
        return tell_stop(r, err);
    if (ok)
        qsort(r->total_ms, r->n_steps, sizeof *r->total_ms, compare_double);
    return ok && duet_cluster_get_ranks(r->cluster, r->ranks, err);
}

// Rank 0 has the scene. Pairs are not gathered: their number and hash are enough.
static bool check(run_state *r, duet_error *err)
{
    bool ok = true;
    if (!r->args->check || r->is_stopped)
        return true;
    if (r->rank == 0) {
        duet_pair *expected = NULL;
        uint64_t n = 0;
        ok = inputs_find_reference(r->scene, r->cluster->def.world.level, &expected, &n, err);
        r->check = (reference_check){.asked = true, .reference = n};
        r->check.missing = n > r->result.pairs ? n - r->result.pairs : 0;
        r->check.extra = n < r->result.pairs ? r->result.pairs - n : 0;
        if (ok && n == r->result.pairs && duet_pairs_hash(expected, n) != r->result.hash)
            r->check.missing = r->check.extra = 1;
        duet_free(expected);
    }
    return ranks_agree(&r->cluster->ranks, ok, err);
}

// ---------------------------------------------------------------- what is told

// Only times are computed; no pairs are searched.
static bool is_forecast(const run_state *r)
{
    return r->simulation && r->simulation->object_seconds > 0;
}

// Weak scaling: the part of all ranks' time that goes to their own objects, not to ghosts or waits,
// in a step that takes so long.
static double efficiency(const run_state *r, double total_ms)
{
    const double own_ms = r->simulation->object_seconds * 1e3 * (double)r->result.objects;
    return own_ms / (r->n_ranks * total_ms);
}

static void add_traffics(cJSON *o, const run_state *r)
{
    json_add(o, NUMBER("colours_between", r->cluster->ranks.traffic->colours));
    cJSON *rows = cJSON_AddArrayToObject(o, "exchanges");
    for (int i = 0; i < GHOST_TRAFFICS; ++i)
        json_add(json_add_row(rows), NUMBER("colours_between", ghost_traffics[i].colours),
                 NUMBER("total_ms", r->traffic_ms[i]),
                 NUMBER("efficiency", efficiency(r, r->traffic_ms[i])));
}

static void add_rank(cJSON *list, const run_state *r, int i)
{
    const duet_cluster_rank *rank = &r->ranks[i];
    cJSON *o = json_add_row(list);
    json_add(o, NUMBER("rank", i), STRING("host", rank->host), STRING("pair", rank->pair),
             NUMBER("objects", rank->objects), NUMBER("ghosts", rank->ghosts),
             NUMBER("pairs", rank->pairs), NUMBER("busy_ms", rank->busy_ms),
             NUMBER("wait_ms", rank->wait_ms), NUMBER("sent_bytes", rank->sent_bytes));
}

static bool report(const run_state *r, duet_error *err)
{
    uint64_t n = r->n_steps;
    cJSON *o = cJSON_CreateObject();
    run_report_add_scene(o, duet_cluster_get_scene_info(r->cluster), r->result.objects);
    if (!is_forecast(r)) {
        json_add(o, NUMBER("pairs", r->result.pairs));
        json_add_hash(o, r->result.hash);
    }
    json_add(o, STRING("level", duet_level_get_info(r->cluster->def.world.level)->name),
             FLAG("resident", r->args->resident), NUMBER("repeat", n),
             NUMBER("total_ms", r->total_ms[(n - 1) / 2]), NUMBER("least_ms", r->total_ms[0]),
             NUMBER("most_ms", r->total_ms[n - 1]));
    if (r->simulation)
        json_add(o, STRING("platform", r->args->simulate));
    if (is_forecast(r))
        json_add(o, NUMBER("efficiency", efficiency(r, r->total_ms[(n - 1) / 2])));
    if (r->cluster->ranks.traffic)
        add_traffics(o, r);
    cJSON *rows = cJSON_AddArrayToObject(o, "ranks");
    for (int i = 0; i < r->n_ranks; ++i)
        add_rank(rows, r, i);
    if (r->check.asked)
        run_report_add_check(o, &r->check);
    return rendering_tell(o, r->args->json, "cli/report/ranks.lua", err);
}

static bool tell(const run_state *r, duet_error *err)
{
    if (r->rank > 0)
        return true;
    if (!report(r, err))
        return false;
    fflush(stdout); // a launcher that was asked to stop, too, may end this rank
    return reference_check_is_right(&r->check) ||
           error_set(err, DUET_STATUS_WRONG_RESULT, "%s: the pairs differ from the reference's",
                     duet_cluster_get_scene_info(r->cluster)->name);
}

// ---------------------------------------------------------------- all of it

static bool run_all(run_state *r, const char *path, duet_error *err)
{
    if (r->args->steps > 0)
        return open_cluster(r, err) && rank_motion_run(r->cluster, r->args, path, err);
    bool ok = open_cluster(r, err) && check_output(r, err) && load(r, path, err) &&
              check_profile(r, err) && choose_plan(r, err) && run_steps(r, err) && check(r, err);
    if (ok && r->args->pairs_path)
        ok = duet_cluster_save_pairs(r->cluster, r->args->pairs_path, r->args->sorted, err);
    return ok && ranks_agree(&r->cluster->ranks, tell(r, err), err) && tell_stop(r, err);
}

static void say_silence(const char *line)
{
    say_note("%s", line);
}

bool rank_run(const cluster_arguments *args, const char *scene, const simulation *s,
              const duet_stored_profile *profile, duet_error *err)
{
    run_state r = {.args = args, .simulation = s, .profile = profile};
    MPI_Comm_rank(MPI_COMM_WORLD, &r.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &r.n_ranks);
    rank_watch watch;
    double silence_s; // after which a rank is told of; 0: never
    bool ok = s || variable_seconds("DUET_RANK_SILENCE", 10, &silence_s, err);
    bool watches = !s && rank_watch_begin(&watch, ok ? silence_s : 0, say_silence, err);
    ok = s || (watches && ranks_agree(&watch.all, ok, err));
    ok = ok && run_all(&r, scene, err);
    duet_cluster_destroy(r.cluster);
    if (watches)
        rank_watch_end(&watch);
    duet_scene_destroy(r.scene);
    free(r.total_ms);
    free(r.ranks);
    return ok;
}
