// SPDX-License-Identifier: MIT
// A scene as it is to be drawn: its boxes or a sample of them, which of them collide,
// and the grid that Duet lays over them.
#ifndef CLI_SKETCH_H
#define CLI_SKETCH_H

#include "cli/draw/view.h"
#include "runtime/broadphase/grid.h"

typedef struct sketch {
    const duet_scene_info *info; // the scene's
    grid grid;
    double from[3]; // the origin of what is drawn: with origin cells the first box's corner
    extent whole;   // all boxes, and the world where one is given
    uint64_t n_pairs;
    uint32_t n_colliding; // boxes that are in some pair

    // The drawn boxes:
    uint32_t n;
    duet_rounded_box *boxes; // from far to near
    bool *colliding;
    extent part;      // holds the drawn boxes
    duet_pair *links; // pairs among them, by place in boxes
    uint64_t n_links;
    double (*crowd)[3]; // centres of a few thousand boxes of the whole scene
    uint32_t n_crowd;   // 0: all boxes are drawn
} sketch;

// Takes all boxes, or the `most` that lie nearest to a collision in the middle of the input. The
// pairs are the plain C reference's. Call sketch_free whatever this returns.
bool sketch_make(sketch *s, const duet_scene *scene, uint32_t most, duet_error *err);
void sketch_free(sketch *s);

// Draws it, with lines of words below.
void sketch_draw(const sketch *s, canvas *c, double width, double height);

corners sketch_corners(const duet_rounded_box *box,
                       uint32_t dims); // corners of a core, with its radius

#endif
