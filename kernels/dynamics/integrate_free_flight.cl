// SPDX-License-Identifier: MIT
// Free flight: a whole step of each object, all substeps at once.
//
// Invariant: objects know nothing of each other here, so a work-item may take any of them.
//
//   ORDER 1   semi-implicit Euler: kick, drift
//   ORDER 2   symmetric: half a drift is on both sides of turn and drag, half a kick around all
//   ORDER 4   three of those with Yoshida's times, the middle one backward
//
//   times  a substep's length, and of ORDER 4 the outer and the inner part
//   drags  what of a velocity is left after each, or after half of it (ORDER > 1)
#define EULER (ORDER == 1)

typedef struct {
    ARG_FIELDS
} flight;

typedef struct {
    real4 centre;
    real4 velocity; // w: inverse mass
    real4 moved;    // with EULER: since the step began, as a solved step has it
    real4 acceleration; // by FORCES
    // With ANGULAR_VELOCITY:
    real4 rotation;
    real4 turned; // with EULER: since the step began
    real4 angular_velocity;
    real4 angular_acceleration; // by the torques of FORCES, as the step begins
    real4 inverse_inertia;      // along the body's own axes; 0: never turned
    bool tumbles;               // with GYRO: turns otherwise than steadily
} body;

// gravity.w / distance^2 towards a point.
static inline real4 attraction_at(real4 centre, real4 gravity, real4 moved)
{
    real4 to = gravity - centre - moved;
    to.w = 0;
    real r = inverse_root(dot_product(to, to) + (real)1e-20);
    return to * (gravity.w * r * r * r);
}

static inline void fall(body *b, const flight *f, real time)
{
    if (GRAVITY == 0 || !(b->velocity.w > 0))
        return;
    real4 acceleration = (real4)(f->gravity.xyz, 0);
    if (GRAVITY == 2)
        acceleration = attraction_at(b->centre, f->gravity, EULER ? b->moved : (real4)(0));
    b->velocity = add_scaled(b->velocity, time, acceleration);
}

static inline void accelerate(body *b, real time)
{
    if (!FORCES)
        return;
    b->velocity = add_scaled(b->velocity, time, b->acceleration);
    if (ANGULAR_VELOCITY)
        b->angular_velocity = add_scaled(b->angular_velocity, time, b->angular_acceleration);
}

static inline void move(body *b, real time)
{
    real4 velocity = (real4)(b->velocity.xyz, 0);
    if (EULER)
        b->moved = add_scaled(b->moved, time, velocity);
    else
        b->centre = add_scaled(b->centre, time, velocity);
}

static inline void drag_body(body *b, real drag)
{
    if (!DRAG || !(b->velocity.w > 0))
        return;
    b->velocity.xyz *= drag;
    if (ANGULAR_VELOCITY)
        b->angular_velocity *= drag;
}

static inline void tumble(body *b, real time)
{
    if (!EULER) {
        free_rotation(&b->rotation, &b->angular_velocity, b->inverse_inertia, time);
        return;
    }
    real4 rotation = normalised(quaternion_product(b->turned, b->rotation));
    free_rotation(&rotation, &b->angular_velocity, b->inverse_inertia, time);
    b->turned = quaternion_product(rotation, conjugate(b->rotation));
}

static inline void rotate_body(body *b, real time)
{
    if (!ANGULAR_VELOCITY || (b->angular_velocity.x == 0 && b->angular_velocity.y == 0 && b->angular_velocity.z == 0))
        return;
    if (GYRO && b->tumbles) {
        tumble(b, time);
        return;
    }
    real4 turn = exponential(b->angular_velocity * time);
    if (EULER)
        b->turned = normalised(quaternion_product(turn, b->turned));
    else
        b->rotation = turned_by(b->rotation, turn);
}

static inline void advance_euler(body *b, const flight *f, real time)
{
    fall(b, f, time);
    accelerate(b, time);
    drag_body(b, f->drags.x);
    move(b, time);
    rotate_body(b, time);
}

static inline void advance_symmetric(body *b, const flight *f, real drag, real time)
{
    real half_time = (real)0.5 * time;
    fall(b, f, half_time);
    accelerate(b, half_time);
    move(b, half_time);
    drag_body(b, drag);
    rotate_body(b, time);
    drag_body(b, drag);
    move(b, half_time);
    accelerate(b, half_time);
    fall(b, f, half_time);
}

static inline void advance(body *b, const flight *f)
{
    if (EULER) {
        advance_euler(b, f, f->times.x);
        return;
    }
    advance_symmetric(b, f, f->drags.x, f->times.x);
    if (ORDER < 4)
        return;
    advance_symmetric(b, f, f->drags.y, f->times.y);
    advance_symmetric(b, f, f->drags.x, f->times.x);
}

// A wall is a mirror for what would be outside.
static inline void mirror_in_wall(real *at, real *speed, real lower, real upper)
{
    if (*at < lower) {
        *at = 2 * lower - *at;
        *speed = fabs(*speed);
    }
    if (*at > upper) {
        *at = 2 * upper - *at;
        *speed = -fabs(*speed);
    }
}

static inline void stay_between_walls(body *b, const flight *f, uint id)
{
    real4 reach = convert_real4(f->halves[id]);
    if (ROTATED)
        reach = box_reach(ANGULAR_VELOCITY ? b->rotation : f->rotations[id], reach);
    if (ROUNDED)
        reach += (real)f->halves[id].w;
    real4 from = f->lower + reach, to = f->upper - reach;
    mirror_in_wall((real *)&b->centre + 0, (real *)&b->velocity + 0, from.x, to.x);
    mirror_in_wall((real *)&b->centre + 1, (real *)&b->velocity + 1, from.y, to.y);
    if (DIMS == 3)
        mirror_in_wall((real *)&b->centre + 2, (real *)&b->velocity + 2, from.z, to.z);
}

// An object that leaves on one side comes in on the other.
static inline real wrap_periodic(real at, real lower, real upper)
{
    real length = upper - lower;
    at = at < lower ? at + length : at;
    return at >= upper ? at - length : at;
}

static inline void stay_in_period(body *b, const flight *f)
{
    b->centre.x = wrap_periodic(b->centre.x, f->lower.x, f->upper.x);
    b->centre.y = wrap_periodic(b->centre.y, f->lower.y, f->upper.y);
    if (DIMS == 3)
        b->centre.z = wrap_periodic(b->centre.z, f->lower.z, f->upper.z);
}

static inline body load_body(const flight *f, uint id)
{
    body b;
    b.centre = f->centres[id];
    b.velocity = f->velocities[id];
    b.moved = (real4)(0);
    b.turned = (real4)(0, 0, 0, 1);
    if (ANGULAR_VELOCITY) {
        b.rotation = f->rotations[id];
        b.angular_velocity = f->angular_velocities[id];
    }
    if (GYRO) {
        b.inverse_inertia = convert_real4(f->inertias[id]);
        b.tumbles = turns_freely(f->inertias[id]);
    }
    if (FORCES) {
        b.acceleration = convert_real4(f->forces[2 * (size_t)id]) * b.velocity.w;
        b.acceleration.w = 0;
    }
    if (FORCES && ANGULAR_VELOCITY) {
        real4 torque = rotated(conjugate(b.rotation), convert_real4(f->forces[2 * (size_t)id + 1]));
        b.angular_acceleration = rotated(b.rotation, torque * convert_real4(f->inertias[id]));
        b.angular_acceleration.w = 0;
    }
    return b;
}

static inline void store_body(const flight *f, uint id, body *b)
{
    if (EULER)
        b->centre.xyz += b->moved.xyz;
    if (EULER && ANGULAR_VELOCITY)
        b->rotation = turned_by(b->rotation, b->turned);
    if (BOUNDARY == 1)
        stay_between_walls(b, f, id);
    if (BOUNDARY == 2)
        stay_in_period(b, f);
    if (ORIGIN)
        normalize_offset(&b->centre, f->cells + id);
    f->centres[id] = b->centre;
    f->velocities[id] = b->velocity;
    if (ANGULAR_VELOCITY) {
        f->rotations[id] = b->rotation;
        f->angular_velocities[id] = b->angular_velocity;
    }
}

__kernel void integrate_free_flight(INTEGRATE_FREE_FLIGHT_ARGS)
{
    const flight f = {INTEGRATE_FREE_FLIGHT_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        body b = load_body(&f, id);
        for (uint k = 0; k < substeps; ++k)
            advance(&b, &f);
        store_body(&f, id, &b);
    }
}
