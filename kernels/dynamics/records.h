// SPDX-License-Identifier: MIT
// What is kept of contacts and bodies, for kernels and host alike. Kernels give the macros
// the parameters of their config, the host what its scene calls for: RESPONSE, FRICTION and
// TURNS are 0 or 1, DIMS 2 or 3.
#ifndef KERNELS_DYNAMICS_RECORDS_H
#define KERNELS_DYNAMICS_RECORDS_H

// ------------------------------------------------------------ contacts

// A contact is a record of floats: a head, and then its points. AT_ are places in the
// record, OF_ in a point. A record means nothing where the contact has no points.
//
// The normal points from the first object, which owns the contact, to the other. Anchors
// reach from the owner's centre to the point, along the world's axes.
//
// With response a manifold is kept while its pair hardly moves: anchors, offset, rotations
// and bases are those of when it was made. A ground's centre is its origin, or that of what moves it.
#define AT_NORMAL 0 // 3
#define AT_OFFSET 3 // 3, with response: from the owner's centre to the other's
#define AT_BASES 6  // with response: separation of each point
#define AT_ROTATIONS_OF(POINTS) (6 + (POINTS)) // where bodies turn: the owner's and the other's
#define HEAD_OF(RESPONSE, TURNS, POINTS) ((RESPONSE) ? 6 + (POINTS) + ((TURNS) ? 8 : 0) : 3)

#define OF_ANCHOR 0          // 3
#define OF_SEPARATION 3      // along the normal; below 0: depth
#define OF_NORMAL_IMPULSE 4  // with response: accumulated in the last substep
#define OF_MAX_IMPULSE 5     // with response: greatest normal impulse of the step
#define OF_TANGENT_IMPULSE 6 // with friction: impulse along each tangent
#define POINT_FLOATS_OF(RESPONSE, FRICTION, DIMS) ((RESPONSE) ? 6 + ((FRICTION) ? (DIMS)-1 : 0) : 4)

// Where nothing turns one point says all.
#define POINTS_OF(RESPONSE, TURNS, DIMS) ((RESPONSE) && !(TURNS) ? 1 : (DIMS) == 3 ? 4 : 2)

// A word for each contact: its number of points, and the axis that the normal lies along or,
// without points, that separates the boxes (box_contact.clh).
#define TOUCH_POINTS 7u
#define TOUCH_DEEP 8u // where bodies sleep: some point is deeper than the margin
#define TOUCH_AXIS 4  // the least of its bits

// ------------------------------------------------------------ constraints

// A contact while it is solved, in fields: IN_ of the whole, BY_ of each point. The fields of the whole,
// of each point, and the speeds, are as many as four can load: IN_FOURS.
#define IN_FOURS(n) (((n) + 3) / 4 * 4)
#define IN_OWNER 0 // a uint, as the next two
#define IN_OTHER 1
#define IN_POINTS 2 // how many
#define IN_RESTITUTION 3
#define IN_NORMAL 4    // 3
#define IN_OFFSET 7    // 3, from the owner's centre to the other's
#define IN_FRICTION 10 // with friction
#define IN_TANGENT 11  // 3, with friction
#define IN_ROLLING_OF(FRICTION) ((FRICTION) ? 14 : 10) // with rolling: a length, which a push turns the bodies back
#define ROLLING_FIELDS 4                               // with, and the impulse of that torque, of all substeps so far
#define BELT_FIELDS 3 // where surfaces move: the other's surface velocity less the owner's, along the world's axes
#define FIELDS_OF(FRICTION, ROLLING, CONVEYS) \
    IN_FOURS(IN_ROLLING_OF(FRICTION) + ((ROLLING) ? ROLLING_FIELDS : 0) + ((CONVEYS) ? BELT_FIELDS : 0))

#define BY_ANCHOR 0           // 3, the owner's
#define BY_NORMAL_MASS 3      // effective, along the normal
#define BY_SEPARATION 4       // when the step began
#define BY_CURRENT 5          // the separation after the last substep
#define BY_EXPECTED_IMPULSE 5 // between a substep's two passes: the most that the next begins with
#define BY_NORMAL_IMPULSE 6   // accumulated in the last substep
#define BY_MAX_IMPULSE 7      // greatest normal impulse of the step
#define BY_TANGENT_IMPULSE 8  // with friction: impulse along each tangent, then its mass
#define BY_FIELDS_OF(FRICTION) (8 + ((FRICTION) ? 4 : 0))

// The speed of each point along the normal when the step began is read once a step, so it
// lies last.
#define CONSTRAINT_OF(FRICTION, ROLLING, CONVEYS, POINTS) \
    (FIELDS_OF(FRICTION, ROLLING, CONVEYS) + (POINTS) * BY_FIELDS_OF(FRICTION) + IN_FOURS(POINTS))

// ------------------------------------------------------------ bodies

// A body while a step is solved, in vectors of four: velocity and inverse mass, the way
// moved since the step began; where bodies turn also angular velocity, the turn since then,
// and the inverse inertia along the world's axes. The warm impulse is what contacts did to it
// in the last substep, an impulse and a torque. Vectors are read two together; what every
// pass reads is one line of a cache.
//
// Behind the last body are what never moves: six walls, and the ground, with which a body has so many
// contacts at most.
#define AT_GROUND 6
#define GROUND_CONTACTS 4
#define FIXED (AT_GROUND + GROUND_CONTACTS)
//@ if CARRIED == 1 then
// A body, or instead of the ground the one that carries it.
#define MOVER_OF(s, id) ((id) >= (s)->n + AT_GROUND ? (s)->carrier : (id))
//@ end
#define BODY_OF(TURNS) ((TURNS) ? 8 : 4)
#define BODY_VELOCITY 0         // w: inverse mass
#define BODY_ANGULAR_VELOCITY 1 // where bodies turn; w: yy of the inverse inertia
#define BODY_INERTIA 2          // where bodies turn: zz, xy, xz, yz
#define BODY_DELTA_POSITION_OF(TURNS) ((TURNS) ? 3 : 1) // w: xx
#define BODY_DELTA_ROTATION 4                           // where bodies turn: a quaternion
#define BODY_ARC 5 // where they turn far in a step: the sum of all turns, as a vector; else spare
//@ if ROUNDED == 1 then
// w of an arc is the radius, where bodies turn.
//@ end
#define BODY_WARM_IMPULSE_OF(TURNS) ((TURNS) ? 6 : 2)
#define BODY_WARM_TORQUE 7 // where bodies turn; else 3 is spare

// What has turned so far since the step began, squared and in radians, pushes as it lies then.
#define FAR_TURNED 0.00390625f

// A word a body, where bodies sleep: whether it sleeps, whether it woke in this step, and
// whether it sleeps deep in others and is pushed out of them: for so many steps at most, in
// so many rounds a step.
#define SLEEPS 1u
#define WOKE 2u
#define PRESSED 4u
#define PRESSED_STEPS 480
#define PRESSED_ROUNDS 4

// ------------------------------------------------------------ colours

// Of contacts: 0 to 30 are bits of a word, and then
#define COLOUR_OVERFLOW 31 // solved in order
#define COLOUR_WAITS 32    // to be coloured
#define COLOUR_NONE 33     // pushes nothing
#define COLOURS 34
#define COLOUR_LEFT 64u // a bit beside one: another domain solves it alone (closure.cl)

// Four words for each colour up to COLOUR_OVERFLOW: its first contact in the list by colour, how many, the slot of the
// first in blocks, and in a domain how many are its border's. One more entry: x, the end of the colours that have
// contacts; y, how many blocks there are.
#define COLOUR_SPANS (COLOUR_OVERFLOW + 2)
#define COLOUR_KEYS 4 // keys of a colour that contacts are sorted by

// The first key of a colour, if colours below COLOUR_OVERFLOW have so many each, and the others one.
#define COLOUR_KEY(COLOUR, EACH) \
    ((COLOUR) < COLOUR_OVERFLOW ? (COLOUR) * (EACH) : COLOUR_OVERFLOW * (EACH) + (COLOUR) - COLOUR_OVERFLOW)

// Words of a team (team.clh), those that all change in lines of a cache of their own.
#define TEAM_LINE 16 // words
#define TEAM_DONE 0
#define TEAM_STAGE TEAM_LINE
#define TEAM_TAKEN (2 * TEAM_LINE)                     // a line for each group
#define MEET_BOUNCES TEAM_LINE                         // of groups that meet: colours in which something bounces
#define TEAM_MOST 320                                  // groups
#define TEAM_PARTS TEAM_LINE                           // parts of a group in a stage, at most
#define TEAM_WORDS (TEAM_TAKEN + TEAM_LINE * TEAM_MOST)
#define TEAM_ROUNDS 1024       // of colouring that a launch of a team counts
#define TEAM_LEAST_PART 32     // contacts that a group takes of a colour at least
#define TEAM_LEAST_CONTACTS 64 // those of a part if a group has several
#define TEAM_LEAST_BODIES 512  // likewise, bodies, pairs, or contacts that are not solved

// Buckets of a team that makes rows of contacts: at most, and the least rows of one as a power of 2; parts of a
// group, at most, that put contacts into them.
#define ROW_BUCKETS 256
#define ROW_LEAST_SHIFT 6
#define ROW_PARTS 2

// ------------------------------------------------------------ flags

// Words that kernels set and the host reads.
#define FLAG_MOVED 0       // something has left its fat AABB
#define FLAG_UNCOLOURED 1  // contacts that wait for a colour
#define FLAG_RECOLOURED 2  // some contact has another colour than before
#define FLAG_EVENTS 3      // events written
#define FLAG_FELL_ASLEEP 4 // something fell asleep or woke
#define FLAG_AWAKE 5       // something neither sleeps nor stands still for ever
#define FLAG_ROUNDS 6      // of the colouring that coloured something
#define FLAG_PRESSED 7     // something is to be pushed out of others in which it sleeps
#define FLAG_WOKE 8        // something woke
#define FLAG_FULL 9        // colours have more blocks than there is space for, or took more rounds than a team counts
#define FLAGS 10

// A step may be sent whole, before the host knows how it goes (motion_step.c): `hopes` are bits of what it takes for
// granted. If something does not hold, kernels that come later do nothing, and the host goes on from there. A kernel
// that names the macros takes `hopes` and `flags` as arguments.
#define HOPES_FITS 1u       // all colours have space, and took no more rounds than are counted
#define HOPES_AWAKE 2u      // nothing wakes or falls asleep
#define HOPES_COLOURS 4u    // no contact has another colour than before
#define HOPES_UNPRESSED 8u  // nothing is to be pushed out of others
#define WAITS_FOR_AWAKE ((hopes & HOPES_AWAKE) && flags[FLAG_FELL_ASLEEP])
#define WAITS_FOR_HOST                                                               \
    (((hopes & HOPES_FITS) && flags[FLAG_FULL]) || WAITS_FOR_AWAKE ||                \
     ((hopes & HOPES_COLOURS) && flags[FLAG_RECOLOURED]) ||                          \
     ((hopes & HOPES_UNPRESSED) && flags[FLAG_PRESSED]))

// Steps that bounds last at least for a body that keeps its velocity, where there is a skin.
#define LEAST_HORIZON 3

// The lengths of the lists of what is awake (awake.cl).
#define LISTED_BODIES 0
#define LISTED_CONTACTS 1
#define LISTED 2

#endif
