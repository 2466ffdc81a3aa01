// SPDX-License-Identifier: MIT
#include "runtime/profiled.h"

#include "runtime/base/blob.h"
#include "runtime/base/error.h"

#include <math.h>
#include <sha256.h>
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

// Units of the whole device, also where ours is a part of it.
static uint32_t whole_units(const device *d)
{
    cl_device_id parent = NULL;
    cl_uint units = d->info.units;
    clGetDeviceInfo(d->id, CL_DEVICE_PARENT_DEVICE, sizeof parent, &parent, NULL);
    if (parent)
        clGetDeviceInfo(parent, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
    return units;
}

// "pocl:0[0-3]" is the part "0-3".
static bool find_part(const char *selector, char name[24])
{
    const char *open = strchr(selector, '[');
    size_t length = open ? strcspn(open + 1, "]") : 0;
    if (length == 0 || length >= 24)
        return false;
    memcpy(name, open + 1, length);
    name[length] = '\0';
    return true;
}

static profile_env describe_device(const device *d, char name[24])
{
    const duet_device_info *info = &d->info;
    bool is_part = find_part(info->selector, name);
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

static bool add_kernel_file(SHA2_CTX *sha, const char *dir, const blob *carried, duet_error *err)
{
    if (!dir) {
        SHA256Update(sha, (const uint8_t *)carried->bytes, carried->length);
        return true;
    }
    text path = {0}, bytes = {0};
    text_add(&path, "%s/%s", dir, carried->path + strlen("kernels/"));
    bool ok = text_ok(&path, err) && text_read_file(&bytes, path.chars, err);
    if (ok)
        SHA256Update(sha, (const uint8_t *)bytes.chars, bytes.length);
    text_free(&path);
    text_free(&bytes);
    return ok;
}

// All kernels and what generates them: whichever of it changes, a time may.
static bool hash_kernels(const char *dir, char kernels[PROFILE_SHA], duet_error *err)
{
    SHA2_CTX sha;
    SHA256Init(&sha);
    for (const blob *b = blobs; b->path; ++b) {
        bool is_kernel = strncmp(b->path, "kernels/", 8) == 0;
        bool makes_kernel = strncmp(b->path, "gen/", 4) == 0;
        if ((is_kernel || makes_kernel) && !add_kernel_file(&sha, is_kernel ? dir : NULL, b, err))
            return false;
    }
    SHA256End(&sha, kernels);
    return true;
}

// ---------------------------------------------------------------- workload

// The cells that the scene itself asks for, whatever grid a plan makes of it.
typedef struct raster {
    double lower[3];
    double edge[3];
    uint32_t cells[3];
} raster;

static raster lay_raster(const duet_world_def *def, const grid_needs *needs)
{
    raster r = {.cells = {1, 1, 1}};
    double edge = fmax(def->cell, needs->widest);
    for (uint32_t k = 0; k < def->dims; ++k) {
        double lower = def->has_world ? def->lower[k] : needs->lower[k];
        double upper = def->has_world ? def->upper[k] : needs->upper[k];
        double along = edge > 0 ? ceil((upper - lower) / edge) : 1;
        r.lower[k] = lower;
        r.edge[k] = edge;
        r.cells[k] = (uint32_t)fmin(fmax(along, 1), 0x1p30);
    }
    return r;
}

static double count_cells(const raster *r)
{
    return (double)r->cells[0] * r->cells[1] * r->cells[2];
}

// Cells twice as wide, until a count for each takes little memory.
static raster coarsen(raster r)
{
    const double most = 0x1p20;
    while (count_cells(&r) > most) {
        int longest = 0;
        for (int k = 1; k < 3; ++k)
            longest = r.cells[k] > r.cells[longest] ? k : longest;
        r.cells[longest] = (r.cells[longest] + 1) / 2;
        r.edge[longest] *= 2;
    }
    return r;
}

static void count_objects(const duet_world *world, const raster *r, uint32_t *counts)
{
    const duet_world_def *def = &world->def;
    for (uint32_t id = 0; id < world->n; ++id) {
        double centre[3] = {0};
        uint32_t cell = 0;
        grid_centre_of(centre, world->objects.bytes, def->shape, id, def->dims);
        for (uint32_t k = def->dims; k-- > 0;) {
            double along = r->edge[k] > 0 ? (centre[k] - r->lower[k]) / r->edge[k] : 0;
            double last = r->cells[k] - 1.0;
            cell = cell * r->cells[k] + (along > 0 ? (uint32_t)fmin(along, last) : 0);
        }
        ++counts[cell];
    }
}

// Objects in a cell where the fullest hundredth of the cells begins.
static double fullest_hundredth(const uint32_t *counts, uint32_t n)
{
    enum { MOST = 4096 };
    uint32_t cells_with[MOST + 1] = {0};
    for (uint32_t i = 0; i < n; ++i)
        ++cells_with[counts[i] < MOST ? counts[i] : MOST];
    uint32_t count = MOST;
    uint64_t fuller = cells_with[MOST];
    while (count > 0 && fuller * 100 < n)
        fuller += cells_with[--count];
    return count;
}

static bool find_p99(const duet_world *world, const raster *fine, double *p99, duet_error *err)
{
    raster r = coarsen(*fine);
    uint32_t n = (uint32_t)count_cells(&r);
    uint32_t *counts = calloc(n, sizeof *counts);
    if (!counts)
        return error_set(err, DUET_NO_MEMORY, "no memory to count the objects of %u cells", n);
    count_objects(world, &r, counts);
    *p99 = fullest_hundredth(counts, n) / (count_cells(fine) / count_cells(&r));
    free(counts);
    return true;
}

// By octaves, so that how few objects are drawn matters little.
static double find_size_ratio(const grid_needs *needs)
{
    int least = GRID_OCTAVES, most = 0;
    for (int octave = 0; octave < GRID_OCTAVES; ++octave) {
        if (needs->octave_n[octave] == 0)
            continue;
        least = octave < least ? octave : least;
        most = octave;
    }
    return least < most ? ldexp(1, most - least) : 1;
}

static bool describe_workload(const duet_world *world, profile_workload *w, duet_error *err)
{
    const duet_world_def *def = &world->def;
    grid_needs needs;
    grid_needs_of(&needs, world->objects.bytes, def->shape, world->n, def->dims);
    raster r = lay_raster(def, &needs);
    bool poses = def->shape == DUET_SHAPE_POSES;
    *w = (profile_workload){
        .dims = def->dims,
        .n = world->n,
        .cells = {r.cells[0], r.cells[1], r.cells[2]},
        .cell = r.edge[0],
        .occ_mean = world->n / count_cells(&r),
        .size_ratio = find_size_ratio(&needs),
        .shape = poses ? "poses" : "bounds",
        .rotated = poses && def->rotated,
        .level = "certified",
    };
    return find_p99(world, &r, &w->occ_p99, err);
}

// ---------------------------------------------------------------- the whole

bool profiled_world(const duet_world *world, profiled *p, duet_error *err)
{
    *p = (profiled){0};
    if (world->n == 0)
        return error_set(
            err, DUET_BAD_ARGUMENT,
            "a world without objects has no profile; right would be to set them first");
    const device *devices = world->def.pair->devices;
    p->pair.a = describe_device(&devices[0], p->parts[0]);
    p->pair.b = describe_device(&devices[1], p->parts[1]);
    return describe_workload(world, &p->workload, err) &&
           hash_kernels(world->def.pair->kernel_dir, p->kernels, err);
}

profile_request profiled_request(const profiled *p)
{
    profile_request request = profile_default_request();
    request.pair = &p->pair;
    request.workload = &p->workload;
    request.kernels = p->kernels;
    return request;
}

bool profiled_read_plan(const profile_plan *stored, duet_plan *plan, duet_error *err)
{
    *plan = (duet_plan){.share = stored->share};
    memcpy(plan->variant_a, stored->variant_a, sizeof plan->variant_a);
    memcpy(plan->variant_b, stored->variant_b, sizeof plan->variant_b);
    for (int mode = 0; duet_mode_name((duet_mode)mode); ++mode) {
        plan->mode = (duet_mode)mode;
        if (strcmp(duet_mode_name(plan->mode), stored->mode) == 0)
            return true;
    }
    return error_set(err, DUET_BAD_INPUT, "the profile's mode '%s' is not known here",
                     stored->mode);
}

profile_plan profiled_write_plan(const duet_plan *plan)
{
    profile_plan stored = {.share = plan->share, .level = "certified"};
    strncpy(stored.mode, duet_mode_name(plan->mode), sizeof stored.mode - 1);
    memcpy(stored.variant_a, plan->variant_a, sizeof stored.variant_a);
    memcpy(stored.variant_b, plan->variant_b, sizeof stored.variant_b);
    return stored;
}
