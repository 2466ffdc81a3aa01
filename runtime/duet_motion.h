// SPDX-License-Identifier: MIT
// Motions: objects that move, touch and sleep.
#ifndef DUET_MOTION_H
#define DUET_MOTION_H

#include "duet_world.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// Parts of the simulation. A motion runs the effects that its objects and its def call for, and
// no others; docs/effects.md says what calls for each.
typedef enum duet_effect {
    DUET_EFFECT_ROTATION = 1u << 0,         // orientation matters
    DUET_EFFECT_MOTION = 1u << 1,           // objects have velocities
    DUET_EFFECT_ANGULAR_VELOCITY = 1u << 2, // objects turn
    DUET_EFFECT_GRAVITY = 1u << 3,          // uniform, or towards a point
    DUET_EFFECT_DRAG = 1u << 4,             // velocities decay
    DUET_EFFECT_BOUNDARY = 1u << 5,         // walls, or a periodic world
    DUET_EFFECT_CONTACT = 1u << 6,          // points at which objects touch
    DUET_EFFECT_CONTACT_RESPONSE = 1u << 7, // contacts push, and bounce
    DUET_EFFECT_FRICTION = 1u << 8,         // contacts have friction
    DUET_EFFECT_CONTINUOUS = 1u << 9,       // fast bodies do not tunnel through thin ones
    DUET_EFFECT_FILTER = 1u << 10,          // groups and masks
    DUET_EFFECT_SLEEP = 1u << 11,           // bodies at rest cost nothing
    DUET_EFFECT_SKIN = 1u << 12,            // the grid lasts until a body leaves its skin
    DUET_EFFECT_EVENTS = 1u << 13,          // contacts that begin, stay and end, and hits
    DUET_EFFECT_FORCES = 1u << 14,          // commands push (duet_motion_commands.h)
    DUET_EFFECT_SENSORS = 1u << 15,         // bodies that touch without pushing
    DUET_EFFECT_RADIUS = 1u << 16,          // bodies have radii: spheres, capsules, rounded boxes
    DUET_EFFECT_ROLLING_RESISTANCE = 1u << 17, // rolling bodies slow down
    DUET_EFFECT_SURFACE_VELOCITY = 1u << 18,   // surfaces move: conveyors
    DUET_EFFECT_MATERIALS = 1u << 19,          // bodies name materials of a table
    DUET_EFFECT_SHOCKS = 1u << 20,             // impacts pass through rows of bodies that touch
    DUET_EFFECT_DEPENETRATION = 1u << 21, // bodies that begin deep in each other are taken apart
    DUET_EFFECT_GROUND = 1u << 22,        // a ground of heights or of triangles
    DUET_EFFECT_ALL = (1u << 23) - 1
} duet_effect;

DUET_API const char *duet_effect_name(uint32_t effect); // one bit: "rotation"; NULL for others

// A body's properties besides its pose.
typedef struct duet_body {
    float velocity[3];         // velocity of the centre, a second
    float angular_velocity[3]; // radians a second, along the world's axes
    float mass;                // 0: nothing changes its velocity
    float restitution;         // part of an impact's speed that comes back, 0 .. 1
    float friction;            // >= 0; a contact has the geometric mean of both bodies'
    uint32_t group;            // two bodies can touch if each one's group and the other's mask
    uint32_t mask;             // have a bit in common
    float radius;              // >= 0; the body is all points so near to the pose's box
    bool fixed_rotation;       // contacts never turn it
    bool sensor;               // its contacts are reported as events and push nothing
    float rolling_resistance;  // >= 0; a contact has the greater one of both bodies'. It turns them
                               // back with that part of the push times the greater radius
    float surface_velocity[3]; // velocity of its surface, along its own axes: friction carries what
                               // it touches
    uint32_t material;         // 1 .. n_materials of the def: that one's friction and restitution
                               // count; 0: the body's own
} duet_body;

DUET_API duet_body duet_default_body(void); // at rest, mass 1, friction 0, all groups

// The position and velocities of a body. In 2D only z of rotation and angular velocity count.
typedef struct duet_state {
    double centre[3];
    double rotation[4]; // quaternion of length 1
    double velocity[3];
    double angular_velocity[3];
} duet_state;

typedef enum duet_boundary {
    DUET_BOUNDARY_NONE,
    DUET_BOUNDARY_WALLS,   // lower and upper are walls
    DUET_BOUNDARY_PERIODIC // a body that leaves on one side comes in on the other
} duet_boundary;

typedef enum duet_integrator {
    DUET_INTEGRATOR_EULER,  // semi-implicit, first order
    DUET_INTEGRATOR_VERLET, // second order, symmetric; without contact response
    DUET_INTEGRATOR_YOSHIDA // fourth order, symmetric; without contact response
} duet_integrator;

// How the numbers of two materials become a contact's. If they have different rules, the later
// counts.
typedef enum duet_combine {
    DUET_COMBINE_AVERAGE,
    DUET_COMBINE_GEOMETRIC_MEAN,
    DUET_COMBINE_MIN,
    DUET_COMBINE_PRODUCT,
    DUET_COMBINE_MAX
} duet_combine;

typedef struct duet_material {
    float friction;    // >= 0
    float restitution; // 0 .. 1
    duet_combine friction_rule;
    duet_combine restitution_rule;
} duet_material;

// The numbers of two materials together, whatever their rules say.
typedef struct duet_material_pair {
    uint32_t a, b; // 1 .. n_materials, in any order, and equal for a material with itself
    float friction;
    float restitution;
} duet_material_pair;

enum { DUET_MATERIALS = 16, DUET_MATERIAL_PAIRS = 120 };

// A ground: a grid of heights in 3D. The cell with the places i and j as its lowest corner lies
// between them and i + 1, j + 1; the line between these two corners divides it into two triangles.
// Space below them is solid, and beside the grid there is no ground.
typedef struct duet_heights {
    uint32_t nx; // heights along x and along y, each at least 2
    uint32_t ny;
    double origin[3];     // position of place 0, 0; its z is added to all heights
    double spacing[2];    // between places, along x and y
    const float *heights; // [ny][nx]
    uint32_t material;    // 1 .. n_materials of the def; 0: contacts have what the body has
} duet_heights;

// A ground has at most so many heights.
#define DUET_MOST_HEIGHTS (1u << 26)

// A ground of any shape in 3D: triangles whose corners are seen counterclockwise from outside.
// Space behind them is solid; a triangle holds what has its centre in front of it.
typedef struct duet_mesh {
    uint32_t n_vertices;
    uint32_t n_triangles;      // 1 or more
    double origin[3];          // position of the vertices' 0
    const float *vertices;     // [n_vertices][3] of which some may lie at one place
    const uint32_t *triangles; // [n_triangles][3] numbers of vertices, from 0 on
    uint32_t material;         // 1 .. n_materials of the def; 0: contacts have what the body has
    uint32_t carrier; // 1 + the id of a body without mass and radius that carries the mesh: the
                      // origin is seen from its centre, along its axes; 0: the mesh never moves
} duet_mesh;

// A mesh has at most so many triangles, and three times as many vertices.
#define DUET_MOST_TRIANGLES (1u << 24)

typedef struct duet_motion_def {
    duet_device_pair *pair; // held; B has the state, both find pairs
    duet_plan plan;         // how pairs are found, and B's kernels (duet_motion_set_plan)
    uint32_t dims;          // 2 or 3
    uint32_t wants;         // effects besides those that the objects call for
    bool doubles;           // keeps the state in double
    double origin[3];       // position of the poses' 0; far away needs doubles, or origin cells
    float origin_edge;      // above 0: keeps the state in origin cells of that edge, a power of two
    double gravity[3];      // acceleration
    double attraction;      // not 0: accelerates by attraction / distance^2 towards `centre`
    double centre[3];
    double drag; // a velocity falls by the factor e in 1 / drag seconds
    duet_boundary boundary;
    double lower[3]; // corners of the world's box
    double upper[3];
    double dt;
    uint32_t substeps; // parts of a step; 0: chosen for what stands at the start (4 to 32)
    duet_integrator integrator;
    double skin;                  // > 0: grows bounds by that much, so that the grid lasts
    double slop;                  // contacts are kept up to 4 slops apart; 0: from objects' sizes
    double max_push_speed;        // greatest speed at which overlap is resolved
    double restitution_threshold; // impacts below this speed do not bounce
    double sleep_speed;           // slower bodies rest; faster ones lose twice that time of rest
    double sleep_after;  // seconds of rest before a body sleeps, unless a moving one touches it
    double hit_speed;    // > 0: reports impacts above that speed as hits
    uint32_t event_mask; // reports events if a bit of it is in the group of one of the two bodies
    const duet_heights *heights; // the ground, copied; NULL: none
    const duet_mesh *mesh;       // the ground as triangles, likewise; one of both is NULL
    bool stage_times;            // times every step by stages; otherwise a GPU times one in 16
    uint32_t n_materials;        // at most 15: those that bodies can name
    duet_material materials[DUET_MATERIALS]; // [1] is the first; [0] is not read
    uint32_t n_material_pairs;
    duet_material_pair material_pairs[DUET_MATERIAL_PAIRS]; // the last of equal pairs counts
    int cookie;
} duet_motion_def;

DUET_API duet_motion_def duet_default_motion_def(void); // 60 steps a second

// Makes a def for an ordinary game in metres, kilograms and seconds, with z up, in 2D y: a
// gravity of 9.81, a slop of 5 mm, and in wants all that its bodies may call for at any time, even
// if none does at first: contact response with friction, turning and fast bodies, groups and
// masks, sleep, forces, sensors and events. wants has no radii: if bodies with radii come
// later, add DUET_EFFECT_RADIUS. dims is 2 or 3.
DUET_API duet_motion_def duet_game_motion_def(duet_device_pair *pair, uint32_t dims);

// Objects that move.
typedef struct duet_motion duet_motion;

// Makes a def of what the scene says about motion; the default def for NULL.
DUET_API duet_motion_def duet_scene_motion_def(const duet_scene *scene, duet_device_pair *pair);
// Returns the scene's bodies [n], the scene's; NULL: it describes none.
DUET_API const duet_body *duet_scene_get_bodies(const duet_scene *scene);

// Creates a motion of n poses and bodies, which it copies. bodies NULL: duet_default_body each.
// BAD_ARGUMENT names the def's field, BAD_OBJECT the object that is wrong, and what is expected.
DUET_API duet_motion *duet_motion_create(const duet_motion_def *def, const duet_pose *poses,
                                         const duet_body *bodies, uint32_t n, duet_error *err);
// Creates a motion of a scene's objects, in its origin cells if it has them. bodies NULL: the
// scene's bodies. Radii are always the scene's.
DUET_API duet_motion *duet_motion_create_from_scene(const duet_motion_def *def,
                                                    const duet_scene *scene,
                                                    const duet_body *bodies, duet_error *err);
DUET_API void duet_motion_destroy(duet_motion *motion);

// A contact that began or ended, a < b. Two objects touch in a step if one of their contact's
// points overlaps or pushes. Walls are objects, too: n + 2 k is the lower and n + 2 k + 1 the
// upper wall of axis k, and n + 6 the ground.
typedef struct duet_event {
    uint32_t a;
    uint32_t b;
    bool begins;
} duet_event;

// An impact: two objects that push came together faster than hit_speed, a < b.
typedef struct duet_hit_event {
    uint32_t a;
    uint32_t b;
    double point[3]; // position of the contact's fastest point
    float normal[3]; // from a to b
    float speed;     // along the normal, when the step began
    float impulse;   // along the normal, the greatest of a substep, of all points
} duet_hit_event;

// The findings of a step. Its memory is the motion's and lasts until the next step.
typedef struct duet_motion_result {
    uint64_t step;            // steps since the start
    double time;              // step * dt
    uint64_t pairs;           // pairs that may touch
    uint64_t contacts;        // contacts that push
    uint32_t colours;         // colours of the contact graph: rounds of a solution
    bool rebuilt;             // this step searched pairs
    const duet_event *events; // [n_events] begins and ends, ascending by a and b
    uint64_t n_events;
    const duet_pair *stays; // [n_stays] pairs that touch as in the last step, ascending
    uint64_t n_stays;
    const duet_hit_event *hits; // [n_hits] ascending by a and b
    uint64_t n_hits;
    double total_ms;
    const duet_stage *stages; // [n_stages] named by effect
    uint32_t n_stages;
    bool timed; // the stages are of this step; otherwise of the last one that was timed
} duet_motion_result;

// Advances all objects by dt. After a failure half a step may be done: the motion can then be
// destroyed, or mended by loading a saved motion into it; until then the calls below that
// take an error are BAD_ARGUMENT.
DUET_API bool duet_motion_advance(duet_motion *motion, duet_motion_result *result, duet_error *err);

// Advance in two halves: begin returns at once, and a thread of Duet's own carries the step while
// the caller does other things; end waits for it and returns the step's result or failure. Between
// the two, duet_motion_destroy waits, duet_motion_get_plan is NULL, effects, count, step, def, ids
// and duet_motion_has_body are those before the step, and all other calls on the motion are
// BAD_ARGUMENT: give commands before or after. begin ends the arrays of an earlier result.
DUET_API bool duet_motion_advance_begin(duet_motion *motion, duet_error *err);
DUET_API bool duet_motion_advance_end(duet_motion *motion, duet_motion_result *result,
                                      duet_error *err);

DUET_API uint32_t duet_motion_get_effects(const duet_motion *motion); // bits of duet_effect
// Returns the plan of its steps, the motion's; NULL if it finds no pairs, or during a step.
DUET_API const duet_plan *duet_motion_get_plan(const duet_motion *motion);
// Sets the plan of the following steps; the state has the same bits by any plan. variant_b may
// also set LANES, WG and PER_ITEM of the kernels in kernels/dynamics, by their names, and the skin
// in percent of the bodies' mean least extent: "auto solve_contacts.WG=64 motion.skin=20". After a
// failure the plan is as before.
DUET_API bool duet_motion_set_plan(duet_motion *motion, const duet_plan *plan, duet_error *err);

// Gives the motion the best plan known for bodies that lie like its own at the start, and for its
// effects, substeps and devices. path and failures are as in duet_world_load_profile. The state
// has the same bits by any plan. A profile of another number of bodies gives its plan alone:
// step_ms and gain are then 0 and verdict is empty. BAD_ARGUMENT for a motion without bodies or
// effects.
DUET_API bool duet_motion_load_profile(duet_motion *motion, const char *path, duet_profile *profile,
                                       duet_error *err);

DUET_API uint32_t duet_motion_get_count(const duet_motion *motion);
DUET_API uint64_t duet_motion_get_step(const duet_motion *motion); // steps since the start

// Copies the states of all objects to states [n]. BAD_OBJECT if a number is no longer finite;
// the states are copied all the same.
DUET_API bool duet_motion_get_states(duet_motion *motion, duet_state *states, duet_error *err);

// Copies the states of the objects at places [n] to states [n]; no others leave the device. A
// place is the object's id as long as no body came or went. BAD_ARGUMENT names the first invalid
// place.
DUET_API bool duet_motion_get_states_of(duet_motion *motion, const uint32_t *places, uint32_t n,
                                        duet_state *states, duet_error *err);

typedef struct duet_moved {
    const uint32_t *places;   // [n] ascending
    const duet_state *states; // [n]
    uint32_t n;
} duet_moved;

// Gets the objects whose centre or rotation changed since the last call; all objects the
// first time, and after bodies came or went. The memory is the motion's and lasts until the
// next call.
DUET_API bool duet_motion_get_moved(duet_motion *motion, duet_moved *moved, duet_error *err);

// Interpolates two steps' states, for drawing: fraction 0 gives `from`, 1 gives `to`.
// The rotation takes the shorter way. Not for bodies that cross the seam of a periodic world.
DUET_API duet_state duet_state_between(const duet_state *from, const duet_state *to,
                                       double fraction);

// Copies the poses of all objects to poses [n], as a tree or a world takes them; a body with
// a radius has the pose of its core. A state in double or in origin cells is rounded to float.
DUET_API bool duet_motion_get_poses(duet_motion *motion, duet_pose *poses, duet_error *err);

// Copies poses and radii of all objects to boxes [n], rounded likewise.
DUET_API bool duet_motion_get_rounded_boxes(duet_motion *motion, duet_rounded_box *boxes,
                                            duet_error *err);

// Copies which objects sleep to asleep [n]: 1 or 0, as the last step left them; all 0 without the
// effect sleep.
DUET_API bool duet_motion_get_asleep(duet_motion *motion, uint8_t *asleep, duet_error *err);

// Sums the state's bits: the hash is equal on all devices, at any share and in any mode.
DUET_API bool duet_motion_get_hash(duet_motion *motion, uint64_t *hash, duet_error *err);

typedef struct duet_energy {
    double kinetic; // energy of the motion of objects with a mass
    double turning; // energy of their rotation
    double potential;
    double momentum[3];
    double angular[3]; // angular momentum about the origin
} duet_energy;

DUET_API bool duet_motion_get_energy(duet_motion *motion, duet_energy *energy, duet_error *err);

// The contact of two objects in the last step.
typedef struct duet_contact {
    uint32_t a, b;   // a has a mass, or is a sensor; b may be below a, or a wall as in duet_event;
                     // a body has a contact with the ground for each direction, up to four
    float normal[3]; // from a to b
    uint32_t n;      // points, 1 .. 4
    struct {
        float anchor[3];      // from a's centre
        float separation;     // below 0: depth
        float normal_impulse; // impulse of the last substep, with contact response
    } points[4];
} duet_contact;

// Copies the last step's contacts, ascending. The caller frees *contacts with duet_free.
DUET_API bool duet_motion_get_contacts(duet_motion *motion, duet_contact **contacts, uint64_t *n,
                                       duet_error *err);

// Saves a motion as a file, or loads it: the loaded motion goes on bit for bit as the saved one
// does, on the saved one's ground. Objects, bodies and def must be those of the saved motion,
// but for its skin; a motion without a ground loads no file with one, nor the reverse. BAD_INPUT
// if the file holds what this motion could not have saved; files may come from anyone. After a
// failure the motion is as before.
DUET_API bool duet_motion_save(duet_motion *motion, const char *path, duet_error *err);
DUET_API bool duet_motion_load(duet_motion *motion, const char *path, duet_error *err);

// One effect of a motion, as duet explain shows it.
typedef struct duet_effect_info {
    const char *name;
    bool active;
    const char *called_by; // names what calls for it, or would
    const char *kernels;   // kernels that have code for it
    uint32_t bytes;        // bytes of state an object, on B
} duet_effect_info;

// How many substeps a motion has, and why.
typedef struct duet_substep_info {
    uint32_t substeps;
    bool chosen; // the def left them to the motion
    uint32_t
        layers;  // if chosen: bodies on each other in the column that decides; 0: nothing stands
    double edge; // if chosen: the column's least width^2 / height; of one that leans the width is
                 // twice the way from where its weight presses to the rim of what bears it
} duet_substep_info;

DUET_API bool duet_motion_explain_substeps(const duet_motion *motion, duet_substep_info *info);

// Gets effect i, and after the last effect how positions are kept ("origin"); false past that.
DUET_API bool duet_motion_explain(const duet_motion *motion, uint32_t i, duet_effect_info *info);

DUET_C_END

#endif
