// SPDX-License-Identifier: MIT
// Arguments reach kernels by their names: cards whose arguments the host does not know, or
// knows otherwise, are refused when the kernel is built, and their order is the card's own.
#include "base/text_file.h"
#include "support/kernels.h"
#include "support/test.h"

#define FOLDER "test_launcher.kernels"

enum { BOXES = 300 };

static duet_pose poses[BOXES];
static duet_device_pair *pair;

// ---------------------------------------------------------------- cards

// Replaces a piece of a card that stands there once.
static void change(const char *card, const char *from, const char *to)
{
    own(text) path = {0}, chars = {0}, changed = {0};
    text_add(&path, "%s/%s", FOLDER, card);
    must(text_read_file(&chars, path.chars, ERR));
    char *at = strstr(chars.chars, from);
    assert_non_null(at);
    assert_null(strstr(at + 1, from));
    text_add(&changed, "%.*s%s%s", (int)(at - chars.chars), chars.chars, to, at + strlen(from));
    must(text_write_file(path.chars, changed.chars, changed.length, ERR));
}

static void open_folder(void)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.kernel_dir = FOLDER;
    pair = kept(duet_device_pair_create(&def, ERR));
}

// ---------------------------------------------------------------- what launches

static bool step_world(const char *variant, duet_result *result, duet_error *err)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.plan.share = 0; // all on B
    strcpy(def.plan.variant_b, variant);
    duet_world *world = duet_world_create(&def, err);
    bool ok = world && duet_world_set_objects(world, DUET_OBJECT_POSES, poses, BOXES, err) &&
              duet_world_step(world, result, err);
    duet_world_destroy(world);
    return ok;
}

static bool ask_pairs(duet_error *err)
{
    duet_pair_query_def def = duet_default_pair_query_def();
    uint8_t verdicts[BOXES / 2];
    duet_pair_query_result result;
    def.pair = pair;
    duet_pair_query *query = duet_pair_query_create(&def, err);
    bool ok = query && duet_pair_query_run(query, poses, BOXES / 2, verdicts, NULL, &result, err);
    duet_pair_query_destroy(query);
    return ok;
}

// Boxes that fall onto each other; *hash: of their state afterwards.
static bool step_motion(uint64_t *hash, duet_error *err)
{
    duet_motion_def def = duet_default_motion_def();
    duet_body bodies[BOXES];
    duet_motion_result result;
    def.pair = pair;
    def.plan.share = 0;
    def.gravity[2] = -9.81;
    def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    for (int i = 0; i < BOXES; ++i)
        bodies[i] = duet_default_body();
    duet_motion *motion = duet_motion_create(&def, poses, bodies, BOXES, err);
    bool ok = motion != NULL;
    for (int i = 0; ok && i < 3; ++i)
        ok = duet_motion_advance(motion, &result, err);
    ok = ok && duet_motion_get_hash(motion, hash, err);
    duet_motion_destroy(motion);
    return ok;
}

static bool launch_all(duet_error *err)
{
    duet_result result;
    uint64_t hash;
    return step_world("gpu", &result, err) && step_world("simd", &result, err) &&
           step_world("paper", &result, err) && step_world("gpu sort=radix", &result, err) &&
           ask_pairs(err) && step_motion(&hash, err);
}

// ---------------------------------------------------------------- tests

// Binds the entry `hash` alone.
#define BEHIND_CELLS "\n      uint key_from\n      uint key_home_to"

TEST(a_card_that_the_host_does_not_know_is_refused)
{
    static const struct {
        const char *card, *from, *to, *wanted;
    } cases[] = {
        {"grid/hash.lua", "uint n_cells" BEHIND_CELLS, "float n_cells" BEHIND_CELLS,
         "argument 'n_cells' of hash is of type 'float'; expected 'uint'"},
        {"grid/hash.lua", "uint *ranks            if", "uint2 *ranks            if",
         "argument 'ranks' of hash is of type 'uint2 *'; expected 'uint *'"},
        {"grid/hash.lua", "uint n_levels\n      uint n_cells" BEHIND_CELLS,
         "const uint *n_levels\n      uint n_cells" BEHIND_CELLS,
         "argument 'n_levels' of hash is of type 'uint *'; expected 'uint'"},
        {"grid/scatter.lua", "uint *ids", "uint *order",
         "scatter has an argument 'order' that its launcher does not know"},
        {"grid/scatter.lua", "scatter = [[", "scatters = [[",
         "has no kernel 'scatter' in its card's args"},
        {"grid/pair_search_paper.lua", "int4 cells", "uint4 cells",
         "argument 'cells' of pair_search_paper is of type 'uint4'; expected 'int4'"},
        {"grid/cell_start.lua", "row_start = [[", "row_start = [[\n uint seed",
         "row_start has an argument 'seed' that its launcher does not know"},
        {"primitives/scan.lua", "uint n_blocks", "int n_blocks",
         "argument 'n_blocks' of scan_tops is of type 'int'; expected 'uint'"},
        {"primitives/radix.lua", "uint first_pass", "float4 first_pass",
         "argument 'first_pass' of radix_move is of type 'float4'; expected 'uint'"},
        {"narrowphase/pair_query.lua", "uchar *answers", "uint *answers",
         "argument 'answers' of pair_query is of type 'uint *'; expected 'uchar *'"},
        {"dynamics/integrate_positions.lua", "float h", "real h",
         "argument 'h' of integrate_positions is of type 'real'; expected 'float'"},
        {"dynamics/build_manifolds.lua", "const float4 *halves", "const float *halves",
         "argument 'halves' of build_manifolds is of type 'float *'; expected 'float4 *'"},
        {"dynamics/colour_contacts.lua", "uint *keys\n      uint *key_counts",
         "uint *key_list\n      uint *key_counts",
         "colour_contacts has an argument 'key_list' that its launcher does not know"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        test_kernels_write(FOLDER, "", "", "");
        change(cases[i].card, cases[i].from, cases[i].to);
        open_folder();
        must_fail(launch_all(ERR), DUET_STATUS_BUILD_FAILED, cases[i].wanted);
    }
}

TEST(the_order_is_the_card_s_own)
{
    duet_result before, after;
    uint64_t hash_before, hash_after;
    test_kernels_write(FOLDER, "", "", "");
    open_folder();
    must(step_world("gpu", &before, ERR) && step_motion(&hash_before, ERR));
    assert_true(before.pairs > 0);
    change("grid/hash.lua", "uint n_levels\n      uint n_cells" BEHIND_CELLS,
           "uint n_cells\n      uint n_levels" BEHIND_CELLS);
    change("grid/scatter.lua", "      const uint *keys\n      const uint *ranks\n",
           "      const uint *ranks\n      const uint *keys\n");
    change("dynamics/integrate_positions.lua", "      float4 *bodies\n      uint n\n",
           "      uint n\n      float4 *bodies\n");
    open_folder();
    must(step_world("gpu", &after, ERR) && step_motion(&hash_after, ERR));
    assert_int_equal(before.pairs, after.pairs);
    assert_true(hash_before == hash_after);
}

// A heap of boxes of edge 1.
static void set_up(void)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < BOXES; ++i) {
        poses[i] = (duet_pose){{0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
        for (int axis = 0; axis < 3; ++axis)
            poses[i].centre[axis] = (float)(8 * rng_unit(&r));
    }
}

TEST_BEGIN(set_up)
