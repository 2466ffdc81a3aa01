// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "base/output.h"
#include "base/text_file.h"
#include "support/program.h"
#include "support/store.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

static void write_in(const char *path, const char *content)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(content, file);
    assert_int_equal(fclose(file), 0);
}

static void assert_content(const char *path, const char *content)
{
    char found[256] = "";
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    found[fread(found, 1, sizeof found - 1, file)] = '\0';
    fclose(file);
    assert_string_equal(found, content);
}

static mode_t mode_of(const char *path)
{
    struct stat info;
    assert_int_equal(lstat(path, &info), 0);
    return info.st_mode;
}

static void assert_refused(const char *path, const char *says)
{
    must_fail(text_write_file(path, "new", 3, ERR), DUET_STATUS_IO_FAILED, "");
    if (!strstr(ERR->text, path) || !strstr(ERR->text, says))
        fail_msg("'%s' for '%s' and '%s'", ERR->text, path, says);
}

TEST(a_file_takes_the_place_of_nothing_or_of_a_file)
{
    mode_t umask_before = umask(027);
    test_write_file("out", "one");
    assert_int_equal(mode_of("out"), S_IFREG | 0640);
    test_write_file("out", "two");
    umask(umask_before);
    assert_content("out", "two");
    assert_int_equal(test_count_files(), 1);
    char longest[256];
    memset(longest, 'x', 255);
    longest[255] = '\0';
    test_write_file(longest, "long");
    assert_content(longest, "long");
    assert_int_equal(test_count_files(), 2);
}

// Names that can be told in advance are of no use to whoever puts links there.
TEST(a_link_at_a_guessed_name_leads_nowhere)
{
    write_in("victim", "safe");
    assert_int_equal(symlink("victim", "out.part"), 0);
    for (int i = 0; i < 8; ++i) {
        char guess[64];
        snprintf(guess, sizeof guess, "out.%ld.%d.part", (long)getpid(), i);
        assert_int_equal(symlink("victim", guess), 0);
    }
    test_write_file("out", "new");
    assert_content("out", "new");
    assert_content("victim", "safe");
}

TEST(a_link_stays_and_its_file_is_replaced)
{
    assert_int_equal(mkdir("below", 0755), 0);
    assert_int_equal(symlink("below/second", "first"), 0);
    assert_int_equal(symlink("../file", "below/second"), 0);
    test_write_file("first", "made"); // a path with nothing at it yet
    assert_content("file", "made");
    test_write_file("first", "again");
    assert_content("file", "again");
    assert_true(S_ISLNK(mode_of("first")) && S_ISLNK(mode_of("below/second")));
    assert_true(S_ISREG(mode_of("file")));
    assert_int_equal(test_count_files(), 3);
}

TEST(links_in_a_ring_are_refused)
{
    assert_int_equal(symlink("b", "a"), 0);
    assert_int_equal(symlink("a", "b"), 0);
    assert_refused("a", "cannot be written");
    assert_int_equal(test_count_files(), 2);
}

TEST(a_folder_is_refused)
{
    assert_int_equal(mkdir("here", 0755), 0);
    assert_refused("here", "directory");
    assert_refused("here/", "directory");
    assert_refused("nowhere/out", "No such file");
    assert_refused("", "No such file");
    assert_int_equal(test_count_files(), 1);
}

TEST(a_check_leaves_everything_as_it_is)
{
    duet_error err = {0};
    write_in("file", "old");
    assert_int_equal(mkfifo("pipe", 0600), 0); // would wait for a reader
    assert_true(output_check("file", &err) && output_check("fresh", &err));
    assert_true(output_check("pipe", &err) && output_check("-", &err));
    must_fail(output_check("no/such/file", ERR), DUET_STATUS_IO_FAILED, "");
    assert_content("file", "old");
    assert_int_equal(test_count_files(), 2);
}

TEST(one_file_is_known_by_all_its_names)
{
    write_in("file", "old");
    assert_int_equal(mkdir("here", 0755), 0);
    assert_int_equal(symlink("file", "link"), 0);
    assert_int_equal(symlink("here/new", "to_new"), 0);
    assert_int_equal(link("file", "hard"), 0);
    static const char *const same[][2] = {
        {"file", "file"},       {"./file", "here/../file"}, {"file", "link"},
        {"link", "file"},       {"hard", "file"},           {"new", "./new"},
        {"new", "here/../new"}, {"here/new", "to_new"},
    };
    static const char *const other[][2] = {
        {"file", "new"},  {"new", "file"}, {"new", "here/new"},        {"new", "newer"},
        {"here", "here"}, {"file", "-"},   {"/dev/null", "/dev/null"}, {"no/new", "no/new"},
    };
    for (size_t i = 0; i < sizeof same / sizeof same[0]; ++i)
        assert_true(output_replaces(same[i][0], same[i][1]));
    for (size_t i = 0; i < sizeof other / sizeof other[0]; ++i)
        assert_false(output_replaces(other[i][0], other[i][1]));
    assert_content("file", "old");
}

TEST(a_check_refuses_what_only_reads)
{
    int ends[2];
    char name[32];
    duet_error err = {0};
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[0]);
    must_fail(output_check(name, ERR), DUET_STATUS_IO_FAILED, "");
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    assert_true(output_check(name, &err));
    assert_int_equal(symlink(name, "link"), 0);
    assert_true(output_check("link", &err));
    close(ends[0]);
    close(ends[1]);
    must_fail(output_check(name, ERR), DUET_STATUS_IO_FAILED, "");
    struct sockaddr_un at = {.sun_family = AF_UNIX, .sun_path = "socket"};
    int socket_file = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(socket_file, (struct sockaddr *)&at, sizeof at), 0);
    must_fail(output_check("socket", ERR), DUET_STATUS_IO_FAILED, "");
    close(socket_file);
    assert_int_equal(mkfifo("deaf", 0400), 0);
    assert_int_equal(output_check("deaf", &err), geteuid() == 0); // root may write all
    assert_int_equal(test_count_files(), 3);
}

TEST(a_pipe_is_written_to_and_stays)
{
    assert_int_equal(mkfifo("pipe", 0600), 0);
    pid_t child = fork();
    if (child == 0)
        _exit(text_write_file("pipe", "through", 7, NULL) ? 0 : 1);
    assert_content("pipe", "through");
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_true(S_ISFIFO(mode_of("pipe")));
    assert_int_equal(test_count_files(), 1);
}

// A node of the test's own where it may make one, since what is at stake is
// that the node is replaced.
static const char *full_device(void)
{
    return mknod("full", S_IFCHR | 0600, makedev(1, 7)) == 0 ? "full" : "/dev/full";
}

TEST(a_full_device_fails_and_stays)
{
    const char *full = full_device();
    skip_without_device(full);
    assert_refused(full, "No space left");
    assert_true(S_ISCHR(mode_of(full)));
    store_close(test_store_open("p.db", STORE_WRITE));
    program_assert_refused(program_run("profiles export %s --profile p.db", full), 1,
                           "cannot be written: No space left");
    assert_true(S_ISCHR(mode_of(full)));
}

// An open file of the process is written to where it stands.
TEST(stdout_is_written_to_whatever_it_is)
{
    skip_without_device("/dev/stdout");
    skip_without_device("/dev/fd/1");
    store_close(test_store_open("p.db", STORE_WRITE));
    static const char *const ways[] = {"", "| cat"};
    static const char *const names[] = {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"};
    for (int way = 0; way < 2; ++way)
        for (int i = 0; i < 3; ++i) {
            program p =
                program_done(program_run("--version %s; \"$DUET_PROGRAM\" profiles export %s "
                                         "--profile p.db %s",
                                         ways[way], names[i], ways[way]));
            assert_string_equal(p.err, "");
            assert_int_equal(strncmp(p.out, "duet ", 5), 0);
            assert_says(p.out, "\n{\"type\":\"store\"");
        }
}

// A file put at the place while the file is written is not taken for it.
TEST(what_comes_between_is_not_replaced)
{
    write_in("victim", "safe");
    output o;
    must(output_open(&o, "out", ERR));
    fputs("new", o.stream);
    assert_int_equal(symlink("victim", "out"), 0);
    must_fail(output_close(&o, true, ERR), DUET_STATUS_IO_FAILED, "");
    assert_true(S_ISLNK(mode_of("out")));
    assert_content("victim", "safe");
    assert_int_equal(test_count_files(), 2);
}

TEST(what_is_not_kept_leaves_nothing)
{
    output o;
    assert_true(output_open(&o, "out", NULL));
    fputs("half_extents", o.stream);
    assert_false(output_close(&o, false, NULL));
    assert_int_equal(test_count_files(), 0);
}

// Does as a program that ends in the middle of two outputs.
TEST(what_is_half_written_is_removed)
{
    static const char *const names[] = {"one", "two", "three"};
    output o[3];
    write_in("two", "old");
    for (int i = 0; i < 3; ++i) {
        must(output_open(&o[i], names[i], ERR));
        fputs("half", o[i].stream);
    }
    must(output_close(&o[2], true, ERR));
    assert_int_equal(system("test $(ls | wc -l) = 4"), 0);
    output_remove_parts();
    assert_int_equal(system("test \"$(echo *)\" = 'three two'"), 0);
    assert_content("two", "old");
    assert_content("three", "half");
    assert_false(output_close(&o[0], true, NULL));
    assert_false(output_close(&o[1], false, NULL));
    assert_int_equal(system("test \"$(echo *)\" = 'three two'"), 0);
}

// Another process has opened the file, and any of those that write into it may outlive it.
TEST(what_others_began_is_removed_until_it_is_forgotten)
{
    output o;
    text path = {0};
    assert_int_equal(mkdir("folder", 0777), 0);
    must(output_open(&o, "folder/out", ERR));
    must(output_part_path(&o, &path, ERR));
    assert_int_equal(access(path.chars, F_OK), 0);
    assert_int_equal(output_watch_part("no/such/folder/out"), -1);
    output_forget_part(-1);
    pid_t child = fork();
    if (child == 0) {
        int slot = output_watch_part(path.chars);
        output_forget_part(slot);
        slot = output_watch_part(path.chars);
        output_remove_parts();
        _exit(slot >= 0 ? 0 : 1);
    }
    int status = 0;
    assert_true(waitpid(child, &status, 0) == child && WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_int_equal(access(path.chars, F_OK), -1);
    assert_false(output_close(&o, true, NULL));
    text_free(&path);

    must(output_open(&o, "folder/out", ERR));
    must(output_part_path(&o, &path, ERR));
    output_forget_part(output_watch_part(path.chars));
    must(output_close(&o, true, ERR));
    text_free(&path);
    must(output_open(&o, "/dev/null", ERR));
    must_fail(output_part_path(&o, &path, ERR), DUET_STATUS_IO_FAILED,
              "/dev/null: cannot be written by several ranks");
    output_close(&o, false, NULL);
}

static void write_too_much(void)
{
    static char bytes[100000];
    struct rlimit limit = {50000, 50000};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
    duet_error err = {0};
    bool written = text_write_file("out", bytes, sizeof bytes, &err);
    _exit(!written && strstr(err.text, "out: cannot be written: File too large") ? 0 : 1);
}

TEST(what_does_not_fit_leaves_the_file_as_it_was)
{
    test_write_file("out", "old");
    pid_t child = fork();
    if (child == 0)
        write_too_much();
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_content("out", "old");
    assert_int_equal(test_count_files(), 1);
}

// The program itself, which such a limit would end by a signal.
TEST(the_program_says_that_a_file_became_too_large)
{
    test_store_tune("p.db");
    test_write_file("rows", "old");
    int names = test_count_files();
    program_assert_refused(program_run_with("ulimit -f 2;", "profiles export rows --profile p.db"),
                           1, "rows: cannot be written: File too large");
    assert_content("rows", "old");
    assert_int_equal(test_count_files(), names);
}

TEST_EACH(test_enter_folder, NULL)
