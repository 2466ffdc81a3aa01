// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "base/text_file.h"
#include "gen/gen.h"
#include "gen/script.h"
#include "profiles/store.h"
#include "runtime/opencl/device.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <pty.h>
#include <sys/stat.h>
#include <unistd.h>

const char *test_running;

_Thread_local duet_error test_error;

enum { MOST_TESTS = 64 };

static struct CMUnitTest tests[MOST_TESTS]; // CMocka passes over those without a name
static int lines[MOST_TESTS];               // ascending
static int n_tests;
void (*test_begin)(void), (*test_each_begin)(void), (*test_each_end)(void);

void test_add(const char *name, CMUnitTestFunction test, int line)
{
    int at = n_tests++;
    if (n_tests > MOST_TESTS)
        abort();
    for (; at > 0 && lines[at - 1] > line; --at) {
        tests[at] = tests[at - 1];
        lines[at] = lines[at - 1];
    }
    tests[at] = (struct CMUnitTest){.name = name, .test_func = test};
    lines[at] = line;
}

static char own_folder[] = "/tmp/duet_test.XXXXXX";

void test_make_folder(char path[64])
{
    snprintf(path, 64, "%s/XXXXXX", own_folder);
    assert_non_null(mkdtemp(path));
}

void test_enter_folder(void)
{
    char path[64];
    test_make_folder(path);
    assert_int_equal(chdir(path), 0);
}

void test_leaves_no_object(void)
{
    assert_int_equal(device_live_objects(), 0);
}

// Things that were given to the running test, or to all, the latest first.
typedef struct kept {
    void *thing;
    void (*back)(void *thing);
    struct kept *next;
} kept;

static kept *by_all, *by_test;
static kept **keeping = &by_all; // until the first test begins

static void *keep(kept **by, void *thing, void (*back)(void *thing))
{
    kept *k = malloc(sizeof *k);
    assert_non_null(k);
    *k = (kept){thing, back, *by};
    *by = k;
    return thing;
}

void *test_keep(void *thing, void (*back)(void *thing))
{
    return keep(keeping, thing, back);
}

void *test_keep_for_all(void *thing, void (*back)(void *thing))
{
    return keep(&by_all, thing, back);
}

static void give_back_first(kept **at)
{
    kept *k = *at;
    *at = k->next;
    k->back(k->thing);
    free(k);
}

void test_give_back(void *thing)
{
    kept **at = keeping;
    while (*at && (*at)->thing != thing)
        at = &(*at)->next;
    assert_non_null(*at);
    give_back_first(at);
}

#define BACK(kind)                      \
    void test_##kind##_back(void *made) \
    {                                   \
        kind##_destroy(made);           \
    }
TEST_KINDS(BACK)

void test_gen_back(void *made)
{
    gen_close(made);
}

void test_script_back(void *made)
{
    script_close(made);
}

void test_store_back(void *made)
{
    store_close(made);
}

duet_device_pair *default_pair(void)
{
    static duet_device_pair *pair;
    if (!pair)
        pair =
            test_keep_for_all(must(duet_device_pair_open(NULL, ERR)), test_duet_device_pair_back);
    return pair;
}

void *test_alloc(size_t bytes)
{
    void *zeros = calloc(1, bytes);
    assert_non_null(zeros);
    return test_keep(zeros, free);
}

void test_must_fail(bool failed, const char *call, duet_status status, const char *says,
                    const char *file, int line)
{
    const duet_error *err = ERR;
    bool right = err->status == status || (status == ANY_FAILURE && err->status != DUET_STATUS_OK);
    if (failed && right && strstr(err->text, says) && !strchr(err->text, '\n'))
        return;
    print_error("%s: %s: %s '%s', not %s '%s'\n", call, failed ? "failed" : "did not fail",
                duet_status_name(err->status), err->text, duet_status_name(status), says);
    _fail(file, line);
}

void test_assert_says(const char *chars, const char *const *list, const char *file, int line)
{
    for (; *list; ++list)
        if (!chars || !strstr(chars, *list)) {
            print_error("no '%s' in:\n%s\n", *list, chars ? chars : "(nothing)");
            _fail(file, line);
        }
}

static int begin_all(void **state)
{
    (void)state;
    if (test_begin)
        test_begin();
    keeping = &by_test;
    return 0;
}

static int begin_test(void **state)
{
    static int n_begun;
    (void)state;
    test_running = tests[n_begun++].name;
    assert_int_equal(chdir(own_folder), 0);
    if (test_each_begin)
        test_each_begin();
    return 0;
}

static int end_test(void **state)
{
    (void)state;
    while (by_test)
        give_back_first(&by_test);
    if (test_each_end)
        test_each_end();
    return 0;
}

static int remove_one(const char *path, const struct stat *info, int type, struct FTW *at)
{
    (void)info, (void)type, (void)at;
    return remove(path);
}

static int n_arguments;
static char **arguments;

const char *test_argument(int place)
{
    return place < n_arguments ? arguments[place] : NULL;
}

bool test_takes_all(void)
{
    const char *first = test_argument(1);
    return first && strcmp(first, "--all") == 0;
}

int test_run(int argc, char **argv)
{
    n_arguments = argc;
    arguments = argv;
    for (int i = 0; i < n_tests; ++i) {
        tests[i].setup_func = begin_test;
        tests[i].teardown_func = end_test;
    }
    setvbuf(stdout, NULL, _IOLBF, 0); // a crash leaves nothing unsaid
    if (!mkdtemp(own_folder) || chmod(own_folder, 0755) != 0 || chdir(own_folder) != 0)
        abort();
    int n_failed = cmocka_run_group_tests(tests, begin_all, NULL);
    while (by_all)
        give_back_first(&by_all);
    const int left = device_live_objects();
    if (left > 0)
        print_error("%d OpenCL objects are left\n", left);
    nftw(own_folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
    return n_failed + (left > 0);
}

static uint64_t seed_of_run(void)
{
    const char *given = getenv("DUET_TEST_SEED");
    return given ? strtoull(given, NULL, 0) : 20261121;
}

uint64_t test_seed(void)
{
    uint64_t seed = seed_of_run();
    print_message("DUET_TEST_SEED=%" PRIu64 "\n", seed);
    return seed;
}

bool test_takes(uint64_t way, unsigned of)
{
    return test_takes_all() || (way + seed_of_run()) % of == 0;
}

void test_write_file(const char *path, const char *content)
{
    must(text_write_file(path, content, strlen(content), ERR));
}

text test_read_file(const char *path)
{
    text content = {0};
    must(text_read_file(&content, path, ERR));
    test_keep(content.chars, free);
    return content;
}

void test_assert_same_file(const char *path, const char *other)
{
    const text a = test_read_file(path), b = test_read_file(other);
    assert_int_equal(a.length, b.length);
    assert_memory_equal(a.chars, b.chars, a.length);
}

void skip_without_device(const char *path)
{
    int file = open(path, O_RDWR | O_CLOEXEC);
    if (file >= 0) {
        close(file);
        return;
    }
    print_message("%s cannot be opened here: %s; skipped\n", path, strerror(errno));
    skip();
}

void skip_without_terminal(void)
{
    int ends[2];
    if (openpty(&ends[0], &ends[1], NULL, NULL, NULL) == 0) {
        close(ends[0]);
        close(ends[1]);
        return;
    }
    print_message("no pseudo terminal can be opened here: %s; skipped\n", strerror(errno));
    skip();
}

int test_count_files(void)
{
    int n = 0;
    DIR *names = opendir(".");
    assert_non_null(names);
    for (const struct dirent *e = readdir(names); e; e = readdir(names))
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(names);
    return n;
}
