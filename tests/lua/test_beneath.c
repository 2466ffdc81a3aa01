// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "lua/policy.h"
#include "support/program.h"
#include "support/store.h"

#include <sys/stat.h>
#include <unistd.h>

// inside/deep/file, links to it and to what lies outside, and a folder "file:".
static test_folder folder;

static void make_folders(void)
{
    folder = test_folder_make();
    store_close(test_store_open(folder.store, STORE_WRITE));
    assert_false(chdir(folder.path) || mkdir("inside", 0755) || chdir("inside") ||
                 mkdir("deep", 0755) || mkdir("file:", 0755));
    test_write_file("deep/boxes.csv", "0 0 0 1 1 1\n");
    test_write_file("../secret.csv", "0 0 0 1 1 1\n");
    assert_false(symlink("deep/boxes.csv", "near.csv") || symlink("../secret.csv", "far.csv") ||
                 symlink("..", "up") || symlink("deep", "across") ||
                 symlink("nowhere", "dangling"));
}

TEST(only_straight_paths_are_beneath)
{
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

TEST(no_descriptor_is_left_open)
{
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

TEST(an_untrusted_script_reads_nothing_through_a_link)
{
    program p = program_done(program_run("lua -e \"assert(duet.scene('deep/boxes.csv'))\""));
    assert_string_equal(p.err, "");
    static const char *const paths[] = {"far.csv", "near.csv", "up/secret.csv", "../secret.csv"};
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; ++i)
        program_assert_refused(program_run("lua -e \"assert(duet.scene('%s'))\"", paths[i]), 1,
                               "is not below the current folder, or a link");
    program_assert_refused(program_run("lua -e \"assert(duet.profiles('up/profiles.db'))\""), 1,
                           "is not below the current folder, or a link");
}

// To SQLite the path after "file:" was a whole one.
TEST(a_folder_called_file_is_no_way_out)
{
    program_assert_refused(
        program_run("lua -e \"assert(duet.profiles('file:%s/profiles.db'))\"", folder.path), 1,
        "there is no profile store");
}

TEST_EACH(make_folders, NULL)
