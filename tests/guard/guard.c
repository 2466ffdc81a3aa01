// SPDX-License-Identifier: MIT
#include "guard/guard.h"

#include "support/test.h"

#include "runtime/opencl/buffer.h"

#include <pthread.h>

enum { GUARD_BYTES = 4096, PATTERN = 0xA5, MOST = 256 };

// A buffer's memory: guard words, its bytes, guard words. Content that nobody
// wrote is the pattern too.
typedef struct fence {
    unsigned char *memory;
    size_t bytes;
    cl_mem mem;
} fence;

static fence fences[MOST];
static uint32_t n_guarded;
static char broken[160];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

bool __wrap_buffer_reserve(buffer *b, const device *d, size_t bytes, duet_error *err);
bool __wrap_buffer_borrow(buffer *b, const device *d, void *host, size_t bytes, duet_error *err);
void __wrap_buffer_release(buffer *b);
bool __real_buffer_borrow(buffer *b, const device *d, void *host, size_t bytes, duet_error *err);
void __real_buffer_release(buffer *b);

// An empty one for mem NULL.
static fence *find(cl_mem mem)
{
    for (int i = 0; i < MOST; ++i)
        if (fences[i].mem == mem)
            return &fences[i];
    return NULL;
}

static void look(const fence *f, ptrdiff_t from, ptrdiff_t to)
{
    for (ptrdiff_t at = from; at < to && !broken[0]; ++at)
        if (f->memory[GUARD_BYTES + at] != PATTERN)
            snprintf(broken, sizeof broken, "byte %td of a buffer of %zu was written", at,
                     f->bytes);
}

static void check_and_free(fence *f)
{
    look(f, -GUARD_BYTES, 0);
    look(f, (ptrdiff_t)f->bytes, (ptrdiff_t)f->bytes + GUARD_BYTES);
    free(f->memory);
    *f = (fence){0};
    ++n_guarded;
}

static bool is_ours(const buffer *b)
{
    pthread_mutex_lock(&lock);
    bool ours = b->mem && find(b->mem);
    pthread_mutex_unlock(&lock);
    return ours;
}

void __wrap_buffer_release(buffer *b)
{
    cl_mem mem = b->mem;
    bool ours = is_ours(b);
    __real_buffer_release(b);
    if (!ours)
        return;
    pthread_mutex_lock(&lock);
    check_and_free(find(mem));
    pthread_mutex_unlock(&lock);
}

static size_t rounded(size_t bytes, size_t to)
{
    return (bytes + to - 1) / to * to;
}

bool __wrap_buffer_reserve(buffer *b, const device *d, size_t bytes, duet_error *err)
{
    if (is_ours(b) && b->bytes >= bytes)
        return true;
    __wrap_buffer_release(b);
    bytes = rounded(bytes ? bytes : 1, sizeof(uint32_t));
    size_t whole = rounded(bytes, GUARD_BYTES) + 2 * (size_t)GUARD_BYTES;
    fence f = {.memory = aligned_alloc(GUARD_BYTES, whole), .bytes = bytes};
    if (!f.memory)
        return no_memory(err, "a guarded buffer");
    memset(f.memory, PATTERN, whole);
    if (!__real_buffer_borrow(b, d, f.memory + GUARD_BYTES, bytes, err)) {
        free(f.memory);
        return false;
    }
    if (!d->info.host_memory)
        b->host = NULL;
    f.mem = b->mem;
    pthread_mutex_lock(&lock);
    *find(NULL) = f;
    pthread_mutex_unlock(&lock);
    return true;
}

bool __wrap_buffer_borrow(buffer *b, const device *d, void *host, size_t bytes, duet_error *err)
{
    if (is_ours(b))
        __wrap_buffer_release(b);
    return __real_buffer_borrow(b, d, host, bytes, err);
}

void guard_assert_whole(const char *what)
{
    if (broken[0])
        fail_msg("%s: %s", what, broken);
    assert_true(n_guarded > 0);
    n_guarded = 0;
}
