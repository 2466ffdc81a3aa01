// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "lua/policy.h"
#include "support/program.h"
#include "support/store.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// inside/deep/file, links to it and to what lies outside, and a folder "file:".
static test_folder folder;
static char start[2048];
static char outside[2200];

static int make_folders(void **state)
{
    (void)state;
    folder = test_folder_make();
    if (!getcwd(start, sizeof start))
        return -1;
    store_close(test_store_open(folder.store, STORE_WRITE));
    snprintf(outside, sizeof outside, "%s/%s", start, folder.path);
    if (chdir(folder.path) || mkdir("inside", 0755) || chdir("inside") || mkdir("deep", 0755) ||
        mkdir("file:", 0755))
        return -1;
    test_write_file("deep/boxes.csv", "0 0 0 1 1 1\n");
    test_write_file("../secret.csv", "0 0 0 1 1 1\n");
    return symlink("deep/boxes.csv", "near.csv") || symlink("../secret.csv", "far.csv") ||
           symlink("..", "up") || symlink("deep", "across") || symlink("nowhere", "dangling");
}

static int remove_folders(void **state)
{
    (void)state;
    int code = chdir(start);
    test_folder_remove(&folder);
    return code;
}

static void only_straight_paths_are_beneath(void **state)
{
    (void)state;
    static const char *const straight[] = {"deep/boxes.csv",
                                           "./deep//boxes.csv",
                                           "deep/./boxes.csv",
                                           "deep/",
                                           "none",
                                           "deep/none/x",
                                           "deep/boxes.csv/x",
                                           "",
                                           ".",
                                           "..x",
                                           "deep/...",
                                           "file:/x"};
    static const char *const others[] = {"/deep",
                                         "..",
                                         "../inside/deep",
                                         "deep/..",
                                         "deep/../x",
                                         "near.csv",
                                         "far.csv",
                                         "up/secret.csv",
                                         "up",
                                         "across/boxes.csv",
                                         "./across/",
                                         "dangling",
                                         "up/inside/deep/boxes.csv",
                                         "none/../x"};
    for (size_t i = 0; i < sizeof straight / sizeof straight[0]; ++i)
        if (!path_is_beneath(straight[i]))
            fail_msg("'%s' is refused", straight[i]);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i)
        if (path_is_beneath(others[i]))
            fail_msg("'%s' is taken", others[i]);
}

static void no_descriptor_is_left_open(void **state)
{
    (void)state;
    int before = dup(0);
    close(before);
    for (int i = 0; i < 50; ++i) {
        path_is_beneath("deep/boxes.csv");
        path_is_beneath("deep/none/x");
        path_is_beneath("across/boxes.csv");
    }
    int after = dup(0);
    close(after);
    assert_int_equal(after, before);
}

static void an_untrusted_script_reads_nothing_through_a_link(void **state)
{
    (void)state;
    program p = program_run("lua -e \"assert(duet.scene('deep/boxes.csv'))\"");
    assert_string_equal(p.err, "");
    assert_int_equal(p.exit_code, 0);
    program_free(&p);
    static const char *const paths[] = {"far.csv", "near.csv", "up/secret.csv", "../secret.csv"};
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; ++i) {
        p = program_run("lua -e \"assert(duet.scene('%s'))\"", paths[i]);
        program_assert_refused(&p, 1, "is not below the current folder, or a link");
    }
    p = program_run("lua -e \"assert(duet.profiles('up/profiles.db'))\"");
    program_assert_refused(&p, 1, "is not below the current folder, or a link");
}

// To SQLite the path after "file:" was a whole one.
static void a_folder_called_file_is_no_way_out(void **state)
{
    (void)state;
    program p = program_run("lua -e \"assert(duet.profiles('file:%s/profiles.db'))\"", outside);
    program_assert_refused(&p, 1, "there is no profile store");
}

#define IN_FOLDERS(test) cmocka_unit_test_setup_teardown(test, make_folders, remove_folders)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDERS(only_straight_paths_are_beneath),
        IN_FOLDERS(no_descriptor_is_left_open),
        IN_FOLDERS(an_untrusted_script_reads_nothing_through_a_link),
        IN_FOLDERS(a_folder_called_file_is_no_way_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
