// SPDX-License-Identifier: MIT
#include "runtime/commands/packed.h"

#include <assert.h>
#include <string.h>

static_assert(sizeof(packed_body) == 68 && sizeof(packed_def) == 144,
              "no byte of a file is left to chance");

packed_body packed_body_of(const duet_body *b)
{
    packed_body p = {.mass = b->mass,
                     .restitution = b->restitution,
                     .friction = b->friction,
                     .group = b->group,
                     .mask = b->mask,
                     .flags = (b->fixed_rotation ? PACKED_FIXED_ROTATION : 0) |
                              (b->sensor ? PACKED_SENSOR : 0) | b->material << PACKED_MATERIAL,
                     .radius = b->radius,
                     .rolling_resistance = b->rolling_resistance};
    memcpy(p.velocity, b->velocity, sizeof p.velocity);
    memcpy(p.angular_velocity, b->angular_velocity, sizeof p.angular_velocity);
    memcpy(p.surface_velocity, b->surface_velocity, sizeof p.surface_velocity);
    return p;
}

duet_body packed_to_body(const packed_body *p)
{
    duet_body b = {.mass = p->mass,
                   .restitution = p->restitution,
                   .friction = p->friction,
                   .group = p->group,
                   .mask = p->mask,
                   .radius = p->radius,
                   .fixed_rotation = p->flags & PACKED_FIXED_ROTATION,
                   .sensor = p->flags & PACKED_SENSOR,
                   .rolling_resistance = p->rolling_resistance,
                   .material = p->flags >> PACKED_MATERIAL};
    memcpy(b.velocity, p->velocity, sizeof b.velocity);
    memcpy(b.angular_velocity, p->angular_velocity, sizeof b.angular_velocity);
    memcpy(b.surface_velocity, p->surface_velocity, sizeof b.surface_velocity);
    return b;
}

packed_def packed_def_of(const duet_motion_def *d)
{
    packed_def p;
#define DEF_MEMBER(name) memcpy(&p.name, &d->name, sizeof p.name);
#include "runtime/commands/def_members.inl"
    return p;
}

void packed_to_def(const packed_def *p, duet_motion_def *d)
{
#define DEF_MEMBER(name) memcpy(&d->name, &p->name, sizeof p->name);
#include "runtime/commands/def_members.inl"
}
