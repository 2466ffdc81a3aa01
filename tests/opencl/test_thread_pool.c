// SPDX-License-Identifier: MIT
// Loops, jobs and calls of a thread pool, beside what one thread does alone.
#include "support/test.h"

#include "runtime/opencl/thread_pool.h"

#include <stdatomic.h>

enum { MOST = 5000, MOST_THREADS = 4, ROUNDS = 100 };

static atomic_uint visits[MOST];
static uint32_t plain[MOST]; // not atomic: whoever waits for a loop sees what its threads wrote

static void visit(void *arg, uint64_t first, uint64_t last)
{
    (void)arg;
    for (; first < last; ++first) {
        for (volatile int busy = 0; busy < 100;) // so that threads are there before all is done
            ++busy;
        atomic_fetch_add(&visits[first], 1);
        plain[first] += (uint32_t)first;
    }
}

static void count(void *arg)
{
    ++*(uint32_t *)arg;
}

static void assert_visited(uint64_t n, uint32_t times)
{
    for (uint64_t i = 0; i < n; ++i) {
        assert_int_equal(atomic_load(&visits[i]), times);
        assert_int_equal(plain[i], (uint32_t)i * times);
        atomic_store(&visits[i], 0);
        plain[i] = 0;
    }
}

static thread_pool *open_pool(uint32_t n_threads)
{
    return must(thread_pool_open(n_threads, ERR));
}

TEST(each_piece_of_a_loop_is_done_once)
{
    rng r = rng_seed(test_seed());
    for (uint32_t threads = 0; threads <= MOST_THREADS; ++threads) {
        thread_pool *pool = threads > 0 ? open_pool(threads) : NULL;
        for (int round = 0; round < ROUNDS; ++round) {
            uint64_t n = rng_below(&r, MOST), piece = 1 + rng_below(&r, 99);
            thread_pool_share(pool, visit, NULL, n, piece);
            assert_visited(n, 1);
        }
        thread_pool_close(pool);
    }
}

TEST(a_loop_that_was_started_is_over_once_it_was_waited_for)
{
    rng r = rng_seed(test_seed());
    thread_pool_wait(NULL);
    for (uint32_t threads = 1; threads <= MOST_THREADS; ++threads) {
        thread_pool *pool = open_pool(threads);
        for (int round = 0; round < ROUNDS; ++round) {
            uint64_t n = rng_below(&r, MOST);
            thread_pool_start(pool, visit, NULL, n);
            thread_pool_wait(pool);
            thread_pool_wait(pool); // nothing is left
            assert_visited(n, 1);
        }
        thread_pool_start(pool, visit, NULL, MOST);
        thread_pool_close(pool); // waits, too
        assert_visited(MOST, 1);
    }
}

TEST(a_call_is_made_once_beside_loops_of_the_others)
{
    rng r = rng_seed(test_seed());
    for (uint32_t threads = 1; threads <= MOST_THREADS; ++threads) {
        thread_pool *pool = open_pool(threads);
        for (uint32_t round = 0; round < ROUNDS; ++round) {
            uint32_t called = 0, loops = rng_below(&r, 4);
            thread_pool_stay_awake(pool, round % 2);
            thread_pool_begin_call(pool, count, &called);
            for (uint32_t i = 0; i < loops; ++i)
                thread_pool_share(pool, visit, NULL, MOST, 64);
            thread_pool_end_call(pool);
            assert_int_equal(called, 1);
            assert_visited(MOST, loops);
        }
        thread_pool_close(pool);
    }
}

TEST(both_jobs_are_done_and_one_needs_no_pool)
{
    uint32_t a = 0, b = 0;
    thread_pool *pool = open_pool(1);
    for (uint32_t round = 1; round <= ROUNDS; ++round) {
        thread_pool_run_both(pool, count, &a, &b);
        assert_int_equal(a, round);
        assert_int_equal(b, round);
    }
    thread_pool_run_both(NULL, count, &a, NULL);
    thread_pool_run_both(NULL, count, NULL, &b);
    thread_pool_run_both(NULL, count, NULL, NULL);
    assert_int_equal(a, ROUNDS + 1);
    assert_int_equal(b, ROUNDS + 1);
    thread_pool_close(pool);
}
