// SPDX-License-Identifier: MIT
// Memory of one device.
//
// A device that works on host memory gets host memory, wrapped; then host is
// set and nothing is ever copied. Others get memory of their own.
#ifndef RUNTIME_BUFFER_H
#define RUNTIME_BUFFER_H

#include "runtime/opencl/device.h"

typedef struct buffer {
    cl_mem mem; // NULL while empty
    void *host; // set if the device works on host memory, else NULL
    size_t bytes;
    bool borrowed; // host belongs to someone else
} buffer;

// Holds at least that many bytes afterwards. Growing loses the content.
bool buffer_reserve(buffer *b, const device *d, size_t bytes, duet_error *err);

// Wraps memory of someone else, which must outlive the buffer's use. Only on a
// device that works on host memory.
bool buffer_borrow(buffer *b, const device *d, void *host, size_t bytes, duet_error *err);

// Either, by what the device works on: host memory itself, or space for its bytes.
bool buffer_hold(buffer *b, const device *d, void *host, size_t bytes, duet_error *err);

// Memory of its own is given back once no command uses it.
void buffer_release(buffer *b);

// Releases a buffer that was made or held, and sets it to NULL; NULL does nothing.
void mem_release(cl_mem *mem);

// Each has the other's memory afterwards; nothing is moved.
void buffer_swap(buffer *a, buffer *b);

// Host memory that devices read and write fast: page-locked by the last of them
// that copies, else plain and aligned.
typedef struct host_block {
    void *bytes;
    size_t size;
    const device *owner; // device whose driver locked it; NULL: plain memory
    cl_mem mem;
} host_block;

// A block that grows waits for the devices' commands, and loses the content.
bool host_block_reserve(host_block *h, const device devices[], int n_devices, size_t size,
                        duet_error *err);
// Commands that use it are over.
void host_block_release(host_block *h);

#endif
