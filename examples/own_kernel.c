// SPDX-License-Identifier: MIT
// A kernel of one's own in an application: bodies that attract each other, whose accelerations two
// devices compute by the plan that 'duet tune --task' found. The rest of a step is plain C.
//
//     cc examples/own_kernel.c -o own_kernel $(pkg-config --cflags --libs duet) -lm
//     ./own_kernel examples/tasks/nbody.task.lua [STORE]
#include <duet/duet.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BODIES = 512, STEPS = 20 };

typedef struct vec4 {
    float x, y, z, w;
} vec4;

static vec4 bodies[BODIES]; // w: the mass
static vec4 velocities[BODIES];

static void place_bodies(void)
{
    for (int i = 0; i < BODIES; ++i) {
        float angle = 2.4f * (float)i, radius = 0.05f * sqrtf((float)i);
        bodies[i].x = radius * cosf(angle);
        bodies[i].y = radius * sinf(angle);
        bodies[i].z = 0.1f * sinf(7 * angle);
        bodies[i].w = 1.0f + (float)(i % 3);
    }
}

static void move_bodies(const vec4 *accelerations, float dt)
{
    for (int i = 0; i < BODIES; ++i) {
        velocities[i].x += dt * accelerations[i].x;
        velocities[i].y += dt * accelerations[i].y;
        velocities[i].z += dt * accelerations[i].z;
        bodies[i].x += dt * velocities[i].x;
        bodies[i].y += dt * velocities[i].y;
        bodies[i].z += dt * velocities[i].z;
    }
}

// Bodies that only attract each other keep their momentum, which is 0 at the start.
static double momentum_left(void)
{
    double x = 0, y = 0, z = 0, all = 0;
    for (int i = 0; i < BODIES; ++i) {
        const vec4 v = velocities[i];
        double mass = bodies[i].w;
        x += mass * v.x;
        y += mass * v.y;
        z += mass * v.z;
        all += mass * sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    }
    return sqrt(x * x + y * y + z * z) / all;
}

static duet_task *open_task(duet_device_pair *pair, const char *path, duet_error *err)
{
    char number[16];
    snprintf(number, sizeof number, "%d", BODIES);
    duet_setting setting;
    setting.name = "n";
    setting.value = number;
    duet_task_def def = duet_default_task_def();
    def.pair = pair;
    def.path = path;
    def.settings = &setting;
    def.n_settings = 1;
    return duet_task_create(&def, err);
}

static bool step(duet_task *task, duet_error *err)
{
    duet_task_result result;
    if (!duet_task_set_array(task, "bodies", bodies, BODIES, err) ||
        !duet_task_run(task, &result, err))
        return false;
    const vec4 *found = (const vec4 *)duet_task_get_array(task, "acceleration", NULL, err);
    if (found)
        move_bodies(found, 1e-4f);
    return found;
}

static bool run(duet_task *task, const char *store, duet_error *err)
{
    duet_profile profile;
    duet_error why;
    memset(&why, 0, sizeof why);
    if (!duet_task_load_profile(task, store, &profile, &why))
        fprintf(stderr, "%s\n", why.text); // and the default plan does
    printf("plan: %s, share %.3f\n", duet_grade_name(profile.grade),
           (double)profile.plan.share / DUET_SHARE_ONE);
    place_bodies();
    for (int i = 0; i < STEPS; ++i)
        if (!step(task, err))
            return false;
    printf("%d steps of %d bodies; momentum is kept: %s\n", STEPS, BODIES,
           momentum_left() < 1e-3 ? "yes" : "no");
    return true;
}

int main(int argc, char **argv)
{
    duet_error err;
    memset(&err, 0, sizeof err);
    if (argc < 2) {
        fprintf(stderr, "own_kernel TASK_FILE [STORE]\n");
        return 2;
    }
    duet_device_pair *pair = duet_device_pair_open(NULL, &err);
    duet_task *task = pair ? open_task(pair, argv[1], &err) : NULL;
    bool ok = task && run(task, argc > 2 ? argv[2] : NULL, &err);
    if (!ok)
        fprintf(stderr, "own_kernel: %s\n", err.text);
    duet_task_destroy(task);
    duet_device_pair_destroy(pair);
    return ok ? 0 : 1;
}
