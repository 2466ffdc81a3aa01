// SPDX-License-Identifier: MIT
// duet verify: two recordings that differ by one command, so that it is known where a run of each
// differs first; recordings of other versions, and damaged ones.
#include "support/json.h"
#include "support/scene_file.h"
#include "support/test.h"

#include "base/text_file.h"

#define SCENE "test_verify.scene.lua"
#define FLYING "test_verify.flying.lua"
#define PLAIN "test_verify.plain.replay"
#define ALTERED "test_verify.altered.replay"

enum { STEPS = 12, BODIES = 24 };

static const char flying_text[] =
    "for i = 0, 24 do\n"
    "  add { centre = { i * 4, 0, 0 }, half_extents = { 0.5, 0.5, 0.5 }, velocity = { 1, 2, 3 } }\n"
    "end\n"
    "return { dims = 3, gravity = { 0, 0, -10 }, wants = { 'forces' } }\n";

static duet_device_pair *pair;

static void begin(void)
{
    pair = kept(duet_device_pair_open("cpu", ERR));
    test_write_file(SCENE, scene_of_sliding_boxes);
    test_write_file(FLYING, flying_text);
}

// What a recording has besides steps: a command to one body.
typedef void command(duet_motion *m, uint64_t id);

static duet_body_list only(const uint64_t *id)
{
    return (duet_body_list){.ids = id, .n = 1};
}

static void push(duet_motion *m, uint64_t id)
{
    const duet_impulse impulse = {.impulse = {0, 2, 0}};
    must(duet_motion_apply_impulses(m, only(&id), &impulse, ERR));
}

static void pull(duet_motion *m, uint64_t id)
{
    const duet_force force = {.force = {0, 0, 6}};
    must(duet_motion_apply_forces(m, only(&id), &force, ERR));
}

static void make_slippery(duet_motion *m, uint64_t id)
{
    const duet_body body = {.friction = 0};
    must(duet_motion_set_bodies(m, only(&id), DUET_BODY_FRICTION, &body, ERR));
}

static void let_fall(duet_motion *m, uint64_t id)
{
    const duet_body body = {.group = 1, .mask = 0};
    must(duet_motion_set_bodies(m, only(&id), DUET_BODY_FILTER, &body, ERR));
}

static void let_grow(duet_motion *m, uint64_t id)
{
    duet_state state;
    const uint32_t place = (uint32_t)id;
    must(duet_motion_get_states_of(m, &place, 1, &state, ERR));
    duet_pose pose = {.half_extents = {0.5f, 0.5f, 0.5625f}};
    for (int k = 0; k < 3; ++k)
        pose.centre[k] = (float)state.centre[k];
    for (int k = 0; k < 4; ++k)
        pose.rotation[k] = (float)state.rotation[k];
    must(duet_motion_set_poses(m, only(&id), &pose, ERR));
}

static void exchange(duet_motion *m, uint64_t id)
{
    const duet_pose pose = {
        .centre = {-20, 0, 9}, .half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0, 1}};
    const duet_body body = duet_default_body();
    duet_motion_result result;
    uint64_t fresh;
    must(duet_motion_remove_bodies(m, only(&id), ERR));
    must(duet_motion_advance(m, &result, ERR));
    must(duet_motion_add_bodies(m, &pose, &body, 1, &fresh, ERR));
    assert_true(fresh == (UINT64_C(1) << 32 | id));
}

static void exchange_and_push(duet_motion *m, uint64_t id)
{
    exchange(m, id);
    push(m, UINT64_C(1) << 32 | id);
}

// Records steps of a scene, in which a command comes before step `at`; NULL: none comes. Keeps the
// state's hash before and after each step in hashes [steps + 1], if that is not NULL.
static void record_long(const char *scene_path, const char *path, uint32_t steps, command *give,
                        uint32_t at, uint64_t id, uint64_t *hashes)
{
    duet_scene *scene = kept(duet_scene_load(scene_path, NULL, 0, ERR));
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    duet_motion *m = kept(duet_motion_create_from_scene(&def, scene, NULL, ERR));
    must(duet_motion_record(m, ERR));
    while (duet_motion_get_step(m) < steps) {
        duet_motion_result result;
        if (hashes)
            must(duet_motion_get_hash(m, &hashes[duet_motion_get_step(m)], ERR));
        if (give && duet_motion_get_step(m) + 1 == at) {
            give(m, id);
            give = NULL;
        }
        must(duet_motion_advance(m, &result, ERR));
    }
    if (hashes)
        must(duet_motion_get_hash(m, &hashes[steps], ERR));
    must(duet_motion_save_recording(m, path, ERR));
}

static void record(const char *scene_path, const char *path, command *give, uint32_t at,
                   uint64_t id)
{
    record_long(scene_path, path, STEPS, give, at, id, NULL);
}

// Fails the test unless runs of PLAIN and ALTERED differ, as a line on stderr says it.
static void assert_differ(const char *scene, const char *says)
{
    program p = program_run("verify %s --replay " PLAIN " --other-replay " ALTERED, scene);
    if (p.exit_code != 1 || !strstr(p.err, says))
        fail_msg("status %d, expected '%s': %s", p.exit_code, says, p.err);
    assert_string_equal(p.out, "");
    assert_ptr_equal(strchr(p.err, '\n'), p.err + strlen(p.err) - 1);
}

// ---------------------------------------------------------------- equal

TEST(equal_runs_are_told_in_one_line)
{
    program p = program_done(program_run("verify " SCENE " --steps 5"));
    assert_ptr_equal(strstr(p.out, "equal: 5 steps, 25 bodies, state hash "), p.out);
    assert_string_equal(p.err, "");
}

// The hash is that of duet run.
TEST(modes_shares_and_halves_give_the_hash_of_one_device)
{
    static const char *const others[] = {
        "--other-pair halves --other-share 0.25 --other-mode own",
        "--other-pair halves --other-share 1 --other-mode slab",
        "--pair halves --share 0.5 --mode shared --other-mode slab --other-share 0.75",
        "--other-variant-b 'auto motion.skin=20'",
    };
    program once = program_run("run " SCENE " --steps 8 --pair cpu --json");
    cJSON *o = json_of(once.out);
    const char *hash = json_string(o, "hash");
    assert_non_null(hash);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) {
        program p = program_run("verify " SCENE " --steps 8 --pair cpu %s", others[i]);
        if (p.exit_code != 0 || !strstr(p.out, hash))
            fail_msg("%s: %s%s, expected %s", others[i], p.out, p.err, hash);
    }
}

TEST(a_recording_is_verified_to_its_end)
{
    record(SCENE, PLAIN, push, 7, 3);
    program p = program_done(program_run("verify " SCENE " --replay " PLAIN));
    assert_says(p.out, "equal: 12 steps, 25 bodies");
}

// ---------------------------------------------------------------- different

TEST(the_step_and_body_of_an_altered_command_are_found)
{
    rng r = rng_seed(test_seed());
    record(SCENE, PLAIN, NULL, 0, 0);
    for (int i = 0; i < 4; ++i) {
        uint32_t step = 1 + rng_below(&r, STEPS), body = 1 + rng_below(&r, BODIES);
        char says[96];
        snprintf(says, sizeof says, "different: step %u, commands, body %u: velocity.y is ", step,
                 body);
        record(SCENE, ALTERED, push, step, body);
        assert_differ(SCENE, says);
    }
}

TEST(the_stage_is_found_in_which_runs_part)
{
    static const struct {
        command *give;
        const char *says;
    } cases[] = {
        {make_slippery, "step 6, solver, body 9: centre.x is "},
        {let_fall, "step 6, contacts, body 9: points of the contact with body 0 is 4 and none"},
        {let_grow, "step 6, manifolds, body 9: separation with body 0 is "},
        {push, "step 6, commands, body 9: velocity.y is "},
    };
    record(SCENE, PLAIN, NULL, 0, 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        record(SCENE, ALTERED, cases[i].give, 6, 9);
        assert_differ(SCENE, cases[i].says);
    }
}

// A force changes a velocity by mass^-1 dt in a step: 6 / 8 / 60 beside -10 / 60 a step.
TEST(what_flies_free_differs_by_the_integration)
{
    record(FLYING, PLAIN, NULL, 0, 0);
    record(FLYING, ALTERED, pull, 4, 21);
    assert_differ(FLYING, "different: step 4, integration, body 21: centre.z is ");
}

TEST(the_id_of_a_body_in_a_place_that_was_used_is_told)
{
    record(SCENE, PLAIN, exchange, 3, 5);
    record(SCENE, ALTERED, exchange_and_push, 3, 5);
    assert_differ(SCENE, "different: step 4, commands, body 4294967301: velocity.y is 0 and 2");
}

TEST(json_has_what_the_line_says)
{
    record(SCENE, PLAIN, NULL, 0, 0);
    record(SCENE, ALTERED, push, 8, 11);
    program p = program_run("verify " SCENE " --json --replay " PLAIN " --other-replay " ALTERED);
    assert_int_equal(p.exit_code, 1);
    cJSON *o = json_of(p.out);
    assert_false(json_true(o, "equal"));
    assert_true(json_number(o, "steps") == 8);
    assert_true(json_number(o, "body") == 11);
    assert_string_equal(json_string(o, "field"), "velocity.y");
    double first = json_number(o, "first");
    double pushed = json_number(o, "other") - first;
    assert_true(pushed > 1.999 && pushed < 2.001); // impulse / mass
    assert_int_equal(json_size(o, "runs"), 2);
}

// ---------------------------------------------------------------- bisection

#define SLIDING "test_verify.sliding.lua"
#define HASHES "test_verify.hashes.lua"

// Boxes that slide for 300 steps, and a heap behind them, in which bodies 41 and on lie on others.
static const char sliding_text[] =
    "add { centre = { 0, 0, -1 }, half_extents = { 90, 60, 1 }, mass = 0, friction = 0.02 }\n"
    "for i = 1, 24 do\n"
    "  add { centre = { i % 6 * 4, i // 6 * 4, 0.5 }, half_extents = { 0.5, 0.5, 0.5 },\n"
    "        velocity = { 1, 0, 0 }, friction = 0.02 }\n"
    "end\n"
    "for i = 0, 31 do\n"
    "  add { centre = { -20 - i % 4 * 1.01, i // 4 % 4 * 1.01, i // 16 * 1.02 + 0.52 },\n"
    "        half_extents = { 0.5, 0.5, 0.5 }, friction = 0.5 }\n"
    "end\n"
    "return { dims = 3, gravity = { 0, 0, -10 }, skin = 0.1 }\n";

static const char hashes_text[] = "local duet = require 'duet'\n"
                                  "local pair <close> = assert(duet.device_pair(arg[1]))\n"
                                  "local scene <close> = assert(duet.scene '" SLIDING "')\n"
                                  "local motion <close> = assert(pair:motion(scene))\n"
                                  "for _ = 1, arg[2] do\n"
                                  "  assert(motion:advance())\n"
                                  "  print(motion:hash())\n"
                                  "end\n";

// A kernel that is wrong on halves of the CPU.
typedef struct wrong_kernel {
    const char *from, *to;
    const char *says; // stage and body
} wrong_kernel;

static const wrong_kernel wrong_kernels[] = {
    {"velocities[id].xyz = convert_real4(velocity).xyz;",
     "velocities[id].xyz = convert_real4(velocity).xyz;"
     "if ((id == 9 || id == 15) && centre.x > 13.1f) velocities[id].y += 0.0001f;",
     "solver, body 9: velocity.y is "},
    {": point.w;", ": point.w - (link.x == 11 && s->centres[link.x].x > 21.77f ? 0.00001f : 0.0f);",
     "manifolds, body 11: separation with body 0 is "},
    {"k ^= k >> 13;", "k = ~(k ^ k >> 13);", "colours, body "},
};

enum { FAR = 160, WRONG = sizeof wrong_kernels / sizeof wrong_kernels[0] };

// The kernel is wrong in that context and later ones.
static const char *variables_of(const wrong_kernel *w, int context)
{
    static char variables[640];
    snprintf(variables, sizeof variables,
             "DUET_CACHE=off ASAN_OPTIONS=verify_asan_link_order=0 LD_PRELOAD=" TEST_WRONG
             " WRONG_CONTEXT=%d WRONG_FROM='%s' WRONG_TO='%s'",
             context, w->from, w->to);
    return variables;
}

// The step whose hash differs first, of both runs from their first step on.
static uint32_t find_step(const wrong_kernel *w)
{
    program right = program_done(program_run("lua --trust " HASHES " cpu %d", FAR));
    program wrong =
        program_done(program_run_with(variables_of(w, 0), "lua --trust " HASHES " halves %d", FAR));
    for (uint32_t i = 0; i < FAR; ++i)
        if (memcmp(right.out + 17 * i, wrong.out + 17 * i, 17) != 0)
            return i + 1;
    fail_msg("%s: nothing is wrong", w->to);
    return 0;
}

static cJSON *verify(const wrong_kernel *w, const char *how, char says[static 160])
{
    program p = program_run_with(variables_of(w, 1),
                                 "verify " SLIDING " --steps %d --pair cpu --other-pair halves "
                                 "--other-share 0.5 --other-mode slab --json %s",
                                 FAR, how);
    cJSON *o = json_of(p.out);
    if (p.exit_code != 1 || !o)
        fail_msg("%s: status %d: %s%s", how, p.exit_code, p.out, p.err);
    snprintf(says, 160, "%s", p.err);
    return o;
}

// Halves of an interval are an interval: besides the steps up to where it is seen no more are taken
// than the interval has.
TEST(a_wrong_kernel_is_found_at_its_step_stage_and_body)
{
    test_write_file(SLIDING, sliding_text);
    test_write_file(HASHES, hashes_text);
    for (int i = 0; i < WRONG; ++i) {
        const wrong_kernel *w = &wrong_kernels[i];
        char line[160], says[160];
        const uint32_t step = find_step(w), every = 64;
        cJSON *o = verify(w, "", line);
        snprintf(says, sizeof says, "different: step %u, %s", step, w->says);
        if (!strstr(line, says))
            fail_msg("expected '%s': %s", says, line);
        const double taken = json_number(o, "steps_taken");
        const uint32_t seen = (step + every - 1) / every * every;
        assert_true(taken <= seen + every + 1);
    }
}

TEST(any_interval_finds_what_step_by_step_comparison_finds)
{
    static const char *const hows[] = {"--every 7", "--every 63", "--every 1000"};
    char expected[160], line[160];
    verify(&wrong_kernels[0], "--every 1", expected);
    for (size_t i = 0; i < sizeof hows / sizeof hows[0]; ++i) {
        verify(&wrong_kernels[0], hows[i], line);
        assert_string_equal(line, expected);
    }
}

// ---------------------------------------------------------------- hostile

static void forge(text *file, size_t at, char by, size_t length, bool summed)
{
    file->chars[at] = (char)(file->chars[at] ^ by);
    if (summed) {
        uint64_t sum = text_checksum(file->chars, length - 8);
        memcpy(file->chars + length - 8, &sum, 8);
    }
    must(text_write_file(ALTERED, file->chars, length, ERR));
    file->chars[at] = (char)(file->chars[at] ^ by);
}

static void assert_refused(const char *says)
{
    program_assert_refused(program_run("verify " SCENE " --replay " ALTERED), 1, says);
}

TEST(recordings_that_are_none_are_refused)
{
    record(SCENE, PLAIN, push, 7, 3);
    text file = test_read_file(PLAIN);
    forge(&file, 14, 1, file.length, true); // "duet commands 3"
    assert_refused("expected \"duet commands 2\"");
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 6; ++i) {
        forge(&file, 0, 0, 16 + rng_below(&r, (uint32_t)file.length - 16), false);
        assert_refused("the recording is cut short or damaged");
    }
    forge(&file, 60, 1, file.length, false);
    assert_refused("the recording is cut short or damaged");
    forge(&file, 0, 0, 0, false);
    assert_refused("begins with \"\"");
}

// Both runs give the same bits, and the recording other ones.
TEST(a_recorded_hash_that_differs_is_told_last)
{
    record(SCENE, PLAIN, NULL, 0, 0);
    text file = test_read_file(PLAIN);
    forge(&file, file.length - 16, 1, file.length, true);
    program p = program_run("verify " SCENE " --replay " ALTERED);
    assert_int_equal(p.exit_code, 1);
    assert_says(p.out, "equal: 12 steps");
    assert_says(p.err, "at the end; expected the recorded");
    forge(&file, 32, 1, file.length, true);
    assert_refused("recorded from step 0, 25 places and the state hash");
}

// ---------------------------------------------------------------- kept hashes

enum { LONG = 100, HEAD = 40, RECORD = 16, HASH_KIND = 254 };

// Where the hashes of a recording without commands lie, as docs/formats.md has it: behind so many
// steps each.
#define HASH_AT(which) (HEAD + (which) * (2 * RECORD + sizeof(uint64_t)) + 2 * RECORD)

TEST(a_recording_keeps_the_hash_of_each_32nd_step)
{
    uint64_t hashes[LONG + 1];
    record_long(SCENE, PLAIN, LONG, NULL, 0, 0, hashes);
    text file = test_read_file(PLAIN);
    assert_int_equal(file.length, HEAD + 3 * (2 * RECORD + 8) + RECORD + 2 * 8);
    for (uint32_t i = 0; i < 3; ++i) {
        uint32_t steps[4], kind[4];
        memcpy(steps, file.chars + HASH_AT(i) - 2 * RECORD, sizeof steps);
        memcpy(kind, file.chars + HASH_AT(i) - RECORD, sizeof kind);
        assert_true(steps[0] == 0 && steps[1] == 32 && kind[0] == HASH_KIND && kind[1] == 1);
        assert_memory_equal(file.chars + HASH_AT(i), &hashes[32 * (i + 1)], 8);
    }
    program p = program_done(program_run("verify " SCENE " --replay " PLAIN));
    assert_ptr_equal(strstr(p.out, "equal: 100 steps, 25 bodies"), p.out);
}

static void assert_parts(const char *arguments, const char *says)
{
    program p = program_run("%s", arguments);
    if (p.exit_code != 1 || !strstr(p.err, says) ||
        strchr(p.err, '\n') != p.err + strlen(p.err) - 1)
        fail_msg("%s: status %d, expected '%s': %s", arguments, p.exit_code, says, p.err);
}

// A push of body 7 before step `at` differs from the recorded one.
TEST(a_replay_ends_at_the_first_kept_hash_that_differs)
{
    static const struct {
        uint32_t at;
        const char *says;
    } cases[] = {
        {1, " at step 32; expected the recorded "},
        {33, "; the first step that differs is one of 33 to 64\n"},
        {64, "; the first step that differs is one of 33 to 64\n"},
        {65, "; the first step that differs is one of 65 to 96\n"},
        {97, "; the first step that differs is one of 97 to 100\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        record_long(SCENE, PLAIN, LONG, push, cases[i].at, 7, NULL);
        text file = test_read_file(PLAIN);
        const float was = 2, is = 2.5f;
        char *impulse = file.chars;
        while (memcmp(impulse, &was, sizeof was) != 0)
            ++impulse;
        memcpy(impulse, &is, sizeof is);
        forge(&file, 0, 0, file.length, true);
        assert_parts("verify " SCENE " --replay " ALTERED, cases[i].says);
        assert_parts("run " SCENE " --steps 100 --replay " ALTERED, cases[i].says);
    }
}

TEST(a_kept_hash_that_was_altered_ends_the_replay)
{
    record_long(SCENE, PLAIN, LONG, NULL, 0, 0, NULL);
    text file = test_read_file(PLAIN);
    forge(&file, HASH_AT(1), 1, file.length, true);
    program p = program_run("verify " SCENE " --replay " ALTERED);
    assert_int_equal(p.exit_code, 1);
    assert_ptr_equal(strstr(p.out, "equal: 64 steps"), p.out);
    assert_says(p.err, "at step 64; expected the recorded");
}

// A hash comes behind steps, and is one of 8 bytes.
TEST(kept_hashes_of_another_form_are_refused)
{
    static const struct {
        size_t at;
        char by;
    } forged[] = {
        {HEAD, (char)HASH_KIND},  // a hash of the start, of 32
        {HEAD + RECORD, 1},       // the ground's kind
        {HEAD + RECORD + 4, 3},   // two hashes
        {HEAD + RECORD + 8, 1},   // fields
        {HEAD + RECORD + 12, 1},  // what is unused
        {HASH_AT(0) + 8 + 4, 32}, // no steps
    };
    record_long(SCENE, PLAIN, LONG, NULL, 0, 0, NULL);
    text file = test_read_file(PLAIN);
    for (size_t i = 0; i < sizeof forged / sizeof forged[0]; ++i) {
        forge(&file, forged[i].at, forged[i].by, file.length, true);
        assert_refused("the recording is cut short or damaged");
    }
    own(text) twice = {0};
    text_add_bytes(&twice, file.chars, HASH_AT(0) + 8);
    text_add_bytes(&twice, file.chars + HASH_AT(0) - RECORD, RECORD + 8);
    text_add_bytes(&twice, file.chars + HASH_AT(0) + 8, file.length - HASH_AT(0) - 8);
    forge(&twice, 0, 0, twice.length, true);
    assert_refused("the recording is cut short or damaged");
}

TEST(wrong_command_lines_are_refused)
{
    static const char *const lines[][2] = {
        {"verify " SCENE, "--steps is missing"},
        {"verify --steps 3", "SCENE|FILE"},
        {"verify " SCENE " --steps 3 --other-replay " PLAIN, "--replay"},
        {"verify " SCENE " --steps 13 --replay " PLAIN, "has 12 recorded steps"},
        {"verify " SCENE " --steps 3 --other-mode upside", "--other-mode 'upside': the modes are"},
        {"verify " SCENE " --steps 3 --mode upside", "duet: --mode 'upside'"},
        {"verify " SCENE " --steps 3 --other-variant foo",
         "--other-variant: variant 'foo': expect"},
        {"verify " SCENE " --steps 3 --other-variant-b foo", "--other-variant-b: variant 'foo'"},
        {"verify " SCENE " --steps 3 --variant-a foo", "duet: --variant-a: variant 'foo'"},
    };
    record(SCENE, PLAIN, NULL, 0, 0);
    program_assert_refused_by(2, lines);
}

TEST_BEGIN(begin)
