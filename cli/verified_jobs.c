// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L // mkdtemp
#include "cli/verified_jobs.h"

#include "base/error.h"
#include "base/text_file.h"
#include "cli/commands/cluster.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// ---------------------------------------------------------------- checkpoints

bool verified_jobs_open(verified_jobs *j, const char *scene, const scene_options *options,
                        duet_error *err)
{
    static const char *const names[CK_FILES] = {"first.ck", "other.ck", "kept.ck"};
    const char *given = getenv("TMPDIR"), *above = given && *given ? given : "/tmp";
    *j = (verified_jobs){.scene = scene, .options = options};
    text_add(&j->folder, "%s/duet-verify-XXXXXX", above);
    bool ok =
        text_ok(&j->folder, err) &&
        (mkdtemp(j->folder.chars) ||
         error_set(err, DUET_STATUS_IO_FAILED,
                   "%s: no folder for checkpoints: %s; TMPDIR says where", above, strerror(errno)));
    for (int i = 0; ok && i < CK_FILES; ++i) {
        text_add(&j->checkpoints[i], "%s/%s", j->folder.chars, names[i]);
        ok = text_ok(&j->checkpoints[i], err);
    }
    return ok;
}

void verified_jobs_close(verified_jobs *j)
{
    for (int i = 0; i < CK_FILES; ++i) {
        if (j->checkpoints[i].chars)
            unlink(j->checkpoints[i].chars);
        text_free(&j->checkpoints[i]);
    }
    if (j->folder.chars)
        rmdir(j->folder.chars);
    text_free(&j->folder);
}

// ---------------------------------------------------------------- a job

// The arguments of duet-cluster: pairs of an option and its value behind the scene.
typedef struct job_words {
    char *list[2 * OPTION_LIST_MOST + 32]; // NULL last
    int n;
    char objects[24], seed[24], steps[24], share[24];
} job_words;

static void add(job_words *w, const char *word)
{
    w->list[w->n++] = (char *)word;
}

static void add_option(job_words *w, const char *name, const char *value)
{
    if (!value)
        return;
    add(w, name);
    add(w, value);
}

static void add_number(job_words *w, const char *name, uint64_t value, char written[24])
{
    snprintf(written, 24, "%" PRIu64, value);
    add_option(w, name, written);
}

static void add_scene(job_words *w, const char *scene, const scene_options *o)
{
    add(w, scene);
    if (o->n != UINT64_MAX)
        add_number(w, "--objects", o->n, w->objects);
    if (o->seed != UINT64_MAX)
        add_number(w, "--seed", o->seed, w->seed);
    for (uint32_t i = 0; i < o->settings.n; ++i)
        add_option(w, "--set", o->settings.items[i].written);
}

static void add_run(job_words *w, const verified_run *r)
{
    add_option(w, "--pair", r->selectors);
    if (r->plan.share != UINT32_MAX) {
        snprintf(w->share, sizeof w->share, "%" PRIu32 "/%u", r->plan.share, DUET_SHARE_ONE);
        add_option(w, "--share", w->share);
    }
    add_option(w, "--mode", r->plan.mode);
    add_option(w, "--variant", r->plan.variant);
    add_option(w, "--variant-a", r->plan.variants[0]);
    add_option(w, "--variant-b", r->plan.variants[1]);
    add_option(w, "--replay", r->path);
}

static bool run_job(verified_jobs *j, const verified_run *r, checkpoint to, uint64_t kept,
                    uint64_t step, duet_error *err)
{
    mpirun_job job = {.output = "/dev/null"};
    job_words words = {0};
    add_scene(&words, j->scene, j->options);
    add_run(&words, r);
    add_number(&words, "--steps", step, words.steps);
    add_option(&words, "--resume", kept > 0 ? j->checkpoints[CK_KEPT].chars : NULL);
    add_option(&words, "--checkpoint", j->checkpoints[to].chars);
    return cluster_run(&job, r->ranks, words.list, &j->status, err) && j->status == 0;
}

// ---------------------------------------------------------------- both

static double byte_at(const text *file, size_t at)
{
    return at < file->length ? (unsigned char)file->chars[at] : NAN;
}

// Notes the first byte in which two files differ. Returns whether any does.
static bool note_unlike(verified_jobs *j, const text *first, const text *other)
{
    const size_t n = first->length < other->length ? first->length : other->length;
    size_t at = 0;
    while (at < n && first->chars[at] == other->chars[at])
        ++at;
    j->unlike.at = at;
    j->unlike.bytes[0] = byte_at(first, at);
    j->unlike.bytes[1] = byte_at(other, at);
    return at < first->length || at < other->length;
}

static bool compare(verified_jobs *j, bool *differ, duet_error *err)
{
    text first = {0}, other = {0};
    bool ok = text_read_file(&first, j->checkpoints[CK_FIRST].chars, err) &&
              text_read_file(&other, j->checkpoints[CK_OTHER].chars, err);
    *differ = ok && note_unlike(j, &first, &other);
    text_free(&first);
    text_free(&other);
    return ok;
}

bool verified_jobs_go(verified_jobs *j, const verified_run runs[2], uint64_t kept, uint64_t step,
                      bool *differ, duet_error *err)
{
    *differ = false;
    return run_job(j, &runs[0], CK_FIRST, kept, step, err) &&
           run_job(j, &runs[1], CK_OTHER, kept, step, err) && compare(j, differ, err);
}

bool verified_jobs_keep(const verified_jobs *j, duet_error *err)
{
    const char *from = j->checkpoints[CK_FIRST].chars;
    return rename(from, j->checkpoints[CK_KEPT].chars) == 0 ||
           error_set(err, DUET_STATUS_IO_FAILED, "%s: %s", from, strerror(errno));
}

bool verified_jobs_load(const verified_jobs *j, verified_run runs[2], duet_error *err)
{
    return duet_motion_load(runs[0].motion, j->checkpoints[CK_FIRST].chars, err) &&
           duet_motion_load(runs[1].motion, j->checkpoints[CK_OTHER].chars, err);
}
