// SPDX-License-Identifier: MIT
// A thrower: twice a second a ball of the game's flies at a wall of crates, and balls that
// are two seconds old go again. Bodies come and go while the motion runs.
#include <duet/duet.h>

#include <stdio.h>

enum { WIDE = 6, HIGH = 5, CRATES = WIDE * HIGH, FRAMES = 300, BETWEEN = 30, LIFE = 120 };
enum { BALLS = LIFE / BETWEEN };

static void build_wall(duet_pose *poses, duet_body *bodies)
{
    const duet_pose ground = {{0, 0, -0.5f}, {20, 20, 0.5f}, {0, 0, 0, 1}};
    poses[CRATES] = ground;
    bodies[CRATES] = duet_default_body();
    bodies[CRATES].mass = 0; // nothing moves the ground
    for (int i = 0; i < CRATES; ++i) {
        const duet_pose crate = {
            {0, (float)(i % WIDE) - 2.5f, (float)(i / WIDE) + 0.5f},
            {0.5f, 0.49f, 0.5f},
            {0, 0, 0, 1},
        };
        poses[i] = crate;
        bodies[i] = duet_default_body();
    }
    for (int i = 0; i <= CRATES; ++i)
        bodies[i].friction = 0.5f;
}

static bool throw_ball(duet_motion *motion, int number, uint64_t *id, duet_error *err)
{
    const duet_pose at = {{-8, (float)(number % 5) - 2, 2}, {0.3f, 0.3f, 0.3f}, {0, 0, 0, 1}};
    duet_body ball = duet_default_body();
    ball.velocity[0] = 15;
    ball.velocity[2] = 2;
    ball.mass = 3;
    ball.friction = 0.5f;
    return duet_motion_add_bodies(motion, &at, &ball, 1, id, err);
}

// The oldest ball goes, and a new one takes its turn.
static bool play(duet_motion *motion, uint64_t balls[BALLS], int frame, duet_error *err)
{
    int number = frame / BETWEEN;
    uint64_t *ball = &balls[number % BALLS];
    const duet_body_list oldest = {ball, 0, 1};
    if (frame % BETWEEN != 0)
        return true;
    return (number < BALLS || duet_motion_remove_bodies(motion, oldest, err)) &&
           throw_ball(motion, number, ball, err);
}

static int count_fallen(const duet_state *states)
{
    int n = 0;
    for (int i = 0; i < CRATES; ++i)
        n += states[i].centre[0] > 0.6;
    return n;
}

int main(void)
{
    duet_pose poses[CRATES + 1];
    duet_body bodies[CRATES + 1];
    duet_state states[CRATES + 1 + 2 * BALLS];
    uint64_t balls[BALLS];
    duet_error err = {0};
    build_wall(poses, bodies);
    duet_device_pair_def devices = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&devices, &err);
    duet_motion_def def = duet_game_motion_def(pair, 3); // z is up
    duet_motion *motion = pair ? duet_motion_create(&def, poses, bodies, CRATES + 1, &err) : NULL;
    duet_motion_result result;
    bool ok = motion != NULL;
    for (int frame = 0; ok && frame < FRAMES; ++frame)
        ok = play(motion, balls, frame, &err) && duet_motion_advance(motion, &result, &err);
    ok = ok && duet_motion_get_states(motion, states, &err);
    if (ok)
        printf("%d balls in %u places; %s\n", FRAMES / BETWEEN,
               duet_motion_get_count(motion) - CRATES - 1,
               count_fallen(states) > 0 ? "the wall is broken" : "the wall stands");
    else
        fprintf(stderr, "%s\n", err.text);
    duet_motion_destroy(motion);
    duet_device_pair_destroy(pair);
    return ok ? 0 : 1;
}
