// SPDX-License-Identifier: MIT
// Boxes in a tree on both devices, for queries of any kind.
#ifndef DUET_TREE_H
#define DUET_TREE_H

#include "duet_motion.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

#define DUET_NO_OBJECT UINT32_MAX

// Objects that queries ask about. Its queries and itself are one thread's at a time.
typedef struct duet_tree duet_tree;

typedef struct duet_tree_def {
    duet_device_pair *pair; // held until the tree and its queries are destroyed
    uint32_t share;         // A's part of what a query asks, out of DUET_SHARE_ONE; 0: B alone;
                            // DUET_SHARE_DEFAULT: that of the pair's default plan
    uint32_t dims;          // 2 or 3
    duet_shape shape;       // of its objects
    float origin_edge;      // above 0: large poses, in origin cells of that edge, a power of two up
                            // to 2^69; what it is asked has cells, too
    int cookie;
} duet_tree_def;

DUET_API duet_tree_def duet_default_tree_def(void); // poses in 3D, the default share

// A def of the tree that takes a motion's bodies: with the pair, the dims and the origin_edge of
// the motion, and with the shape ROUNDED_BOXES if bodies have or had radii, or the motion's wants
// ask for them; rounded boxes have no origin cells. The default one for NULL.
DUET_API duet_tree_def duet_motion_tree_def(const duet_motion *motion);

// Builds the kernels that it needs; it has no objects yet.
DUET_API duet_tree *duet_tree_create(const duet_tree_def *def, duet_error *err);
DUET_API void duet_tree_destroy(duet_tree *tree); // its queries may outlive it

// The objects from now on, n of them, at most 2^30; they are copied. kind is that of
// the tree's shape, or LARGE_POSES where it has an origin_edge. BAD_OBJECT names the first that is
// none, has a number above 2^100 or is beyond 2^30 origin cells; the tree is empty then.
DUET_API bool duet_tree_set_objects(duet_tree *tree, duet_object_kind kind, const void *objects,
                                    uint32_t n, duet_error *err);

// The objects from now on are a motion's bodies where they are, as duet_motion_get_poses says, and
// their ids are their places (docs/commands.md, "Ids"); those that were removed or are disabled
// are left out. A tree of rounded boxes has their radii, too; one of poses takes no motion whose
// bodies have or had radii: duet_motion_tree_def chooses. Where B keeps the motion's sizes, as for
// contacts, the boxes stay on B, unless A has a share. The motion goes on as before. BAD_ARGUMENT
// for a tree of another shape or of other dims, BAD_OBJECT where a body is at no finite place or
// above 2^100; the tree is empty then.
DUET_API bool duet_tree_set_motion(duet_tree *tree, duet_motion *motion, duet_error *err);

// Two can touch if each one's group has a bit of the other's mask, as those of a duet_body say.
typedef struct duet_filter {
    uint32_t group;
    uint32_t mask;
} duet_filter;

// The objects' filters, n of them, one an object, until the objects are set again; they are copied.
// Before, each group and mask is all ones; duet_tree_set_motion sets those of the bodies. A query
// whose def has a filter finds the objects that it can touch, and no others; a query without one
// looks at no filters. BAD_ARGUMENT unless n is the number of objects.
DUET_API bool duet_tree_set_filters(duet_tree *tree, const duet_filter *filters, uint32_t n,
                                    duet_error *err);

// Its queries divide what they are asked so from now on. A device that gets its first share builds
// its kernels and its tree, and keeps both up to date from then on. The hits are the same.
DUET_API bool duet_tree_set_share(duet_tree *tree, uint32_t share, duet_error *err);

// Gives the tree's queries of one kind the share that is known to be the best for about n items
// against so many boxes. query is "rays closest", "rays any", "rays every", the same of "sweeps",
// "boxes", "boxes itself", "points" or "points nearest K". They have it until duet_tree_set_share;
// other queries keep theirs. Objects must be set, and the store is as in duet_world_load_profile:
// path NULL is the user's and the system's, and on failure the share is as it was.
// profile->plan.share is the share after the call.
DUET_API bool duet_tree_load_profile(duet_tree *tree, const char *query, uint64_t n,
                                     const char *path, duet_profile *profile, duet_error *err);

// What a query along a line wants of each item.
typedef enum duet_query_wants {
    DUET_QUERY_CLOSEST, // the hit with the least t, of several the one with the least id
    DUET_QUERY_ANY,     // whether there is one: id and t are 0 where there is
    DUET_QUERY_EVERY    // all hits, by item, t and id
} duet_query_wants;

// "closest", "any", "every"; NULL outside
DUET_API const char *duet_query_wants_name(duet_query_wants wants);

DUET_C_END

#endif
