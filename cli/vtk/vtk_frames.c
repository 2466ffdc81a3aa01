// SPDX-License-Identifier: MIT
#include "cli/vtk/vtk_frames.h"

#include "cli/vtk/vtk_bodies.h"
#include "cli/vtk/vtk_contacts.h"
#include "cli/vtk/vtk_ground.h"

void vtk_frames_begin(vtk_frames *f, const char *folder, duet_motion *motion)
{
    f->motion = motion;
    f->bodies = (vtk_series){.folder = folder, .name = "bodies", .ending = "vtu"};
    f->contacts = (vtk_series){.folder = folder, .name = "contacts", .ending = "vtp"};
    f->ground = (vtk_series){.folder = folder, .name = "ground", .ending = "vtp"};
    solids_make(f->solids, duet_motion_get_def(motion)->dims);
}

static bool add_bodies(vtk_frames *f, const body_states *bodies, double time, duet_error *err)
{
    const char *path = vtk_series_next(&f->bodies, err);
    return path && vtk_bodies_write(path, bodies, f->solids, bodies->def.dims, time, err) &&
           vtk_series_add(&f->bodies, time, err);
}

static bool add_contacts(vtk_frames *f, const body_states *bodies, double time, duet_error *err)
{
    if (!(duet_motion_get_effects(f->motion) & DUET_EFFECT_CONTACT))
        return true;
    const char *path = vtk_series_next(&f->contacts, err);
    return path && vtk_contacts_write(path, f->motion, bodies, time, err) &&
           vtk_series_add(&f->contacts, time, err);
}

// Adds it once if it never moves.
static bool add_ground(vtk_frames *f, const body_states *bodies, double time, duet_error *err)
{
    const duet_mesh *mesh = duet_motion_get_def(f->motion)->mesh;
    if (!mesh || mesh->carrier == 0)
        return f->bodies.n > 0 || vtk_ground_write_once(f->bodies.folder, &bodies->def, time, err);
    const char *path = vtk_series_next(&f->ground, err);
    return path && vtk_ground_write(path, &bodies->def, time, err) &&
           vtk_series_add(&f->ground, time, err);
}

bool vtk_frames_add(vtk_frames *f, double time, duet_error *err)
{
    body_states bodies;
    bool ok = body_states_read(&bodies, f->motion, err) &&
              body_states_read_asleep(&bodies, f->motion, err) &&
              add_ground(f, &bodies, time, err) && add_bodies(f, &bodies, time, err) &&
              add_contacts(f, &bodies, time, err);
    body_states_free(&bodies);
    return ok;
}

void vtk_frames_end(vtk_frames *f)
{
    vtk_series_free(&f->bodies);
    vtk_series_free(&f->contacts);
    vtk_series_free(&f->ground);
}
