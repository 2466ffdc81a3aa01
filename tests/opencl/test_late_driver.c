// SPDX-License-Identifier: MIT
// A driver's thread that lets go of a command long after the command was over, as it does where a
// busy machine runs it late: PoCL's uses queue and device once more behind the end it tells of.
#define _GNU_SOURCE
#include "support/devices.h"
#include "support/test.h"

#include "runtime/opencl/timeline.h"

#include <dlfcn.h>
#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { LATE_US = 700000, MOMENT_US = 20000 };

static atomic_bool is_late;
static atomic_int n_late; // threads of the driver that wait

// The driver tells of an end by it.
__attribute__((visibility("default"))) int pthread_cond_broadcast(pthread_cond_t *condition)
{
    int (*real)(pthread_cond_t *);
    *(void **)&real = dlsym(RTLD_NEXT, "pthread_cond_broadcast");
    int code = real(condition);
    if (gettid() == getpid() || !atomic_load(&is_late))
        return code;
    atomic_fetch_add(&n_late, 1);
    usleep(LATE_US);
    atomic_fetch_sub(&n_late, 1);
    return code;
}

static void open_part(device *d)
{
    char selector[96];
    snprintf(selector, sizeof selector, "%s[0-0]", cuttable_cpu()->selector);
    must(device_open(d, selector, ERR));
}

static void fill(device *d, buffer *b)
{
    timeline times = {0};
    timeline_begin(&times, d, false); // an event of ours would be waited for
    must(timeline_fill(&times, "fill", b, 7, 0, 100, ERR));
    must(timeline_finish(&times, ERR));
    timeline_clear(&times);
}

static void close_early(bool copies)
{
    device d;
    buffer b = {0};
    open_part(&d);
    must(buffer_reserve(&b, &d, 4096, ERR));
    fill(&d, &b);
    mallopt(M_PERTURB, 0x5a); // freed memory is no longer what it was
    atomic_store(&is_late, true);
    fill(&d, &b);
    buffer_release(&b);
    d.info.host_memory &= !copies;
    device_close(&d);
    atomic_store(&is_late, false);
    do
        usleep(MOMENT_US);
    while (atomic_load(&n_late) > 0);
    usleep(MOMENT_US);
    assert_int_equal(device_live_objects(), 0);
}

TEST(a_device_closes_before_its_driver_lets_go_of_a_command)
{
    close_early(false);
}

// How a device gets its memory says nothing of the driver's threads.
TEST(so_does_one_that_is_sent_copies)
{
    close_early(true);
}
