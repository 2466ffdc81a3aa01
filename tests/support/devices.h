// SPDX-License-Identifier: MIT
// Worlds on the default device pair, and what the reference finds.
#ifndef TESTS_DEVICES_H
#define TESTS_DEVICES_H

#include "base/rng.h"
#include "runtime/duet.h"
#include "runtime/scene/reference.h"

// Fail the test if it cannot be made; it lasts until the test ends.
duet_world *create_world(const duet_world_def *def);

// The default pair, which the test keeps. copies: its devices seem to have memory of their own.
duet_device_pair *open_copying(bool copies);
// A CPU that can be cut into parts; skips the test where there is none.
const duet_device_info *cuttable_cpu(void);
duet_world *create_world_of(const duet_world_def *def, duet_object_kind kind, const void *objects,
                            uint32_t n);
duet_world_def devices_def(uint32_t dims); // the default one, on the default pair
void set_share(duet_world *world, uint32_t share);
void set_variants(duet_plan *plan, const char *variant); // both
duet_plan plan_of(duet_mode mode, uint32_t share, const char *variant_a, const char *variant_b);

// Step; the first two by another plan, or with these objects.
duet_result step_by(duet_world *world, const duet_plan *plan);
duet_result step_with(duet_world *world, duet_object_kind kind, const void *objects, uint32_t n);
duet_result step_world(duet_world *world);

// The pairs of objects, or of a scene, by the plain C reference.
typedef struct known_pairs {
    uint64_t n, hash;
} known_pairs;

known_pairs known_pairs_of(duet_object_kind kind, const void *objects, uint32_t n, uint32_t dims);
known_pairs known_pairs_of_scene(const duet_scene *scene, duet_level level);

// Fails unless these are a step's pairs.
void assert_found(const duet_result *result, known_pairs pairs);
void assert_step_finds(duet_world *world, known_pairs pairs);

// A cube whose edges are upright, and one of edge 1 anywhere in a range, turned anyhow.
duet_rounded_box rounded_at(double x, double y, double z, double hx, double hy, double hz,
                            double radius);
duet_pose cube_at(double x, double y, double z, double half);
duet_pose random_cube(rng *r, double from, double to);
void turn_at_random(duet_pose *pose, rng *r);
duet_bounds bounds_of_upright(const duet_pose *pose);

// Returns what is found of objects in a way, which lasts until the test ends.
reference_found found_by(const reference_objects *objects, reference_way way);

// The hash of the pairs of objects, found in a way. n: how many they are.
uint64_t reference_hash(const reference_objects *objects, reference_way way, uint64_t *n);

// Whether the default device pair is two: halves of a CPU with one unit are that CPU, twice.
bool devices_are_two(void);
void skip_on_one_device(void); // with a line

// Worlds made from now on are made as for GPUs with memory of their own, or again as for what
// the devices are.
void devices_seem_gpus(bool seem);

#endif
