// SPDX-License-Identifier: MIT
// The objects of a scene as a motion takes them: cores as poses, and radii in bodies.
#ifndef RUNTIME_SCENE_BODIES_H
#define RUNTIME_SCENE_BODIES_H

#include "runtime/duet.h"

// The scene's, but what is made for objects with radii.
typedef struct scene_bodies {
    uint32_t n;
    const duet_pose *poses;
    const duet_large_pose *large_poses; // NULL without origin cells
    const duet_body *bodies;            // NULL: default ones
    duet_pose *made_poses;
    duet_body *made_bodies;
} scene_bodies;

// bodies NULL: the scene's. False for objects that do not move. Call scene_bodies_free whatever this
// returns.
bool scene_bodies_take(scene_bodies *b, const duet_scene *scene, const duet_body *bodies,
                       duet_error *err);
void scene_bodies_free(scene_bodies *b);

#endif
