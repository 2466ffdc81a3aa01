// SPDX-License-Identifier: MIT
// The programs that a device has, whatever set built them.
#include "runtime/opencl/program_build.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static void release_program(cl_program *built)
{
    if (!*built)
        return;
    clReleaseProgram(*built);
    device_object_gone();
    *built = NULL;
}

static void release_kernel(cl_kernel k)
{
    if (!k)
        return;
    clReleaseKernel(k);
    device_object_gone();
}

void program_close(program *p)
{
    for (int i = 0; i < p->n_entries; ++i)
        release_kernel(p->entries[i].k.cl);
    release_program(&p->cl);
    free(p->text);
    free(p->binary);
    free(p);
}

// Three times what a world and a motion with every effect have together: a search among variants
// comes back to those it tried. PoCL holds 1.3 MB a program.
enum { PLACES = 128 };

struct program_pool {
    pthread_mutex_t lock;
    unsigned next; // the place that is replaced next
    struct {
        char sha256[65];
        cl_program cl;
    } places[PLACES];
};

program_pool *program_pool_open(void)
{
    program_pool *pool = calloc(1, sizeof *pool);
    if (pool)
        pthread_mutex_init(&pool->lock, NULL);
    return pool;
}

void program_pool_close(program_pool *pool)
{
    if (!pool)
        return;
    for (int i = 0; i < PLACES; ++i)
        release_program(&pool->places[i].cl);
    pthread_mutex_destroy(&pool->lock);
    free(pool);
}

static cl_program retained(cl_program built)
{
    clRetainProgram(built);
    device_object_made();
    return built;
}

bool program_pool_take(program_pool *pool, program *p)
{
    if (!pool)
        return false;
    pthread_mutex_lock(&pool->lock);
    for (int i = 0; i < PLACES && !p->cl; ++i)
        if (pool->places[i].cl && strcmp(pool->places[i].sha256, p->sha256) == 0)
            p->cl = retained(pool->places[i].cl);
    pthread_mutex_unlock(&pool->lock);
    return p->cl;
}

void program_pool_put(program_pool *pool, const program *p)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    unsigned i = pool->next++ % PLACES;
    release_program(&pool->places[i].cl);
    memcpy(pool->places[i].sha256, p->sha256, sizeof p->sha256);
    pool->places[i].cl = retained(p->cl);
    pthread_mutex_unlock(&pool->lock);
}
