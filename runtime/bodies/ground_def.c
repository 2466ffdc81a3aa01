// SPDX-License-Identifier: MIT
#include "runtime/bodies/ground_def.h"

#include "base/error.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/narrowphase/mesh.h"

bool ground_def_check(const duet_motion_def *def, duet_error *err)
{
    uint32_t material = ground_def_material(def);
    if (!ground_def_is_given(def))
        return true;
    if (def->heights && def->mesh)
        return bad_argument(err, "the def has heights and a mesh; expected one ground");
    if (def->dims != 3 || def->origin_edge != 0.0f)
        return bad_argument(err, "heights and meshes are for motions in 3D without origin cells");
    if (material > def->n_materials)
        return bad_argument(err,
                            "the ground's material is %u; expected one of the def's %u materials",
                            material, def->n_materials);
    return def->mesh ? mesh_check(def->mesh, err) : heights_check(def->heights, err);
}

bool ground_def_check_carrier(const duet_motion_def *def, const duet_body *bodies, uint32_t n,
                              duet_error *err)
{
    uint32_t carrier = ground_def_carrier(def);
    if (carrier > n)
        return bad_argument(err, "the mesh's carrier is body %u; expected one of %u bodies",
                            carrier - 1, n);
    const duet_body *b = carrier > 0 ? &bodies[carrier - 1] : NULL;
    return !b || (b->mass == 0.0f && b->radius == 0.0f) ||
           bad_argument(
               err, "body %u, the mesh's carrier, has the mass %g and the radius %g; expected 0",
               carrier - 1, (double)b->mass, (double)b->radius);
}
