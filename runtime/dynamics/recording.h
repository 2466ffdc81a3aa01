// SPDX-License-Identifier: MIT
// What is recorded of a motion, and the form of the file (docs/formats.md, "Recordings").
#ifndef RUNTIME_RECORDING_H
#define RUNTIME_RECORDING_H

#include "base/text.h"
#include "runtime/duet.h"
#include "runtime/dynamics/packed.h"

typedef enum recorded_kind {
    RECORDED_STEPS, // n steps, one after the other
    RECORDED_ADD,
    RECORDED_REMOVE,
    RECORDED_DISABLE,
    RECORDED_ENABLE,
    RECORDED_WAKE,
    RECORDED_SLEEP,
    RECORDED_USER_DATA,
    RECORDED_BODIES,
    RECORDED_POSES,
    RECORDED_DEF,
    RECORDED_FORCES,
    RECORDED_IMPULSES,
    RECORDED_TARGETS,
    RECORDED_KINDS
} recorded_kind;

typedef struct recording_head {
    char magic[16];
    uint32_t dims;
    uint32_t n; // places
    uint64_t step;
    uint64_t hash;
    uint64_t end_hash;
} recording_head;

extern const char recording_magic[16]; // how a recording begins

// Begins each record; n ids and n rows of the kind's size follow, or a def.
typedef struct recorded {
    uint32_t kind;
    uint32_t n;      // bodies, or steps
    uint32_t fields; // of bodies that are set
    uint32_t unused;
} recorded;

// Bytes of a kind's row; whether a kind's records have ids.
size_t recorded_row(uint32_t kind);
bool recorded_has_ids(uint32_t kind);

// What a motion holds while it is recorded.
typedef struct motion_recording {
    recording_head head;
    text records;
    uint64_t steps; // not yet in the records
} motion_recording;

void motion_forget_recording(duet_motion *m);

// Called after each command was carried out. They do nothing in a motion that is not recorded.
void motion_note_def(duet_motion *m);
void motion_note_arrivals(duet_motion *m, const duet_pose *poses, const duet_body *bodies,
                          uint32_t n);
void motion_note(duet_motion *m, recorded_kind kind, const uint32_t *places, uint32_t n,
                 const void *rows);
void motion_note_bodies(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t fields,
                        const duet_body *bodies);

#endif
