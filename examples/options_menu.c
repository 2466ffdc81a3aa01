// SPDX-License-Identifier: MIT
// An entry of an options menu, "optimise for this computer": measures for ten seconds at most
// which plan is best for boxes like the game's, shows how far it is, and stops when Enter is
// pressed. The result lies in the player's own store, where game_loop.c finds it.
#include <duet/duet.h>
#include <duet/duet_tune.h>

#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { BOXES = 5000, ACROSS = 17 };

// The same as in game_loop.c. A game takes a frame that is like its worst.
static void place_boxes(duet_pose *poses)
{
    for (int i = 0; i < BOXES; ++i) {
        float phase = (float)(i % 97);
        const duet_pose pose = {
            {1.2f * (float)(i % ACROSS) + 0.2f * sinf(phase),
             1.2f * (float)(i / ACROSS % ACROSS) + 0.2f * cosf(phase),
             1.2f * (float)(i / ACROSS / ACROSS)},
            {0.5f, 0.5f, 0.5f},
            {0, 0, sinf(0.5f * phase), cosf(0.5f * phase)},
        };
        poses[i] = pose;
    }
}

static bool is_cancelled(void)
{
    struct pollfd input = {STDIN_FILENO, POLLIN, 0};
    char key;
    return poll(&input, 1, 0) > 0 && read(STDIN_FILENO, &key, 1) == 1;
}

// Called after each trial, often within a frame's time, and while other programs take the cores: a
// game draws its menu here.
static bool show(void *context, const duet_tune_progress *progress)
{
    double budget_seconds = *(const double *)context;
    printf("\r%3.0f %%  %u plans tried, Enter cancels%s%s ",
           fmin(100, 100 * progress->seconds / budget_seconds), progress->trials,
           progress->waiting ? "; " : "", progress->waiting ? progress->waiting : "");
    fflush(stdout);
    return !is_cancelled();
}

// The kernels are those of the default plan: which mode and share are best is known soon.
static bool optimise(duet_device_pair *pair, double budget_seconds, duet_tune_outcome *outcome,
                     duet_error *err)
{
    static duet_pose poses[BOXES];
    const char *variants[] = {"auto"};
    place_boxes(poses);
    duet_scene *scene = duet_scene_create(DUET_OBJECT_POSES, poses, BOXES, 3, 0, err);
    duet_tune_def def = duet_default_tune_def();
    def.pair = pair;
    def.scene = scene;
    def.variants = variants;
    def.n_variants = 1;
    def.budget_seconds = budget_seconds;
    def.watch = show;
    def.watch_context = &budget_seconds;
    bool ok = scene && duet_tune_run(&def, outcome, err);
    duet_scene_destroy(scene);
    return ok;
}

int main(int argc, char **argv)
{
    duet_error err = {0};
    duet_tune_outcome outcome;
    duet_device_pair *pair = duet_device_pair_open(NULL, &err);
    bool ok = pair && optimise(pair, argc > 1 ? atof(argv[1]) : 10, &outcome, &err);
    if (ok && outcome.unused[0])
        printf("\nnothing changes: %s\n", outcome.unused);
    else if (ok)
        printf("\nthe game uses a share of %.3f from its next start: %.2f ms a frame\n",
               (double)outcome.plan.share / DUET_SHARE_ONE, outcome.step_ms);
    else if (err.status == DUET_STATUS_INTERRUPTED)
        printf("\ncancelled; the next time goes on from here\n");
    else
        fprintf(stderr, "\n%s\n", err.text);
    duet_device_pair_destroy(pair);
    return ok || err.status == DUET_STATUS_INTERRUPTED ? 0 : 1;
}
