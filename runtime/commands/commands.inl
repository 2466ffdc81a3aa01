// SPDX-License-Identifier: MIT
// The commands to a motion, each once. Public calls, their checks, recordings, replays and Lua's
// methods are made from this list, for a motion and for one over ranks. Functions of these names
// look at commands and carry them out (command.h).
//
//   COMMAND(number, name, form, bodies, effect, type, rows)
//
// number  in recordings: it stays as it is
// form    the arguments behind the motion: LIST of bodies, ROWS a list and a row for each of its
//         bodies, FIELDS a list, bits of duet_body_field and a duet_body each; ADD and DEF take no
//         list, but the poses and bodies that come, and a def
// bodies  ENABLED if the listed ones must be, else ANY
// effect  that the motion must have
// type    of a row, and the name of the argument
COMMAND(1, add_bodies, ADD, ANY, 0, duet_pose, poses)
COMMAND(2, remove_bodies, LIST, ANY, 0, , )
COMMAND(3, disable_bodies, LIST, ANY, 0, , )
COMMAND(4, enable_bodies, LIST, ANY, 0, , )
COMMAND(5, wake_bodies, LIST, ENABLED, DUET_EFFECT_SLEEP, , )
COMMAND(6, sleep_bodies, LIST, ENABLED, DUET_EFFECT_SLEEP, , )
COMMAND(7, set_user_data, ROWS, ANY, 0, uint64_t, data)
COMMAND(8, set_bodies, FIELDS, ANY, 0, duet_body, bodies)
COMMAND(9, set_poses, ROWS, ANY, 0, duet_pose, poses)
COMMAND(10, set_def, DEF, ANY, 0, duet_motion_def, def)
COMMAND(11, apply_forces, ROWS, ENABLED, DUET_EFFECT_FORCES, duet_force, forces)
COMMAND(12, apply_impulses, ROWS, ENABLED, DUET_EFFECT_MOTION, duet_impulse, impulses)
COMMAND(13, set_targets, ROWS, ENABLED, 0, duet_transform, targets)
#undef COMMAND
