// SPDX-License-Identifier: MIT
// The narrow phase alone at full size: 220 000 hard pairs in 3D and as many in
// 2D at every level, and more pairs than 31 bits count.
#define _GNU_SOURCE
#include "support/test.h"

#include "support/devices.h"
#include "support/hard_test.h"

#include <sys/mman.h>
#include <unistd.h>

// ------------------------------------------------------------ hard pairs

enum { EACH = 10000 };

TEST(hard_pairs_in_3d_get_what_their_level_promises)
{
    hard_test_run(3, EACH);
}

TEST(hard_pairs_in_2d_get_what_their_level_promises)
{
    hard_test_run(2, EACH);
}

// ------------------------------------------------------------ many pairs

// One block of memory that lies behind itself again and again, so that 172 GB
// of poses need no more than a block and the tables of its pages.
typedef struct tiles {
    char *bytes;
    size_t block;
    size_t n_blocks;
} tiles;

static tiles tiles_open(size_t block, uint64_t bytes)
{
    tiles t = {.block = block, .n_blocks = (size_t)((bytes + block - 1) / block)};
    int file = memfd_create("tiles", 0);
    assert_true(file >= 0);
    assert_int_equal(ftruncate(file, (off_t)block), 0);
    t.bytes = mmap(NULL, block * t.n_blocks, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE,
                   -1, 0);
    assert_true(t.bytes != MAP_FAILED);
    for (size_t i = 0; i < t.n_blocks; ++i)
        assert_true(mmap(t.bytes + i * block, block, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED,
                         file, 0) != MAP_FAILED);
    close(file);
    return t;
}

static void tiles_close(tiles *t)
{
    munmap(t->bytes, t->block * t->n_blocks);
}

// A block holds 2^20 pairs, of which one in four is apart.
enum { PAIRS_A_BLOCK = 1 << 20 };

static void fill_block(duet_pose *poses)
{
    for (int i = 0; i < PAIRS_A_BLOCK; ++i) {
        float at = i % 4 == 3 ? 5.0f : 0.25f;
        poses[2 * i] = (duet_pose){{0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
        poses[2 * i + 1] = (duet_pose){{at, 0, 0}, {0.5f, 0.5f, 0.5f}, {0, 0, 1, 1}};
    }
}

TEST(more_pairs_than_31_bits_count_are_counted)
{
    const uint64_t n = ((uint64_t)1 << 31) + 12345;
    tiles poses = tiles_open(2 * sizeof(duet_pose) * PAIRS_A_BLOCK, 2 * sizeof(duet_pose) * n);
    tiles answers = tiles_open(PAIRS_A_BLOCK, n);
    fill_block((duet_pose *)poses.bytes);
    duet_pair_query_result result;
    hard_test_answers(DUET_LEVEL_SPHERE, 3, DUET_SHARE_ONE / 2, (const duet_pose *)poses.bytes, n,
                      (uint8_t *)answers.bytes, &result);
    print_message("%" PRIu64 " of %" PRIu64 " pairs collide, %.1f s\n", result.colliding, n,
                  result.total_ms * 1e-3);
    assert_true(result.colliding == n - n / 4);
    tiles_close(&answers);
    tiles_close(&poses);
}
