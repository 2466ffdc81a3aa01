// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE
#include "runtime/opencl/buffer.h"

#include "base/budget.h"
#include "base/error.h"

#include <stdlib.h>
#include <sys/mman.h>

enum { ALIGNMENT = 4096, SMALLEST = 4096, LARGE_PAGE = 1 << 21 };

static size_t rounded(size_t bytes, size_t to)
{
    return (bytes + to - 1) / to * to;
}

// Large pages where there are any: objects are read and placed at random, and
// small pages' translations would be missed as often as the cache.
static void *take_pages(size_t bytes)
{
    if (bytes < LARGE_PAGE)
        return aligned_alloc(ALIGNMENT, rounded(bytes, ALIGNMENT));
    size_t whole = rounded(bytes, LARGE_PAGE);
    void *memory = aligned_alloc(LARGE_PAGE, whole);
    if (memory)
        madvise(memory, whole, MADV_HUGEPAGE);
    return memory;
}

static void *allocate(size_t bytes, duet_error *err)
{
    void *memory = budget_space(bytes, err) ? take_pages(bytes) : NULL;
    if (memory)
        budget_hold(bytes);
    else
        no_memory(err, "%zu bytes", bytes);
    return memory;
}

static void give_back(void *memory, size_t bytes)
{
    if (memory)
        budget_release(bytes);
    free(memory);
}

static void CL_CALLBACK free_memory(cl_mem mem, void *memory)
{
    (void)mem;
    free(memory);
}

void mem_release(cl_mem *mem)
{
    if (!*mem)
        return;
    clReleaseMemObject(*mem);
    device_object_gone();
    *mem = NULL;
}

// Allocates device memory, or wraps the given host memory (CL_MEM_USE_HOST_PTR). If that is the
// buffer's, the driver frees it once the buffer is released and no command uses it any more.
static bool create(buffer *b, const device *d, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    cl_mem_flags flags = CL_MEM_READ_WRITE | (b->host ? CL_MEM_USE_HOST_PTR : 0);
    b->mem = clCreateBuffer(d->context, flags, b->bytes, b->host, &code);
    if (!b->mem)
        return error_set_cl(err, code, "%s: %s%zu bytes%s", d->info.selector,
                            b->host ? "wrapping " : "a buffer of ", b->bytes,
                            b->host ? " of host memory" : "");
    device_object_made();
    if (b->host && !b->borrowed)
        code = clSetMemObjectDestructorCallback(b->mem, free_memory, b->host);
    if (code == CL_SUCCESS)
        return true;
    mem_release(&b->mem);
    return error_set_cl(err, code, "%s: keeping host memory", d->info.selector);
}

bool buffer_reserve(buffer *b, const device *d, size_t bytes, duet_error *err)
{
    if (b->mem && !b->borrowed && b->bytes >= bytes)
        return true;
    buffer_release(b);
    if (bytes > d->info.max_buffer_bytes)
        return error_set(err, DUET_STATUS_NO_MEMORY,
                         "%s: %zu bytes wanted, a buffer holds at most %llu", d->info.selector,
                         bytes, (unsigned long long)d->info.max_buffer_bytes);
    b->bytes = rounded(bytes < SMALLEST ? SMALLEST : bytes, ALIGNMENT);
    if (d->info.host_memory)
        b->host = allocate(b->bytes, err);
    bool ok = (b->host || !d->info.host_memory) && create(b, d, err);
    if (!ok)
        buffer_release(b);
    return ok;
}

bool buffer_borrow(buffer *b, const device *d, void *host, size_t bytes, duet_error *err)
{
    if (b->mem && b->borrowed && b->host == host && b->bytes == bytes)
        return true;
    buffer_release(b);
    *b = (buffer){.host = host, .bytes = bytes, .borrowed = true};
    bool ok = create(b, d, err);
    if (!ok)
        *b = (buffer){0};
    return ok;
}

bool buffer_hold(buffer *b, const device *d, void *host, size_t bytes, duet_error *err)
{
    return d->info.host_memory ? buffer_borrow(b, d, host, bytes, err)
                               : buffer_reserve(b, d, bytes, err);
}

void buffer_release(buffer *b)
{
    if (b->host && !b->borrowed)
        budget_release(b->bytes);
    if (!b->mem && !b->borrowed)
        free(b->host);
    mem_release(&b->mem);
    *b = (buffer){0};
}

void buffer_swap(buffer *a, buffer *b)
{
    buffer other = *a;
    *a = *b;
    *b = other;
}

static bool lock_block(host_block *h, const device *d, size_t size)
{
    cl_int code = CL_SUCCESS;
    h->mem =
        clCreateBuffer(d->context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, size, NULL, &code);
    if (!h->mem)
        return false;
    device_object_made();
    h->owner = d;
    h->bytes = clEnqueueMapBuffer(d->queue, h->mem, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, size, 0,
                                  NULL, NULL, &code);
    if (!h->bytes)
        host_block_release(h);
    return h->bytes;
}

// Waits for commands that send from a block or read into it.
static void await_uses(const device devices[], int n_devices)
{
    for (int i = 0; i < n_devices; ++i) {
        clFinish(devices[i].queue);
        clFinish(devices[i].beside);
    }
}

bool host_block_reserve(host_block *h, const device devices[], int n_devices, size_t size,
                        duet_error *err)
{
    if (h->bytes && h->size >= size)
        return true;
    if (h->bytes)
        await_uses(devices, n_devices);
    host_block_release(h);
    size = rounded(size < SMALLEST ? SMALLEST : size, ALIGNMENT);
    for (int i = n_devices - 1; i >= 0 && !h->bytes; --i)
        if (!devices[i].info.host_memory)
            lock_block(h, &devices[i], size);
    if (!h->bytes)
        h->bytes = allocate(size, err);
    if (!h->bytes)
        return false;
    h->size = size;
    return true;
}

void host_block_release(host_block *h)
{
    if (h->mem && h->bytes) {
        clEnqueueUnmapMemObject(h->owner->queue, h->mem, h->bytes, 0, NULL, NULL);
        clFinish(h->owner->queue);
    }
    if (!h->mem)
        give_back(h->bytes, h->size);
    mem_release(&h->mem);
    *h = (host_block){0};
}
