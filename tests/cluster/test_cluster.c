// SPDX-License-Identifier: MIT
// duet cluster as a person runs it; cluster_ranks.c has what must hold for its ranks. Those of
// simulated ranks are skipped where Duet was built without SimGrid. --all: more of these.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/store.h"
#include "support/test.h"

#include "base/npy.h"
#include "base/text_file.h"
#include "profiles/duet_profiles.h"
#include "profiles/sql.h"

#include <sys/stat.h>
#include <unistd.h>

static void assert_same_pairs(const char *scene, int ranks, int parts)
{
    cJSON *expected = json_of_run("run --repeat 1 --json %s", scene);
    cJSON *found =
        json_of_run("cluster --ranks %d --parts %d --repeat 1 --json %s", ranks, parts, scene);
    assert_true(json_number(expected, "pairs") > 0);
    assert_string_equal(json_string(found, "hash"), json_string(expected, "hash"));
    assert_true(json_number(found, "pairs") == json_number(expected, "pairs"));
    assert_true(json_number(found, "objects") == json_number(expected, "objects"));
}

TEST(ranks_with_devices_find_the_pairs_of_run)
{
    assert_same_pairs("paper -n 900 --set world=18", 2, 1);
    assert_same_pairs("paper2d -n 900 --set world=40", 3, 4);
    assert_same_pairs("spheres -n 900 --set world=14", 2, 3);
}

// ---------------------------------------------------------------- pictures

static void draw(const char *command, const char *options)
{
    program p = program_run("%s %s", command, options);
    assert_string_equal(p.err, "");
    assert_int_equal(p.exit_code, 0);
}

// Rank 0 draws all ranks' bodies, byte for byte as one motion is drawn.
TEST(pictures_of_ranks_are_those_of_run)
{
    draw("run falling -n 200 --steps 20", "--picture one.png --frames one");
    draw("cluster falling -n 200 --steps 20 --ranks 3",
         "--picture many.png --frames many --format png");
    test_assert_same_file("one.png", "many.png");
    test_assert_same_file("one/00000.png", "many/00000.png");
    test_assert_same_file("one/00010.png", "many/00010.png");
    assert_true(access("one/00011.png", F_OK) != 0 && access("many/00011.png", F_OK) != 0);
    draw("cluster falling -n 200 --steps 8 --ranks 2", "--checkpoint picture.ck");
    draw("cluster falling -n 200 --steps 20 --ranks 2", "--resume picture.ck --picture many.png");
    test_assert_same_file("one.png", "many.png");
    remove("picture.ck");
    program_assert_refused(program_run("cluster falling -n 9 --steps 2 --picture a.jpg"), 2,
                           "--picture: the name of a run's picture ends with .png");
    program_assert_refused(
        program_run("cluster falling -n 9 --steps 2 --ranks 2 --picture no/a.png"), 1,
        "no/a.png: cannot be written: No such file or directory");
}

// ---------------------------------------------------------------- compared with one motion

#define READ_TWICE "read_twice.lua"
#define FIRST "first.lua"

// Prints the first step whose hash differs.
static const char first_text[] =
    "local duet = require 'duet'\n"
    "local pair <close> = assert(duet.device_pair())\n"
    "local rough <close> = assert(pair:motion(assert(duet.scene 'rough.lua')))\n"
    "local smooth <close> = assert(pair:motion(assert(duet.scene 'smooth.lua')))\n"
    "for _ = 1, 20 do\n"
    "  assert(rough:advance() and smooth:advance())\n"
    "  if rough:hash() ~= smooth:hash() then return print(rough:step()) end\n"
    "end\n";

// Boxes slide, one of them with that friction.
static void write_sliding(const char *path, double friction)
{
    own(text) scene = {0};
    text_add(&scene,
             "for i = 0, 26 do\n"
             "  add { centre = { 1.2 * (i %% 3), 1.2 * (i // 3 %% 3), 0.6 + 1.1 * (i // 9) },\n"
             "        half_extents = { 0.5, 0.5, 0.5 }, velocity = { 0.5, 0, 0 },\n"
             "        friction = i == 5 and %g or 0.5 }\n"
             "end\n"
             "return { dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',\n"
             "         wants = { 'contact_response', 'friction' },\n"
             "         world = { lower = { -3, -3, 0 }, upper = { 7, 7, 8 } } }\n",
             friction);
    test_write_file(path, text_chars(&scene));
}

// Runs it with a scene that the ranks read first and rank 0's one motion second.
static program check_two(const char *first, const char *second)
{
    char writer[200];
    remove(READ_TWICE);
    must(mkfifo(READ_TWICE, 0600) == 0);
    snprintf(writer, sizeof writer,
             "timeout 60 sh -c 'cat %s >" READ_TWICE "; sleep 0.3; cat %s >" READ_TWICE "' &",
             first, second);
    must(system(writer) == 0);
    program p = program_run("cluster " READ_TWICE " --steps 20 --ranks 2 --check --json");
    remove(READ_TWICE);
    return p;
}

// Friction is in no state, so the motions part in the step in which it first acts.
TEST(the_first_step_stage_and_body_that_differ_from_one_motion_are_named)
{
    write_sliding("rough.lua", 0.5);
    write_sliding("smooth.lua", 0.4);
    test_write_file(FIRST, first_text);
    program same = check_two("rough.lua", "rough.lua");
    assert_true(json_true(json_of_program(same), "equal"));
    program p = check_two("rough.lua", "smooth.lua");
    assert_int_equal(p.exit_code, 1);
    assert_says(p.err, ", solver, body 5: ", ": one motion and 2 ranks\n");
    char says[60];
    program first = program_done(program_run("lua --trust " FIRST));
    snprintf(says, sizeof says, "different: step %d, ", atoi(first.out));
    assert_says(p.err, says);
}

// ---------------------------------------------------------------- stopped

// On a slow machine no step may have been made yet, which is said in the same line.
TEST(ctrl_c_shows_what_ranks_moved)
{
    program_run("cluster falling -n 200 --steps 20"); // kernels are built
    program p = program_run_with("timeout --foreground --preserve-status -s INT 3",
                                 "cluster falling -n 200 --steps 100000000");
    assert_int_equal(p.exit_code, 130);
    assert_string_equal(p.err, "duet: stopped\n");
    assert_true(!*p.out || strstr(p.out, "\nstate hash "));
}

// ---------------------------------------------------------------- recorded commands

// Commands of every form, the last ones after the last step.
static void record_commands(void)
{
    static const char script[] =
        "local duet = require 'duet'\n"
        "local pair <close> = assert(duet.device_pair())\n"
        "local scene <close> = assert(duet.scene 'rough.lua')\n"
        "local motion <close> = assert(pair:motion(scene))\n"
        "local all <const> = 0xffffffff\n"
        "local ball <const> = { { 0, 0, -3, 0, 0, 0, 3, 0, 0.5, all, all, 0, false, false } }\n"
        "assert(motion:record())\n"
        "for k = 1, 20 do\n"
        "  if k == 3 then assert(motion:remove_bodies { 4 }) end\n"
        "  local pose <const> = { k / 4, 1, 6, 0.3, 0.3, 0.3, 0, 0, 0, 1 }\n"
        "  if k % 5 == 4 then assert(motion:add_bodies({ pose }, ball)) end\n"
        "  if k == 8 then assert(motion:set_poses({ 7 }, { pose })) end\n"
        "  if k == 9 then assert(motion:set_user_data({ 8 }, { 42 })) end\n"
        "  assert(motion:advance())\n"
        "end\n"
        "assert(motion:remove_bodies { 9 })\n"
        "assert(motion:save_recording 'told.replay')\n";
    test_write_file("tell.lua", script);
    assert_int_equal(program_run("lua --trust tell.lua").exit_code, 0);
}

TEST(recorded_commands_are_given_to_ranks)
{
    write_sliding("rough.lua", 0.5);
    record_commands();
    program one = program_run("run rough.lua --steps 20 --replay told.replay --json");
    for (int ranks = 2; ranks <= 3; ++ranks) {
        cJSON *told = json_of_run(
            "cluster rough.lua --steps 20 --replay told.replay --check --ranks %d --json", ranks);
        assert_true(json_true(told, "equal"));
        assert_string_equal(json_string(told, "hash"), json_string(json_of_program(one), "hash"));
    }
    program_assert_refused(
        program_run("cluster rough.lua --steps 21 --replay told.replay --ranks 2"), 2,
        "--steps 21: told.replay has 20 recorded steps");
}

// A mesh and its carrier, on which boxes lie, come to targets and elsewhere while bodies come and
// go, which gives the ground another number.
TEST(commands_to_a_carrier_are_given_to_ranks)
{
    static const char scene[] =
        "for i = 0, 47 do\n"
        "  add { centre = { i % 8 - 3.5, i // 8 - 2.5, 0.5 + i % 3 }, half_extents = { 0.4, 0.4, "
        "0.3 } }\n"
        "end\n"
        "add { centre = { 0, 0, 0.1 }, half_extents = { 0.6, 0.6, 0.3 }, mass = 0 }\n"
        "return { dims = 3, gravity = { 0, 0, -9.81 }, wants = { 'sleep', 'events' }, skin = 0.1,\n"
        "  mesh = { vertices = { -9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0 },\n"
        "           triangles = { 0, 1, 2, 0, 2, 3 }, carrier = 48 } }\n";
    static const char script[] =
        "local duet = require 'duet'\n"
        "local pair <close> = assert(duet.device_pair())\n"
        "local scene <close> = assert(duet.scene 'mixer.lua')\n"
        "local motion <close> = assert(pair:motion(scene))\n"
        "assert(motion:record())\n"
        "for k = 1, 50 do\n"
        "  local pose <const> = { k / 4, 1, 6, 0.3, 0.3, 0.3, 0, 0, 0, 1 }\n"
        "  local target <const> = { 0, 0, 0.1 + k / 90, 0, 0, math.sin(k / 60), math.cos(k / 60) "
        "}\n"
        "  if k == 20 then assert(motion:remove_bodies { 4 }) end\n"
        "  if k % 8 == 5 then assert(motion:add_bodies({ pose })) end\n"
        "  if k > 15 and k < 40 then assert(motion:set_targets({ 48 }, { target })) end\n"
        "  if k == 45 then\n"
        "    assert(motion:set_poses({ 48 }, { { 0.5, 0, 0.2, 0.6, 0.6, 0.3, 0, 0, 0, 1 } }))\n"
        "  end\n"
        "  assert(motion:advance())\n"
        "end\n"
        "assert(motion:save_recording 'mixer.replay')\n";
    test_write_file("mixer.lua", scene);
    test_write_file("tell.lua", script);
    program_done(program_run("lua --trust tell.lua"));
    for (int ranks = 2; ranks <= 4; ranks += 2)
        program_done(program_run(
            "cluster mixer.lua --steps 50 --replay mixer.replay --check --ranks %d", ranks));
}

// Friction is in no state, so the motions begin alike.
TEST(another_state_than_the_recorded_one_is_told_by_ranks)
{
    write_sliding("rough.lua", 0.5);
    write_sliding("smooth.lua", 0.4);
    program_run("run rough.lua --steps 20 --record rough.replay");
    program_assert_refused(
        program_run("cluster smooth.lua --steps 20 --replay rough.replay --ranks 2"), 1,
        "rough.replay: the state hash is ");
    program_assert_refused(
        program_run("cluster falling -n 27 --steps 20 --replay rough.replay --ranks 2"), 1,
        "rough.replay: recorded from step 0, 27 places and the state hash ");
}

TEST(ranks_end_at_the_first_kept_hash_that_differs)
{
    write_sliding("rough.lua", 0.5);
    write_sliding("smooth.lua", 0.4);
    program_run("run rough.lua --steps 70 --record rough.replay");
    program_assert_refused(
        program_run("cluster smooth.lua --steps 70 --replay rough.replay --ranks 2"), 1,
        "; the first step that differs is one of 1 to 32");
    program_assert_refused(
        program_run("cluster smooth.lua --steps 70 --replay rough.replay --check --ranks 2"), 1,
        "; the first step that differs is one of 1 to 32");
    program_done(program_run("cluster rough.lua --steps 70 --replay rough.replay --ranks 3"));
}

// The told recording has commands before and after step 10, of which a checkpoint has the first
// ones; without them the state is another one.
TEST(ranks_go_on_from_a_checkpoint_within_a_recording)
{
    static const char pushes[] =
        "local duet = require 'duet'\n"
        "local pair <close> = assert(duet.device_pair 'cpu')\n"
        "local scene <close> = assert(duet.scene 'rough.lua')\n"
        "local motion <close> = assert(pair:motion(scene))\n"
        "assert(motion:record())\n"
        "for i = 1, 20 do\n"
        "  if i % 3 == 0 then assert(motion:apply_impulses(i, { 0, 1, 0, 0, 0, 0 })) end\n"
        "  assert(motion:advance())\n"
        "end\n"
        "assert(motion:save_recording 'pushed.replay')\n";
    write_sliding("rough.lua", 0.5);
    test_write_file("pushes.lua", pushes);
    program_done(program_run("lua --trust pushes.lua"));
    program_done(program_run("cluster rough.lua --steps 10 --replay pushed.replay --ranks 3 "
                             "--checkpoint pushed.ck"));
    program_done(program_run("cluster rough.lua --steps 20 --replay pushed.replay --ranks 2 "
                             "--resume pushed.ck --check"));
    program_done(program_run("cluster rough.lua --steps 10 --ranks 2 --checkpoint pushed.ck"));
    program_assert_refused(program_run("cluster rough.lua --steps 20 --replay pushed.replay "
                                       "--ranks 2 --resume pushed.ck"),
                           1, "pushed.replay: the state hash is ");
    program_done(program_run("run rough.lua --steps 5 --record short.replay"));
    program_assert_refused(program_run("cluster rough.lua --steps 10 --replay short.replay "
                                       "--ranks 2 --resume pushed.ck"),
                           2, "--steps 10: short.replay has 5 recorded steps");
    remove("pushed.ck");
}

// ---------------------------------------------------------------- how often ghosts come

static cJSON *move(const char *variables, const char *arguments)
{
    cJSON *told =
        json_of_run_with(variables, "cluster falling -n 300 --steps 80 --json %s", arguments);
    assert_string_equal(json_string(told, "hash"),
                        json_string(json_of_run("run falling -n 300 --steps 80 --json"), "hash"));
    return told;
}

static void assert_ghosts(const cJSON *told, double colours, const char *by)
{
    assert_true(json_number(told, "colours_between") == colours);
    assert_string_equal(json_string(told, "colours_by"), by);
}

// Nobody said how often. A busy machine may make messages dear, and then others are tried.
static void assert_ghosts_unsaid(const cJSON *told)
{
    if (strcmp(json_string(told, "colours_by"), "default") == 0)
        assert_true(json_number(told, "colours_between") == 1);
    else
        assert_says("trying tried", json_string(told, "colours_by"));
}

// A tuning leaves a profile for as many ranks and parts, which a plan on the command line
// overrides.
TEST(what_is_found_of_ghosts_is_kept_for_such_ranks)
{
    test_folder folder = test_folder_make();
    assert_ghosts_unsaid(move(folder.variable, "--ranks 2"));
    cJSON *tuned = move(folder.variable, "--ranks 2 --tune-colours");
    assert_ghosts(tuned, json_number(tuned, "colours_between"), "tuned");
    duet_profile_list *list = must(duet_profile_list_create(folder.store, false, ERR));
    assert_int_equal(duet_profile_list_get_count(list), 1);
    const duet_stored_profile *profile = duet_profile_list_get_profile(list, 0);
    char variant[64];
    snprintf(variant, sizeof variant, "auto motion.colours=%.0f",
             json_number(tuned, "colours_between"));
    assert_string_equal(profile->variant_b, variant);
    assert_true(profile->moving && profile->rounds >= 8);
    assert_string_equal(profile->objective, "time over 2 ranks of 1 part on 1 host");
    duet_profile_list_destroy(list);

    test_store_run(folder.store, "UPDATE profile SET variant_b = 'auto motion.colours=8'");
    assert_ghosts(move(folder.variable, "--ranks 2"), 8, "exact");
    assert_ghosts(move(folder.variable, "--ranks 2 --variant 'auto motion.colours=4'"), 4, "given");
    assert_ghosts_unsaid(move(folder.variable, "--ranks 3"));
    assert_ghosts_unsaid(move(folder.variable, "--ranks 2 --parts 2"));
}

TEST(a_tuning_of_ghosts_that_cannot_be_is_refused)
{
    program_assert_refused(program_run("cluster falling -n 60 --steps 90 --tune-colours"), 2,
                           "--tune-colours: one domain exchanges nothing; expected several ranks "
                           "or parts");
    program_assert_refused(program_run("cluster falling -n 60 --steps 39 --tune-colours --parts 2"),
                           2, "--tune-colours: 39 steps are left; expected 40 or more");
    program p = program_run("cluster falling -n 0 --steps 90 --tune-colours --parts 2");
    assert_int_equal(p.exit_code, 2);
    assert_says(p.err, ": a motion of 0 bodies has no profile; expected bodies that");
}

TEST(one_colour_between_exchanges_is_told_as_one)
{
    program p = program_done(program_run("cluster falling -n 60 --steps 1 --ranks 2"));
    assert_says(p.out, "1  colour at the most between two; by default\n");
}

// The job ends before step 1, after which its checkpoint would be there.
TEST(a_tuning_of_ghosts_that_no_store_can_keep_takes_no_step)
{
    test_folder folder = test_folder_make();
    const char *const paths[] = {folder.store, folder.path};
    test_write_file(folder.store, "garbage");
    for (int i = 0; i < 2; ++i) {
        char variables[160];
        snprintf(variables, sizeof variables, "DUET_PROFILE=%s", paths[i]);
        program p = program_run_with(variables, "cluster falling -n 60 --steps 40 --ranks 2 "
                                                "--tune-colours --checkpoint kept.ck --every 1");
        program_assert_refused(p, 1, paths[i]);
        assert_int_not_equal(access("kept.ck", F_OK), 0);
    }
}

// The job's own checkpoint takes the place of the store while it takes its steps.
TEST(a_tuning_of_ghosts_that_is_lost_in_the_end_tells_its_table)
{
    test_folder folder = test_folder_make();
    program p = program_run_with(
        folder.variable,
        "cluster falling -n 60 --steps 40 --ranks 2 --tune-colours --checkpoint %s", folder.store);
    assert_int_equal(p.exit_code, 1);
    assert_says(p.err, folder.store);
    assert_says(p.out, "\nstate hash ");
}

// ---------------------------------------------------------------- simulated ranks

#define NETWORK "network.xml"
#define NO_ROUTE "no_route.xml"

static void write_platform(const char *path, const char *inside)
{
    own(text) file = {0};
    text_add(&file,
             "<?xml version='1.0'?>"
             "<!DOCTYPE platform SYSTEM \"https://simgrid.org/simgrid.dtd\">"
             "<platform version='4.1'><config><prop id='network/model' value='CM02'/>"
             "<prop id='network/crosstraffic' value='0'/></config>"
             "<zone id='all' routing='Full'>%s</zone></platform>",
             inside);
    test_write_file(path, text_chars(&file));
}

static void write_network(void)
{
    write_platform(NETWORK, "<cluster id='hosts' prefix='host' suffix='' radical='0-63' "
                            "speed='1Gf' bw='1GBps' lat='10us'/>");
}

TEST(simulated_ranks_find_the_pairs_of_run)
{
    skip_without("duet-simulate", "SimGrid");
    static const char *const scenes[] = {
        "paper -n 900 --set world=18", "clustered -n 900",       "mixed -n 900",
        "paper -n 5 --set world=1",    "paper -n 0 2>/dev/null", "rounded -n 63"};
    write_network();
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; ++i)
        for (int ranks = 64; ranks <= (test_takes_all() ? 256 : 64); ranks *= 4) {
            program one = program_run("cluster --plain --repeat 1 --check --json %s", scenes[i]);
            cJSON *expected = json_of_program(one),
                  *found = json_of_run("cluster --simulate " NETWORK " --ranks %d --repeat 1 "
                                       "--json %s",
                                       ranks, scenes[i]);
            json_array(found, "ranks", ranks);
            assert_true(json_true(json_field(expected, "check"), "right"));
            assert_string_equal(json_string(found, "hash"), json_string(expected, "hash"));
            assert_true(json_number(found, "pairs") == json_number(expected, "pairs"));
            assert_true(json_number(found, "total_ms") > 0.01 && // one message takes that
                        json_number(found, "total_ms") < 1000);
        }
}

static cJSON *forecast(const test_folder *folder, const char *uid, const char *arguments)
{
    return json_of_run_with(
        folder->variable, "cluster --simulate " NETWORK " --profile %s --json %s", uid, arguments);
}

static double of_all_ranks(const cJSON *result, const char *name)
{
    double sum = 0;
    const cJSON *ranks = json_field(result, "ranks");
    for (int i = 0; i < cJSON_GetArraySize(ranks); ++i)
        sum += json_number(cJSON_GetArrayItem(ranks, i), name);
    return sum;
}

// Counts of ghosts that come after so many colours: bytes for each object at a border, and
// bodies.
typedef struct counted_ghosts {
    int colours, apart;
    double between, first, last, at_end, work, border;
} counted_ghosts;

static const counted_ghosts often = {1, 1, 10.6, 9.8, 6.3, 132, 0.46, 2.17},
                            seldom = {31, 8, 5.1, 23.2, 21.6, 335, 1.47, 5.22};
static const double parts_of_colours[14] = {0.1705,  0.1633,  0.1424,  0.1294, 0.1169,
                                            0.1002,  0.0807,  0.0546,  0.029,  0.0101,
                                            0.00246, 0.00034, 0.00004, 0.00002};

// Two ranks with one border between them, and the step of the one with more bodies.
typedef struct forecast_step {
    double bodies, border, stands_for;
    double body_s; // of the profile's step
} forecast_step;

static forecast_step step_of(const cJSON *told, double stands_for, double body_ms)
{
    const cJSON *ranks = json_array(told, "ranks", 2);
    double a = json_number(cJSON_GetArrayItem(ranks, 0), "objects"),
           b = json_number(cJSON_GetArrayItem(ranks, 1), "objects");
    return (forecast_step){.bodies = fmax(a, b) / stands_for,
                           .border = of_all_ranks(told, "ghosts") / stands_for,
                           .stands_for = stands_for,
                           .body_s = body_ms * 1e-3 * stands_for};
}

// Two links of 10 us, and 1 GB/s.
static double message_s(const forecast_step *s, double bytes)
{
    return bytes > 0 ? 20e-6 + ceil(bytes * s->border) * s->stands_for / 1e9 : 0;
}

// An eighth of the 0.35 of a step in which sweeps solve contacts, of which bodies have 1.3. A
// message takes longer than the contacts that are solved meanwhile, or they hide it: all that are
// not at the border, if a colour has 4096 of them.
static double sweep_s(const counted_ghosts *c, const forecast_step *s, double first)
{
    const double sweep = 0.35 / 8 * s->body_s, inner = s->bodies - c->border * s->border;
    double seconds = sweep * (s->bodies + c->work * s->border), bytes = first;
    for (int i = 0; i < 14; i += c->apart) {
        const double beside = 1.3 * parts_of_colours[i] * inner * s->stands_for >= 4096
                                  ? sweep * parts_of_colours[i] * inner
                                  : 0;
        seconds += fmax(message_s(s, bytes) - beside, 0);
        bytes = 0;
        for (int k = i; k < i + c->apart && k < 14; ++k)
            bytes += c->between * parts_of_colours[k];
    }
    return seconds;
}

static double step_s(const counted_ghosts *c, const forecast_step *s)
{
    return 0.65 * s->body_s * (s->bodies + c->work * s->border) +
           4 * (sweep_s(c, s, c->first) + message_s(s, c->last) + sweep_s(c, s, 0)) +
           message_s(s, c->last) + 5 * message_s(s, c->at_end / 5);
}

static double told_ms(const cJSON *told, int colours)
{
    const cJSON *all = json_array(told, "exchanges", 5);
    int i = 0;
    while (json_number(cJSON_GetArrayItem(all, i), "colours_between") != colours)
        ++i;
    return json_number(cJSON_GetArrayItem(all, i), "total_ms");
}

// Agreements, of a few messages each, come to it. They are the same however often ghosts come.
static void assert_takes_as_long(const cJSON *told, double stands_for, double body_ms)
{
    const forecast_step s = step_of(told, stands_for, body_ms);
    const double each_ms = told_ms(told, 1), all_ms = told_ms(told, 31);
    const double expected = (step_s(&seldom, &s) - step_s(&often, &s)) * 1e3;
    assert_true(s.border > 0 && s.bodies > seldom.border * s.border);
    assert_true(fabs(all_ms - each_ms - expected) < 0.02); // a rank begins up to a message later
    assert_true(each_ms > step_s(&often, &s) * 1e3 && each_ms < step_s(&often, &s) * 1e3 + 1);
}

// If ghosts come after each colour, both sides send a message after each of 13 colours of eight
// sweeps, as each of four substeps begins, after the colours of its first sweep and after all; then
// what a step ends with.
static void assert_sends_for_each_colour(const cJSON *moving, const cJSON *still)
{
    double border = of_all_ranks(moving, "ghosts"); // two ranks: all of one border
    double more = of_all_ranks(moving, "sent_bytes") - of_all_ranks(still, "sent_bytes");
    double sent = 4 * ceil(often.first * border) + 5 * ceil(often.last * border) +
                  5 * ceil(often.at_end / 5 * border);
    for (int i = 0; i < 13; ++i)
        sent += 8 * ceil(often.between * parts_of_colours[i] * border);
    assert_true(more == 2 * sent);
    assert_true(json_number(moving, "colours_between") == 1);
}

// One of the numbers of colours that are tried takes the least time, and is told.
static void assert_best_is_told(const cJSON *moving)
{
    const cJSON *all = json_array(moving, "exchanges", 5);
    double least = INFINITY, colours = 0;
    for (int i = 0; i < 5; ++i) {
        const cJSON *one = cJSON_GetArrayItem(all, i);
        if (json_number(one, "total_ms") < least) {
            least = json_number(one, "total_ms");
            colours = json_number(one, "colours_between");
        }
    }
    assert_true(colours > 0 && json_number(moving, "colours_between") == colours);
    assert_true(json_number(moving, "total_ms") <= least * 1.001);
}

static void set_workload(const char *path, const char *effects, const char *variant)
{
    char change[160];
    snprintf(change, sizeof change, "UPDATE workload SET effects = '%s'", effects);
    test_store_run(path, change);
    snprintf(change, sizeof change, "UPDATE profile SET variant_b = '%s'", variant);
    test_store_run(path, change);
}

static void a_moving_profile_sends_for_each_colour(const test_folder *folder, const char *uid,
                                                   const cJSON *still, double body_ms)
{
    static const char arguments[] = "--ranks 2 paper -n 4000 --set world=32";
    set_workload(folder->store, "moving", "auto motion.colours=1");
    assert_sends_for_each_colour(forecast(folder, uid, arguments), still);
    set_workload(folder->store, "moving", "auto motion.colours=7");
    assert_true(json_number(forecast(folder, uid, arguments), "colours_between") == 4);
    set_workload(folder->store, "moving", "auto");
    assert_best_is_told(forecast(folder, uid, arguments));
    assert_takes_as_long(forecast(folder, uid, arguments), 1, body_ms);
    assert_takes_as_long(
        forecast(folder, uid, "--ranks 2 --stands-for 100 paper -n 4000 --set world=148"), 100,
        body_ms);
    set_workload(folder->store, "", "auto");
}

typedef struct known_profile {
    test_folder folder;
    char uid[9]; // of the store's only profile
    double step_ms;
} known_profile;

static known_profile make_profile(void)
{
    known_profile k = {.folder = test_folder_make()};
    test_store_tune(k.folder.store);
    duet_profile_list *list = must(duet_profile_list_create(k.folder.store, false, ERR));
    const duet_stored_profile *profile = duet_profile_list_get_profile(list, 0);
    snprintf(k.uid, sizeof k.uid, "%.8s", profile->uid);
    k.step_ms = profile->step_ms;
    duet_profile_list_destroy(list);
    write_network();
    return k;
}

// One object that stands for K travels as K would, and takes a device as long.
TEST(a_forecast_takes_the_times_of_a_profile)
{
    skip_without("duet-simulate", "SimGrid");
    const known_profile k = make_profile();
    cJSON *one = forecast(&k.folder, k.uid, "--ranks 1 paper -n 4000");
    assert_true(json_number(one, "total_ms") >= 4 * k.step_ms * 0.999);
    assert_true(json_number(one, "total_ms") <= 4 * k.step_ms + 1);
    assert_null(cJSON_GetObjectItem(one, "hash"));
    cJSON *two = forecast(&k.folder, k.uid, "--ranks 2 paper -n 4000 --set world=32");
    cJSON *many =
        forecast(&k.folder, k.uid, "--ranks 2 --stands-for 1000 paper -n 4000 --set world=320");
    assert_true(json_number(two, "efficiency") < 1);
    assert_true(json_number(many, "objects") == 4e6);
    assert_true(
        json_number(forecast(&k.folder, k.uid, "--ranks 1 --stands-for 1000000 paper -n 5000"),
                    "objects") == 5e9);
    assert_true(json_number(many, "total_ms") > 2000 * k.step_ms);
    double bytes = 0; // at 1 GB/s
    for (int i = 0; i < 2; ++i)
        bytes = fmax(bytes, json_number(json_row(many, "ranks", i), "sent_bytes"));
    assert_true(bytes > 0);
    assert_true(json_number(many, "total_ms") > 2000 * k.step_ms + bytes * 1e-6 * 0.99);
    a_moving_profile_sends_for_each_colour(&k.folder, k.uid, two, k.step_ms / 1000);
}

#define CANNOT_BE "its time of a step or its objects cannot be"

TEST(a_profile_that_forecasts_nothing_is_refused)
{
    static const struct {
        const char *change; // of the store; NULL: none
        const char *arguments;
        int exit_code;
        const char *says;
    } rows[] = {
        {NULL, "paper2d -n 9", 2, "': a profile in 3D, and paper2d is in 2D; expected the same"},
        {NULL, "paper -n 9 --level aabb", 2,
         "': a profile at level certified, and this is at level aabb; expected the same"},
        {"workload SET query = 'rays closest', boxes = 9", "still", 2,
         "': a profile of the query 'rays closest'; expected one of steps"},
        {"workload SET query = NULL, boxes = 0; UPDATE profile SET objective = "
         "'time over 3 ranks of 1 part on 2 hosts'",
         "still", 2,
         "': a profile of time over 3 ranks of 1 part on 2 hosts; expected one of steps on one "
         "device pair"},
        {"profile SET objective = 'time', median_ns = 9e999", "still", 1, CANNOT_BE},
        {"profile SET median_ns = -5", "still", 1, CANNOT_BE},
        {"profile SET median_ns = 0", "still", 1, CANNOT_BE},
        {"profile SET median_ns = 7; UPDATE workload SET n = 0", "still", 1, CANNOT_BE},
    };
    skip_without("duet-simulate", "SimGrid");
    const known_profile k = make_profile();
    program_assert_refused(program_run_with(k.folder.variable, "cluster --simulate " NETWORK
                                                               " --ranks 2 --profile none still"),
                           2, "--profile 'none': 0 profiles begin so");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        char change[240];
        snprintf(change, sizeof change, "PRAGMA ignore_check_constraints = ON; UPDATE %s",
                 rows[i].change);
        if (rows[i].change)
            test_store_run(k.folder.store, change);
        program p = program_run_with(k.folder.variable,
                                     "cluster --simulate " NETWORK " --ranks 2 --profile %s %s",
                                     k.uid, rows[i].arguments);
        program_assert_refused(p, rows[i].exit_code, rows[i].says);
    }
}

TEST(a_platform_that_is_none_is_one_line)
{
    skip_without("duet-simulate", "SimGrid");
    static const program_refusal wrong[] = {
        {"no.xml --ranks 2 still", 1, "no.xml: No such file or directory"},
        {"/dev/null --ranks 2 still", 1, "/dev/null: no platform of SimGrid: "},
        {NO_ROUTE " --ranks 2 still", 1,
         NO_ROUTE ": no platform of SimGrid: no route leads from a to b"},
        {NETWORK " still", 2, "--simulate does nothing without --ranks"},
        {NETWORK " --ranks 2 --pair cpu still", 2, "--pair and --simulate do not go together"},
        {NETWORK " --ranks 2 papr", 2, "rank 0 on host0: papr: no such file or scene"},
        {NETWORK " --ranks 2 --stands-for 9 still", 2, "--stands-for does nothing without "},
    };
    write_network();
    write_platform(NO_ROUTE, "<host id='a' speed='1Gf'/><host id='b' speed='1Gf'/>");
    program_assert_refusals("cluster --simulate ", "", wrong);
}

// ---------------------------------------------------------------- what is told

// Corners, or boxes with a radius of which the first have no extents.
static double number_of_row(int columns, int i, int k)
{
    double at = i * 37 % 100 * 0.3;
    if (columns == 6)
        return at + (k < 3 ? 0 : 1);
    return k < 3 ? at : k < 6 ? (i > 60 ? 0.25 : 0) : k < 9 ? 0 : k == 9 ? 1 : 0.5;
}

// Each rank reads its rows; with --check rank 0 reads all.
TEST(an_array_is_read_in_parts)
{
    for (int columns = 6; columns <= 11; columns += 5) {
        own(text) file = {0};
        npy_add_header(&file, NPY_FLOAT64, 100, (uint64_t)columns);
        for (int i = 0; i < 100 * columns; ++i) {
            double number = number_of_row(columns, i / columns, i % columns);
            text_add_bytes(&file, (const char *)&number, sizeof number);
        }
        must(text_write_file("rows.npy", text_chars(&file), file.length, ERR));
        cJSON *expected = json_of_run("cluster --plain --repeat 1 --check --json rows.npy"),
              *found = json_of_run("cluster --plain --repeat 1 --ranks 3 --json rows.npy");
        assert_true(json_true(json_field(expected, "check"), "right"));
        assert_true(json_number(expected, "pairs") > 100);
        assert_true(json_number(found, "objects") == 100);
        assert_string_equal(json_string(found, "hash"), json_string(expected, "hash"));
    }
}

// Its pair, the sums of all ranks, and nothing of stdin lost.
TEST(each_rank_has_its_row_and_its_part_of_the_devices)
{
    cJSON *o =
        json_of_run_with("printf '0,0,0,1,1,1\\n.5,.5,.5,2,2,2\\n9,9,9,9,9,9\\n' | DUET_PAIR=",
                         "cluster --ranks 2 --weights 1,2 --check --json -");
    const cJSON *rows = json_array(o, "ranks", 2);
    const cJSON *first = cJSON_GetArrayItem(rows, 0), *second = cJSON_GetArrayItem(rows, 1);
    cJSON *devices = json_of_run("devices --json");
    const cJSON *device = json_row(devices, "devices", 0);
    if (json_size(devices, "devices") == 1 && json_number(device, "units") > 1)
        assert_string_not_equal(json_string(first, "pair"), json_string(second, "pair"));
    assert_string_equal(json_string(first, "host"), json_string(second, "host"));
    assert_true(json_number(second, "rank") == 1);
    assert_true(json_number(first, "objects") + json_number(second, "objects") == 3);
    assert_true(json_number(first, "pairs") + json_number(second, "pairs") == 1);
    assert_true(json_number(o, "pairs") == 1);
    assert_true(json_true(json_field(o, "check"), "right"));
}

TEST(a_rank_that_is_bound_to_one_core_of_several_is_told_of)
{
    cJSON *devices = json_of_run("devices --json");
    double units = json_number(json_row(devices, "devices", 0), "units");
    program p = program_done(
        program_run_with("DUET_PAIR=pocl:0 taskset -c 0", "cluster --repeat 1 still -n 3"));
    assert_true((units > 1) == (strstr(p.err, "duet: rank 0 may use 1 of the ") != NULL));
    assert_says(p.out, "  pocl:0  "); // the device that does it all is named once
}

TEST(a_person_reads_a_table)
{
    program p =
        program_done(program_run("cluster --ranks 3 --plain --check --resident planes -n 60"));
    assert_string_equal(p.err, "");
    assert_says(p.out, "3 ranks", "   2  ", "same ");
}

TEST(the_file_of_pairs_is_that_of_one_rank)
{
    for (int ranks = 1; ranks <= 3; ranks += 2) {
        cJSON *o = json_of_run("cluster --plain --repeat 1 --json --ranks %d --sorted "
                               "--pairs %d.npy planes -n 90",
                               ranks, ranks);
        char path[16];
        snprintf(path, sizeof path, "%d.npy", ranks);
        assert_int_equal(test_read_file(path).length, 128 + 16 * (size_t)json_number(o, "pairs"));
    }
    test_assert_same_file("1.npy", "3.npy");
}

TEST(a_failure_is_one_line)
{
    static const program_refusal wrong[] = {
        {"cluster --ranks 2 papr", 2, "duet: rank 0 on "},
        {"cluster --ranks 2 papr", 2, "papr: no such file or scene; did you mean 'paper'?"},
        {"cluster papr", 2, "duet: papr: no such file or scene"},
        {"cluster --ranks 3 --pair abacus still -n 2", 2, ": no device 'abacus'; there is "},
        {"cluster --ranks 2 --plain --weights 1,1,1 still", 2, "3 numbers for 2 ranks"},
        {"cluster --ranks 2 --plain --weights 1,0 still", 2, "give numbers above 0"},
        {"cluster --ranks 2 --plain --weights 1,inf still", 2, "give numbers above 0"},
        {"cluster --ranks 2 --plain --pairs no/such/p.npy papr", 1, "p.npy: cannot be written"},
        {"cluster --pairs p.csv still", 2, "expected a file whose name ends in .npy"},
        {"cluster --sorted still", 2, "--sorted does nothing without --pairs"},
        {"cluster --hosts one still", 2, "--hosts does nothing without --ranks"},
        {"cluster --ranks 2 --hosts '' still", 2,
         "--hosts '': the value is empty; expected --hosts H,H"},
        {"cluster --verbose still", 2, "--verbose does nothing without --ranks"},
        {"cluster --plain --mode own still", 2, "--mode and --plain do not go together"},
        {"cluster --mode abacus still", 2, "--mode 'abacus': the modes are"},
        {"cluster --level abacus still", 2, "--level 'abacus': the levels are"},
        {"cluster --ranks 0 still", 2, "--ranks '0': give a whole number"},
        {"cluster --parts 1025 still", 2, "--parts '1025': give a whole number"},
        {"cluster", 2, "SCENE|FILE is missing"},
        {"lua -e 'duet.cluster()'", 1, "duet.cluster needs 'duet lua --trust'"},
    };
    program_assert_refusals("", "", wrong);
    program_assert_refused(program_run_with("printf '0,0,0,1,1,1\\n0,0,0,1,1,inf\\n' |",
                                            "cluster --ranks 3 --plain -"),
                           1, "stdin:2: object 1: ");
    static const char *const silences[] = {"soon", "-1", "nan", "1e99", "2s"};
    for (size_t i = 0; i < sizeof silences / sizeof *silences; ++i) {
        char variable[40], says[80];
        snprintf(variable, sizeof variable, "DUET_RANK_SILENCE=%s", silences[i]);
        snprintf(says, sizeof says, "DUET_RANK_SILENCE is '%s'; expected a number of seconds",
                 silences[i]);
        program_assert_refused(program_run_with(variable, "cluster --ranks 2 --plain still"), 2,
                               says);
    }
    program_assert_refused(program_run_with("OMPI_COMM_WORLD_SIZE=3 OMPI_COMM_WORLD_RANK=0",
                                            "cluster --ranks 2 still"),
                           2, "this is rank 0 of 3 of an MPI job already");
}

// Starts one program for each rank, as a person can by mpirun itself.
static program two_programs(const char *first, const char *second)
{
    return program_run_with("timeout 60 mpirun --quiet --oversubscribe -n 1",
                            "cluster %s : -n 1 \"$DUET_PROGRAM\" cluster %s", first, second);
}

TEST(ranks_of_other_words_are_refused)
{
    static const char *const wrong[][3] = {
        {"still -n 3", "paper -n 3", "'paper', where rank 0 has 'still'"},
        {"still -n 3", "still -n 4", "'4', where rank 0 has '3'"},
        {"still -n 3 --repeat 2", "still -n 3", "nothing, where rank 0 has '--repeat'"},
        {"still -n 3", "still -n 3 --check", "'--check', where rank 0 has nothing"},
        {"still -n 3", "still -n 3 --papr", "'--papr', where rank 0 has nothing"},
        {"falling -n 9 --steps 3", "falling -n 9 --steps 5", "'5', where rank 0 has '3'"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        program p = two_programs(wrong[i][0], wrong[i][1]);
        assert_says(p.err, "duet: rank 1 on ", wrong[i][2]);
        program_assert_refused(p, 2, "; expected the same words on all ranks\n");
    }
    assert_true(json_number(json_of_program(two_programs("still -n 3 --json", "still -n 3 --json")),
                            "objects") == 3);
}

// mpirun is the program's child, and the ranks are mpirun's. Some seconds later that one would
// still be at work. It may have no name for a rank that has just been started.
TEST(a_rank_that_is_killed_ends_the_job_and_leaves_no_file)
{
    static const char kill_one[] =
        "& job=$!; children() { cat /proc/$1/task/*/children 2>/dev/null; }; rank=; "
        "until [ -n \"$rank\" ]; do for child in $(children $job); do "
        "for rank in $(children $child); do :; done; done; done; kill -9 $rank; wait $job";
    program p = program_run("cluster --ranks 3 --plain --repeat 100000 --pairs killed.npy paper "
                            "-n 30000 %s",
                            kill_one);
    assert_string_equal(p.out, "");
    program_assert_refused(p, 1, "a rank was ended by signal 9 (Killed), and with it the job");
    assert_int_equal(access("killed.npy", F_OK), -1);
    assert_int_equal(system("ls killed.npy* >/dev/null 2>&1") == 0, 0);
}

// The ranks are there once rank 0 opens the scene, which is a pipe.
TEST(a_rank_that_is_stopped_is_told_of_and_goes_on)
{
    static const char stop_one[] =
        "2>stopped.says & job=$!; "
        "children() { cat /proc/$1/task/*/children 2>/dev/null; }; "
        "exec 3>stopped.csv; "
        "for child in $(children $job); do for rank in $(children $child); do :; done; done; "
        "says() { until grep -q \"rank [0-2] of 3 (host [^ ]*, pid $rank) $1\" stopped.says; "
        "do sleep .1; done; }; "
        "kill -STOP $rank; says 'has not answered for 2 s'; "
        "kill -CONT $rank; says 'answers again'; "
        "printf '0 0 0 1 1 1\\n1 1 1 2 2 2\\n' >&3; exec 3>&-; wait $job";
    remove("stopped.csv");
    assert_int_equal(mkfifo("stopped.csv", 0600), 0);
    program p =
        program_run_with("DUET_RANK_SILENCE=2",
                         "cluster --ranks 3 --plain --repeat 1 --json stopped.csv %s", stop_one);
    assert_int_equal(p.exit_code, 0);
    cJSON *o = json_of_program(p);
    assert_true(json_number(o, "pairs") == 1);
}
