// SPDX-License-Identifier: MIT
// Bodies as large and heavy as planets, whose inertia a float hardly holds.
#include "support/mover.h"
#include "support/test.h"

// A body that tumbles, as large as `size` and of that mass, for 2 s; its angular velocity in the
// end.
static void tumble(double size, double mass, uint32_t wants, double end[3])
{
    mover *m = mover_new(3);
    uint32_t id = mover_add(m, 0, 0, 0, size, 1.5 * size, 2 * size);
    m->bodies[id].mass = (float)mass;
    m->bodies[id].angular_velocity[0] = 0.1f;
    m->bodies[id].angular_velocity[1] = 2.0f;
    m->def.wants |= wants;
    m->def.substeps = 4;
    mover_run(m, 120);
    mover_assert_finite(m);
    for (int k = 0; k < 3; ++k)
        end[k] = m->states[id].angular_velocity[k];
}

// A free turn does not depend on size or mass: inertias of 1e3 to 1e41, in free flight, in steps
// that could push, and in those that follow bodies which turn far.
TEST(a_planet_tumbles_as_a_box_does)
{
    static const uint32_t wants[] = {0, DUET_EFFECT_CONTACT_RESPONSE,
                                     DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_CONTINUOUS};
    static const double sizes[] = {1e3, 1e7, 6.4e6, 1e10, 1e6},
                        masses[] = {1e-3, 1e23, 6e24, 1e19, 1e29};
    for (int w = 0; w < 3; ++w) {
        double box[3], large[3];
        tumble(1.0, 1.0, wants[w], box);
        for (int i = 0; i < 5; ++i) {
            tumble(sizes[i], masses[i], wants[w], large);
            for (int k = 0; k < 3; ++k)
                if (!(fabs(large[k] - box[k]) < 1e-3))
                    fail_msg("size %g, mass %g, effects %x: turns at %g, not %g", sizes[i],
                             masses[i], wants[w], large[k], box[k]);
        }
    }
}

TEST_MAIN(mover_open_pair, mover_close_pair)
