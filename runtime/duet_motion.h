// SPDX-License-Identifier: MIT
// Motions: objects that move, touch and sleep.
#ifndef DUET_MOTION_H
#define DUET_MOTION_H

#include "duet_world.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// What a scene can call for. A motion runs those that its objects and its def
// call for and nothing else: docs/effects.md says by what each is called for.
typedef enum duet_effect {
    DUET_EFFECT_ROTATION = 1u << 0,         // orientation matters
    DUET_EFFECT_MOTION = 1u << 1,           // objects have velocities
    DUET_EFFECT_ANGULAR_VELOCITY = 1u << 2, // and turn
    DUET_EFFECT_GRAVITY = 1u << 3,          // uniform, or towards a point
    DUET_EFFECT_DRAG = 1u << 4,             // velocities decay
    DUET_EFFECT_BOUNDARY = 1u << 5,         // walls, or a world that repeats itself
    DUET_EFFECT_CONTACT = 1u << 6,          // where objects touch
    DUET_EFFECT_CONTACT_RESPONSE = 1u << 7, // contacts push, and bounce
    DUET_EFFECT_FRICTION = 1u << 8,         // contacts have friction
    DUET_EFFECT_CONTINUOUS = 1u << 9,       // fast bodies do not tunnel through thin ones
    DUET_EFFECT_FILTER = 1u << 10,          // groups and masks
    DUET_EFFECT_SLEEP = 1u << 11,           // what rests leaves the work
    DUET_EFFECT_SKIN = 1u << 12,            // the grid lasts until something leaves its skin
    DUET_EFFECT_EVENTS = 1u << 13,          // contacts that begin, stay and end, and hits
    DUET_EFFECT_FORCES = 1u << 14,          // commands push (duet_motion_commands.h)
    DUET_EFFECT_SENSORS = 1u << 15,         // bodies that touch without pushing
    DUET_EFFECT_RADIUS = 1u << 16,          // bodies have radii: spheres, capsules, rounded boxes
    DUET_EFFECT_ALL = (1u << 17) - 1
} duet_effect;

DUET_API const char *duet_effect_name(uint32_t effect); // one bit: "rotation"; NULL for others

// What an object is besides its pose.
typedef struct duet_body {
    float velocity[3];         // of the centre, a second
    float angular_velocity[3]; // angular velocity, radians a second, along the world's axes
    float mass;                // 0: nothing changes its velocity
    float restitution;         // what of an impact's speed comes back, 0 .. 1
    float friction;            // >= 0; a contact has the geometric mean of its two objects'
    uint32_t group;            // two objects can touch where each one's group has a bit
    uint32_t mask;             // of the other's mask
    float radius;              // >= 0; the body is all that is so near to the pose's box
    bool fixed_rotation;       // never turned by others
    bool sensor;               // what touches it is told as events, and not pushed
} duet_body;

DUET_API duet_body duet_default_body(void); // at rest, mass 1, friction 0, all groups

// Where an object is and how it moves. In 2D only z of rotation and angular velocity count.
typedef struct duet_state {
    double centre[3];
    double rotation[4]; // of length 1
    double velocity[3];
    double angular_velocity[3];
} duet_state;

typedef enum duet_boundary {
    DUET_BOUNDARY_NONE,
    DUET_BOUNDARY_WALLS,   // lower and upper are walls
    DUET_BOUNDARY_PERIODIC // what leaves on one side comes in on the other
} duet_boundary;

typedef enum duet_integrator {
    DUET_INTEGRATOR_EULER,  // semi-implicit, first order
    DUET_INTEGRATOR_VERLET, // second order, symmetric; without contact response
    DUET_INTEGRATOR_YOSHIDA // fourth order, symmetric; without contact response
} duet_integrator;

typedef struct duet_motion_def {
    duet_device_pair *pair; // held; B has the state, both find pairs
    duet_plan plan;         // how pairs are found, and B's kernels (duet_motion_set_plan)
    uint32_t dims;          // 2 or 3
    uint32_t wants;         // effects asked for besides those that the objects call for
    bool doubles;           // the state is in double
    double origin[3];       // where the poses' 0 lies; far away needs doubles, or origin cells
    float origin_edge;      // above 0: the state is in origin cells of that edge, a power of two
    double gravity[3];      // an acceleration
    double attraction;      // not 0: attraction / distance^2 towards the point `centre`
    double centre[3];
    double drag; // a velocity falls by the factor e in 1 / drag seconds
    duet_boundary boundary;
    double lower[3]; // the world's box
    double upper[3];
    double dt;
    uint32_t substeps;
    duet_integrator integrator;
    double skin;                  // > 0: how far bounds are grown so that the grid lasts
    double slop;                  // contacts are kept to 4 slops apart; 0: from the objects' sizes
    double max_push_speed;        // greatest speed at which overlap is resolved
    double restitution_threshold; // impacts below it do not bounce
    double sleep_speed;  // what is slower rests, and what is faster takes back twice the time
    double sleep_after;  // seconds of rest: sleeps, if nothing that moves touches it
    double hit_speed;    // > 0: impacts above that speed are told as hits
    uint32_t event_mask; // events are those of objects, one of the two, whose group has a bit of it
    bool stage_times;    // every step is timed by stages; else, on a GPU, one in 16
    int cookie;
} duet_motion_def;

DUET_API duet_motion_def duet_default_motion_def(void); // 60 steps a second, 4 substeps

// The same for an ordinary game in metres, kilograms and seconds, of which z is up, in 2D y: a
// gravity of 9.81, a slop of 5 mm, and in wants what its bodies may call for at any time, even if
// there are none at first: contact response with friction, turning and fast bodies, groups and
// masks, sleep, forces, sensors and events. Radii are not in it: where bodies with some come only
// later, add DUET_EFFECT_RADIUS to wants. dims is 2 or 3.
DUET_API duet_motion_def duet_game_motion_def(duet_device_pair *pair, uint32_t dims);

// Objects that move.
typedef struct duet_motion duet_motion;

// A def with what the scene says of motion, the default one for NULL, and its objects'
// bodies: [n], or NULL where nothing is said of any.
DUET_API duet_motion_def duet_scene_motion_def(const duet_scene *scene, duet_device_pair *pair);
DUET_API const duet_body *duet_scene_get_bodies(const duet_scene *scene);

// Copies n poses and bodies (NULL: duet_default_body each). BAD_ARGUMENT names
// the field of the def, BAD_OBJECT the object, that is wrong and what would be
// right.
DUET_API duet_motion *duet_motion_create(const duet_motion_def *def, const duet_pose *poses,
                                         const duet_body *bodies, uint32_t n, duet_error *err);
// The same of a scene's objects, in its origin cells where it has some. bodies
// NULL: those that the scene gives. Radii are the scene's.
DUET_API duet_motion *duet_motion_create_from_scene(const duet_motion_def *def,
                                                    const duet_scene *scene,
                                                    const duet_body *bodies, duet_error *err);
DUET_API void duet_motion_destroy(duet_motion *motion);

// Two objects touch in a step if a point of theirs overlaps or pushes. A contact that began
// to touch or ended, a < b; a wall 2 k or 2 k + 1, the lower or upper one of axis k, is
// object n + 2 k or n + 2 k + 1.
typedef struct duet_event {
    uint32_t a;
    uint32_t b;
    bool begins;
} duet_event;

// An impact: two objects that push came together faster than hit_speed, a < b.
typedef struct duet_hit_event {
    uint32_t a;
    uint32_t b;
    double point[3]; // of the world: the fastest point of the contact
    float normal[3]; // from a to b
    float speed;     // along the normal, when the step began
    float impulse;   // along the normal, the greatest of a substep, of all points
} duet_hit_event;

// What a step did. Its memory is the motion's and lasts until the next step.
typedef struct duet_motion_result {
    uint64_t step;            // steps since the start
    double time;              // step * dt
    uint64_t pairs;           // that may touch
    uint64_t contacts;        // that push
    uint32_t colours;         // rounds of a solution
    bool rebuilt;             // pairs were searched in this step
    const duet_event *events; // that begin and end, ascending by a and b
    uint64_t n_events;
    const duet_pair *stays; // that touch, and did so in the last step; likewise
    uint64_t n_stays;
    const duet_hit_event *hits; // likewise
    uint64_t n_hits;
    double total_ms;
    const duet_stage *stages; // named by effect
    uint32_t n_stages;
    bool timed; // the stages are of this step; else of the last that was timed
} duet_motion_result;

// Advances all objects by dt. After a failure half a step may be done: until a saved
// motion is loaded into it, the motion can only be destroyed, and the calls below that
// take an error are BAD_ARGUMENT.
DUET_API bool duet_motion_advance(duet_motion *motion, duet_motion_result *result, duet_error *err);

// A step in two halves: begin returns at once and a thread of Duet's own carries the step, while
// the caller does other things; end waits for it, and is the step's result or failure. Between the
// two duet_motion_destroy waits, duet_motion_get_plan is NULL, effects, count, step, def, ids and
// duet_motion_has_body are those before the step, and all other calls that take the motion are
// BAD_ARGUMENT: commands come before or after. The arrays of an earlier result are gone.
DUET_API bool duet_motion_advance_begin(duet_motion *motion, duet_error *err);
DUET_API bool duet_motion_advance_end(duet_motion *motion, duet_motion_result *result,
                                      duet_error *err);

DUET_API uint32_t duet_motion_get_effects(const duet_motion *motion); // bits of duet_effect
// The plan of its steps, the motion's; NULL where it finds no pairs, or a step is under way.
DUET_API const duet_plan *duet_motion_get_plan(const duet_motion *motion);
// Steps by another plan from now on, with the same bits. variant_b may set LANES, WG and PER_ITEM
// of the kernels in kernels/dynamics as well, by their names, and the skin in percent of the
// bodies' mean least extent: "auto solve_contacts.WG=64 motion.skin=20". After a failure the plan
// is as before.
DUET_API bool duet_motion_set_plan(duet_motion *motion, const duet_plan *plan, duet_error *err);

// Gives the motion the best plan that is known for bodies that lie so at the start, effects,
// substeps and devices such as its own, as duet_world_load_profile does; its state has the same
// bits by any. Of a motion with other many bodies the plan alone is taken: step_ms, gain and
// verdict are then 0 and empty. BAD_ARGUMENT for a motion without bodies or effects.
DUET_API bool duet_motion_load_profile(duet_motion *motion, const char *path, duet_profile *profile,
                                       duet_error *err);

DUET_API uint32_t duet_motion_get_count(const duet_motion *motion);
DUET_API uint64_t duet_motion_get_step(const duet_motion *motion); // steps since the start

// Copies the state of all objects to states [n]. BAD_OBJECT where a number of it is no
// longer finite; the states are copied all the same.
DUET_API bool duet_motion_get_states(duet_motion *motion, duet_state *states, duet_error *err);

// Copies the states of the objects in these places, which are their ids where no body came or
// went, to states [n]; no others travel. BAD_ARGUMENT names the first place that is none.
DUET_API bool duet_motion_get_states_of(duet_motion *motion, const uint32_t *places, uint32_t n,
                                        duet_state *states, duet_error *err);

typedef struct duet_moved {
    const uint32_t *places; // [n] ascending
    const duet_state *states;
    uint32_t n;
} duet_moved;

// The objects whose centre or rotation changed since this was called last; all of them the
// first time, and after bodies came or went. Their memory is the motion's and lasts until the
// next call.
DUET_API bool duet_motion_get_moved(duet_motion *motion, duet_moved *moved, duet_error *err);

// A state from one step's to the next one's, for drawing: fraction 0 is from, and 1 is to.
// The rotation takes the shorter way. At the seam of a periodic world it is not to be used.
DUET_API duet_state duet_state_between(const duet_state *from, const duet_state *to,
                                       double fraction);

// Copies where all objects are to poses [n], as a tree or a world takes them, of bodies with
// radii the cores: in floats, to which a state in double or in origin cells is rounded.
DUET_API bool duet_motion_get_poses(duet_motion *motion, duet_pose *poses, duet_error *err);

// The same with the bodies' radii.
DUET_API bool duet_motion_get_rounded_boxes(duet_motion *motion, duet_rounded_box *boxes,
                                            duet_error *err);

// A sum over the state's bits, equal on all devices, at any share and in any
// split mode.
DUET_API bool duet_motion_get_hash(duet_motion *motion, uint64_t *hash, duet_error *err);

typedef struct duet_energy {
    double kinetic; // of objects with a mass
    double turning; // of their rotation
    double potential;
    double momentum[3];
    double angular[3]; // momentum about the origin
} duet_energy;

DUET_API bool duet_motion_get_energy(duet_motion *motion, duet_energy *energy, duet_error *err);

// Where two objects touched in the last step.
typedef struct duet_contact {
    uint32_t a, b;   // a has a mass, or is a sensor; b may be below a, or a wall as in duet_event
    float normal[3]; // from a to b
    uint32_t n;      // points, 1 .. 4
    struct {
        float anchor[3];      // from a's centre
        float separation;     // below 0: depth
        float normal_impulse; // of the last substep, with contact response
    } points[4];
} duet_contact;

// Copies those contacts; the caller frees *contacts with duet_free. They are
// ascending.
DUET_API bool duet_motion_get_contacts(duet_motion *motion, duet_contact **contacts, uint64_t *n,
                                       duet_error *err);

// A motion as a file: advanced after loading, it goes on bit for bit as the
// saved one does. Objects, bodies and def must be those of the saved motion.
// BAD_INPUT where the file says what this motion could not have saved; files may come
// from anyone. After a failure the motion is as before.
DUET_API bool duet_motion_save(duet_motion *motion, const char *path, duet_error *err);
DUET_API bool duet_motion_load(duet_motion *motion, const char *path, duet_error *err);

// One effect of a motion, as duet explain shows it.
typedef struct duet_effect_info {
    const char *name;
    bool active;
    const char *called_by; // what calls for it, or would
    const char *kernels;   // those that have code for it
    uint32_t bytes;        // of state an object, on B
} duet_effect_info;

// Effect i, and after the last one how positions are kept ("origin"); false past that.
DUET_API bool duet_motion_explain(const duet_motion *motion, uint32_t i, duet_effect_info *info);

DUET_C_END

#endif
