// SPDX-License-Identifier: MIT
// The files of this module to each other: each adds its functions to the
// module's table, which is at -1, and its methods to the classes of what its
// objects are made of; and it lends what others need of its objects.
#ifndef LUA_NOUNS_H
#define LUA_NOUNS_H

#include "gen/field.h"
#include "lua/array.h"
#include "lua/class.h"

#include "runtime/duet.h"
#include "runtime/narrowphase/accuracy.h"

// The nouns, each after those whose classes it adds to.
// clang-format off
#define LUA_NOUNS(X) \
    X(device) X(plan) X(scene) X(world) X(result) X(search) X(tune) X(motion) X(task) X(online) \
    X(motion_def) X(motion_step) X(motion_state) X(motion_commands) X(source) X(pair_query) \
    X(tree) X(tree_query) X(profiles) X(contact_query) X(pair_delta) X(replay) X(cluster)
// clang-format on

#define DECLARE_NOUN(noun) extern const lua_noun noun##_noun;
LUA_NOUNS(DECLARE_NOUN)

void load_carried(lua_State *L, const char *path); // pushes a script that the library carries

extern const field_type field_plan;  // a duet_plan, as a table
extern const field_type field_share; // uint32_t out of DUET_SHARE_ONE, as 0 to 1

void plan_read(lua_State *L, duet_plan *plan);      // the argument at 2
int plan_push(lua_State *L, const duet_plan *plan); // nil for NULL; returns 1
const char *shape_name(int shape);
const char *query_wants_name(int wants);
duet_level level_check(lua_State *L, int index);

duet_device_pair *device_pair_check(lua_State *L); // the one at 1

// Advances the motion at the index in this way, and pushes the result, or the failure.
typedef bool advance_call(void *by, duet_motion *motion, duet_motion_result *result,
                          duet_error *err);
int motion_advance_by(lua_State *L, int index, advance_call *advance, void *by);
// The same, after the motion's script.
int motion_run_by(lua_State *L, int index, advance_call *advance, void *by);

duet_tree *tree_check(lua_State *L); // the one at 1
enum { TREE_LARGE_POSES = DUET_SHAPES };
int tree_shape(lua_State *L); // shape of its objects, a duet_shape, or TREE_LARGE_POSES

array_kind shape_array_kind(int shape); // or TREE_LARGE_POSES

duet_motion *motion_check_lua(lua_State *L); // the one at 1
duet_motion *motion_check_at(lua_State *L, int index);
// Counts mappings of the motion at 1, by part: views of earlier ones are invalid.
uint64_t *motion_maps_lua(lua_State *L);

typedef struct world_box {
    duet_world *world;
    uint64_t steps;     // results of earlier ones no longer hold
    uint64_t maps;      // so with mapped poses
    uint64_t size_maps; // and sizes
    uint32_t onlines;   // online plans that step it
} world_box;

world_box *world_check(lua_State *L);    // the one at 1
void world_forget_views(world_box *box); // objects mapped before are not sent again

duet_task *task_check_lua(lua_State *L, int index);
int task_result_push(lua_State *L, const duet_task_result *result); // pushes a table; returns 1
duet_task_file *task_file_test(lua_State *L, int index); // NULL if there is something else

duet_scene *scene_check(lua_State *L, int index);
// { n = 1000, rotated = false } -> names and values as text, kept by a table
// that is left on the stack.
const duet_setting *scene_read_settings(lua_State *L, int index, uint32_t *n);
void scene_push_info(lua_State *L, const duet_scene_info *info); // pushes a table

void profile_push_known(lua_State *L, const duet_profile *profile); // pushes a table

// Pushes a list of tables, one a stage.
void stages_push(lua_State *L, const duet_stage *stages, uint32_t n);

// Pushes the result of the world at index, which is open.
void result_push(lua_State *L, int world_index, const duet_result *result);

#endif
