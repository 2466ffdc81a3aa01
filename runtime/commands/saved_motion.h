// SPDX-License-Identifier: MIT
// The form of a saved motion (docs/formats.md, "Saved motions"): a head, the kept buffers, each
// place, targets, forces, the ground, and a sum of it all.
//
// A file is read into a copy of the motion that has its own arrays and buffers. The copy replaces
// the motion's state once all of the file was checked; a refused file leaves the motion as it was.
#ifndef RUNTIME_SAVED_MOTION_H
#define RUNTIME_SAVED_MOTION_H

#include "base/text.h"
#include "runtime/commands/packed.h"
#include "runtime/dynamics/motion_commands.h"

typedef struct saved_head {
    char magic[16];
    uint32_t n; // places
    uint32_t dims, doubles, effects;
    uint32_t record; // floats a contact
    uint32_t n_contacts;
    uint32_t has_graph, rows_stale;
    uint32_t n_targets;
    uint32_t pushed; // forces wait for the next step
    float origin_edge;
    uint32_t ground[2]; // heights along x and y, or vertices and triangles; 0: the file has none
    uint32_t has_mesh;
    uint64_t step, n_pairs;
    double margin;
    packed_def def;
} saved_head;

// Bytes of the places, targets and forces behind the buffers, and of the ground behind these.
size_t saved_places_size(const saved_head *h);
size_t saved_ground_size(const saved_head *h);

// Adds them to a file.
bool saved_places_add(duet_motion *m, text *file, duet_error *err);
void saved_ground_add(const duet_motion *m, text *file);
void saved_ground_count(const duet_motion *m, saved_head *h); // as the head says

// Whether a file of the motion has its ground: whether bodies can touch it.
bool saved_ground_is_kept(const duet_motion *m);

// Takes the head's def, and the places, targets and forces at `bytes`, into a copy. BAD_INPUT if a
// motion could not have saved them.
bool saved_places_take(duet_motion *copy, const saved_head *h, const char *bytes, const char *path,
                       duet_error *err);

// The ground of a file, in whose bytes its arrays lie.
typedef struct saved_ground_seen {
    duet_heights heights;
    duet_mesh mesh;
} saved_ground_seen;

// Lets a copy's def have the ground at `bytes`, which were checked in length alone; take then
// copies it, once the def was checked. Its material and carrier are the motion's; BAD_INPUT if the
// file has another carrier.
bool saved_ground_see(duet_motion *copy, saved_ground_seen *seen, const saved_head *h,
                      const char *bytes, const char *path, duet_error *err);
bool saved_ground_take(duet_motion *copy, const saved_head *h, duet_error *err);

// A copy of a motion with n places, and without the arrays, buffers and ground.
duet_motion saved_copy_begin(const duet_motion *m, uint32_t n);
void saved_copy_free(duet_motion *copy);

// The copy's state is the motion's from then on; the motion's is freed.
void saved_copy_adopt(duet_motion *m, duet_motion *copy);

#endif
