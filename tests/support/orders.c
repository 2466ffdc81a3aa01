// SPDX-License-Identifier: MIT
#include "support/orders.h"

#include <string.h>

static float between(orders *o, double from, double to)
{
    return (float)rng_between(&o->r, from, to);
}

duet_pose orders_pose(orders *o)
{
    duet_pose pose = {.rotation = {between(o, -1, 1), between(o, -1, 1), between(o, -1, 1), 1}};
    if (o->is_flat)
        pose.rotation[0] = pose.rotation[1] = 0;
    for (int k = 0; k < 3; ++k) {
        pose.centre[k] = (float)o->at[k] + between(o, 0.5, k == 2 ? o->size : o->size - 0.5);
        pose.half_extents[k] = between(o, 0.1, 0.4);
    }
    return pose;
}

duet_body orders_body(orders *o)
{
    duet_body b = duet_default_body();
    for (int k = 0; k < 3; ++k) {
        b.velocity[k] = between(o, -3, 3);
        b.angular_velocity[k] = o->turns ? between(o, -3, 3) : 0;
    }
    b.mass = rng_below(&o->r, 6) ? between(o, 0.5, 3) : 0;
    if (b.mass == 0 && rng_below(&o->r, 2))
        memset(b.velocity, 0, sizeof b.velocity);
    if (!o->touches)
        return b;
    b.sensor = rng_below(&o->r, 11) == 0;
    b.friction = between(o, 0, 1);
    b.restitution = between(o, 0, 0.5);
    b.group = 1u << rng_below(&o->r, 3);
    return b;
}

verb orders_verb(orders *o)
{
    verb what;
    do
        what = (verb)rng_below(&o->r, VERBS);
    while (!o->touches && (what == WAKE || what == PUT_TO_SLEEP));
    return what;
}

order orders_draw(orders *o, verb what)
{
    const known_ids *known = &o->known;
    order given = {.n = what == AIM ? 1 : 1 + rng_below(&o->r, o->most),
                   .fields = rng_below(&o->r, o->fields),
                   .gravity = {between(o, -2, 2), between(o, -2, 2), between(o, -10, 0)}};
    uint32_t at = rng_below(&o->r, known->n);
    given.n = given.n < known->n ? given.n : known->n;
    for (uint32_t i = 0; i < given.n; ++i) {
        given.ids[i] = known->ids[(at + 7 * i) % known->n];
        given.data[i] = rng_next(&o->r);
        given.poses[i] = orders_pose(o);
        given.bodies[i] = orders_body(o);
        for (int k = 0; k < 3; ++k) {
            given.forces[i].force[k] = between(o, -30, 30);
            given.forces[i].torque[k] = o->turns ? between(o, -3, 3) : 0;
            given.impulses[i].impulse[k] = between(o, -2, 2);
            given.impulses[i].anchor[k] = between(o, -0.3, 0.3);
            given.targets[i].centre[k] = given.poses[i].centre[k];
        }
        memcpy(given.targets[i].rotation, given.poses[i].rotation,
               sizeof given.targets[i].rotation);
    }
    return given;
}

uint64_t orders_stale_id(orders *o)
{
    uint32_t n = o->known.n_stale < ORDER_IDS ? o->known.n_stale : ORDER_IDS;
    return o->known.stale[rng_below(&o->r, n)];
}

void orders_added(orders *o, const order *given, const uint64_t *came)
{
    for (uint32_t i = 0; i < given->n; ++i)
        o->known.ids[o->known.n++] = came[i];
}

void orders_removed(orders *o, const order *given)
{
    known_ids *known = &o->known;
    for (uint32_t i = 0; i < given->n; ++i) {
        uint32_t at = 0;
        while (known->ids[at] != given->ids[i])
            ++at;
        known->ids[at] = known->ids[--known->n];
        known->stale[known->n_stale++ % ORDER_IDS] = given->ids[i];
    }
}
