// SPDX-License-Identifier: MIT
// Saved motions: the same state gives the same bytes, whatever devices and plan made it.
#include "support/mover.h"
#include "support/test.h"

#include "base/text.h"

enum { PILE = 250 };

typedef struct way {
    const char *name, *pair;
    double share; // of A
    duet_mode mode;
    const char *variant;
} way;

static const way ways[] = {
    {"one device", "cpu", 0, DUET_MODE_OWN, ""},
    {"one device, variant gpu", "cpu", 0, DUET_MODE_OWN, "gpu"},
    {"halves, slab", "halves", 0.5, DUET_MODE_SLAB, ""},
    {"halves, own", "halves", 0.25, DUET_MODE_OWN, ""},
    {"halves, shared", "halves", 0.75, DUET_MODE_SHARED, ""},
    {"halves, all by A", "halves", 1, DUET_MODE_SLAB, ""},
};

enum { WAYS = sizeof ways / sizeof ways[0] };

// A motion is made of this: an effect or two more than a pile, by bits.
enum { SLEEPS = 1, SKIN = 2, EVENTS = 4, ORIGIN = 8, WALLS = 16, COMMANDS = 32, KINDS = 64 };

static mover *make_pile(duet_device_pair *pair, int kind, const way *w)
{
    mover *m = mover_new(3);
    m->def.pair = pair;
    m->def.plan = duet_default_plan(pair);
    m->def.plan.share = (uint32_t)(w->share * DUET_SHARE_ONE);
    m->def.plan.mode = w->mode;
    if (w->variant[0])
        snprintf(m->def.plan.variant_b, sizeof m->def.plan.variant_b, "%s", w->variant);
    mover_add_pile(m, PILE);
    m->def.wants |= kind & SLEEPS ? DUET_EFFECT_SLEEP : 0;
    m->def.wants |= kind & EVENTS ? DUET_EFFECT_EVENTS : 0;
    m->def.wants |= kind & COMMANDS ? DUET_EFFECT_FORCES | DUET_EFFECT_FILTER : 0;
    m->def.skin = kind & SKIN ? 0.1 : 0;
    m->def.origin_edge = kind & ORIGIN ? 8 : 0;
    if (kind & ORIGIN || !(kind & WALLS)) // origin cells know no walls
        m->def.boundary = DUET_BOUNDARY_NONE;
    return m;
}

static void command(mover *m, uint64_t step)
{
    const uint64_t id = 7 + step, other = 90 + step;
    const duet_force force = {.force = {1, 2, 3}};
    const duet_body_list one = {.ids = &id, .n = 1}, two = {.ids = &other, .n = 1};
    must(duet_motion_apply_forces(m->motion, one, &force, ERR));
    must(duet_motion_remove_bodies(m->motion, two, ERR));
    if (step % 2)
        must(duet_motion_add_bodies(m->motion, &m->poses[other], &m->bodies[other], 1, NULL, ERR));
}

static text bytes_after(duet_device_pair *pair, int kind, const way *w, uint32_t steps)
{
    mover *m = make_pile(pair, kind, w);
    mover_run(m, steps);
    for (uint64_t k = 0; kind & COMMANDS && k < 4; ++k) {
        command(m, k);
        mover_run(m, 2);
    }
    if (kind & COMMANDS)
        command(m, 5);
    must(duet_motion_save(m->motion, "saved", ERR));
    mover_free(m);
    return test_read_file("saved");
}

TEST(the_bytes_of_a_state_do_not_tell_which_devices_made_it)
{
    rng r = rng_seed(test_seed());
    duet_device_pair *one = kept(duet_device_pair_open("cpu", ERR));
    duet_device_pair *two = kept(duet_device_pair_open("halves", ERR));
    for (int i = 0; i < 4; ++i) {
        int kind = (int)rng_below(&r, KINDS);
        uint32_t steps = 1 + rng_below(&r, 60);
        const text right = bytes_after(one, kind, &ways[0], steps);
        for (int k = 0; k < WAYS; ++k) {
            bool is_one = strcmp(ways[k].pair, "cpu") == 0;
            const text bytes = bytes_after(is_one ? one : two, kind, &ways[k], steps);
            bool same = bytes.length == right.length &&
                        memcmp(text_chars(&bytes), text_chars(&right), right.length) == 0;
            if (!same)
                fail_msg("%s, kind %d, %u steps: other bytes", ways[k].name, kind, steps);
        }
    }
}
