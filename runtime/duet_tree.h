// SPDX-License-Identifier: MIT
// Trees: boxes on both devices, for queries of any kind.
#ifndef DUET_TREE_H
#define DUET_TREE_H

#include "duet_motion.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

#define DUET_NO_OBJECT UINT32_MAX

// Objects that queries ask about. A tree and its queries belong to one thread at a time.
typedef struct duet_tree duet_tree;

typedef struct duet_tree_def {
    duet_device_pair *pair; // held until the tree and its queries are destroyed
    uint32_t share;         // A's part of a query's items, out of DUET_SHARE_ONE; 0: B alone;
                            // DUET_SHARE_DEFAULT: the share of the pair's default plan
    uint32_t dims;          // 2 or 3
    duet_shape shape;       // shape of its objects
    float origin_edge;      // above 0: large poses, in origin cells of that edge, a power of two up
                            // to 2^69; items of its queries have cells, too
    int cookie;
} duet_tree_def;

DUET_API duet_tree_def duet_default_tree_def(void); // poses in 3D, the default share

// Makes a def of the tree that takes a motion's bodies: with the motion's pair, dims and
// origin_edge, and with the shape ROUNDED_BOXES if bodies have or had radii, or the motion's wants
// ask for radii; rounded boxes have no origin cells. The default def for NULL.
DUET_API duet_tree_def duet_motion_tree_def(const duet_motion *motion);

// Creates a tree without objects and builds its kernels.
DUET_API duet_tree *duet_tree_create(const duet_tree_def *def, duet_error *err);
DUET_API void duet_tree_destroy(duet_tree *tree); // its queries may outlive it

// Replaces the objects by copies of n objects, at most 2^30. kind is the kind of the tree's shape,
// or LARGE_POSES if it has an origin_edge. BAD_OBJECT names the first object that is invalid, has a
// number above 2^100 or is beyond 2^30 origin cells; the tree is then empty.
DUET_API bool duet_tree_set_objects(duet_tree *tree, duet_object_kind kind, const void *objects,
                                    uint32_t n, duet_error *err);

// Replaces the objects by a motion's bodies at their present poses (duet_motion_get_poses). Their
// ids are their places (docs/commands.md, "Ids"); removed and disabled bodies are left out. A tree
// of rounded boxes has their radii, too; a tree of poses takes no motion whose bodies have or had
// radii: duet_motion_tree_def chooses. If B keeps the motion's sizes, as it does for contacts, the
// boxes stay on B, unless A has a share. The motion is not changed. BAD_ARGUMENT for a tree of
// another shape or other dims, BAD_OBJECT if a body's position is not finite or above 2^100; the
// tree is then empty.
DUET_API bool duet_tree_set_motion(duet_tree *tree, duet_motion *motion, duet_error *err);

// Sets a ground, which is copied; NULL: none. It lies beside the objects and queries find it as one
// more, with the id n + 6 for n objects, as in a motion's events. All under its triangles is part
// of it, without an end below. duet_tree_set_motion takes a motion's ground, or none; set_objects
// keeps what there is. BAD_ARGUMENT for a ground that no motion can have, and for trees in 2D or in
// origin cells.
DUET_API bool duet_tree_set_heights(duet_tree *tree, const duet_heights *heights, duet_error *err);

// Sets a ground of triangles likewise, instead of one of heights. Its triangles alone are part of
// it, met from both sides: what lies behind them is not.
DUET_API bool duet_tree_set_mesh(duet_tree *tree, const duet_mesh *mesh, duet_error *err);

// Two can touch if each one's group has a bit of the other's mask, as in a duet_body.
typedef struct duet_filter {
    uint32_t group;
    uint32_t mask;
} duet_filter;

// Sets the objects' filters [n], one an object, until the objects are set again; they are copied.
// Until then groups and masks are all ones, or after duet_tree_set_motion the bodies'. A query
// whose def has a filter finds only the objects that it can touch; a query without one
// reads no filters. BAD_ARGUMENT unless n is the number of objects.
DUET_API bool duet_tree_set_filters(duet_tree *tree, const duet_filter *filters, uint32_t n,
                                    duet_error *err);

// Sets the share of the tree's queries. A device that gets its first share builds its kernels and
// its tree, and keeps both up to date from then on. The hits are the same.
DUET_API bool duet_tree_set_share(duet_tree *tree, uint32_t share, duet_error *err);

// Gives the tree's queries of one kind the best share known for about n items against its number of
// boxes, until duet_tree_set_share; other queries keep theirs. query is "rays closest", "rays any",
// "rays every", the same of "sweeps", "boxes", "boxes itself", "points" or "points nearest K".
// Objects must be set. The store is as in duet_world_load_profile: path NULL is the user's and the
// system's, and on failure the share is as before. profile->plan.share is the share after the call.
DUET_API bool duet_tree_load_profile(duet_tree *tree, const char *query, uint64_t n,
                                     const char *path, duet_profile *profile, duet_error *err);

// Which hits of each item a query along a line finds.
typedef enum duet_query_wants {
    DUET_QUERY_CLOSEST, // the hit with the least t, of equal ones the one with the least id
    DUET_QUERY_ANY,     // whether there is one: id and t are then 0
    DUET_QUERY_EVERY    // all hits, by item, t and id
} duet_query_wants;

// "closest", "any", "every"; NULL outside
DUET_API const char *duet_query_wants_name(duet_query_wants wants);

DUET_C_END

#endif
