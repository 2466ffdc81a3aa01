// SPDX-License-Identifier: MIT
// duet verify over ranks: recordings that differ by one command, so that it is known where jobs
// that replay them differ first.
#include "support/json.h"
#include "support/scene_file.h"
#include "support/test.h"

#include <glob.h>
#include <sys/stat.h>

#define SCENE "verify_ranks.scene.lua"
#define RECORDER "verify_ranks.recorder.lua"
#define FOLDER "verify_ranks_folder"

enum { STEPS = 12 };

// A command before a step to a body: a push, a number, or not to touch any more.
static const char recorder_text[] =
    "local duet = require 'duet'\n"
    "local path, steps, at, body, command = table.unpack(arg)\n"
    "local pair <close> = assert(duet.device_pair 'cpu')\n"
    "local scene <close> = assert(duet.scene '" SCENE "')\n"
    "local motion <close> = assert(pair:motion(scene))\n"
    "assert(motion:record())\n"
    "for step = 1, steps do\n"
    "  if step == tonumber(at) and command == 'push' then\n"
    "    assert(motion:apply_impulses(tonumber(body), { 0, 2, 0, 0, 0, 0 }))\n"
    "  elseif step == tonumber(at) and command == 'number' then\n"
    "    assert(motion:set_user_data(tonumber(body), { 77 }))\n"
    "  elseif step == tonumber(at) then\n"
    "    local row = { 0, 0, 0, 0, 0, 0, 1, 0, 0.5, 1, 0, 0, false, false }\n"
    "    assert(motion:set_bodies(tonumber(body), 'filter', { row }))\n"
    "  end\n"
    "  assert(motion:advance())\n"
    "end\n"
    "assert(motion:save_recording(path))\n";

// No command comes before step 0.
static void record(const char *path, int at, int body, const char *command)
{
    program_done(
        program_run("lua --trust " RECORDER " %s %d %d %d %s", path, STEPS, at, body, command));
}

static void begin(void)
{
    test_write_file(SCENE, scene_of_sliding_boxes);
    test_write_file(RECORDER, recorder_text);
    record("plain.replay", 0, 0, "push");
}

// Runs it, after which no checkpoint is left; mpirun leaves a folder of its own.
static program verify(const char *arguments)
{
    mkdir(FOLDER, 0700);
    program p = program_run_with("TMPDIR=$PWD/" FOLDER, "verify " SCENE " %s", arguments);
    glob_t left;
    assert_int_equal(glob(FOLDER "/duet-verify-*", 0, NULL, &left), GLOB_NOMATCH);
    return p;
}

TEST(ranks_give_the_hash_of_one_device)
{
    program once = program_run("run " SCENE " --steps 8 --pair cpu --json");
    cJSON *o = json_of(once.out);
    const char *hash = json_string(o, "hash");
    char says[120];
    assert_non_null(hash);
    snprintf(says, sizeof says, "equal: 8 steps, 25 bodies, state hash %s: 3 ranks and 1 rank\n",
             hash);
    program p = program_done(verify("--steps 8 --ranks 3 --every 5"));
    assert_string_equal(p.out, says);
    assert_string_equal(p.err, "");
}

TEST(the_step_and_body_of_an_altered_command_are_found)
{
    static const struct {
        int step, body;
        const char *how, *says;
    } cases[] = {
        {8, 3, "--ranks 2 --every 10", "different: step 8, solver, body 3: "},
        {1, 24, "--other-ranks 2 --every 1", "different: step 1, solver, body 24: "},
        {STEPS, 9, "--ranks 3 --other-ranks 2 --every 5", "different: step 12, solver, body 9: "},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char arguments[120];
        record("altered.replay", cases[i].step, cases[i].body, "push");
        snprintf(arguments, sizeof arguments,
                 "--replay plain.replay --other-replay altered.replay %s", cases[i].how);
        program_assert_refused(verify(arguments), 1, cases[i].says);
    }
}

TEST(the_contact_is_found_by_which_ranks_part)
{
    record("altered.replay", 6, 9, "let");
    program p = verify("--replay plain.replay --other-replay altered.replay --ranks 2 --json");
    assert_int_equal(p.exit_code, 1);
    assert_says(p.err, "different: step 6, contacts, body 9: points of the contact with "
                       "body 0 is 4 and none: 2 ranks and 1 rank\n");
    cJSON *o = json_of(p.out);
    assert_true(json_number(o, "steps") == 6);
    const cJSON *other = json_row(o, "runs", 1);
    assert_true(json_number(other, "ranks") == 1);
}

// User data are in no state and no contact.
TEST(what_has_no_stage_is_told_as_a_byte_of_the_checkpoints)
{
    record("altered.replay", 7, 9, "number");
    program p = verify("--replay plain.replay --other-replay altered.replay --ranks 2");
    program_assert_refused(p, 1, "different: step 7, checkpoint, byte ");
    assert_says(p.err, " is 0 and 77: 2 ranks and 1 rank\n");
}

// A recording of another scene: the job's line is the only one.
TEST(a_job_that_fails_ends_both)
{
    program_done(program_run("run falling -n 25 --steps 12 --record falling.replay"));
    program_assert_refused(verify("--replay plain.replay --other-replay falling.replay --ranks 2"),
                           1, "falling.replay: recorded from step 0, 25 places");
}

TEST(ranks_that_cannot_be_started_are_refused)
{
    static const struct {
        const char *variables, *scene, *says;
        int code;
    } rows[] = {
        {"OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=1", SCENE,
         "--ranks: this is rank 1 of 2 of an MPI job already", 2},
        {"TMPDIR=no", "-", "--ranks: the scene is read more than once", 2},
        {"TMPDIR=no", SCENE,
         "no: no folder for checkpoints: No such file or directory; TMPDIR says where", 1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i)
        program_assert_refused(
            program_run_with(rows[i].variables, "verify %s --steps 3 --ranks 2", rows[i].scene),
            rows[i].code, rows[i].says);
}

TEST_BEGIN(begin)
