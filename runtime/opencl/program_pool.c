// SPDX-License-Identifier: MIT
#include "runtime/opencl/program_pool.h"

#include "runtime/opencl/device.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

// Three times what a world and a motion with every effect have together: a search among variants
// comes back to those it tried. PoCL holds 1.3 MB a program.
enum { PLACES = 128 };

struct program_pool {
    pthread_mutex_t lock;
    unsigned next; // whose turn it is to be replaced
    struct {
        char sha256[65];
        cl_program program;
    } places[PLACES];
};

static cl_program retained(cl_program program)
{
    clRetainProgram(program);
    device_object_made();
    return program;
}

static void release(cl_program program)
{
    if (!program)
        return;
    clReleaseProgram(program);
    device_object_gone();
}

program_pool *program_pool_open(void)
{
    program_pool *s = calloc(1, sizeof *s);
    if (s)
        pthread_mutex_init(&s->lock, NULL);
    return s;
}

void program_pool_close(program_pool *s)
{
    for (int i = 0; s && i < PLACES; ++i)
        release(s->places[i].program);
    if (s)
        pthread_mutex_destroy(&s->lock);
    free(s);
}

cl_program program_pool_take(program_pool *s, const char sha256[65])
{
    cl_program found = NULL;
    if (!s)
        return NULL;
    pthread_mutex_lock(&s->lock);
    for (int i = 0; i < PLACES && !found; ++i)
        if (s->places[i].program && strcmp(s->places[i].sha256, sha256) == 0)
            found = retained(s->places[i].program);
    pthread_mutex_unlock(&s->lock);
    return found;
}

void program_pool_put(program_pool *s, const char sha256[65], cl_program program)
{
    if (!s)
        return;
    pthread_mutex_lock(&s->lock);
    unsigned i = s->next++ % PLACES;
    release(s->places[i].program);
    memcpy(s->places[i].sha256, sha256, sizeof s->places[i].sha256);
    s->places[i].program = retained(program);
    pthread_mutex_unlock(&s->lock);
}
