// SPDX-License-Identifier: MIT
// duet accuracy, as a person calls it.
#include "support/program.h"
#include "support/test.h"

#include "runtime/base/text.h"
#include "runtime/duet.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

#define SCENE "test_accuracy.scene.lua"
#define PLOT "test_accuracy.svg"
#define TABLE "test_accuracy.csv"

static const char scene_text[] =
    "local p = parameters { n = 3000, seed = 1 }\n"
    "local random = random(p.seed)\n"
    "for _ = 1, p.n do\n"
    "  local x, y, z = random.uniform(0, 12), random.uniform(0, 12), random.uniform(0, 12)\n"
    "  add(x, y, z, 0.5, 0.5, 0.5, random.quaternion())\n"
    "end\n"
    "return { dims = 3 }\n";

static int make_scene(void **state)
{
    (void)state;
    duet_error err = {0};
    assert_ok(text_write_file(SCENE, scene_text, strlen(scene_text), &err), err);
    return 0;
}

static int remove_files(void **state)
{
    (void)state;
    remove(SCENE);
    remove(PLOT);
    remove(TABLE);
    return 0;
}

static double number_of(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);
    if (!cJSON_IsNumber(item))
        fail_msg("no number '%s'", key);
    return item->valuedouble;
}

static void assert_row_is_what_its_level_promises(const cJSON *row, double truth)
{
    const char *name = cJSON_GetObjectItemCaseSensitive(row, "level")->valuestring;
    duet_level level;
    assert_true(duet_level_named(name, &level));
    const duet_level_info *info = duet_level_describe(level);
    double missed = number_of(row, "missed"), added = number_of(row, "false");
    assert_true(number_of(row, "pairs") == truth - missed + added);
    assert_true(number_of(row, "step_ms") > 0);
    if (info->missed == 0)
        assert_true(missed == 0);
    if (info->added == 0)
        assert_true(added == 0);
    if (level == DUET_LEVEL_AABB || level == DUET_LEVEL_SPHERE || level == DUET_LEVEL_SAT6)
        assert_true(added > 0 && number_of(row, "widest_false") > 0);
}

static void each_levels_price_is_told_for_each_device(void **state)
{
    (void)state;
    program p = program_run("accuracy --json --repeat 1 --csv " TABLE " --plot " PLOT " " SCENE);
    if (p.exit_code != 0)
        fail_msg("accuracy: %s", p.err);
    cJSON *o = cJSON_Parse(p.out);
    assert_non_null(o);
    const cJSON *levels = cJSON_GetObjectItemCaseSensitive(o, "levels");
    assert_int_equal(cJSON_GetArraySize(levels), 2 * DUET_LEVELS);
    const cJSON *row;
    bool front = false;
    cJSON_ArrayForEach(row, levels)
    {
        assert_row_is_what_its_level_promises(row, number_of(o, "pairs"));
        front |= cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(row, "front"));
    }
    assert_true(front);
    cJSON_Delete(o);
    program_free(&p);
}

static void the_table_and_the_plot_name_every_level(void **state)
{
    (void)state;
    static const char *const files[] = {TABLE, PLOT};
    program p = program_run("accuracy --repeat 1 --csv " TABLE " --plot " PLOT " " SCENE);
    assert_int_equal(p.exit_code, 0);
    for (int l = 0; l < DUET_LEVELS; ++l)
        assert_non_null(strstr(p.out, duet_level_describe((duet_level)l)->name));
    for (int f = 0; f < 2; ++f) {
        text content = {0};
        duet_error err = {0};
        assert_ok(text_read_file(&content, files[f], &err), err);
        assert_true(content.length > 200);
        text_free(&content);
    }
    program_free(&p);
}

static void a_plot_of_another_kind_is_refused(void **state)
{
    (void)state;
    program p = program_run("accuracy --repeat 1 --plot plot.gif " SCENE);
    assert_int_equal(p.exit_code, 2);
    assert_non_null(strstr(p.err, ".svg"));
    program_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_levels_price_is_told_for_each_device),
        cmocka_unit_test(the_table_and_the_plot_name_every_level),
        cmocka_unit_test(a_plot_of_another_kind_is_refused),
    };
    return cmocka_run_group_tests(tests, make_scene, remove_files);
}
