// SPDX-License-Identifier: MIT
#include "support/skin.h"

#include "support/test.h"

enum { BOXES = 48, CHECK_EVERY = 10 };

// Faces that meet by less than a slop, 0.5 % of the mean least extent, do not touch,
// and a face wins over edges that are less deep by half of one: what crosses there
// may be somewhat deeper.
static double depth_unseen(const mover *m, const duet_pose *poses)
{
    double sum = 0;
    for (uint32_t i = 0; i < m->n; ++i) {
        const float *half = poses[i].half_extents;
        double least = half[0] < half[1] ? half[0] : half[1];
        sum += m->def.dims == 3 && half[2] < least ? half[2] : least;
    }
    double slop = 0.005 * 2 * sum / m->n;
    return 2 * slop;
}

// Whichever of the two comes first: one without mass is second.
static bool has_contact(const duet_contact *contacts, uint64_t n, uint32_t a, uint32_t b)
{
    for (uint64_t i = 0; i < n; ++i)
        if ((contacts[i].a == a && contacts[i].b == b) ||
            (contacts[i].a == b && contacts[i].b == a))
            return true;
    return false;
}

void skin_assert_none_missed(mover *m, const duet_pose *poses)
{
    duet_contact *contacts = NULL;
    uint64_t n = 0;
    double unseen = depth_unseen(m, poses);
    must(duet_motion_get_contacts(m->motion, &contacts, &n, ERR));
    for (uint32_t a = 0; a < m->n; ++a)
        for (uint32_t b = a + 1; b < m->n; ++b)
            if ((m->bodies[a].mass > 0 || m->bodies[b].mass > 0) &&
                duet_poses_separation(&poses[a], &poses[b], m->def.dims) < -unseen &&
                !has_contact(contacts, n, a, b))
                fail_msg("step %d: objects %u and %u are missed", (int)m->last.step, a, b);
    duet_free(contacts);
}

static mover *bouncing_boxes(double skin)
{
    rng r = rng_seed(test_seed());
    mover *m = mover_new(3);
    m->def.skin = skin;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    m->def.restitution_threshold = 0.0;
    mover_wall_in(m, 0, 8.0);
    for (int i = 0; i < BOXES; ++i) {
        double x = 1 + 2 * (i % 4), y = 1 + 2 * (i / 4 % 4), z = 1 + 2 * (i / 16);
        uint32_t id = mover_add(m, x, y, z, 0.3, 0.4, 0.5);
        mover_turn(m, id, rng_normal(&r), rng_normal(&r), rng_normal(&r), rng_between(&r, 0, 3));
        m->bodies[id].restitution = 1.0f;
        for (int k = 0; k < 3; ++k)
            m->bodies[id].velocity[k] = (float)rng_between(&r, -2, 2);
    }
    return m;
}

void skin_run(uint32_t steps)
{
    mover *skinned = bouncing_boxes(0.25), *plain = bouncing_boxes(0);
    duet_pose before[BOXES];
    uint32_t rebuilt = 0;
    memcpy(before, skinned->poses, sizeof before);
    for (uint32_t step = 0; step < steps; ++step) {
        mover_run(skinned, 1);
        mover_run(plain, 1);
        rebuilt += skinned->last.rebuilt;
        if (step % CHECK_EVERY == 0) {
            skin_assert_none_missed(skinned, before);
            assert_true(mover_hash(skinned) == mover_hash(plain));
        }
        for (uint32_t i = 0; i < BOXES; ++i) // the state is in float, so that nothing is rounded
            before[i] = mover_pose(skinned, i);
    }
    print_message("%u steps, the grid was built in %u\n", steps, rebuilt);
    assert_true(rebuilt > 1 && rebuilt < steps / 2);
}
