// SPDX-License-Identifier: MIT
// Every test includes this: CMocka in the order it needs, the headers that most tests use, which
// they do not name again, seeds, small helps.
#ifndef TESTS_TEST_H
#define TESTS_TEST_H

#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/error.h"
#include "base/rng.h"
#include "runtime/duet.h"

// A test, named by the fact it shows: TEST(fact) { ... }. A program's tests run in the order in
// which they stand in its file.
#define TEST(fact)                                            \
    static void fact(void **state);                           \
    __attribute__((constructor)) static void add_##fact(void) \
    {                                                         \
        test_add(#fact, fact, __LINE__);                      \
    }                                                         \
    static void fact(__attribute__((unused)) void **state)

void test_add(const char *name, CMUnitTestFunction test, int line);

// Names what is called before all tests of the program. What it keeps lasts until all have ended.
#define TEST_BEGIN(begin)                                    \
    __attribute__((constructor)) static void set_begin(void) \
    {                                                        \
        test_begin = begin;                                  \
    }

// Names what is called before and after each of them; either may be NULL.
#define TEST_EACH(begin, end)                               \
    __attribute__((constructor)) static void set_each(void) \
    {                                                       \
        test_each_begin = begin;                            \
        test_each_end = end;                                \
    }

extern void (*test_begin)(void), (*test_each_begin)(void), (*test_each_end)(void);

// Runs the program's tests. Each starts in the program's folder, which any user may enter; it is
// removed at the end with all that is left in it. Returns how many failed; an OpenCL object that
// is left then is one more failure.
int test_run(int argc, char **argv);

extern const char *test_running; // its name; NULL before the first

// Makes an empty folder within the program's own; path is absolute.
void test_make_folder(char path[64]);

void test_enter_folder(void);     // one for each test, by TEST_EACH
void test_leaves_no_object(void); // after each, likewise: fails if an OpenCL object is left

// DUET_TEST_SEED where set, else a fixed one; printed, so that a failing run
// can be repeated.
uint64_t test_seed(void);

// A test whose kernels are compiled for each of many ways takes one in `of` of them, by the
// seed; every one with --all, as the label long has it.
bool test_takes(uint64_t way, unsigned of);
bool test_takes_all(void);
const char *test_argument(int place); // of the program, from 1; NULL: it has fewer

void test_write_file(const char *path, const char *content);
struct text
test_read_file(const char *path); // base/text.h; its characters last until the test ends
void test_assert_same_file(const char *path, const char *other);

// A scene's objects by their type.
static inline const duet_pose *test_poses(const duet_scene *scene)
{
    return duet_scene_get_objects(scene, DUET_OBJECT_POSES);
}

static inline const duet_bounds *test_bounds(const duet_scene *scene)
{
    return duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS);
}

// Both skip the test with a line: where a device file cannot be opened for reading and writing,
// as in a root that has few of them, and where no pseudo terminal can be opened.
void skip_without_device(const char *path);
void skip_without_terminal(void);

// Gives a thing to the test that runs: when it ends, however it ends, `back` is called with it,
// after those with what was given later. test_give_back does it now. Returns the thing.
void *test_keep(void *thing, void (*back)(void *thing));
void *test_keep_for_all(void *thing, void (*back)(void *thing)); // until all tests have ended
void test_give_back(void *thing);
void *test_alloc(size_t bytes); // zeros, which the test keeps

// A value that its block frees at the end, by TYPE_free: own(text) line = {0};
#define own(type) __attribute__((cleanup(type##_free))) type

// The kinds that public calls make and destroy, each with its test_KIND_back for test_keep.
// clang-format off
#define TEST_KINDS(OF)                                                                           \
    OF(duet_box_query) OF(duet_contact_query) OF(duet_device_pair) OF(duet_motion)               \
    OF(duet_pair_query) OF(duet_point_query) OF(duet_ray_query) OF(duet_replay) OF(duet_scene)   \
    OF(duet_sweep_query) OF(duet_task) OF(duet_task_file) OF(duet_tree) OF(duet_world)
// clang-format on
#define TEST_BACK(kind) void test_##kind##_back(void *made);
TEST_KINDS(TEST_BACK)
void test_gen_back(void *made); // these three by ..._close
void test_script_back(void *made);
void test_store_back(void *made);

// The pair of the tests' environment: opened when it is first asked for, until all have ended.
duet_device_pair *default_pair(void);

// How many names there are in the folder one is in.
int test_count_files(void);

// The value of a call that must succeed, in which ERR stands for the error that it fills:
//     duet_world *world = must(duet_world_create(&def, ERR));
#define must(call)                                                                  \
    __extension__({                                                                 \
        test_error = (duet_error){0};                                               \
        __typeof__(call) given_ = (call);                                           \
        if (!given_)                                                                \
            fail_msg("%s: %s %s", #call, duet_status_name(ERR->status), ERR->text); \
        given_;                                                                     \
    })
#define ERR (&test_error)

// Fails unless the text has each of the strings; says which one it lacks. The list ends with NULL.
#define assert_says(text, ...) assert_says_all(text, ((const char *const[]){__VA_ARGS__, NULL}))
#define assert_says_all(text, list) test_assert_says(text, list, __FILE__, __LINE__)

void test_assert_says(const char *chars, const char *const *list, const char *file, int line);

// A row of a table: what a call is given, and what the line says that refuses it.
typedef struct refusal {
    const char *given, *says;
} refusal;

// A call that must fail with this status, or ANY_FAILURE, and one line that has `says`, which ERR
// keeps.
#define ANY_FAILURE DUET_STATUS_OK
#define must_fail(call, status, says) \
    test_must_fail((test_error = (duet_error){0}, !(call)), #call, status, says, __FILE__, __LINE__)

void test_must_fail(bool failed, const char *call, duet_status status, const char *says,
                    const char *file, int line);

// The same, and the test keeps what was made: one of TEST_KINDS, or of the three.
// clang-format off
#define TEST_BACK_OF(kind) kind *: test_##kind##_back,
#define kept(call)                                                                             \
    test_keep(must(call),                                                                      \
              _Generic((call), TEST_KINDS(TEST_BACK_OF) struct gen *: test_gen_back,           \
                       struct script *: test_script_back, struct store *: test_store_back))
// clang-format on

extern _Thread_local duet_error test_error;

#endif
