// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/kernel_args.h"
#include "support/test.h"

#include "base/text_file.h"
#include "runtime/opencl/buffer.h"
#include "runtime/opencl/cache.h"
#include "runtime/opencl/program.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char dir[64];
static const char key[65] = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";
static const char binary[] = "\x7f"
                             "ELF\0 not really, but long enough to be cut\n";

static void make_dir(void)
{
    test_make_folder(dir);
}

static void remove_dir(void)
{
    char command[160];
    snprintf(command, sizeof command, "chmod -R u+w %s; rm -rf %s", dir, dir);
    assert_int_equal(system(command), 0);
}

static void entry_path(char path[160])
{
    snprintf(path, 160, "%s/%s.bin", dir, key);
}

static void assert_kept(bool kept)
{
    own(text) found = {0};
    assert_int_equal(cache_get(dir, key, &found), kept);
    if (kept)
        assert_int_equal(found.length, sizeof binary);
    if (kept)
        assert_memory_equal(found.chars, binary, sizeof binary);
    else
        assert_null(found.chars);
}

TEST(what_was_kept_comes_back)
{
    assert_kept(false);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_kept(true);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_kept(true);
    char other[65];
    memcpy(other, key, sizeof other);
    other[0] = 'f';
    text found = {0};
    assert_false(cache_get(dir, other, &found));
}

// Every entry that is cut anywhere, or has any one byte changed.
TEST(a_damaged_entry_is_as_if_it_were_not_there)
{
    char path[160];
    own(text) whole = {0};
    entry_path(path);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    must(text_read_file(&whole, path, ERR));
    for (size_t i = 0; i < whole.length; ++i) {
        must(text_write_file(path, whole.chars, i, ERR));
        assert_kept(false);
        whole.chars[i] ^= 0x20;
        must(text_write_file(path, whole.chars, whole.length, ERR));
        assert_kept(false);
        whole.chars[i] ^= 0x20;
    }
    text_add(&whole, "more");
    must(text_write_file(path, whole.chars, whole.length, ERR));
    assert_kept(false);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_kept(true);
}

TEST(an_entry_under_anothers_name_is_not_taken)
{
    char path[160], other[160];
    entry_path(path);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    memcpy(other, path, sizeof other);
    other[strlen(dir) + 1] = 'f';
    assert_int_equal(rename(path, other), 0);
    char other_key[65];
    memcpy(other_key, key, sizeof other_key);
    other_key[0] = 'f';
    text found = {0};
    assert_false(cache_get(dir, other_key, &found));
}

TEST(what_is_no_file_is_passed_over)
{
    char path[160];
    entry_path(path);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_kept(false); // and does not wait for a writer
    assert_int_equal(remove(path), 0);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_kept(false);
    assert_false(cache_put(dir, key, binary, sizeof binary));
    assert_int_equal(rmdir(path), 0);
    assert_int_equal(symlink("/dev/zero", path), 0);
    assert_kept(false);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_kept(true);
}

TEST(a_missing_folder_is_made_and_an_impossible_one_passed_over)
{
    char below[100];
    snprintf(below, sizeof below, "%s/new", dir);
    assert_true(cache_put(below, key, binary, sizeof binary));
    text found = {0};
    assert_true(cache_get(below, key, &found));
    text_free(&found);
    assert_false(cache_put("/dev/null/x", key, binary, sizeof binary));
    assert_false(cache_get("/dev/null/x", key, &found));
    assert_false(cache_put("no/such/folder", key, binary, sizeof binary));
}

// ------------------------------------------------------- with another user

enum { OTHER_USER = 65534 };

// Whether the test may act as another user; a line where it may not.
static bool may_change_user(void)
{
    if (geteuid() != 0)
        print_message("this test needs two users, so root: skipped\n");
    return geteuid() == 0;
}

static void as_other(bool other)
{
    assert_int_equal(seteuid(other ? OTHER_USER : 0), 0);
}

static void assert_folder_refused(const char *says)
{
    must_fail(cache_check(dir, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    if (!strstr(ERR->text, says) || !strstr(ERR->text, dir))
        fail_msg("'%s' for '%s' in %s", ERR->text, says, dir);
    assert_kept(false);
    assert_false(cache_put(dir, key, binary, sizeof binary));
}

TEST(a_folder_of_another_user_is_refused)
{
    if (!may_change_user())
        skip();
    assert_true(cache_check(dir, NULL));
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_int_equal(chmod(dir, 0755), 0);
    as_other(true);
    assert_folder_refused("belongs to another user"); // root's too, for a user
    as_other(false);
    assert_int_equal(chown(dir, OTHER_USER, (gid_t)-1), 0);
    assert_folder_refused("belongs to another user"); // and a user's, for root
}

TEST(a_folder_that_others_can_write_is_refused)
{
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_int_equal(chmod(dir, 0770), 0);
    assert_folder_refused("can be written by other users");
    assert_int_equal(chmod(dir, 0707), 0);
    assert_folder_refused("can be written by other users");
    assert_int_equal(chmod(dir, 0755), 0);
    assert_kept(true);
}

TEST(a_link_to_a_folder_is_refused)
{
    char own[64];
    assert_true(cache_put(dir, key, binary, sizeof binary));
    memcpy(own, dir, sizeof own);
    snprintf(dir, sizeof dir, "%.40s.link", own);
    assert_int_equal(symlink(own, dir), 0);
    assert_folder_refused("is a link");
    assert_int_equal(remove(dir), 0);
    memcpy(dir, own, sizeof dir);
}

TEST(a_pair_of_devices_does_not_open_on_such_a_folder)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.cache_dir = dir;
    assert_int_equal(chmod(dir, 0777), 0);
    must_fail(duet_device_pair_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, dir);
}

TEST(an_entry_of_another_user_is_not_taken)
{
    char path[160];
    entry_path(path);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_int_equal(chmod(path, 0666), 0);
    assert_kept(false);
    assert_int_equal(chmod(path, 0644), 0);
    assert_kept(true);
    if (!may_change_user())
        skip();
    assert_int_equal(chown(path, OTHER_USER, (gid_t)-1), 0);
    assert_kept(false);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_kept(true);
}

// The name is now an own file, now a link to a file that only looks like one.
static void flip(const char *path, const char *evil, const char *good)
{
    char next[192];
    snprintf(next, sizeof next, "%s.next", path);
    for (;;) {
        if (symlink(evil, next) != 0 || rename(next, path) != 0)
            _exit(1);
        if (link(good, next) != 0 || rename(next, path) != 0)
            _exit(1);
    }
}

// Another user's entry with a right line: what reading through a link gives.
static void make_evil(const char *path, const char *bytes)
{
    char own[64];
    memcpy(own, dir, sizeof own);
    snprintf(dir, sizeof dir, "%.40s/evil", own);
    assert_true(cache_put(dir, key, bytes, sizeof binary));
    char made[160];
    entry_path(made);
    assert_int_equal(rename(made, path), 0);
    assert_int_equal(rmdir(dir), 0);
    memcpy(dir, own, sizeof dir);
}

TEST(a_link_that_flips_while_it_is_read_gives_nobody_elses_code)
{
    char path[160], evil[160], good[160], evil_bytes[sizeof binary];
    entry_path(path);
    snprintf(evil, sizeof evil, "%s/evil.file", dir);
    snprintf(good, sizeof good, "%s/good.file", dir);
    memset(evil_bytes, 'E', sizeof evil_bytes);
    make_evil(evil, evil_bytes);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_int_equal(link(path, good), 0);
    pid_t child = fork();
    if (child == 0)
        flip(path, "evil.file", good);
    int n_found = 0, n_wrong = 0;
    for (int i = 0; i < 50000; ++i) {
        text found = {0};
        bool got = cache_get(dir, key, &found);
        n_found += got;
        n_wrong += got && memcmp(found.chars, binary, sizeof binary) != 0;
        text_free(&found);
    }
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    print_message("%d of 50000 reads found the entry\n", n_found);
    assert_int_equal(n_wrong, 0);
    assert_true(n_found > 0);
}

// The files of a killed process go with the next entry, once it is old.
TEST(what_was_left_half_written_is_cleared_away)
{
    char old[160], young[160];
    snprintf(old, sizeof old, "%s/%s.bin.0123456789abcdef.part", dir, key);
    snprintf(young, sizeof young, "%s/%s.bin.fedcba9876543210.part", dir, key);
    test_write_file(old, "half_extents");
    test_write_file(young, "half_extents");
    const struct timespec times[2] = {{.tv_sec = 1000000000}, {.tv_sec = 1000000000}};
    assert_int_equal(utimensat(AT_FDCWD, old, times, 0), 0);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_int_not_equal(access(old, F_OK), 0);
    assert_int_equal(access(young, F_OK), 0);
    assert_kept(true);
}

TEST(each_part_of_the_key_counts)
{
    duet_device_info a = {.name = "x", .vendor = "v", .driver = "1", .platform = "p"};
    char keys[8][65];
    duet_device_info b = a;
    cache_key("text", "-O", &a, keys[0]);
    cache_key("text2", "-O", &a, keys[1]);
    cache_key("text", "-O2", &a, keys[2]);
    cache_key("tex", "t-O", &a, keys[3]);
    strcpy(b.driver, "2");
    cache_key("text", "-O", &b, keys[4]);
    b = a;
    strcpy(b.name, "y");
    cache_key("text", "-O", &b, keys[5]);
    b = a;
    strcpy(b.vendor, "w");
    cache_key("text", "-O", &b, keys[6]);
    b = a;
    strcpy(b.platform_version, "3.1");
    cache_key("text", "-O", &b, keys[7]);
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < i; ++k)
            assert_string_not_equal(keys[i], keys[k]);
    char again[65];
    b = a;
    strcpy(b.selector, "pocl:1"); // a selector depends on what else is installed
    cache_key("text", "-O", &b, again);
    assert_string_equal(again, keys[0]);
}

// Writers replace the entry while readers read; a reader finds it whole or not
// at all.
static void *write_and_read(void *unused)
{
    (void)unused;
    for (int i = 0; i < 200; ++i) {
        own(text) found = {0};
        cache_put(dir, key, binary, sizeof binary);
        bool whole = !cache_get(dir, key, &found) || found.length == sizeof binary;
        if (!whole)
            return "an entry came back in part";
    }
    return NULL;
}

TEST(threads_and_processes_may_share_a_folder)
{
    pid_t child = fork();
    if (child == 0)
        _exit(write_and_read(NULL) ? 1 : 0);
    pthread_t threads[2];
    for (int i = 0; i < 2; ++i)
        assert_int_equal(pthread_create(&threads[i], NULL, write_and_read, NULL), 0);
    for (int i = 0; i < 2; ++i) {
        void *said = NULL;
        pthread_join(threads[i], &said);
        assert_null(said);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_kept(true);
}

// The least recently used go until a quarter is free; sparse files count by their length.
TEST(a_cache_that_outgrew_its_limit_loses_what_was_not_used)
{
    enum { FILES = 5 };
    char path[FILES][200];
    assert_true(cache_put(dir, key, binary, sizeof binary)); // makes the folder
    for (int i = 0; i < FILES; ++i) {
        snprintf(path[i], sizeof path[i], "%.40s/%064d.bin", dir, i);
        int file = open(path[i], O_CREAT | O_WRONLY, 0600);
        assert_int_equal(ftruncate(file, CACHE_MOST_BYTES / 4), 0);
        const struct timespec used[2] = {{.tv_sec = 1000 * (i + 1)}, {.tv_sec = 1000 * (i + 1)}};
        assert_int_equal(futimens(file, used), 0);
        close(file);
    }
    assert_kept(true); // is used now
    assert_true(cache_put(dir, key, binary, sizeof binary));
    assert_kept(true);
    for (int i = 0; i < FILES; ++i)
        assert_int_equal(access(path[i], F_OK), i < 3 ? -1 : 0);
}

TEST(a_folder_that_cannot_be_written_is_said)
{
    char missing[96];
    snprintf(missing, sizeof missing, "%.40s/a/b", dir);
    assert_true(cache_put(dir, key, binary, sizeof binary));
    must(cache_check_writable(missing, ERR)); // made, with the one above
    assert_int_equal(access(missing, W_OK), 0);
    must_fail(cache_check_writable("/proc/duet", ERR), DUET_STATUS_BAD_ARGUMENT,
              "built kernels cannot be kept in /proc/duet: ");
    assert_int_equal(rmdir(missing), 0);
    *strrchr(missing, '/') = '\0';
    assert_int_equal(rmdir(missing), 0);
}

// ------------------------------------------------------- with a device

static uint32_t compiled;

static void count_compiled(void *context, const duet_device_info *d, const char *name, uint32_t k,
                           uint32_t n)
{
    (void)context;
    assert_true(k >= 1 && k <= n && *d->selector);
    compiled += name != NULL;
}

static void build_on(const device *d)
{
    gen *g = kept(gen_open(NULL, ERR));
    const program_builder builder = {.cache_dir = dir, .on_compile = count_compiled};
    program_set *set = must(program_set_open(d, g, &builder, ERR));
    must(program_set_kernel(set, "cell_start", "cell_start", NULL, 0, cell_start_bindings, ERR));
    must(program_set_build(set, ERR));
    program_set_close(set);
}

// Builds a small kernel through the cache, as a program that begins does.
static void build_one(void)
{
    device d;
    must(device_open(&d, "pocl:0", ERR));
    build_on(&d);
    device_close(&d);
}

// The one entry of the folder.
static void only_entry(text *entry, char path[160])
{
    char command[100];
    snprintf(command, sizeof command, "ls %s/*.bin", dir);
    FILE *list = popen(command, "r");
    assert_non_null(list);
    assert_non_null(fgets(path, 160, list));
    pclose(list);
    path[strcspn(path, "\n")] = '\0';
    must(text_read_file(entry, path, ERR));
}

TEST(a_program_is_built_from_its_entry_or_else_again)
{
    char path[160];
    own(text) entry = {0}, again = {0};
    compiled = 0;
    build_one();
    assert_int_equal(compiled, 1);
    only_entry(&entry, path);
    struct stat before, after;
    assert_int_equal(stat(path, &before), 0);
    build_one();
    assert_int_equal(compiled, 1);
    assert_int_equal(stat(path, &after), 0);
    assert_int_equal(before.st_ino, after.st_ino); // not built and kept once more

    // An entry with the right line over bytes that the driver refuses.
    size_t begin = strcspn(entry.chars, "\n") + 1;
    char found_key[65];
    memcpy(found_key, strrchr(path, '/') + 1, 64);
    found_key[64] = '\0';
    memset(entry.chars + begin, 7, entry.length - begin);
    assert_true(cache_put(dir, found_key, entry.chars + begin, entry.length - begin));
    build_one();
    only_entry(&again, path);
    assert_int_not_equal(again.chars[begin], 7);

    assert_int_equal(chmod(path, 0), 0);
    assert_int_equal(chmod(dir, 0500), 0);
    build_one();
    assert_int_equal(device_live_objects(), 0);
}

// On an open device a program is not even looked for in the folder again, nor
// does it go with the world that had it built.
TEST(a_device_keeps_what_was_built_last)
{
    device d;
    char path[160];
    own(text) entry = {0};
    must(device_open(&d, "pocl:0", ERR));
    build_on(&d);
    only_entry(&entry, path);
    remove(path);
    build_on(&d);
    assert_int_not_equal(access(path, F_OK), 0);
    device_close(&d);
    assert_int_equal(device_live_objects(), 0);
}

TEST_EACH(make_dir, remove_dir)
