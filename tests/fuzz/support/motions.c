// SPDX-License-Identifier: MIT
#include "support/motions.h"

enum { BOXES = 5 };

duet_device_pair *motions_open_pair(duet_error *err)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    return duet_device_pair_create(&def, err);
}

// A floor, and boxes that fall on it and on each other.
static void place(duet_pose poses[BOXES], duet_body bodies[BOXES], uint32_t up)
{
    for (uint32_t i = 0; i < BOXES; ++i) {
        poses[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0.1f, 1}};
        poses[i].centre[0] = 0.4f * (float)i;
        poses[i].centre[up] = 0.9f * (float)i;
        bodies[i] = duet_default_body();
        bodies[i].friction = 0.5f;
        bodies[i].restitution = 0.2f;
    }
    poses[0].centre[up] = -0.5f;
    poses[0].half_extents[0] = 4.0f;
    poses[0].rotation[2] = 0.0f;
    bodies[0].mass = 0.0f;
    bodies[BOXES - 1].group = 2;
}

duet_motion *motions_make(int which, duet_device_pair *pair, duet_error *err)
{
    static const uint32_t wants[MOTIONS] = {
        DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS,
        DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_CONTINUOUS | DUET_EFFECT_EVENTS,
        DUET_EFFECT_CONTACT | DUET_EFFECT_ANGULAR_VELOCITY,
        DUET_EFFECT_CONTACT_RESPONSE,
        DUET_EFFECT_CONTACT_RESPONSE,
    };
    static const float values[] = {0.5f, 0, 0.25f, 0, -0.5f, 0};
    static const duet_heights ground = {
        .nx = 3, .ny = 2, .origin = {-2, -2, 0}, .spacing = {2, 4}, .heights = values};
    static const float vertices[] = {-2, -2, 0.5f, 2, -2, 0, 2, 2, -0.5f, -2, 2, 0};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    static const duet_mesh mesh = {
        .n_vertices = 4, .n_triangles = 2, .vertices = vertices, .triangles = triangles};
    duet_motion_def def = duet_default_motion_def();
    duet_pose poses[BOXES];
    duet_body bodies[BOXES];
    def.pair = pair;
    def.plan = duet_default_plan(pair);
    def.dims = which == 1 ? 2 : 3;
    def.wants = wants[which];
    def.doubles = which == 2;
    def.origin_edge = which == 1 ? 16.0f : 0.0f;
    def.skin = which == 0 ? 0.1 : 0.0;
    def.gravity[def.dims - 1] = -9.81;
    def.heights = which == 3 ? &ground : NULL;
    def.mesh = which == 4 ? &mesh : NULL;
    place(poses, bodies, def.dims - 1);
    return duet_motion_create(&def, poses, bodies, BOXES, err);
}
