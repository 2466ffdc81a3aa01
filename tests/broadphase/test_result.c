// SPDX-License-Identifier: MIT
// Numbers of pairs beyond 32 bits, without the memory for so many: lists of which
// only the pages that are read exist. tests/long/test_crowds.c has devices count
// that many.
#define _GNU_SOURCE
#include "support/test.h"

#include "runtime/broadphase/part.h"

#include <sys/mman.h>

#define MANY (((uint64_t)1 << 32) + 10)

static duet_pair *open_list(uint64_t n)
{
    void *list = mmap(NULL, n * sizeof(duet_pair), PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    assert_true(list != MAP_FAILED);
    return list;
}

TEST(places_beyond_32_bits_lead_to_their_pairs)
{
    duet_pair *a = open_list(MANY), *b = open_list(MANY);
    duet_result result = {.pairs = 2 * MANY, .spans = {{a, MANY}, {b, MANY}}};
    a[0] = (duet_pair){1, 2};
    a[MANY - 1] = (duet_pair){3, 4};
    b[0] = (duet_pair){5, 6};
    b[MANY - 1] = (duet_pair){7, 8};
    assert_int_equal(duet_result_get_pair(&result, 0).a, 1);
    assert_int_equal(duet_result_get_pair(&result, MANY - 1).a, 3);
    assert_int_equal(duet_result_get_pair(&result, MANY).a, 5);
    assert_int_equal(duet_result_get_pair(&result, 2 * MANY - 1).b, 8);
    munmap(a, MANY * sizeof *a);
    munmap(b, MANY * sizeof *b);
}

TEST(a_device_s_counters_have_64_bits)
{
    const uint32_t counts[COUNTERS] = {[COUNT_PAIRS] = 5, [COUNT_PAIRS + 1] = 3};
    part_found found = part_found_of(counts);
    assert_true(found.pairs == 3 * ((uint64_t)1 << 32) + 5);
    assert_true(found.candidates == 0);
}
