// SPDX-License-Identifier: MIT
// duet accuracy, as a person calls it.
#include "support/devices.h"
#include "support/json.h"
#include "support/test.h"

#include "base/text.h"

#define SCENE "test_accuracy.scene.lua"
#define ORBIT "test_accuracy.orbit.lua"
#define STACK "test_accuracy.stack.lua"
#define PLOT "test_accuracy.svg"
#define TABLE "test_accuracy.csv"

static const char scene_text[] =
    "local p = parameters { n = 1500, seed = 1 }\n"
    "local random = random(p.seed)\n"
    "for _ = 1, p.n do\n"
    "  local x, y, z = random.uniform(0, 9.5), random.uniform(0, 9.5), random.uniform(0, 9.5)\n"
    "  add(x, y, z, 0.5, 0.5, 0.5, random.quaternion())\n"
    "end\n"
    "return { dims = 3 }\n";

static const char orbit_text[] =
    "for i = 1, 20 do\n"
    "  add { centre = { i, 0 }, half_extents = { 0.1, 0.1 }, velocity = { 0, 10 / math.sqrt(i) } "
    "}\n"
    "end\n"
    "return { dims = 2, attraction = { centre = { 0, 0 }, strength = 100 }, substeps = 1,\n"
    "  integrator = 'verlet', doubles = true, wants = { 'contact' } }\n";

static const char stack_text[] =
    "for i = 0, 3 do add { centre = { 0, 0, i * 1.1 + 0.6 }, half_extents = { 0.5, 0.5, 0.5 } } "
    "end\n"
    "add { centre = { 0, 0, -0.5 }, half_extents = { 5, 5, 0.5 }, mass = 0 }\n"
    "return { dims = 3, gravity = { 0, 0, -10 }, wants = { 'contact_response' } }\n";

static void make_scene(void)
{
    test_write_file(SCENE, scene_text);
    test_write_file(ORBIT, orbit_text);
    test_write_file(STACK, stack_text);
}

static void assert_row_is_what_its_level_promises(const cJSON *row, double truth)
{
    const char *name = json_string(row, "level");
    duet_level level;
    assert_true(duet_level_from_name(name, &level));
    const duet_level_info *info = duet_level_get_info(level);
    double missed = json_number(row, "missed"), added = json_number(row, "false");
    assert_true(json_number(row, "pairs") == truth - missed + added);
    assert_true(json_number(row, "step_ms") > 0);
    if (info->missed == 0)
        assert_true(missed == 0);
    if (info->added == 0)
        assert_true(added == 0);
    if (level == DUET_LEVEL_AABB || level == DUET_LEVEL_SPHERE || level == DUET_LEVEL_SAT6)
        assert_true(added > 0 && json_number(row, "widest_false") > 0);
}

TEST(each_levels_cost_is_told_for_each_device)
{
    program p = program_done(
        program_run("accuracy --json --repeat 1 --csv " TABLE " --plot " PLOT " " SCENE));
    cJSON *o = json_of(p.out);
    const cJSON *levels = json_field(o, "levels");
    assert_int_equal(cJSON_GetArraySize(levels), (devices_are_two() ? 2 : 1) * DUET_LEVELS);
    const cJSON *row;
    bool front = false;
    cJSON_ArrayForEach(row, levels)
    {
        assert_row_is_what_its_level_promises(row, json_number(o, "pairs"));
        front |= json_true(row, "front");
    }
    assert_true(front);
}

TEST(an_only_device_is_measured_once)
{
    program p = program_done(program_run("accuracy --repeat 1 --pair cpu " SCENE));
    const char *first = strstr(p.out, "certified");
    assert_non_null(first);
    assert_null(strstr(first + 1, "certified"));
    assert_null(strstr(p.out, "alone"));
}

// One of 95 % from 7 rounds leaves out none of them; from 5 rounds there is none.
TEST(a_difference_from_sat15_is_noise_or_not)
{
    static const int rounds[] = {5, 7};
    for (int i = 0; i < 2; ++i) {
        program p = program_run("accuracy --json --repeat %d " SCENE, rounds[i]);
        cJSON *o = json_of(p.out);
        const cJSON *row;
        cJSON_ArrayForEach(row, json_field(o, "levels"))
        {
            const cJSON *high = cJSON_GetObjectItemCaseSensitive(row, "relative_high");
            double low = json_number(row, "relative_low"), relative = json_number(row, "relative");
            bool same = json_true(row, "same");
            bool is_sat15 = strcmp(json_string(row, "level"), "sat15") == 0;
            assert_true((high != NULL) == (rounds[i] == 7));
            assert_true(low <= relative && (!high || relative <= high->valuedouble));
            assert_true(is_sat15 || same == (low <= 1 && (!high || high->valuedouble >= 1)));
        }
    }
    program p = program_run("accuracy --repeat 1 " SCENE);
    assert_says(p.out, "Fewer than 6 rounds tell no difference from noise");
}

TEST(the_table_and_the_plot_name_every_level)
{
    static const char *const files[] = {TABLE, PLOT};
    program p =
        program_done(program_run("accuracy --repeat 1 --csv " TABLE " --plot " PLOT " " SCENE));
    for (int l = 0; l < DUET_LEVELS; ++l)
        assert_says(p.out, duet_level_get_info((duet_level)l)->name);
    for (int f = 0; f < 2; ++f) {
        const text content = test_read_file(files[f]);
        assert_true(content.length > 200);
    }
}

TEST(a_plot_of_another_kind_is_refused)
{
    program p = program_run("accuracy --repeat 1 --plot plot.gif " SCENE);
    assert_int_equal(p.exit_code, 2);
    assert_says(p.err, ".svg");
}

// ---------------------------------------------------------------- what moves

static cJSON *measure(const char *arguments)
{
    return json_of_run("accuracy --json %s", arguments);
}

// The error of a row of free flight.
static double error_at(const cJSON *timesteps, const char *integrator, double per_second)
{
    const cJSON *row;
    cJSON_ArrayForEach(row, timesteps)
    {
        double dt = json_number(row, "dt");
        const char *name = json_string(row, "integrator");
        if (strcmp(name, integrator) == 0 && dt * per_second > 0.99 && dt * per_second < 1.01)
            return json_number(row, "error");
    }
    fail_msg("no row of %s at dt 1/%g", integrator, per_second);
    return 0;
}

static int count_true(const cJSON *rows, const char *key)
{
    int n = 0;
    const cJSON *row;
    cJSON_ArrayForEach(row, rows) n += cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(row, key));
    return n;
}

// Errors shrink with dt as the integrator's order has it.
TEST(flights_compare_integrators)
{
    cJSON *o = measure("--csv " TABLE " --plot " PLOT " " ORBIT);
    const cJSON *timesteps = json_field(o, "timesteps");
    assert_int_equal(cJSON_GetArraySize(timesteps), 12);
    static const struct {
        const char *integrator;
        double factor; // ratio of the error from dt 1/60 to 1/120
    } orders[] = {{"euler", 2}, {"verlet", 4}, {"yoshida", 16}};
    for (int i = 0; i < 3; ++i) {
        double factor = error_at(timesteps, orders[i].integrator, 60) /
                        error_at(timesteps, orders[i].integrator, 120);
        if (!(factor > 0.8 * orders[i].factor && factor < 1.3 * orders[i].factor))
            fail_msg("%s: half the dt has a factor of %g", orders[i].integrator, factor);
    }
    assert_int_equal(count_true(timesteps, "own"), 1);
    assert_true(count_true(timesteps, "front") > 0);
    assert_int_equal(count_true(timesteps, "finite"), 12);
}

TEST(contacts_compare_dt_and_substeps)
{
    cJSON *o = measure("--time 0.5 " STACK);
    const cJSON *timesteps = json_field(o, "timesteps");
    assert_int_equal(cJSON_GetArraySize(timesteps), 16);
    assert_int_equal(count_true(timesteps, "own"), 1);
    assert_int_equal(count_true(timesteps, "finite"), 16);
    double coarse = json_number(cJSON_GetArrayItem(timesteps, 0), "depth");
    double fine = json_number(cJSON_GetArrayItem(timesteps, 15), "depth");
    assert_true(coarse > fine && fine > 0);
}

TEST(a_limit_ends_it_after_a_run)
{
    program p = program_done(program_run("accuracy --limit 0 --time 0.1 " STACK));
    assert_says(p.out, "15 dearer ones were not begun");
}

TEST(still_asks_for_levels_of_what_moves)
{
    cJSON *o = measure("--still --repeat 1 " STACK);
    assert_non_null(json_field(o, "levels"));
}

TEST_BEGIN(make_scene)
