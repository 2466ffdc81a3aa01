// SPDX-License-Identifier: MIT
// Where bodies are as boxes, for queries and worlds.
#include "runtime/dynamics/motion_poses.h"

#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"

#include <stdlib.h>
#include <string.h>

static duet_pose pose_of(const duet_motion *m, uint32_t id, const duet_state *state)
{
    duet_pose pose = m->poses[id];
    for (int k = 0; k < 3; ++k)
        pose.centre[k] = (float)state->centre[k];
    for (int k = 0; k < 4; ++k)
        pose.rotation[k] = (float)state->rotation[k];
    return pose;
}

bool duet_motion_get_poses(duet_motion *m, duet_pose *poses, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) ||
        (m->n > 0 && !error_given(poses, __func__, "poses", err)))
        return false;
    duet_state *states = motion_read_states(m, err);
    for (uint32_t id = 0; states && id < m->n; ++id)
        poses[id] = pose_of(m, id, &states[id]);
    free(states);
    return states;
}

// Poses become rounded boxes where they lie, the last first.
static void add_radii(const duet_motion *m, void *rows)
{
    const duet_pose *poses = rows;
    duet_rounded_box *boxes = rows;
    for (uint32_t id = m->n; id-- > 0;) {
        duet_pose pose = poses[id];
        boxes[id] = (duet_rounded_box){pose, m->bodies[id].radius};
    }
}

bool duet_motion_get_rounded_boxes(duet_motion *m, duet_rounded_box *boxes, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) ||
        (m->n > 0 && !error_given(boxes, __func__, "boxes", err)))
        return false;
    void *rows = boxes;
    if (!duet_motion_get_poses(m, rows, err))
        return false;
    add_radii(m, rows);
    return true;
}

bool motion_copy_poses(duet_motion *m, bool radii, void *rows, duet_error *err)
{
    size_t width = radii ? sizeof(duet_rounded_box) : sizeof(duet_pose);
    if (!(radii ? duet_motion_get_rounded_boxes(m, rows, err)
                : duet_motion_get_poses(m, rows, err)))
        return false;
    for (uint32_t id = 0; id < m->n; ++id) {
        duet_pose *pose = (void *)((char *)rows + id * width);
        if (motion_is_hidden(m, id))
            pose->half_extents[0] = -1;
    }
    return true;
}

bool motion_copy_large_poses(duet_motion *m, duet_large_pose *poses, duet_error *err)
{
    duet_state *states = calloc((size_t)m->n + 1, sizeof *states);
    cl_int4 *cells = calloc((size_t)m->n + 1, sizeof *cells);
    bool ok = states && cells;
    if (!ok)
        no_memory(err, "%u states", m->n);
    ok = ok && motion_fetch_states(m, NULL, m->n, states, cells, err);
    for (uint32_t id = 0; ok && id < m->n; ++id) {
        poses[id] = (duet_large_pose){.pose = pose_of(m, id, &states[id])};
        memcpy(poses[id].cell, &cells[id], sizeof poses[id].cell);
        if (motion_is_hidden(m, id))
            poses[id].pose.half_extents[0] = -1;
    }
    free(states);
    free(cells);
    return ok;
}

bool motion_has_radii(const duet_motion *m)
{
    return m->facts & FACT_ROUND;
}

bool motion_has_poses(const duet_motion *m, bool radii)
{
    return motion_words(m, HALVES) > 0 && !m->cells &&
           (!radii || (m->effects & DUET_EFFECT_RADIUS));
}

bool motion_write_poses(duet_motion *m, bool radii, const buffer *rows, duet_error *err)
{
    m->poses_to = *rows;
    m->reading.row_words =
        (radii ? sizeof(duet_rounded_box) : sizeof(duet_pose)) / sizeof(cl_float);
    return motion_launch(m, WRITE_POSES, err) && timeline_finish(&m->times, err);
}
