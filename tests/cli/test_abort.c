// SPDX-License-Identifier: MIT
// A process that ends in the middle, as a driver that aborts ends it: whichever
// of its calls is the last, what it leaves is whole or is not there.
//
// This program puts its own functions in front of the system's and the
// driver's, which count and abort at the k-th call; SQLite and OpenCL find them
// too.
#define _GNU_SOURCE
#include "support/test.h"

#include "base/text_file.h"
#include "profiles/exchange.h"
#include "profiles/sql.h"
#include "runtime/opencl/cache.h"
#include "support/store.h"

#include <CL/cl.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

// ------------------------------------------------------------------- the counting

static int calls_left; // 0: do not count
static int kernel_calls_left;

static void count(int *left)
{
    if (*left > 0 && --*left == 0)
        abort();
}

#define IN_FRONT __attribute__((visibility("default")))

IN_FRONT ssize_t write(int file, const void *bytes, size_t n)
{
    count(&calls_left);
    return syscall(SYS_write, file, bytes, n);
}

IN_FRONT ssize_t pwrite64(int file, const void *bytes, size_t n, off64_t at)
{
    count(&calls_left);
    return syscall(SYS_pwrite64, file, bytes, n, at);
}

IN_FRONT int ftruncate64(int file, off64_t n)
{
    count(&calls_left);
    return (int)syscall(SYS_ftruncate, file, n);
}

IN_FRONT int fsync(int file)
{
    count(&calls_left);
    return (int)syscall(SYS_fsync, file);
}

IN_FRONT int fdatasync(int file)
{
    count(&calls_left);
    return (int)syscall(SYS_fdatasync, file);
}

IN_FRONT int link(const char *from, const char *to)
{
    count(&calls_left);
    return (int)syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0);
}

IN_FRONT int unlink(const char *path)
{
    count(&calls_left);
    return (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0);
}

IN_FRONT int renameat(int from_folder, const char *from, int to_folder, const char *to)
{
    count(&calls_left);
    return (int)syscall(SYS_renameat2, from_folder, from, to_folder, to, 0);
}

IN_FRONT int close(int file)
{
    count(&calls_left);
    return (int)syscall(SYS_close, file);
}

// The driver's own function, behind the one here, into `call`.
static void find_behind(const char *name, void *call)
{
    void *f = dlsym(RTLD_NEXT, name);
    if (!f)
        abort();
    memcpy(call, &f, sizeof f);
}

typedef cl_int build_call(cl_program, cl_uint, const cl_device_id *, const char *,
                          void(CL_CALLBACK *)(cl_program, void *), void *);
typedef cl_int info_call(cl_program, cl_program_info, size_t, void *, size_t *);
typedef cl_int launch_call(cl_command_queue, cl_kernel, cl_uint, const size_t *, const size_t *,
                           const size_t *, cl_uint, const cl_event *, cl_event *);

IN_FRONT cl_int clBuildProgram(cl_program program, cl_uint n, const cl_device_id *devices,
                               const char *options, void(CL_CALLBACK *told_of)(cl_program, void *),
                               void *context)
{
    count(&kernel_calls_left);
    build_call *call = NULL;
    find_behind("clBuildProgram", &call);
    return call(program, n, devices, options, told_of, context);
}

IN_FRONT cl_int clGetProgramInfo(cl_program program, cl_program_info what, size_t n, void *to,
                                 size_t *size)
{
    count(&kernel_calls_left);
    info_call *call = NULL;
    find_behind("clGetProgramInfo", &call);
    return call(program, what, n, to, size);
}

IN_FRONT cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dims,
                                       const size_t *from, const size_t *items, const size_t *group,
                                       cl_uint n, const cl_event *after, cl_event *event)
{
    count(&kernel_calls_left);
    launch_call *call = NULL;
    find_behind("clEnqueueNDRangeKernel", &call);
    return call(queue, kernel, dims, from, items, group, n, after, event);
}

// --------------------------------------------------------------------- the children

enum { MOST_CALLS = 2000 };

static test_folder folder;
static char path[128]; // the file that the child writes
static int *told;      // by the child, in memory that both see

static void enter_folder(void)
{
    folder = test_folder_make();
    snprintf(path, sizeof path, "%s/out", folder.path);
}

static void make_folder(void)
{
    enter_folder();
    told = mmap(NULL, sizeof *told, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_true(told != MAP_FAILED);
}

static void remove_folder(void)
{
    munmap(told, sizeof *told);
}

// Whether the child was ended by its k-th call; false where it came to its end.
static bool ends_at(int k, int *left, bool (*work)(void))
{
    *told = 0;
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
        signal(SIGABRT, SIG_DFL);
        *left = k;
        bool done = work();
        *left = 0;
        _exit(done ? 0 : 1);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return false;
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
    return true;
}

// ------------------------------------------------------------------------- outputs

static char new_content[30000];

static bool write_output(void)
{
    return text_write_file(path, new_content, sizeof new_content, NULL);
}

TEST(an_output_is_the_old_one_or_the_new_one)
{
    memset(new_content, 'n', sizeof new_content);
    int k = 1;
    bool was_new = false;
    for (bool ended = true; ended; ++k) {
        enter_folder();
        test_write_file(path, "old");
        ended = ends_at(k, &calls_left, write_output);
        text found = test_read_file(path);
        bool is_new = found.length == sizeof new_content &&
                      memcmp(found.chars, new_content, found.length) == 0;
        assert_true(is_new || strcmp(found.chars, "old") == 0);
        assert_true(is_new || ended);
        was_new = was_new || (is_new && ended);
    }
    print_message("%d places to end at\n", k - 2);
    assert_true(k > 2 && was_new);
}

// The system ends a process that writes beyond its limit, in the middle of a write.
TEST(an_output_is_whole_wherever_a_limit_ends_its_writer)
{
    for (rlim_t limit = 0; limit < sizeof new_content + 2000; limit += 1500) {
        struct stat info;
        enter_folder();
        pid_t child = fork();
        if (child == 0) {
            setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
            setrlimit(RLIMIT_FSIZE, &(struct rlimit){limit, limit});
            write_output();
            _exit(0);
        }
        int status = 0;
        assert_int_equal(waitpid(child, &status, 0), child);
        bool there = stat(path, &info) == 0;
        assert_int_equal(there, WIFEXITED(status));
        assert_true(!there || info.st_size == sizeof new_content);
    }
}

// --------------------------------------------------------------------------- cache

static const char key[65] = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";

static bool put_entry(void)
{
    return cache_put(path, key, new_content, sizeof new_content);
}

TEST(a_cache_gives_the_kernel_or_nothing)
{
    int n_found = 0;
    for (int k = 1; ends_at(k, &calls_left, put_entry); ++k) {
        text found = {0};
        bool got = cache_get(path, key, &found);
        assert_true(!got || (found.length == sizeof new_content &&
                             memcmp(found.chars, new_content, found.length) == 0));
        n_found += got;
        text_free(&found);
        enter_folder();
    }
    assert_true(n_found > 0);
    text found = {0};
    assert_true(cache_get(path, key, &found));
    text_free(&found);
}

// --------------------------------------------------------------------------- stores

static bool commit_some(void)
{
    store *s = store_open(folder.store, STORE_WRITE, NULL);
    for (int i = 0; s && i < 3; ++i) {
        if (!store_begin(s, NULL) || !store_audit(s, "one", "of two", NULL) ||
            !store_end(s, store_audit(s, "two", "of two", NULL), NULL))
            return false;
        ++*told;
    }
    store_close(s);
    return s != NULL;
}

// Every row that the child was told is kept, and no half of a transaction.
static void assert_committed(int64_t least)
{
    store *s = test_store_open(folder.store, STORE_READ);
    int64_t n = test_count(s, "audit");
    assert_true(n == 2 * least || n == 2 * least + 2);
    assert_int_equal(test_count(s, "pragma_integrity_check WHERE integrity_check <> 'ok'"), 0);
    store_close(s);
    s = test_store_open(folder.store, STORE_WRITE);
    assert_int_equal(test_count(s, "audit"), n);
    store_close(s);
}

TEST(a_store_keeps_all_that_was_committed)
{
    int k = 1;
    for (bool ended = true; ended && k < MOST_CALLS; ++k) {
        enter_folder();
        ended = ends_at(k, &calls_left, commit_some);
        if (*told > 0 || access(folder.store, F_OK) == 0)
            assert_committed(*told);
        store_close(test_store_open(folder.store, STORE_WRITE)); // the next run goes on
    }
    print_message("%d places to end at\n", k - 2);
    assert_true(k > 20 && k < MOST_CALLS);
}

static char *rows;
static size_t row_bytes;

static bool import_rows(void)
{
    profile_import_counts counts;
    FILE *in = fmemopen(rows, row_bytes, "r");
    store *s = store_open(folder.store, STORE_WRITE, NULL);
    bool ok = s && profile_import(s, in, "rows", &counts, NULL);
    store_close(s);
    fclose(in);
    return ok;
}

static void make_rows(void)
{
    store *s = test_store_open(folder.store, STORE_WRITE);
    test_tune_usual(s);
    FILE *out = open_memstream(&rows, &row_bytes);
    assert_true(profile_export(s, out, "rows", NULL));
    fclose(out);
    store_close(s);
}

TEST(an_import_is_all_or_nothing)
{
    make_rows();
    int k = 1, n_all = 0;
    for (bool ended = true; ended && k < MOST_CALLS; k += 1 + k / 20) {
        enter_folder();
        ended = ends_at(k, &calls_left, import_rows);
        store *s = test_store_open(folder.store, STORE_WRITE);
        int64_t profiles = test_count(s, "profile");
        assert_int_equal(test_count(s, "trial"), 9 * profiles);
        assert_int_equal(test_count(s, "audit"), profiles);
        assert_true(profiles == 1 || ended);
        n_all += profiles == 1;
        store_close(s);
    }
    assert_true(k > 20 && k < MOST_CALLS && n_all > 0);
    free(rows);
}

// -------------------------------------------------------------------------- devices

enum { N_BOXES = 300 };

// A row of boxes, each of which touches the next: N_BOXES - 1 pairs.
static bool step_once(duet_device_pair *pair, uint64_t *n_pairs)
{
    static duet_pose boxes[N_BOXES];
    for (int i = 0; i < N_BOXES; ++i)
        boxes[i] = (duet_pose){{(float)i, 0, 0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    duet_world_def def = duet_default_world_def();
    duet_result result = {0};
    def.pair = pair;
    def.plan = duet_default_plan(pair);
    duet_world *world = duet_world_create(&def, NULL);
    bool ok = world && duet_world_set_objects(world, DUET_OBJECT_POSES, boxes, N_BOXES, NULL) &&
              duet_world_step(world, &result, NULL);
    *n_pairs = result.pairs;
    duet_world_destroy(world);
    return ok;
}

// A frame of an application: kernels from the cache or into it, a row into the
// store, a step, its result into a file and another row.
static bool run_a_frame(void)
{
    char count_of[32];
    uint64_t n = 0;
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = def.b = "pocl:0";
    def.cache_dir = path;
    duet_device_pair *pair = duet_device_pair_create(&def, NULL);
    store *s = pair ? store_open(folder.store, STORE_WRITE, NULL) : NULL;
    bool ok = s && store_audit(s, "begun", "", NULL);
    *told += ok;
    ok = ok && step_once(pair, &n);
    snprintf(count_of, sizeof count_of, "%llu", (unsigned long long)n);
    ok = ok && text_write_file("test_abort.pairs", count_of, strlen(count_of), NULL) &&
         store_audit(s, "done", "", NULL);
    *told += ok;
    store_close(s);
    duet_device_pair_destroy(pair);
    return ok && n == N_BOXES - 1;
}

TEST(a_driver_that_aborts_leaves_nothing_half_done)
{
    bool ended = true;
    int k = 1, n_ended = 0;
    for (; ended && k < 200; k += 1 + k / 3) {
        remove("test_abort.pairs");
        remove(folder.store);
        ended = ends_at(k, &kernel_calls_left, run_a_frame);
        n_ended += ended;
        store *s = test_store_open(folder.store, STORE_READ);
        assert_int_equal(test_count(s, "audit"), *told);
        store_close(s);
        own(text) found = {0};
        bool there = text_read_file(&found, "test_abort.pairs", NULL);
        assert_int_equal(there, *told == 2);
        assert_true(!there || strcmp(found.chars, "299") == 0);
    }
    print_message("ended at %d calls of the driver\n", n_ended);
    assert_true(!ended && n_ended > 3);
}

TEST_EACH(make_folder, remove_folder)
