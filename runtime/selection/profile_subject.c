// SPDX-License-Identifier: MIT
#include "runtime/selection/profile_subject.h"

#include "runtime/broadphase/world.h"

#include "base/blob.h"
#include "base/error.h"
#include "base/text_file.h"
#include "runtime/broadphase/variant.h"
#include "runtime/broadphase/workload_stats.h"
#include "runtime/dynamics/motion.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/task/task.h"

#include <sha256.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- devices

static const char *kind_name(duet_device_kind kind)
{
    switch (kind) {
    case DUET_KIND_CPU:
        return "cpu";
    case DUET_KIND_GPU:
        return "gpu";
    case DUET_KIND_ACCELERATOR:
        return "accel";
    }
    return "accel";
}

// The device itself, where ours is no part of it.
static cl_device_id whole_of(const device *d)
{
    cl_device_id whole = d->id, parent = d->id;
    while (parent) {
        whole = parent;
        parent = NULL;
        clGetDeviceInfo(whole, CL_DEVICE_PARENT_DEVICE, sizeof parent, &parent, NULL);
    }
    return whole;
}

static uint32_t whole_units(const device *d)
{
    cl_uint units = d->info.units;
    if (whole_of(d) != d->id)
        clGetDeviceInfo(whole_of(d), CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
    return units;
}

// "pocl:0[0-3]" is the part "0-3".
static bool find_part(const char *selector, char name[PROFILE_PART])
{
    const char *open = strchr(selector, '[');
    size_t length = open ? strcspn(open + 1, "]") : 0;
    if (length == 0 || length >= PROFILE_PART - sizeof " " PROFILE_SECOND)
        return false;
    memcpy(name, open + 1, length);
    name[length] = '\0';
    return true;
}

// OpenCL says how many units a part of the caller's has, and not which: A's are taken to be the
// first ones, and B's the next.
static bool name_part(const device devices[2], int side, char name[PROFILE_PART])
{
    const device *a = &devices[0], *d = &devices[side];
    cl_device_id whole = whole_of(d);
    if (!d->callers)
        return find_part(d->info.selector, name);
    if (whole == d->id)
        return false;
    bool beside = a->id != d->id && a->id != whole && whole_of(a) == whole;
    uint32_t first = beside ? a->info.units : 0;
    snprintf(name, PROFILE_PART, "%u-%u", first, first + d->info.units - 1);
    return true;
}

static profile_env describe_device(const device devices[2], int side, char name[PROFILE_PART])
{
    const device *d = &devices[side];
    const duet_device_info *info = &d->info;
    bool is_part = name_part(devices, side, name);
    return (profile_env){
        .device = {.kind = kind_name(info->kind),
                   .vendor = info->vendor,
                   .name = info->name,
                   .units = whole_units(d),
                   .max_group = info->max_group,
                   .local_bytes = info->local_bytes,
                   .global_bytes = info->global_bytes},
        .platform = info->platform,
        .platform_version = info->platform_version,
        .driver = info->driver,
        .cl_version = info->cl_version,
        .part = is_part ? name : NULL,
        .part_units = is_part ? info->units : 0,
    };
}

// ---------------------------------------------------------------- kernels

static bool hash_file(const char *dir, const char *name, char key[PROFILE_SHA], duet_error *err)
{
    text path = {0}, bytes = {0};
    text_add(&path, "%s/%s", dir, name);
    bool ok = text_ok(&path, err) && text_read_file(&bytes, path.chars, err);
    if (ok)
        SHA256Data((const uint8_t *)bytes.chars, bytes.length, key);
    text_free(&path);
    text_free(&bytes);
    return ok;
}

// All kernels and what generates them: whichever of it changes, a time may. Carried kernels were
// hashed at build time.
static bool hash_kernels(const char *dir, char kernels[PROFILE_SHA], duet_error *err)
{
    static const char folder[] = "kernels/";
    SHA2_CTX sha;
    SHA256Init(&sha);
    for (const blob *b = blobs; b->path; ++b) {
        char read[PROFILE_SHA];
        const char *key = b->sha256;
        bool is_kernel = strncmp(b->path, folder, strlen(folder)) == 0;
        if (!is_kernel && strncmp(b->path, "gen/", 4) != 0)
            continue;
        if (is_kernel && dir) {
            if (!hash_file(dir, b->path + strlen(folder), read, err))
                return false;
            key = read;
        }
        SHA256Update(&sha, (const uint8_t *)key, strlen(key));
    }
    SHA256End(&sha, kernels);
    return true;
}

// ---------------------------------------------------------------- the whole

static void ask_any_level(profile_subject *p, const duet_accuracy *accuracy)
{
    p->workload.level = PROFILE_ANY_LEVEL;
    p->accuracy = *accuracy;
    for (p->n_levels = 0; p->n_levels < DUET_LEVELS; ++p->n_levels)
        p->levels[p->n_levels] = duet_level_get_info((duet_level)p->n_levels)->name;
}

// With so few strays a slab is a range of the input, or still mostly that.
static const double few_strays = 1.0 / 32, some_strays = 1.0 / 4;

static const char *describe_order(const duet_world *world, double astray)
{
    bool keeps_order = world->def.ordered && astray < some_strays;
    return !keeps_order ? NULL : astray < few_strays ? "ordered" : "ordered strays";
}

static const char *const shapes[DUET_SHAPES] = {
    [DUET_SHAPE_POSES] = "poses",
    [DUET_SHAPE_BOUNDS] = "bounds",
    [DUET_SHAPE_ROUNDED_BOXES] = "rounded boxes",
    [DUET_SHAPE_SPHERES] = "spheres",
};

static profile_workload describe_workload(const duet_world *world)
{
    const duet_world_def *def = &world->def;
    workload_summary s = workload_summarise(world);
    bool turns = def->shape == DUET_SHAPE_POSES || def->shape == DUET_SHAPE_ROUNDED_BOXES;
    return (profile_workload){
        .dims = def->dims,
        .n = world->objects.all.n,
        .cells = {s.cells[0], s.cells[1], s.cells[2]},
        .cell = s.cell,
        .occ_mean = s.mean_occupancy,
        .occ_p99 = s.crowding,
        .size_ratio = s.size_ratio,
        .shape = shapes[def->shape],
        .rotated = turns && def->rotated,
        .effects = describe_order(world, s.strays),
        .level = duet_level_get_info(def->level)->name,
    };
}

// Two devices are another pair than one of them alone, however alike they are.
static void tell_apart(profile_pair *pair, char b_part[PROFILE_PART])
{
    char a[PROFILE_SHA], b[PROFILE_SHA];
    profile_env_key(&pair->a, a);
    profile_env_key(&pair->b, b);
    if (strcmp(a, b) != 0)
        return;
    size_t length = pair->b.part ? strlen(b_part) : 0;
    snprintf(b_part + length, PROFILE_PART - length, "%s%s", length ? " " : "", PROFILE_SECOND);
    pair->b.part = b_part;
}

static void describe_pair(profile_subject *p, const duet_device_pair *pair)
{
    p->pair.a = describe_device(pair->devices, 0, p->parts[0]);
    p->pair.b = describe_device(pair->devices, 1, p->parts[1]);
    if (!duet_device_pair_is_one(pair))
        tell_apart(&p->pair, p->parts[1]);
}

bool profile_subject_read(duet_world *world, profile_subject *p, duet_error *err)
{
    *p = (profile_subject){0};
    if (world->objects.all.n == 0)
        return bad_argument(
            err, "a world without objects has no profile; expected objects to be set first");
    if (!world_take_objects(world, true, err))
        return false;
    describe_pair(p, world->def.pair);
    p->workload = describe_workload(world);
    world_unmap_objects(world);
    if (world->def.has_accuracy)
        ask_any_level(p, &world->def.accuracy);
    return hash_kernels(world->def.pair->kernel_dir, p->kernels, err);
}

bool profile_subject_read_query(const duet_tree *tree, const query_name *query, uint64_t n,
                                profile_subject *p, duet_error *err)
{
    const duet_tree_def *def = tree_def(tree);
    *p = (profile_subject){0};
    if (tree_count(tree) == 0 || n == 0)
        return bad_argument(err, "a query of no %s has no profile", n == 0 ? "items" : "boxes");
    describe_pair(p, def->pair);
    query_name_write(query, p->query);
    p->workload = (profile_workload){
        .dims = def->dims,
        .n = n,
        .size_ratio = 1,
        .shape = shapes[def->shape],
        .level = duet_level_get_info(DUET_LEVEL_CERTIFIED)->name,
        .query = p->query,
        .boxes = tree_count(tree),
    };
    return hash_kernels(def->pair->kernel_dir, p->kernels, err);
}

_Static_assert(PROFILE_TASK >= TASK_WORDS, "a task's words fit");

bool profile_subject_read_task(const duet_task_file *t, const duet_device_pair *pair,
                               profile_subject *p, duet_error *err)
{
    *p = (profile_subject){0};
    describe_pair(p, pair);
    task_write_words(t, p->task);
    p->workload = (profile_workload){
        .dims = 3,
        .n = t->size,
        .size_ratio = 1,
        .shape = "task",
        .level = duet_level_get_info(DUET_LEVEL_CERTIFIED)->name,
        .query = p->task,
    };
    return task_kernel_hash(t, pair, p->kernels, err);
}

// ---------------------------------------------------------------- motions

// The settings that decide the text of its kernels, and how often they run.
static void list_effects(const duet_motion *m, char words[PROFILE_EFFECTS])
{
    int n = snprintf(words, PROFILE_EFFECTS, PROFILE_MOVING " substeps=%u%s", m->def.substeps,
                     m->def.doubles ? " doubles" : "");
    for (uint32_t i = 0; effect_at(i); ++i)
        if (m->effects & effect_at(i)->effect)
            n += snprintf(words + n, PROFILE_EFFECTS - (size_t)n, " %s", effect_at(i)->name);
}

static void *copy_bodies(const duet_motion *m, duet_object_kind kind, duet_error *err)
{
    duet_large_pose *large = kind == DUET_OBJECT_LARGE_POSES ? calloc(m->n, sizeof *large) : NULL;
    duet_rounded_box *boxes = large ? NULL : calloc(m->n, sizeof *boxes);
    for (uint32_t i = 0; large && i < m->n; ++i) {
        large[i].pose = m->poses[i];
        memcpy(large[i].cell, m->cells[i].s, sizeof large[i].cell);
    }
    for (uint32_t i = 0; boxes && i < m->n; ++i)
        boxes[i] = (duet_rounded_box){.pose = m->poses[i], .radius = m->bodies[i].radius};
    if (!large && !boxes)
        no_memory(err, "%u bodies", m->n);
    return large ? (void *)large : boxes;
}

// Describes the still world that holds the bodies.
static bool read_bodies(const duet_motion *m, profile_subject *p, duet_error *err)
{
    duet_world_def def = duet_default_world_def();
    def.pair = m->def.pair;
    def.dims = m->def.dims;
    def.origin_edge = m->cells ? m->def.origin_edge : 0;
    def.rotated = m->effects & DUET_EFFECT_ROTATION;
    def.shape = !m->cells && (m->facts & FACT_ROUND) ? DUET_SHAPE_ROUNDED_BOXES : DUET_SHAPE_POSES;
    duet_object_kind kind = origin_row_kind(def.shape, def.origin_edge);
    void *rows = copy_bodies(m, kind, err);
    duet_world *world = rows ? duet_world_create(&def, err) : NULL;
    bool ok = world && duet_world_set_objects(world, kind, rows, m->n, err) &&
              profile_subject_read(world, p, err);
    duet_world_destroy(world);
    free(rows);
    return ok;
}

bool profile_subject_read_motion(const duet_motion *m, profile_subject *p, duet_error *err)
{
    *p = (profile_subject){0};
    if (m->n == 0 || m->effects == 0)
        return bad_argument(
            err,
            "a motion of %u bodies%s has no profile; expected bodies that something happens to",
            m->n, m->effects ? "" : " and no effects");
    if (!read_bodies(m, p, err))
        return false;
    list_effects(m, p->effects);
    p->workload.effects = p->effects;
    return true;
}

void profile_subject_settle(profile_subject *p, duet_level level)
{
    p->workload.level = duet_level_get_info(level)->name;
    p->n_levels = 0;
}

profile_request profile_subject_request(const profile_subject *p)
{
    profile_request request = profile_default_request();
    request.pair = &p->pair;
    request.workload = &p->workload;
    request.kernels = p->kernels;
    request.objective = p->objective ? p->objective : request.objective;
    if (p->n_levels == 0)
        return request;
    request.levels = p->levels;
    request.n_levels = p->n_levels;
    request.max_missed_rate = p->accuracy.missed;
    request.max_false_rate = p->accuracy.false_rate;
    return request;
}

bool profile_subject_look(const char *path, const profile_request *request, profile_found *found,
                          text *why, duet_error *err)
{
    text user = {0};
    text system = {0};
    // Without a place for a user's store there may still be a system's.
    const char *first = path;
    if (!path && store_user_path(&user, NULL))
        first = text_chars(&user);
    const char *second = !path && store_system_path(&system) ? text_chars(&system) : NULL;
    bool ok = profile_lookup_files(first, second, request, found, why, err);
    text_free(&user);
    text_free(&system);
    return ok;
}

bool profile_subject_read_level(const char *name, duet_level *level, duet_error *err)
{
    return duet_level_from_name(name, level) ||
           bad_input(err, "the profile's level '%s' is not known here", name);
}

bool profile_subject_read_plan(const profile_plan *stored, duet_plan *plan, duet_error *err)
{
    *plan = (duet_plan){.share = stored->share};
    memcpy(plan->variant_a, stored->variant_a, sizeof plan->variant_a);
    memcpy(plan->variant_b, stored->variant_b, sizeof plan->variant_b);
    return mode_from_name(stored->mode, &plan->mode) ||
           bad_input(err, "the profile's mode '%s' is not known here", stored->mode);
}

profile_plan profile_subject_write_plan(const duet_plan *plan, const char *level)
{
    profile_plan stored = {.share = plan->share};
    strncpy(stored.level, level, sizeof stored.level - 1);
    strncpy(stored.mode, duet_mode_name(plan->mode), sizeof stored.mode - 1);
    memcpy(stored.variant_a, plan->variant_a, sizeof stored.variant_a);
    memcpy(stored.variant_b, plan->variant_b, sizeof stored.variant_b);
    return stored;
}
