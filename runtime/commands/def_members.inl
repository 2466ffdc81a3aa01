// SPDX-License-Identifier: MIT
// The members of a duet_motion_def that a command can change, in the order that files have them.
DEF_MEMBER(gravity)
DEF_MEMBER(attraction)
DEF_MEMBER(centre)
DEF_MEMBER(drag)
DEF_MEMBER(lower)
DEF_MEMBER(upper)
DEF_MEMBER(max_push_speed)
DEF_MEMBER(restitution_threshold)
DEF_MEMBER(sleep_speed)
DEF_MEMBER(sleep_after)
#undef DEF_MEMBER
