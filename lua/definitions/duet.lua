---@meta duet
-- Made from api.lua by define.lua; do not edit.

--- A table: one device as OpenCL presents it.
---@class duet.Device
---@field can_cut boolean its units can be cut into parts with [first-last]
---@field cl_version string
---@field clock_mhz integer
---@field driver string
---@field fp64 boolean has double
---@field global_bytes integer
---@field host_memory boolean works on host memory without copies
---@field kind "CPU"|"GPU"|"accelerator"
---@field local_bytes integer
---@field max_buffer_bytes integer
---@field max_group integer work-items in a work-group
---@field name string
---@field platform string
---@field platform_version string
---@field selector string "pocl:0"; a part of a CPU is "pocl:0[0-1]"
---@field units integer compute units
---@field vendor string
local Device = {}

--- A table: how a step is to be done.
---@class duet.Plan
---@field mode string how grids are built: one of duet.modes()
---@field share number A's part of the work, 0 to 1, in steps of 1/65536
---@field variant_a string A's kernels: "rows", or with settings: "auto sort=radix"
---@field variant_b string B's kernels
local Plan = {}

--- A table: what a store of profiles knows of a world.
---@class duet.Profile
---@field accuracy duet.Accuracy of that level, as measured with the plan
---@field gain number over the best single device: 0.25 is a quarter faster
---@field gain_high number
---@field gain_low number
---@field grade string "exact", "other driver", "interpolated", "transferred", "stale", "default"
---@field level string of accuracy, the world's from the call on
---@field measured_s integer since 1970, UTC; 0: predicted
---@field plan duet.Plan the world's, from the call on
---@field step_ms number by that plan; 0 where nothing is known
---@field true_pairs integer that it was measured on; 0: it was not
---@field verdict string "faster", "same", "slower", "ambiguous"; empty where nothing is known
local Profile = {}

--- A table: one profile of a store.
---@class duet.StoredProfile
---@field a duet.StoredDevice
---@field b duet.StoredDevice
---@field dims integer
---@field false_rate number
---@field gain number over the best single device: 0.25 is a quarter faster
---@field gain_high number
---@field gain_low number
---@field high_ms number
---@field level string of accuracy
---@field low_ms number its interval
---@field measured_s integer since 1970, UTC
---@field missed_rate number of the pairs that collide
---@field mode string
---@field objects integer
---@field origin string "measured", "online" or "manual"
---@field replaced string why it serves no more; empty: it is live
---@field scene string empty: not known
---@field session string empty: put in by hand
---@field share number A's part, 0 to 1
---@field step_ms number the median
---@field uid string its first digits name it
---@field variant_a string
---@field variant_b string
---@field verdict string "faster", "same", "slower", "ambiguous"
local StoredProfile = {}

--- A table: a device as a store knows it.
---@class duet.StoredDevice
---@field driver string
---@field name string
---@field part string "0-3" of a CPU; empty: the whole device
local StoredDevice = {}

--- A table: a plan that was measured on the way to a profile.
---@class duet.StoredTrial
---@field a_ms number A's part of it
---@field b_ms number and B's
---@field high_ms number
---@field low_ms number its interval
---@field mode string
---@field outcome string "ok", "build", "launch", "wrong", "timeout" or "pruned"
---@field reason string where not ok
---@field samples integer
---@field share number A's part, 0 to 1
---@field step_ms number the median; 0 unless ok, as those below
---@field variant_a string
---@field variant_b string
local StoredTrial = {}

--- A table: one kernel or transfer of a step.
---@class duet.Stage
---@field device "A"|"B"
---@field ms number from OpenCL events; a host stage from the clock
---@field name string "hash", "sort" ...
---@field transfer boolean
local Stage = {}

--- An ordered device pair: A takes the share, B the rest.
---@class duet.DevicePair
local DevicePair = {}

--- Oriented boxes: rows of centre xyz, half extents xyz, quaternion xyzw.
---@class duet.Poses
local Poses = {}

--- Axis-aligned boxes: rows of lower xyz, upper xyz.
---@class duet.Bounds
local Bounds = {}

--- Where boxes are: rows of centre xyz, quaternion xyzw.
---@class duet.Transforms
local Transforms = {}

--- How large boxes are: rows of half extents xyz.
---@class duet.Sizes
local Sizes = {}

--- Collisions: rows of two ids a < b, from 0.
---@class duet.Pairs
local Pairs = {}

--- A strategy that looks for the best share, asked and told by a script.
---@class duet.Search
local Search = {}

--- A table: a way to search.
---@class duet.Strategy
---@field about string what it does, in a line
---@field name string
local Strategy = {}

--- A table: what a tuning found.
---@class duet.Tuning
---@field accuracy duet.Accuracy of that level, as measured
---@field best duet.Plan the best that shares the work; taken only where it is faster
---@field gain number of the best plan over the better single device: 0.25 is a quarter faster
---@field gain_high number
---@field gain_low number
---@field known boolean finished before: nothing was measured
---@field launches integer all, of interrupted sessions too
---@field level string of accuracy, that was tuned
---@field objects integer
---@field plan duet.Plan to use
---@field resumed boolean continued an interrupted session
---@field seconds number
---@field single_ms number by the better single device
---@field step_high_ms number
---@field step_low_ms number
---@field step_ms number by the plan to use, the median
---@field terms table<string, number> of equations 4 to 6: t1, cpu1, cpu2, gpu1 ... bus3, imbalance
---@field trials integer
---@field true_pairs integer that it was measured on; 0: it was not
---@field verdict string of the best plan: "faster", "same", "slower", "ambiguous"
local Tuning = {}

--- What objects are besides: rows of velocity xyz, angular velocity xyz, mass, restitution, friction, group, mask, fixed_rotation.
---@class duet.Bodies
local Bodies = {}

--- Where objects are and how they move: rows of centre xyz, rotation xyzw, velocity xyz, angular velocity xyz.
---@class duet.States
local States = {}

--- Where objects touch: rows of a, b, normal xyz, n, and four times anchor xyz, separation, normal impulse.
---@class duet.Contacts
local Contacts = {}

--- The narrow phase alone: tests pairs that the script brings.
---@class duet.PairQuery
local PairQuery = {}

--- Rows of one number: 0 separated, 1 colliding.
---@class duet.Verdicts
local Verdicts = {}

--- Rows of one number: how far apart two poses are; below 0, how deep in each other.
---@class duet.Separations
local Separations = {}

--- A table: what a test found and took.
---@class duet.PairQueryResult
---@field colliding integer pairs
---@field device_ms number[] of A and of B
---@field total_ms number wall clock
---@field undecided integer pairs that float left open and the host decided
local PairQueryResult = {}

--- A table: a kernel and its card.
---@class duet.Kernel
---@field about string what it does
---@field configs integer valid ones
---@field name string
---@field params table[] { name, about, default, values }
local Kernel = {}

--- A table: the text of a variant.
---@class duet.Source
---@field group integer work-items in a group
---@field name string of the variant
---@field per_item integer work that one item does
---@field sha256 string of the text
---@field text string OpenCL C
local Source = {}

--- A table: a level of accuracy.
---@class duet.Level
---@field about string what is tested
---@field added number how far apart what is added may be
---@field missed number how deep, as part of the sizes, a collision may be that is missed
---@field name string
local Level = {}

--- A table: how much may be wrong, by the number of pairs that collide.
---@class duet.Accuracy
---@field false_rate number found besides those pairs
---@field missed number of those pairs, not found
local Accuracy = {}

--- Objects that move.
---@class duet.Motion
local Motion = {}

--- What a motion's step did; holds until the next.
---@class duet.MotionResult
---@field colours integer rounds of a solution
---@field contacts integer that push
---@field n_events integer contacts that began or ended
---@field pairs integer that may touch
---@field rebuilt boolean pairs were searched in this step
---@field step integer steps since the start
---@field time number step * dt
---@field total_ms number
local MotionResult = {}

--- A table: energies and momenta of a motion.
---@class duet.Energy
---@field angular number[] momentum about the origin
---@field kinetic number of objects with a mass
---@field momentum number[]
---@field potential number
---@field turning number of their rotation
local Energy = {}

--- A table: one effect of a motion, and what calls for it.
---@class duet.Effect
---@field active boolean
---@field bytes integer of state an object, on B
---@field called_by string what calls for it, or would
---@field kernels string those that have code for it
---@field name string
local Effect = {}

--- Objects with the world they live in.
---@class duet.Scene
---@field accuracy duet.Accuracy
---@field cell number cell edge asked for; 0: chosen from the objects
---@field cell_fixed boolean a cell that is too small is refused
---@field dims integer 2 or 3
---@field has_accuracy boolean it leaves the level to a profile within accuracy
---@field has_world boolean lower and upper were given
---@field level string of accuracy, that the scene wants
---@field lower number[] of the world
---@field n integer objects; also #scene
---@field name string of the file or the scene's own
---@field origin_edge number edge of the origin cells that its objects are placed in; 0: none
---@field rotated boolean some object has a rotation
---@field shape "poses"|"bounds" what its rows are
---@field upper number[] of the world
local Scene = {}

--- Objects on a device pair, stepped again and again.
---@class duet.World
local World = {}

--- Keeps a world's share near its best while frames go by.
---@class duet.Online
local Online = {}

--- What a step found; holds until the world's next step.
---@class duet.Result
---@field bad integer objects left out (keep_bad)
---@field bytes integer[] memory held on A and on B
---@field candidates integer pairs whose bounds overlap
---@field cell number its least edge
---@field cell_widened boolean the edge asked for was below the largest object
---@field cells integer[] the grid
---@field device_ms number[] of A and of B
---@field first_bad integer the least id among them
---@field kernel_ms number[] of A and of B, from the first kernel to the last one's end
---@field objects integer in the step
---@field runs integer 1, or more where a buffer had to grow
---@field total_ms number wall clock, poses in to pairs on the host
---@field undecided integer pairs that float left open and the host decided
local Result = {}

--- Collisions among boxes, found by two OpenCL devices together.
---@class duet
---@field version string "1.0.0"
local duet = {}

--- All rows as they lie in memory, packed.
---@return string
function Bodies:bytes() end

--- Gives the memory back.
function Bodies:close() end

--- for place, ... in it:each() do
---@return fun(): integer, number, number, number, number, number, number, number, number, number, integer, integer, boolean
function Bodies:each() end

--- The row at a place from 0.
---@param place integer
---@return number, number, number, number, number, number, number, number, number, integer, integer, boolean
function Bodies:get(place) end

--- Writes a row: 12 values.
---@param place integer
---@param ... any
function Bodies:set(place, ...) end

--- All rows as they lie in memory, packed.
---@return string
function Bounds:bytes() end

--- Gives the memory back.
function Bounds:close() end

--- for place, ... in it:each() do
---@return fun(): integer, number, number, number, number, number, number
function Bounds:each() end

--- The row at a place from 0.
---@param place integer
---@return number, number, number, number, number, number
function Bounds:get(place) end

--- Writes a row: 6 values.
---@param place integer
---@param ... any
function Bounds:set(place, ...) end

--- All rows as they lie in memory, packed.
---@return string
function Contacts:bytes() end

--- Gives the memory back.
function Contacts:close() end

--- for place, ... in it:each() do
---@return fun(): integer, integer, integer, number, number, number, integer, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number
function Contacts:each() end

--- The row at a place from 0.
---@param place integer
---@return integer, integer, number, number, number, integer, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number
function Contacts:get(place) end

--- Writes a row: 26 values.
---@param place integer
---@param ... any
function Contacts:set(place, ...) end

--- Worlds made on it stay until they are closed.
function DevicePair:close() end

--- One of the two devices.
---@param which "A"|"B"
---@return duet.Device
function DevicePair:device(which) end

--- Objects that move: of a scene, with def second, or poses with bodies. A def { plan, dims, wants, doubles, origin, origin_edge, gravity, attraction, centre, drag, boundary, lower, upper, dt, substeps, integrator, skin, slop, max_push_speed, restitution_threshold, sleep_speed, sleep_after }; wants is a list of effects, boundary none, walls or periodic, integrator euler, verlet or yoshida.
---@param objects duet.Scene|duet.Poses|string|any[]
---@param bodies? duet.Bodies|string|any[]|table
---@param def? table
---@return duet.Motion?
---@return string? message
---@return string? status
function DevicePair:motion(objects, bodies, def) end

--- What is done here where nothing was measured.
---@return duet.Plan
function DevicePair:plan() end

--- Readies both devices to test pairs at a level; A has the share, of the default plan where none is given.
---@param def? { level?: string, share?: number, dims?: integer }
---@return duet.PairQuery?
---@return string? message
---@return string? status
function DevicePair:query(def) end

--- Chooses variants, mode and share for the scene and keeps them in a store. A def { store, keep, fresh, strategy, strategy_lua, variants, modes, level (a name, or a list), accuracy, budget_seconds, budget_trials, repeats, seed, script, watch }; watch(progress) is called after each trial and stops the tuning with false.
---@param scene duet.Scene
---@param def? table
---@return duet.Tuning?
---@return string? message
---@return string? status
function DevicePair:tune(scene, def) end

--- A world by a def { plan, dims, shape, level, accuracy, rotated, cell, cell_fixed, lower, upper, separate_sizes, keep_bad, max_pairs }; given a scene, with its objects and, where the def says nothing, its settings.
---@param scene? duet.Scene|table
---@param def? table
---@return duet.World?
---@return string? message
---@return string? status
function DevicePair:world(scene, def) end

--- Advances all objects by dt.
---@return duet.MotionResult?
---@return string? message
---@return string? status
function Motion:advance() end

--- Gives the devices' memory back.
function Motion:close() end

--- Where objects touched in the last step; ascending.
---@return duet.Contacts?
---@return string? message
---@return string? status
function Motion:contacts() end

--- Those that run. #motion is the number of objects.
---@return string[]
function Motion:effects() end

--- Energies and momenta.
---@return duet.Energy?
---@return string? message
---@return string? status
function Motion:energy() end

--- Every effect, and what calls for it, or would; last, how positions are kept.
---@return duet.Effect[]
function Motion:explain() end

--- A sum over the state's bits, the same at any share.
---@return string?
---@return string? message
---@return string? status
function Motion:hash() end

--- Goes on from there bit for bit.
---@param path string
---@return true?
---@return string? message
---@return string? status
function Motion:load(path) end

--- The state of all objects.
---@param into? duet.States
---@return duet.States?
---@return string? message
---@return string? status
function Motion:read(into) end

--- Writes the motion to a file.
---@param path string
---@return true?
---@return string? message
---@return string? status
function Motion:save(path) end

--- Forgets the motion.
function MotionResult:close() end

--- for a, b, begins in result:events() do
---@return fun(): integer, integer, boolean
function MotionResult:events() end

--- Where the time went, by effect.
---@return duet.Stage[]
function MotionResult:stages() end

--- Stores what was learned, where that was asked for.
---@return true?
---@return string? message
---@return string? status
function Online:close() end

--- In the place of world:step.
---@return duet.Result?
---@return string? message
---@return string? status
function Online:step() end

--- How often the share was tuned again.
---@return integer
function Online:tunings() end

--- Gives the devices' memory back.
function PairQuery:close() end

--- Tests rows 0 and 1, 2 and 3 ... with each other.
---@param poses duet.Poses|string|number[]|number[][]
---@param with_separations? boolean
---@return duet.Verdicts, duet.PairQueryResult, duet.Separations?
---@return string? message
---@return string? status
function PairQuery:run(poses, with_separations) end

--- All rows as they lie in memory, packed.
---@return string
function Pairs:bytes() end

--- Gives the memory back.
function Pairs:close() end

--- for place, ... in it:each() do
---@return fun(): integer, integer, integer
function Pairs:each() end

--- The row at a place from 0.
---@param place integer
---@return integer, integer
function Pairs:get(place) end

--- The pair hash, 16 hex digits.
---@return string
function Pairs:hash() end

--- Writes a row: 2 values.
---@param place integer
---@param ... any
function Pairs:set(place, ...) end

--- All rows as they lie in memory, packed.
---@return string
function Poses:bytes() end

--- Gives the memory back.
function Poses:close() end

--- Whether the exact boxes of two rows share a point.
---@param a integer
---@param b integer
---@param dims? integer
---@return boolean
function Poses:collide(a, b, dims) end

--- for place, ... in it:each() do
---@return fun(): integer, number, number, number, number, number, number, number, number, number, number
function Poses:each() end

--- The row at a place from 0.
---@param place integer
---@return number, number, number, number, number, number, number, number, number, number
function Poses:get(place) end

--- How far two rows are apart along the best axis; below 0, how deep in each other.
---@param a integer
---@param b integer
---@param dims? integer
---@return number
function Poses:separation(a, b, dims) end

--- Writes a row: 10 values.
---@param place integer
---@param ... any
function Poses:set(place, ...) end

--- Forgets the world.
function Result:close() end

--- The pairs in memory of their own.
---@return duet.Pairs
function Result:copy() end

--- The pair hash, 16 hex digits.
---@return string
function Result:hash() end

--- The pair at a place from 0.
---@param place integer
---@return integer, integer
function Result:pair(place) end

--- for a, b in result:pairs() do
---@return fun(): integer, integer
function Result:pairs() end

--- Where the time went.
---@return duet.Stage[]
function Result:stages() end

--- A view of what the scene says of motion; nil where that is nothing.
---@return duet.Bodies?
function Scene:bodies() end

--- A view of the objects; nil where they are poses.
---@return duet.Bounds?
function Scene:bounds() end

--- Gives the objects back.
function Scene:close() end

--- A view of the objects; nil where they are bounds; in origin cells centres are rounded.
---@return duet.Poses?
function Scene:poses() end

--- All pairs, exactly, by the plain C twin; or what a level finds. Ascending.
---@param level? string
---@return duet.Pairs?
---@return string? message
---@return string? status
function Scene:reference(level) end

--- The share to measure next; nothing once the search is done.
---@return number?
---@return string? message
---@return string? status
function Search:ask() end

--- Where the strategy believes the best share to lie.
---@return number, number
function Search:bracket() end

--- Forgets the samples.
function Search:close() end

--- The share to use after what was told so far.
---@return number
function Search:pick() end

--- What was measured there: wall-clock times of the step and of the devices.
---@param share number
---@param total_ms number
---@param a_ms number
---@param b_ms number
---@return true?
---@return string? message
---@return string? status
function Search:tell(share, total_ms, a_ms, b_ms) end

--- All rows as they lie in memory, packed.
---@return string
function Separations:bytes() end

--- Gives the memory back.
function Separations:close() end

--- for place, ... in it:each() do
---@return fun(): integer, number
function Separations:each() end

--- The row at a place from 0.
---@param place integer
---@return number
function Separations:get(place) end

--- Writes a row: 1 values.
---@param place integer
---@param ... any
function Separations:set(place, ...) end

--- All rows as they lie in memory, packed.
---@return string
function Sizes:bytes() end

--- Gives the memory back.
function Sizes:close() end

--- for place, ... in it:each() do
---@return fun(): integer, number, number, number
function Sizes:each() end

--- The row at a place from 0.
---@param place integer
---@return number, number, number
function Sizes:get(place) end

--- Writes a row: 3 values.
---@param place integer
---@param ... any
function Sizes:set(place, ...) end

--- All rows as they lie in memory, packed.
---@return string
function States:bytes() end

--- Gives the memory back.
function States:close() end

--- for place, ... in it:each() do
---@return fun(): integer, number, number, number, number, number, number, number, number, number, number, number, number, number
function States:each() end

--- The row at a place from 0.
---@param place integer
---@return number, number, number, number, number, number, number, number, number, number, number, number, number
function States:get(place) end

--- Writes a row: 13 values.
---@param place integer
---@param ... any
function States:set(place, ...) end

--- All rows as they lie in memory, packed.
---@return string
function Transforms:bytes() end

--- Gives the memory back.
function Transforms:close() end

--- for place, ... in it:each() do
---@return fun(): integer, number, number, number, number, number, number, number
function Transforms:each() end

--- The row at a place from 0.
---@param place integer
---@return number, number, number, number, number, number, number
function Transforms:get(place) end

--- Writes a row: 7 values.
---@param place integer
---@param ... any
function Transforms:set(place, ...) end

--- All rows as they lie in memory, packed.
---@return string
function Verdicts:bytes() end

--- Gives the memory back.
function Verdicts:close() end

--- for place, ... in it:each() do
---@return fun(): integer, integer
function Verdicts:each() end

--- The row at a place from 0.
---@param place integer
---@return integer
function Verdicts:get(place) end

--- Writes a row: 1 values.
---@param place integer
---@param ... any
function Verdicts:set(place, ...) end

--- Gives the devices' memory back.
function World:close() end

--- Why a store of profiles has what it has for the objects: a line for each ground, from the best down.
---@param path? string
---@return string?
---@return string? message
---@return string? status
function World:explain_profile(path) end

--- Of accuracy, of the next step.
---@return string
function World:level() end

--- Takes the best plan that a store of profiles knows for the objects; the user's store without a path.
---@param path? string
---@return duet.Profile?
---@return string? message
---@return string? status
function World:load_profile(path) end

--- The same for bounds.
---@param n integer
---@return duet.Bounds?
---@return string? message
---@return string? status
function World:map_bounds(n) end

--- Space for n poses that the devices read without a copy: map, write, then step.
---@param n integer
---@return duet.Poses?
---@return string? message
---@return string? status
function World:map_poses(n) end

--- Their sizes, which are sent again only once they were mapped again.
---@param n integer
---@return duet.Sizes?
---@return string? message
---@return string? status
function World:map_sizes(n) end

--- The same for a world with separate_sizes: what a step sends there.
---@param n integer
---@return duet.Transforms?
---@return string? message
---@return string? status
function World:map_transforms(n) end

--- Begins to watch the frames' times.
---@param def? { most_extra?: number, keep?: boolean, store?: string }
---@return duet.Online?
---@return string? message
---@return string? status
function World:online(def) end

--- The plan of the next step.
---@return duet.Plan
function World:plan() end

--- Copies the objects in.
---@param bounds duet.Bounds|string|number[]|number[][]
---@return true?
---@return string? message
---@return string? status
function World:set_bounds(bounds) end

--- What is taken for a collision, from the next step on.
---@param level string
---@return true?
---@return string? message
---@return string? status
function World:set_level(level) end

--- What the table leaves out stays.
---@param plan duet.Plan
---@return true?
---@return string? message
---@return string? status
function World:set_plan(plan) end

--- Copies the objects in.
---@param poses duet.Poses|string|number[]|number[][]
---@return true?
---@return string? message
---@return string? status
function World:set_poses(poses) end

--- Copies the scene's objects in.
---@param scene duet.Scene
---@return true?
---@return string? message
---@return string? status
function World:set_scene(scene) end

--- Finds all pairs.
---@return duet.Result?
---@return string? message
---@return string? status
function World:step() end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Bodies
function duet.bodies(from) end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Bounds
function duet.bounds(from) end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Contacts
function duet.contacts(from) end

--- Opens two devices by their selectors; the default pair without.
---@param def? { a?: string, b?: string, kernel_dir?: string, cache_dir?: string }
---@return duet.DevicePair?
---@return string? message
---@return string? status
function duet.device_pair(def) end

--- All root devices of all platforms.
---@return duet.Device[]?
---@return string? message
---@return string? status
function duet.devices() end

--- All that a scene can call for.
---@return string[]
function duet.effects() end

--- Writes all rows of a store to a file, as JSON lines.
---@param file string
---@param path? string
---@return true?
---@return string? message
---@return string? status
function duet.export_profiles(file, path) end

--- Takes such a file's rows in, all or none: how many were added, and how many known.
---@param file string
---@param path? string
---@return integer, integer?
---@return string? message
---@return string? status
function duet.import_profiles(file, path) end

--- The kernels, and what their cards let vary on a device of these limits.
---@param limits? { max_group?: integer, local_bytes?: integer, fp64?: boolean, cpu?: boolean }
---@return duet.Kernel[]?
---@return string? message
---@return string? status
function duet.kernels(limits) end

--- Whether the first promises all that the second does.
---@param level string
---@param other string
---@return boolean
function duet.level_covers(level, other) end

--- Levels of accuracy, the default first.
---@return duet.Level[]
function duet.levels() end

--- Reads pairs for duet.PairQuery:run, two poses a row; rows 0 and 1 of its poses are the first pair.
---@param path string
---@return duet.Scene?
---@return string? message
---@return string? status
function duet.load_pairs(path) end

--- The modes that a plan can have.
---@return string[]
function duet.modes() end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Pairs
function duet.pairs(from) end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Poses
function duet.poses(from) end

--- The trials of the profile that is named by its uid's first digits.
---@param uid string
---@param path? string
---@return duet.StoredTrial[]?
---@return string? message
---@return string? status
function duet.profile_trials(uid, path) end

--- The profiles of a store, the user's without a path; those that were replaced come last.
---@param path? string
---@param replaced_too? boolean
---@return duet.StoredProfile[]?
---@return string? message
---@return string? status
function duet.profiles(path, replaced_too) end

--- Loads a scene from a file, with settings for a Lua scene; or copies rows, with dims 2 or 3.
---@param from string|duet.Poses|duet.Bounds
---@param settings? table|integer
---@return duet.Scene?
---@return string? message
---@return string? status
function duet.scene(from, settings) end

--- Begins a search for the share; the default strategy without.
---@param def? { strategy?: string, strategy_lua?: string, launches?: integer, points?: integer, rounds?: integer, quantum?: number, start?: number, probe_cost?: number }
---@return duet.Search?
---@return string? message
---@return string? status
function duet.search(def) end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Separations
function duet.separations(from) end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Sizes
function duet.sizes(from) end

--- The exact text of a kernel with a config; what is not set takes the card's default.
---@param kernel string
---@param settings? table<string, integer>
---@param limits? table
---@return duet.Source?
---@return string? message
---@return string? status
function duet.source(kernel, settings, limits) end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.States
function duet.states(from) end

--- The strategies there are, the default first.
---@return duet.Strategy[]
function duet.strategies() end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Transforms
function duet.transforms(from) end

--- Space for so many rows, or a copy of packed rows, of numbers one after the other, or of rows.
---@param from integer|string|any[]
---@return duet.Verdicts
function duet.verdicts(from) end

return duet
