// SPDX-License-Identifier: MIT
// Gives an order by the public calls. Before including this, define
//   TARGET             the first parameter
//   CALL(name, ...)    the command of that name to the target, with these arguments
//   DEF                the target's def
//   GIVEN(rows)        the argument for these rows
static bool obey(TARGET, verb what, const order *o, uint64_t *came, duet_error *err)
{
    const duet_body_list list = {.ids = GIVEN(o->ids), .n = GIVEN(o) ? o->n : 0};
    const uint32_t fields = GIVEN(o) ? o->fields : 0;
    duet_motion_def def = *DEF;
    memcpy(def.gravity, o->gravity, sizeof def.gravity);
    switch (what) {
    case ADD:
        return CALL(add_bodies, GIVEN(o->poses), GIVEN(o->bodies), o->n, came, err);
    case REMOVE:
        return CALL(remove_bodies, list, err);
    case SET:
        return CALL(set_bodies, list, fields, GIVEN(o->bodies), err);
    case SET_POSES:
        return CALL(set_poses, list, GIVEN(o->poses), err);
    case FORCE:
        return CALL(apply_forces, list, GIVEN(o->forces), err);
    case IMPULSE:
        return CALL(apply_impulses, list, GIVEN(o->impulses), err);
    case AIM:
        return CALL(set_targets, list, GIVEN(o->targets), err);
    case DISABLE:
        return CALL(disable_bodies, list, err);
    case ENABLE:
        return CALL(enable_bodies, list, err);
    case PUT_TO_SLEEP:
        return CALL(sleep_bodies, list, err);
    case WAKE:
        return CALL(wake_bodies, list, err);
    case NAME:
        return CALL(set_user_data, list, GIVEN(o->data), err);
    default:
        return CALL(set_def, GIVEN(&def), err);
    }
}
