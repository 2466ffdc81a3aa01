// SPDX-License-Identifier: MIT
// An application in a language whose numbers have a comma: what it measures, stores and loads is
// the same as without one, and its own numbers keep their comma.
#include "support/locale.h"
#include "support/test.h"

#include "profiles/duet_profiles.h"
#include "tuner/duet_tune.h"

enum { BOXES = 100 };

static duet_scene *scene;

static void assert_comma(bool is)
{
    char shown[8];
    snprintf(shown, sizeof shown, "%.1f", 0.5);
    assert_string_equal(shown, is ? "0,5" : "0.5");
}

static void begin(void)
{
    const duet_setting n = {"n", "100"};
    scene = kept(duet_scene_load("paper", &n, 1, ERR));
    test_make_comma_locale();
}

TEST_BEGIN(begin)

static bool see(void *context, const duet_tune_progress *progress)
{
    ++*(uint32_t *)context;
    return progress != NULL;
}

static void tune(const char *store)
{
    const char *const variant = "auto";
    const duet_mode mode = DUET_MODE_OWN;
    uint32_t seen = 0;
    duet_tune_outcome outcome;
    duet_tune_def def = duet_default_tune_def();
    def.pair = default_pair();
    def.scene = scene;
    def.store = store;
    def.variants = &variant;
    def.n_variants = 1;
    def.modes = &mode;
    def.n_modes = 1;
    def.wait_seconds = 0;
    def.watch = see;
    def.watch_context = &seen;
    must(duet_tune_run(&def, &outcome, ERR));
    assert_true(seen > 0);
    assert_string_equal(outcome.unused, "");
}

static duet_grade load(const char *store)
{
    duet_profile profile;
    duet_world_def def = duet_scene_world_def(scene, default_pair());
    duet_world *world = kept(duet_world_create(&def, ERR));
    must(duet_world_set_scene(world, scene, ERR));
    must(duet_world_load_profile(world, store, &profile, ERR));
    return profile.grade;
}

static void speak_without_comma(void)
{
    test_speak_with_comma(false);
}

TEST_EACH(NULL, speak_without_comma)

TEST(a_tuning_with_a_comma_is_found_without_one)
{
    test_speak_with_comma(true);
    tune("comma.db");
    assert_comma(true);
    assert_int_equal(load("comma.db"), DUET_GRADE_EXACT);
    test_speak_with_comma(false);
    assert_comma(false);
    assert_int_equal(load("comma.db"), DUET_GRADE_EXACT);
}

TEST(a_tuning_without_a_comma_is_found_with_one)
{
    tune("point.db");
    test_speak_with_comma(true);
    assert_int_equal(load("point.db"), DUET_GRADE_EXACT);
}

TEST(stores_are_exported_and_imported_with_a_comma)
{
    duet_import_counts counts;
    must(duet_profiles_export("point.db", "point.jsonl", ERR));
    test_speak_with_comma(true);
    must(duet_profiles_import("copy.db", "point.jsonl", &counts, ERR));
    must(duet_profiles_export("copy.db", "comma.jsonl", ERR));
    assert_true(counts.added > 0);
    test_assert_same_file("point.jsonl", "comma.jsonl");
}

TEST(a_failed_call_gives_the_comma_back)
{
    duet_error err = {0};
    test_speak_with_comma(true);
    assert_null(duet_scene_load("none.csv", NULL, 0, &err));
    assert_null(duet_scene_load("none.csv", NULL, 0, NULL));
    assert_comma(true);
}
