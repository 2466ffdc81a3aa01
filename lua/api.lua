-- SPDX-License-Identifier: MIT
-- Every name of the Lua API, once: the build makes definitions/duet.lua from this list
-- by define.lua, and tests hold it against the module and the C headers.
--
-- A class is { name, about, its fields, columns = of a row of an array }: fields are read from an object or a table.
-- A row of names is { name, parameters, results, about, c = names of the C API that it stands for }. A parameter is
-- "name: type" or "name?: type"; a result with fails = true may be nil, message, "STATUS" instead. "Class:method" is a
-- method, "Class.field" a field that a C name stands for.

local api = {}

-- Fields of what asking a tree took.
local asked = [[
    undecided: integer  hits that float left open and the host decided
    total_ms: number  wall clock
    device_ms: number[]  of A and of B
]]

api.classes = {
  { "duet.Device", "A table: one device as OpenCL presents it.", [[
    selector: string  "pocl:0"; a part of a CPU is "pocl:0[0-1]"
    platform, platform_version, name, vendor, driver, cl_version: string
    kind: "CPU"|"GPU"|"accelerator"
    units: integer  compute units
    clock_mhz: integer
    max_group: integer  work-items in a work-group
    global_bytes, local_bytes, max_buffer_bytes: integer
    host_memory: boolean  works on host memory without copies
    fp64: boolean  has double
    can_cut: boolean  its units can be cut into parts with [first-last]
    quirks: string[]  flaws of its driver, and what Duet does about each
  ]] },
  { "duet.Plan", "A table: how a step is to be done.", [[
    share: number  A's part of the work, 0 to 1, in steps of 1/65536
    mode: string  how grids are built: one of duet.modes()
    variant_a: string  A's kernels: "auto", "simd", "gpu" or "paper", or with settings: "auto sort=radix"
    variant_b: string  B's kernels
  ]] },
  { "duet.Profile", "A table: what a store of profiles knows of a world.", [[
    grade: string  "exact", "other driver", "interpolated", "transferred", "stale", "default"
    plan: duet.Plan  the world's, from the call on
    level: string  of accuracy, the world's from the call on
    accuracy: duet.Accuracy  of that level, as measured with the plan
    true_pairs: integer  that it was measured on; 0: it was not
    step_ms: number  by that plan; 0 from grade "transferred" on, as what follows
    gain: number  over the best single device: 0.25 is a quarter faster
    gain_low, gain_high: number
    verdict: string  "faster", "same", "slower", "ambiguous"; empty from "transferred" on
    measured_s: integer  since 1970, UTC; 0: predicted
  ]] },
  { "duet.StoredProfile", "A table: one profile of a store.", [[
    uid: string  its first digits name it
    replaced: string  why it is not used; empty: it is live
    scene: string  empty: not known
    dims, objects: integer
    query: string  "rays closest", asked of the objects; empty: of steps
    items: integer  of the query
    moving: boolean  of steps of a motion
    a, b: duet.StoredDevice
    share: number  A's part, 0 to 1
    mode, variant_a, variant_b: string
    level: string  of accuracy
    objective: string  what it makes small: "time", "energy", or time over ranks
    step_ms: number  the median
    low_ms: number  its interval
    high_ms: number
    gain: number  over the best single device: 0.25 is a quarter faster
    gain_low, gain_high: number
    verdict: string  "faster", "same", "slower", "ambiguous"
    rounds: integer  of the race that the verdict is of; 0: not known
    watched: integer  launches whose threads were watched; 0: not known
    disturbed: integer  and those of them that waited for a core
    whole_ms: number?  by the one device that A and B are parts of; nil: not raced
    whole_gain: number?  of the plan over that one; nil: not raced
    whole_gain_low, whole_gain_high: number?
    missed_rate: number  of the pairs that collide
    false_rate: number
    origin: string  "measured", "online" or "manual"
    session: string  empty: put in by hand
    measured_s: integer  since 1970, UTC
  ]] },
  { "duet.StoredDevice", "A table: a device as a store knows it.", [[
    name: string
    part: string  "0-3" of a CPU; empty: the whole device
    driver: string
  ]] },
  { "duet.StoredTrial", "A table: a plan that was measured on the way to a profile.", [[
    share: number  A's part, 0 to 1
    mode, variant_a, variant_b: string
    samples: integer
    step_ms: number?  the median; nil unless ok, as those below
    low_ms: number?  its interval
    high_ms: number?
    a_ms: number?  A's part of it
    b_ms: number?  and B's
    outcome: string  "ok", "build", "launch", "wrong", "timeout" or "pruned"
    reason: string  where not ok
  ]] },
  { "duet.Stage", "A table: one kernel or transfer of a step.", [[
    name: string  "hash", "sort" ...
    device: "A"|"B"
    ms: number  from OpenCL events; a host stage from the clock
    transfer: boolean
    begin_ms: number  of its first command, by the host's clock, since its device's part began
    end_ms: number  of its last one
  ]] },
  { "duet.DevicePair", "An ordered device pair: A takes the share, B the rest." },
  { "duet.Poses", "Oriented boxes: rows of centre xyz, half extents xyz, quaternion xyzw.", columns = ("f"):rep(10) },
  { "duet.Bounds", "Axis-aligned boxes: rows of lower xyz, upper xyz.", columns = ("f"):rep(6) },
  { "duet.Transforms", "Where boxes are: rows of centre xyz, quaternion xyzw.", columns = ("f"):rep(7) },
  { "duet.CompactTransforms", "The same in 20 bytes: the quaternion's parts are whole numbers.", columns = ("f"):rep(3) .. ("h"):rep(4) },
  { "duet.Sizes", "How large boxes are: rows of half extents xyz.", columns = ("f"):rep(3) },
  { "duet.RoundedBoxes", "Boxes with a radius, so capsules and spheres too: rows of a pose, radius.", columns = ("f"):rep(11) },
  { "duet.Spheres", "Rows of centre xyz, radius.", columns = ("f"):rep(4) },
  { "duet.Pairs", "Collisions: rows of two ids a < b, from 0.", columns = "II" },
  { "duet.Search", "A strategy that looks for the best share, asked and told by a script." },
  { "duet.Strategy", "A table: a way to search.", [[
    name: string
    about: string  what it does, in a line
  ]] },
  { "duet.Tuning", "A table: what a tuning found.", [[
    plan: duet.Plan  to use
    best: duet.Plan  the best that shares the work; taken only where it is faster
    objects: integer
    level: string  of accuracy, that was tuned
    accuracy: duet.Accuracy  of that level, as measured
    true_pairs: integer  that it was measured on; 0: it was not
    gain: number  of the best plan over the better single device: 0.25 is a quarter faster
    gain_low, gain_high: number
    verdict: string  of the best plan: "faster", "same", "slower", "ambiguous"
    rounds: integer  of the race that the verdict is of
    watched: integer  launches whose threads were watched; 0: the system cannot
    disturbed: integer  and those of them that waited for a core
    step_ms: number  by the plan to use, the median; 0: the tuning gave up waiting for other programs
    step_low_ms, step_high_ms: number
    single_ms: number?  by the better single device; nil: not known
    single_joules: number  by it, as terms.joules by the plan to use; 0: energy was not measured
    whole_ms: number?  by the one device that A and B are parts of; nil: not raced
    whole_gain: number?  of the plan to use over that one; nil: not raced
    whole_gain_low, whole_gain_high: number?
    terms: table<string, number>  of equations 4 to 6: t1, cpu1, cpu2, gpu1 ... bus3, imbalance; joules
    kernels: table[]  what was searched of A's and B's: configs, tried, launches, gain, gain_low, gain_high, verdict
    plans: integer  that a strategy for kernels and share together could choose from; 0: it was none
    plans_tried: integer  by it
    trials: integer
    launches: integer  all, of interrupted sessions too
    seconds: number
    known: boolean  the same was asked and finished before: nothing was measured
    resumed: boolean  continued an interrupted session
    uid: string  of the profile in the store; empty: none is kept
    unused: string  why applications do not load it; empty: they do
  ]] },
  { "duet.Bodies", "What objects are besides: rows of velocity xyz, angular velocity xyz, mass, restitution, friction, group, mask, radius, fixed_rotation, sensor, rolling_resistance, surface velocity xyz, material. In a table a row may end behind sensor: the rest is 0.", columns = ("f"):rep(9) .. "IIfBBffffI" },
  { "duet.States", "Where objects are and how they move: rows of centre xyz, rotation xyzw, velocity xyz, angular velocity xyz.", columns = ("d"):rep(13) },
  { "duet.Contacts", "Where objects touch: rows of a, b, normal xyz, n, and four times anchor xyz, separation, normal impulse.", columns = "IIfffI" .. ("f"):rep(20) },
  { "duet.PairQuery", "The narrow phase alone: tests pairs that the script brings." },
  { "duet.Answers", "Rows of one number, 0 or 1: separated or colliding, awake or asleep.", columns = "C" },
  { "duet.Separations", "Rows of one number: how far apart two poses are; below 0, how deep in each other.", columns = "d" },
  { "duet.PairQueryResult", "A table: what a test found and took.", [[
    colliding: integer  pairs
    undecided: integer  pairs that float left open and the host decided
    total_ms: number  wall clock
    device_ms: number[]  of A and of B
  ]] },
  { "duet.Tree", "Boxes in a tree on both devices, for queries." },
  { "duet.RayQuery", "Casts rays at the boxes of a tree." },
  { "duet.Rays", "Rows of origin xyz, direction xyz, t_max.", columns = ("f"):rep(7) },
  { "duet.LargePoses", "Rows of offset xyz, half extents xyz, rotation xyzw and origin cell xyz, whole numbers.", columns = ("f"):rep(10) .. "iii" },
  { "duet.LargeRays", "Rows of offset xyz, direction xyz, t_max and origin cell xyz.", columns = ("f"):rep(7) .. "iii" },
  { "duet.LargeSweeps", "Rows of offset xyz, half extents xyz, rotation xyzw, origin cell xyz, direction xyz, t_max.", columns = ("f"):rep(10) .. "iiiffff" },
  { "duet.LargePoints", "Rows of offset xyz and origin cell xyz.", columns = "fffiii" },
  { "duet.Hits", "Rows of a ray, the id of the box that it meets, and where: origin + t direction.", columns = "IIf" },
  { "duet.Ids", "Rows of one whole number: bodies' ids, or what a script keeps for them.", columns = "Q" },
  { "duet.Forces", "What pushes in the next step: rows of force xyz, torque xyz.", columns = ("f"):rep(6) },
  { "duet.Impulses", "What pushes at once: rows of impulse xyz, anchor xyz, from the centre.", columns = ("f"):rep(6) },
  { "duet.StateRows", "A part of a motion's state in place: rows of four numbers.", columns = ("f"):rep(4) },
  { "duet.DoubleStateRows", "The same of a motion with doubles.", columns = ("d"):rep(4) },
  { "duet.RayQueryResult", "A table: what casting rays took.", [[
    normals: duet.Points?  of the hits: rows xyz, of length 1 and out of the box; 0 where a ray begins in it, and for no hit
]] .. asked },
  { "duet.ContactQuery", "The narrow phase of contacts, for pairs that a world found or a script brings." },
  { "duet.ContactQueryResult", "A table: what finding contacts took.", [[
    touching: integer  contacts with points
    total_ms: number  wall clock
    device_ms: number[]  of A and of B
  ]] },
  { "duet.Places", "Places of objects, from 0: their ids where no body came or went.", columns = "I" },
  { "duet.PairDelta", "The pairs of a still world's last step." },
  { "duet.Replay", "Recorded commands to a motion." },
  { "duet.ReplayInfo", "A table: what a replay holds.", [[
    steps: integer  recorded
    commands: integer  recorded
    steps_done: integer  so far
  ]] },
  { "duet.BoxQuery", "Tests boxes against those of a tree." },
  { "duet.Filters", "A group and a mask of each object: two touch where each one's group has a bit of the other's mask.", columns = "II" },
  { "duet.BoxHits", "Rows of a box that was asked about, and the id of the tree's box that it collides with.", columns = "II" },
  { "duet.BoxQueryResult", "A table: what testing boxes took.", asked },
  { "duet.PointQuery", "Asks which boxes of a tree contain points, or are nearest to them." },
  { "duet.Points", "Rows of xyz.", columns = "fff" },
  { "duet.PointHits", "Rows of a point, the id of a box, and the distance between them.", columns = "IIf" },
  { "duet.PointQueryResult", "A table: what asking about points took.", asked },
  { "duet.SweepQuery", "Moves boxes along straight lines, to what they meet in a tree." },
  { "duet.Sweeps", "Rows of a pose, direction xyz, t_max.", columns = ("f"):rep(14) },
  { "duet.BoundsSweeps", "Rows of lower xyz, upper xyz, direction xyz, t_max.", columns = ("f"):rep(10) },
  { "duet.RoundedSweeps", "Rows of a pose, radius, direction xyz, t_max.", columns = ("f"):rep(15) },
  { "duet.SphereSweeps", "Rows of centre xyz, radius, direction xyz, t_max.", columns = ("f"):rep(8) },
  { "duet.SweepHits", "Rows of a sweep, the id of the box that it meets, t, and the normal there.", columns = "IIffff" },
  { "duet.SweepQueryResult", "A table: what moving boxes took.", asked },
  { "duet.TaskFile", "A kernel of the user's with its arguments and what is right, as a task file describes it." },
  { "duet.Task", "The same on a device pair, run again and again." },
  { "duet.TaskArg", "A table: an argument of a task's kernel.", [[
    name: string  the kernel's name of it
    type: string  of an element of an array, "float4"; empty for a number
    access: string  of an array: all, slice, out slice, in out slice or sum
    elements: integer  of an array; 0: it is a number
    bytes: integer  of an element
  ]] },
  { "duet.TaskResult", "A table: what a run of a task took.", [[
    total_ms: number  wall clock
    device_ms: number[]  of A and of B
    stages: duet.Stage[]  what was sent, launched and fetched
  ]] },
  { "duet.Kernel", "A table: a kernel and its card.", [[
    name: string
    about: string  what it does
    configs: integer  valid ones
    params: table[]  { name, about, default, values }
  ]] },
  { "duet.Source", "A table: the text of a variant.", [[
    name: string  of the variant
    sha256: string  of the text
    text: string  OpenCL C
    group: integer  work-items in a group
    per_item: integer  work that one item does
  ]] },
  { "duet.Level", "A table: a level of accuracy.", [[
    name: string
    about: string  what is tested
    missed: number  how deep, as part of the sizes, a collision may be that is missed
    added: number  how far apart what is added may be
  ]] },
  { "duet.Accuracy", "A table: how much may be wrong, by the number of pairs that collide.", [[
    missed: number  of those pairs, not found
    false_rate: number  found besides those pairs
  ]] },
  { "duet.Motion", "Objects that move." },
  { "duet.MotionResult", "What a motion's step did; holds until the next.", [[
    step: integer  steps since the start
    time: number  step * dt
    pairs: integer  that may touch
    contacts: integer  that push
    colours: integer  rounds of a solution
    rebuilt: boolean  pairs were searched in this step
    n_events: integer  contacts that began or ended
    n_stays: integer  contacts that touch and did so in the last step
    n_hits: integer  impacts above hit_speed
    total_ms: number
    timed: boolean  the stages are of this step; else of the last that was timed
  ]] },
  { "duet.Energy", "A table: energies and momenta of a motion.", [[
    kinetic: number  of objects with a mass
    turning: number  of their rotation
    potential: number
    momentum: number[]
    angular: number[]  momentum about the origin
  ]] },
  { "duet.SubstepInfo", "A table: how many substeps a step has, and why.", [[
    substeps: integer  of a step
    chosen: boolean  the def left them to the motion
    layers: integer  if chosen: bodies on each other in the column that decides; 0: nothing stands
    edge: number  if chosen: the column's least width^2 / height
  ]] },
  { "duet.Effect", "A table: one effect of a motion, and what calls for it.", [[
    name: string
    active: boolean
    called_by: string  what calls for it, or would
    kernels: string  those that have code for it
    bytes: integer  of state an object, on B
  ]] },
  { "duet.Scene", "Objects with the world they live in.", [[
    dims: integer  2 or 3
    shape: "poses"|"bounds"|"rounded boxes"|"spheres"  what its rows are
    n: integer  objects; also #scene
    rotated: boolean  some object has a rotation
    cell: number  cell edge asked for; 0: chosen from the objects
    cell_fixed: boolean  a cell that is too small is refused
    has_world: boolean  lower and upper were given
    lower: number[]  of the world
    upper: number[]  of the world
    level: string  of accuracy, that the scene wants
    has_accuracy: boolean  it leaves the level to a profile within accuracy
    accuracy: duet.Accuracy
    origin_edge: number  edge of the origin cells that its objects are placed in; 0: none
  ]] },
  { "duet.World", "Objects on a device pair, stepped again and again." },
  { "duet.Cluster", "Objects divided among the ranks of an MPI job; every rank runs the script and makes the same calls." },
  { "duet.ClusterResult", "A table: what all ranks found in a step.", [[
    objects: integer  of all ranks, as are
    pairs: integer  their number
    hash: string  the pair hash, as duet.Result:hash has it
    total_ms: number  wall clock of the rank that took longest
  ]] },
  { "duet.ClusterMotionResult", "A table: what a time step over all ranks did.", [[
    step: integer  steps taken, this one included
    bodies: integer  of all ranks, as are
    ghosts: integer  bodies that domains have of others
    contacts: integer  that push
    colours: integer
    total_ms: number  wall clock of the rank that took longest
    slowest_ms: number  that the rank was busy that was so longest, of steps before
    mean_ms: number  and the mean rank
    slowest_rank: integer
    events: duet.ClusterEvent[]  contacts that began or ended, of this rank
    stays: duet.ClusterStay[]  that touch and did so in the last step, likewise
    hits: duet.ClusterHit[]  impacts above hit_speed, likewise
  ]] },
  { "duet.ClusterEvent", "A table: a contact that began or ended.", [[
    a: integer  a global id, as the others
    b: integer  or a wall
    begins: boolean
  ]] },
  { "duet.ClusterStay", "A table: a contact that goes on.", [[
    a, b: integer
  ]] },
  { "duet.ClusterHit", "A table: an impact.", [[
    a, b: integer
    point: number[]  x, y and z
    normal: number[]  from a to b
    speed: number  along the normal
    impulse: number  the greatest of a substep
  ]] },
  { "duet.ClusterRank", "A table: what one rank did in the last step.", [[
    host: string
    pair: string  selectors of its devices; "plain" without
    objects: integer  that it owns
    ghosts: integer  objects of other ranks that it received
    pairs: integer  that it found
    sent_bytes: integer  to other ranks
    busy_ms: number
    wait_ms: number  for other ranks, and for what they sent
  ]] },
  { "duet.Pairs64", "Collisions of a cluster: rows of two ids a < b, of 64 bits.", columns = "QQ" },
  { "duet.Online", "Keeps the plan of a world or a motion near its best while frames go by." },
  { "duet.Result", "What a step found; holds until the world's next step.", [[
    objects: integer  in the step
    bad: integer  objects left out (keep_bad)
    first_bad: integer  the least id among them
    candidates: integer  pairs whose bounds overlap
    undecided: integer  pairs that float left open and the host decided
    total_ms: number  wall clock, poses in to pairs on the host
    device_ms: number[]  of A and of B
    kernel_ms: number[]  of A and of B, from the first kernel to the last one's end
    bytes: integer[]  memory held on A and on B
    cells: integer[]  the grid
    cell: number  its least edge
    cell_widened: boolean  the edge asked for was below the largest object
    grid_levels: integer  each with cells of its own size
    hashed: boolean  cells share a table's entries, as in a sparse world
    runs: integer  1, or more where a buffer had to grow
    timed: boolean  stages and kernel_ms are of this step; else of the last that was timed
  ]] },
}

-- Stands for C names that no single Lua name stands for.
api.others = {
  ["the third result of a failed call"] = { "duet_status_name" },
  ["the garbage collector"] = { "duet_free" },
  ["fields that a table leaves out"] = {
    "duet_default_device_pair_def", "duet_default_world_def", "duet_default_tune_def",
    "duet_default_online_def", "duet_default_cluster_def", "duet_default_motion_def", "duet_default_body", "duet_default_pair_query_def",
    "duet_default_ray_query_def", "duet_default_contact_query_def",
    "duet_default_task_def", "duet_default_tree_def", "duet_default_ray_query_def", "duet_default_box_query_def",
    "duet_default_point_query_def", "duet_default_sweep_query_def",
  },
  ["a scene with origin = \"cell\""] = {
    "duet_large_pose_set",
    "duet_large_poses_collide", "duet_large_poses_separation",
  },
  ["an OpenCL program in C: scripts have no OpenCL of their own"] = {
    "duet_device_pair_create_on_queues", "duet_world_set_objects_buffer", "duet_world_leave_pairs",
    "duet_world_bring_pairs", "duet_world_get_pair_buffers", "duet_world_step_begin_event",
    "duet_motion_copy_states", "duet_task_set_buffer",
  },
  ["a task file: scripts are Lua as it is"] = { "duet_task_file_create" },
  ["set_poses of a world of compact transforms"] = { "duet_compact_transform_set" },
  ["tostring of a device pair"] = { "duet_device_pair_is_one" },
  ["require"] = {
    "luaopen_duet", "luaopen_duet_frame", "luaopen_duet_lab", "luaopen_duet_plot",
    "luaopen_duet_timeline",
  },
}

local ids = "ids: duet.Ids|integer[]|integer|table"

api.names = {
  { "duet.version", "string", "\"0.9.0\"", c = "duet_version" },
  { "duet.devices", {}, "duet.Device[]",
    "All root devices of all platforms; in its absent is for each platform without one why, as a line.", fails = true,
    c = { "duet_device_list_create", "duet_device_list_destroy", "duet_device_list_get_count",
          "duet_device_list_get_info", "duet_device_list_get_absent", "duet_device_info_get_quirk" } },
  { "duet.device_pair", { "def?: string|{ a?: string, b?: string, kernel_dir?: string, cache_dir?: string }" },
    "duet.DevicePair", "Opens two devices, as \"cpu,gpu\", \"halves\" or by their selectors; the default pair without.",
    fails = true, c = { "duet_device_pair_create", "duet_device_pair_open" } },
  { "duet.profiles", { "path?: string", "replaced_too?: boolean" }, "duet.StoredProfile[]",
    "The profiles of a store, the user's without a path; those that are not used come last.",
    fails = true, c = { "duet_profile_list_create", "duet_profile_list_destroy",
                        "duet_profile_list_get_count", "duet_profile_list_get_profile" } },
  { "duet.profile_trials", { "uid: string", "path?: string" }, "duet.StoredTrial[]",
    "The trials of the profile that is named by its uid's first digits.", fails = true, c = "duet_profile_get_trials" },
  { "duet.use_profile", { "uid: string", "path?: string" }, "true",
    "Makes a stored profile the one that applications load in its place.", fails = true, c = "duet_profile_use" },
  { "duet.forget_profile", { "uid: string", "path?: string" }, "true",
    "Removes a profile; its trials stay.", fails = true, c = "duet_profile_forget" },
  { "duet.export_profiles", { "file: string", "path?: string" }, "true",
    "Writes all rows of a store to a file, as JSON lines.", fails = true, c = "duet_profiles_export" },
  { "duet.import_profiles", { "file: string", "path?: string" }, "integer, integer",
    "Takes such a file's rows in, all or none: how many were added, and how many known.",
    fails = true, c = "duet_profiles_import" },
  { "duet.scene", { "from: string|duet.Poses|duet.Bounds|duet.RoundedBoxes|duet.Spheres", "settings?: table|integer" }, "duet.Scene",
    "Loads a scene from a file, or by name one that comes with Duet, with settings for a Lua scene; or copies rows, with dims 2 or 3.",
    fails = true, c = { "duet_scene_load", "duet_scene_create" } },
  { "duet.load_pairs", { "path: string" }, "duet.Scene",
    "Reads pairs for duet.PairQuery:run, two poses a row; rows 0 and 1 of its poses are the first pair.", fails = true,
    c = "duet_scene_load_pairs" },
  { "duet.modes", {}, "string[]", "The modes that a plan can have.", c = "duet_mode_name" },
  { "duet.search", { "def?: { strategy?: string, strategy_lua?: string, launches?: integer, points?: integer, rounds?: integer, " ..
    "quantum?: number, start?: number, probe_cost?: number }" }, "duet.Search",
    "Begins a search for the share; the default strategy without.", fails = true },
  { "duet.strategies", {}, "duet.Strategy[]", "The strategies there are, the default first.",
    c = { "duet_strategy_get_name", "duet_strategy_get_summary" } },
  { "duet.Search:ask", {}, "number?", "The share to measure next; nothing once the search is done.", fails = true },
  { "duet.Search:tell", { "share: number", "total_ms: number", "a_ms: number", "b_ms: number" }, "true",
    "What was measured there: wall-clock times of the step and of the devices.", fails = true },
  { "duet.Search:pick", {}, "number", "The share to use after what was told so far." },
  { "duet.Search:bracket", {}, "number, number", "Where the strategy believes the best share to lie." },
  { "duet.Search:close", {}, nil, "Forgets the samples." },

  { "duet.cluster", { "def?: table" }, "duet.Cluster",
    "Begins a cluster of all ranks of the MPI job, which is one rank without mpirun. A def { pair (a text), plain, weight, parts, " ..
    "drops_pairs, imbalance, plan, dims, shape, level, rotated, cell, cell_fixed, max_pairs }. Needs libduet_cluster, and --trust.",
    fails = true, c = "duet_cluster_create" },
  { "duet.Cluster.rank", "integer", "of this process, from 0", c = "duet_cluster_get_rank" },
  { "duet.Cluster.rank_count", "integer", "", c = "duet_cluster_get_rank_count" },
  { "duet.Cluster:load_scene", { "from: string", "settings?: table" }, "table",
    "Reads a scene, as duet.scene does, and says what it is.", fails = true, c = "duet_cluster_load_scene" },
  { "duet.Cluster:scene", {}, "table?", "What the loaded scene is; n is of all ranks.",
    c = "duet_cluster_get_scene_info" },
  { "duet.Cluster:set_objects",
    { "ids: duet.Ids|integer[]", "objects: duet.Poses|duet.Bounds|duet.RoundedBoxes|duet.Spheres|duet.LargePoses|any[]" }, "true",
    "Objects of this rank's choice, with their ids; those of all ranks replace all that were there.",
    fails = true, c = "duet_cluster_set_objects" },
  { "duet.Cluster:map_owned", {}, "duet.Poses|duet.Bounds|duet.RoundedBoxes|duet.Spheres|duet.LargePoses, duet.Ids",
    "This rank's objects, of the kind that the def's shape or the scene says, to be written in place, and their ids; both hold " ..
    "until the next call.", fails = true, c = "duet_cluster_map_owned" },
  { "duet.Cluster:set_plan", { "plan: table" }, "true", "Of this rank's devices.", fails = true,
    c = "duet_cluster_set_plan" },
  { "duet.Cluster:set_level", { "level: string" }, "true", "Of accuracy, on all ranks.", fails = true,
    c = "duet_cluster_set_level" },
  { "duet.Cluster:load_profile", { "path?: string" }, "duet.Profile, string?",
    "Gives each rank the best plan that a store knows, and as many objects as suit its speed; or a motion how often ghosts come. Also why the store could not be read.",
    fails = true, c = "duet_cluster_load_profile" },
  { "duet.Cluster:step", {}, "duet.ClusterResult", "Finds all pairs.", fails = true, c = "duet_cluster_step" },
  { "duet.Cluster:own_pairs", {}, "duet.Pairs64",
    "The pairs of the last step that this rank found, before objects are mapped or set again; they hold until the next step.",
    fails = true, c = "duet_cluster_get_own_pairs" },
  { "duet.Cluster:ranks", {}, "duet.ClusterRank[]", "What each rank did in the last step, rank 0 first.", fails = true,
    c = "duet_cluster_get_ranks" },
  { "duet.Cluster:save_pairs", { "path: string", "sorted?: boolean" }, "true",
    "Writes all pairs of the last step as a NumPy array, by all ranks at once.", fails = true,
    c = "duet_cluster_save_pairs" },
  { "duet.Cluster:begin_motion", { "from: string", "settings?: table", "resume?: string" }, "true",
    "Reads a scene whose bodies move, on every rank whole, and divides its bodies among the ranks; resume: a file of save_motion.",
    fails = true, c = "duet_cluster_begin_motion" },
  { "duet.Cluster:motion_step", {}, "integer",
    "Steps that the motion has taken, those before a file that it goes on from included; 0: nothing moves.",
    c = "duet_cluster_get_motion_step" },
  { "duet.Cluster:advance", {}, "duet.ClusterMotionResult",
    "Takes a time step: bodies have the bits of one motion. After a failure the motion is gone.", fails = true,
    c = "duet_cluster_advance" },
  { "duet.Cluster:state_hash", {}, "string", "The state hash of all ranks' bodies, as duet.Motion:hash has it.", fails = true,
    c = "duet_cluster_get_state_hash" },
  { "duet.Cluster:save_motion", { "path: string" }, "true",
    "Writes all ranks' bodies; the file's bytes are the same for any number of ranks.", fails = true,
    c = "duet_cluster_save_motion" },
  { "duet.Cluster:close", {}, nil, "On all ranks, as every call.", c = "duet_cluster_destroy" },
  { "duet.DevicePair:device", { "which: \"A\"|\"B\"" }, "duet.Device", "One of the two devices.",
    c = "duet_device_pair_get_info" },
  { "duet.DevicePair:check_cache", {}, "true", "Whether built kernels can be kept where they are to be.",
    fails = true, c = "duet_device_pair_check_cache" },
  { "duet.DevicePair:plan", {}, "duet.Plan", "What is done here where nothing was measured.", c = "duet_default_plan" },
  { "duet.DevicePair:world", { "scene?: duet.Scene|table", "def?: table" }, "duet.World",
    "A world by a def { plan, dims, shape, level, accuracy, rotated, cell, cell_fixed, lower, upper, " ..
    "pose_form (poses, transforms, compact), ordered, keep_bad, max_pairs, stage_times }; given a scene, with its objects and, where the def says nothing, its settings.",
    fails = true, c = { "duet_world_create", "duet_scene_world_def" } },
  { "duet.DevicePair:tune", { "scene: duet.Scene|duet.TaskFile", "def?: table" }, "duet.Tuning",
    "Chooses variants, mode and share for the scene or task file and keeps them in a store. A def { store, keep, fresh, ordered, " ..
    "strategy, strategy_lua, strategy_name, objective (time, energy), search, query, items, steps, variants, modes, level (a name, or a list), accuracy, budget_seconds, budget_trials, wait_seconds, repeats, seed, script, watch }; " ..
    "watch(progress) is called after each trial, and while the tuning waits for other programs (progress.waiting says why), and stops the tuning with false. keep = false uses no store; " ..
    "keep = true lets applications load what a strategy other than the default one finds, too. " ..
    "With search = \"kernels\", or a kernel's name, it searches the kernels' parameters too. " ..
    "With steps = 100 it tunes the scene's motion, by runs of so many. " ..
    "With query = \"rays closest\" it looks for the share of what a tree of the objects is asked, for so many items.",
    fails = true, c = "duet_tune_run" },

  { "duet.DevicePair:close", {}, nil, "Worlds made on it stay until they are closed.", c = "duet_device_pair_destroy" },

  { "duet.Scene:poses", {}, "duet.Poses?", "A view of the objects; nil where they are bounds; in origin cells centres are rounded.",
    c = "duet_scene_get_objects" },
  { "duet.Scene:bounds", {}, "duet.Bounds?", "A view of the objects; nil where they are poses.",
    c = "duet_scene_get_objects" },
  { "duet.Scene:rounded_boxes", {}, "duet.RoundedBoxes?", "A view of the objects; nil where they are others.",
    c = "duet_scene_get_objects" },
  { "duet.Scene:spheres", {}, "duet.Spheres?", "A view of the objects; nil where they are others.",
    c = "duet_scene_get_objects" },
  { "duet.Scene:reference", { "level?: string" }, "duet.Pairs",
    "All pairs, exactly, by the plain C twin; or what a level finds. Ascending.",
    fails = true, c = { "duet_reference", "duet_reference" } },
  { "duet.Scene:close", {}, nil, "Gives the objects back.", c = "duet_scene_destroy" },
  { "duet.Scene.name", "string", "of the file or the scene's own", c = "duet_scene_get_info" },

  { "duet.World:set_poses", { "poses: duet.Poses|string|number[]|number[][]" }, "true",
    "Copies the objects in.", fails = true, c = "duet_world_set_objects" },
  { "duet.World:set_bounds", { "bounds: duet.Bounds|string|number[]|number[][]" }, "true",
    "Copies the objects in.", fails = true, c = "duet_world_set_objects" },
  { "duet.World:set_rounded_boxes", { "boxes: duet.RoundedBoxes|string|number[]|number[][]" }, "true",
    "Copies the objects in.", fails = true, c = "duet_world_set_objects" },
  { "duet.World:set_spheres", { "spheres: duet.Spheres|string|number[]|number[][]" }, "true",
    "Copies the objects in.", fails = true, c = "duet_world_set_objects" },
  { "duet.World:set_scene", { "scene: duet.Scene" }, "true", "Copies the scene's objects in.",
    fails = true, c = "duet_world_set_scene" },
  { "duet.World:map_poses", { "n: integer" }, "duet.Poses",
    "Space for n poses that the devices read without a copy: map, write, then step.", fails = true,
    c = "duet_world_map_objects" },
  { "duet.World:map_bounds", { "n: integer" }, "duet.Bounds", "The same for bounds.", fails = true,
    c = "duet_world_map_objects" },
  { "duet.World:map_rounded_boxes", { "n: integer" }, "duet.RoundedBoxes", "The same for rounded boxes.", fails = true,
    c = "duet_world_map_objects" },
  { "duet.World:map_spheres", { "n: integer" }, "duet.Spheres", "The same for spheres.", fails = true,
    c = "duet_world_map_objects" },
  { "duet.World:map_transforms", { "n: integer" }, "duet.Transforms",
    "The same for a world of transforms (pose_form): what a step sends there.", fails = true, c = "duet_world_map_objects" },
  { "duet.World:map_compact_transforms", { "n: integer" }, "duet.CompactTransforms",
    "The same for a world of compact transforms.", fails = true, c = "duet_world_map_objects" },
  { "duet.World:map_sizes", { "n: integer" }, "duet.Sizes",
    "Their sizes, which are sent again only once they were mapped again.", fails = true, c = "duet_world_map_objects" },
  { "duet.World:order", {}, "duet.Places",
    "The objects' ids by cell: rows that are kept in about this order make steps faster.", fails = true,
    c = "duet_world_order" },
  { "duet.World:plan", {}, "duet.Plan", "The plan of the next step.", c = "duet_world_get_plan" },
  { "duet.World:set_plan", { "plan: duet.Plan" }, "true", "What the table leaves out stays.",
    fails = true, c = "duet_world_set_plan" },
  { "duet.World:load_profile", { "path?: string" }, "duet.Profile",
    "Takes the best plan that a store of profiles knows for the objects; the user's store without a path.",
    fails = true, c = { "duet_world_load_profile", "duet_grade_name" } },
  { "duet.World:explain_profile", { "path?: string" }, "string",
    "Why a store of profiles has what it has for the objects: a line for each ground, from the best down.",
    fails = true, c = "duet_world_explain_profile" },
  { "duet.levels", {}, "duet.Level[]", "Levels of accuracy, the default first.", c = { "duet_level_get_info" } },
  { "duet.World:level", {}, "string", "Of accuracy, of the next step.", c = "duet_world_get_level" },
  { "duet.World:set_level", { "level: string" }, "true", "What is taken for a collision, from the next step on.",
    fails = true, c = { "duet_world_set_level", "duet_level_from_name" } },
  { "duet.level_covers", { "level: string", "other: string" }, "boolean",
    "Whether the first promises all that the second does.", c = "duet_level_covers" },
  { "duet.World:step", {}, "duet.Result", "Finds all pairs.", fails = true, c = "duet_world_step" },
  { "duet.World:step_begin", {}, "true", "Begins a step that a thread of Duet's carries while the script goes on.",
    fails = true, c = "duet_world_step_begin" },
  { "duet.World:step_end", {}, "duet.Result", "Waits for the step that began; nothing else can be done to the world before.",
    fails = true, c = "duet_world_step_end" },
  { "duet.World:online", { "def?: { most_extra?: number, modes?: string[], variants?: string[], keep?: boolean, store?: string }" }, "duet.Online",
    "Steps the world with every mode and variant, if it has objects, and begins to watch the frames' times.",
    fails = true, c = "duet_online_create" },
  { "duet.Online:step", {}, "duet.Result", "In the place of world:step.", fails = true, c = "duet_online_step" },
  { "duet.Motion:online", { "def?: { most_extra?: number }" }, "duet.Online",
    "Watches the motion's searches of pairs, and moves their share.", fails = true, c = "duet_online_create" },
  { "duet.Online:advance", {}, "duet.MotionResult", "In the place of motion:advance.", fails = true, c = "duet_online_advance" },
  { "duet.Task:online", { "def?: { most_extra?: number }" }, "duet.Online",
    "Watches the times of the task's runs, and moves its share.", fails = true, c = "duet_online_create" },
  { "duet.Online:run", {}, "duet.TaskResult", "In the place of task:run.", fails = true, c = "duet_online_run" },
  { "duet.Online:tunings", {}, "integer", "How often the share was tuned again, or another plan taken.", c = "duet_online_get_tunings" },
  { "duet.Online:close", {}, "true", "Stores what was learned, where that was asked for.", fails = true,
    c = "duet_online_destroy" },
  { "duet.World:close", {}, nil, "Gives the devices' memory back.", c = "duet_world_destroy" },

  { "duet.Result:pairs", {}, "fun(): integer, integer", "for a, b in result:pairs() do" },
  { "duet.Result:pair", { "place: integer" }, "integer, integer", "The pair at a place from 0.",
    c = "duet_result_get_pair" },
  { "duet.Result:copy", {}, "duet.Pairs", "The pairs in memory of their own." },
  { "duet.Result:stages", {}, "duet.Stage[]", "Where the time went." },
  { "duet.Result:hash", {}, "string", "The pair hash, 16 hex digits.", c = "duet_result_get_hash" },
  { "duet.Result:close", {}, nil, "Forgets the world." },

  { "duet.Pairs:hash", {}, "string", "The pair hash, 16 hex digits.", c = "duet_pairs_hash" },
  { "duet.Poses:collide", { "a: integer", "b: integer", "dims?: integer" }, "boolean",
    "Whether the exact boxes of two rows share a point.", c = "duet_poses_collide" },
  { "duet.Poses:separation", { "a: integer", "b: integer", "dims?: integer" }, "number",
    "How far two rows are apart along the best axis; below 0, how deep in each other.", c = "duet_poses_separation" },

  { "duet.DevicePair:query", { "def?: { level?: string, share?: number, dims?: integer }" }, "duet.PairQuery",
    "Readies both devices to test pairs at a level; A has the share, of the default plan where none is given.",
    fails = true, c = "duet_pair_query_create" },
  { "duet.RoundedBoxes:collide", { "a: integer", "b: integer", "dims?: integer" }, "boolean",
    "Whether the exact rounded boxes of two rows share a point.", c = "duet_rounded_boxes_collide" },
  { "duet.RoundedBoxes:separation", { "a: integer", "b: integer", "dims?: integer" }, "number",
    "How far two rows are apart; below 0, how deep in each other.", c = "duet_rounded_boxes_separation" },
  { "duet.PairQuery:run", { "poses: duet.Poses|string|number[]|number[][]", "with_separations?: boolean" },
    "duet.Answers, duet.PairQueryResult, duet.Separations?", "Tests rows 0 and 1, 2 and 3 ... with each other.",
    fails = true, c = "duet_pair_query_run" },
  { "duet.PairQuery:close", {}, nil, "Gives the devices' memory back.", c = "duet_pair_query_destroy" },

  { "duet.task_file", { "path: string", "settings?: table" }, "duet.TaskFile",
    "Reads a task file with these parameters set, to be tuned.", fails = true, c = "duet_task_file_load" },
  { "duet.TaskFile:close", {}, nil, "Gives the arrays' memory back.", c = "duet_task_file_destroy" },
  { "duet.DevicePair:task", { "path: string", "settings?: table" }, "duet.Task",
    "Reads a task file without what is right, makes its arrays on both devices and builds its kernel. Runs are not checked.",
    fails = true, c = "duet_task_create" },
  { "duet.Task:args", {}, "duet.TaskArg[]", "The kernel's arguments, by name.", c = "duet_task_get_arg" },
  { "duet.Task:items", {}, "integer", "How many items there are.", c = "duet_task_get_items" },
  { "duet.Task:set", { "name: string", "value: number|number[]|string" }, "duet.Task",
    "Sets a number, or all of an array that is read: a list of its components, or a string of its bytes.",
    fails = true, c = { "duet_task_set_number", "duet_task_set_integer", "duet_task_set_array" } },
  { "duet.Task:get", { "name: string", "form?: string" }, "number[]|string",
    "All of an array, as a list of its components, or with \"bytes\" as a string.",
    fails = true, c = "duet_task_get_array" },
  { "duet.Task:plan", {}, "duet.Plan", "The plan of its runs; a task has no modes.", c = "duet_task_get_plan" },
  { "duet.Task:set_plan", { "plan: duet.Plan|table" }, "duet.Task",
    "Sets share and variants of the following runs; what it leaves out stays.", fails = true, c = "duet_task_set_plan" },
  { "duet.Task:load_profile", { "path?: string" }, "duet.Profile",
    "Gives it the best plan that a store knows for its kernel, key and size on these devices.",
    fails = true, c = "duet_task_load_profile" },
  { "duet.Task:run", {}, "duet.TaskResult", "Runs the kernel over all items on both devices.",
    fails = true, c = "duet_task_run" },
  { "duet.Task:close", {}, nil, "Gives the devices' memory back.", c = "duet_task_destroy" },

  { "duet.DevicePair:tree", { "motion?: duet.Motion|table", "def?: { shape?: string, share?: number, dims?: integer, origin_edge?: number }" }, "duet.Tree",
    "An empty tree; shape is that of a world, and A has the share of what its queries ask. With an origin_edge " ..
    "it is of large poses, in origin cells of that edge. Given a motion, the tree of its bodies where they are: " ..
    "dims, origin_edge and, if they have radii, shape are the motion's where the def says nothing.",
    fails = true, c = { "duet_tree_create", "duet_motion_tree_def" } },
  { "duet.Tree:set_objects", { "objects: duet.Poses|duet.Bounds|duet.RoundedBoxes|duet.Spheres|duet.LargePoses|string|number[]|number[][]" }, "duet.Tree",
    "The boxes from now on, as the tree's shape; they are copied.", fails = true, c = "duet_tree_set_objects" },
  { "duet.Tree:set_motion", { "motion: duet.Motion" }, "duet.Tree",
    "The boxes from now on are a motion's bodies where they are, by place; removed and disabled ones are left out. " ..
    "Bodies with radii need a tree of rounded boxes.", fails = true, c = "duet_tree_set_motion" },
  { "duet.Tree:set_heights", { "heights?: table" }, "duet.Tree",
    "A ground { nx, ny, spacing, origin, values } beside the boxes, or none; a motion brings its own. Queries find it as one more box, " ..
    "with the number of boxes plus 6 as its id.", fails = true, c = "duet_tree_set_heights" },
  { "duet.Tree:set_mesh", { "mesh?: table" }, "duet.Tree",
    "A ground of triangles, { file, scale } or { vertices, triangles }, with origin, instead of heights, or none. Only the triangles " ..
    "are part of it, from both sides.", fails = true, c = "duet_tree_set_mesh" },
  { "duet.Tree:set_filters", { "filters: duet.Filters|string|integer[]|integer[][]" }, "duet.Tree",
    "The boxes' filters until they are set again; a motion's bodies bring theirs. Queries whose def has a filter { group, mask } " ..
    "find the boxes that it can touch.", fails = true, c = "duet_tree_set_filters" },
  { "duet.Tree:set_share", { "share: number" }, "duet.Tree", "A's part of what its queries ask from now on, 0 to 1.",
    fails = true, c = "duet_tree_set_share" },
  { "duet.Tree:load_profile", { "query: string", "n: integer", "path?: string" }, "duet.Profile",
    "Gives queries of a kind, as \"rays closest\", the share that a store of profiles knows for about n items; " ..
    "profile.plan.share is theirs after the call.", fails = true, c = "duet_tree_load_profile" },
  { "duet.Tree:close", {}, nil, "Gives the devices' memory back, once its queries are closed.",
    c = "duet_tree_destroy" },
  { "duet.NO_OBJECT", "integer", "the id where a query finds no box" },

  { "duet.Tree:ray_query", { "def?: { wants?: string, normals?: boolean, filter?: integer[] }" }, "duet.RayQuery",
    "Readies both devices for rays; wants is closest, any or every. With normals results have them, but not for any.",
    fails = true, c = { "duet_ray_query_create", "duet_query_wants_name" } },
  { "duet.RayQuery:run", { "rays: duet.Rays|duet.LargeRays|string|number[]|number[][]" }, "duet.Hits, duet.RayQueryResult",
    "Casts rays: a hit for each, or by wants = \"every\" all of them, by ray, t and id.",
    fails = true, c = { "duet_ray_query_run", "duet_ray_query_run_large" } },
  { "duet.RayQuery:close", {}, nil, "Gives the devices' memory back.", c = "duet_ray_query_destroy" },

  { "duet.Tree:box_query", { "def?: { level?: string, filter?: integer[] }" }, "duet.BoxQuery",
    "Readies both devices to test boxes against the tree's, at a level.", fails = true, c = "duet_box_query_create" },
  { "duet.BoxQuery:run", { "boxes: duet.Poses|duet.Bounds|duet.RoundedBoxes|duet.Spheres|duet.LargePoses|string|number[]|number[][]" },
    "duet.BoxHits, duet.BoxQueryResult", "Which of the tree's boxes each collides with, by box and id.",
    fails = true, c = "duet_box_query_run" },
  { "duet.BoxQuery:run_itself", { "filters?: duet.Filters|string|integer[]|integer[][]" },
    "duet.BoxHits, duet.BoxQueryResult",
    "Which of the tree's boxes collide with each other, the lower id first, where their filters let them touch.",
    fails = true, c = "duet_box_query_run_itself" },
  { "duet.BoxQuery:close", {}, nil, "Gives the devices' memory back.", c = "duet_box_query_destroy" },

  { "duet.Tree:point_query", { "def?: { nearest?: integer, filter?: integer[] }" }, "duet.PointQuery",
    "Readies both devices for points: so many of the nearest boxes of each, or without `nearest` those that contain it.",
    fails = true, c = "duet_point_query_create" },
  { "duet.PointQuery:run", { "points: duet.Points|duet.LargePoints|string|number[]|number[][]" },
    "duet.PointHits, duet.PointQueryResult",
    "The boxes that contain each point, by point and id; or its nearest ones, by distance and id.",
    fails = true, c = { "duet_point_query_run", "duet_point_query_run_large" } },
  { "duet.PointQuery:close", {}, nil, "Gives the devices' memory back.", c = "duet_point_query_destroy" },

  { "duet.Tree:sweep_query", { "def?: { wants?: string, filter?: integer[] }" }, "duet.SweepQuery",
    "Readies both devices for poses or bounds that move; wants is closest, any or every.",
    fails = true, c = "duet_sweep_query_create" },
  { "duet.SweepQuery:run", { "sweeps: duet.Sweeps|duet.BoundsSweeps|duet.RoundedSweeps|duet.SphereSweeps|duet.LargeSweeps|string|number[]|number[][]" },
    "duet.SweepHits, duet.SweepQueryResult",
    "Moves boxes: a hit for each, or by wants = \"every\" all of them, by sweep, t and id.",
    fails = true, c = "duet_sweep_query_run" },
  { "duet.SweepQuery:close", {}, nil, "Gives the devices' memory back.", c = "duet_sweep_query_destroy" },

  { "duet.pair_delta", {}, "duet.PairDelta", "Compares a still world's pairs from step to step.", fails = true,
    c = "duet_pair_delta_create" },
  { "duet.PairDelta:update", { "pairs: duet.Pairs|string|number[]|number[][]" }, "duet.Pairs, duet.Pairs, duet.Pairs",
    "The pairs that began, ended and stay since the last update; ascending.", fails = true, c = "duet_pair_delta_update" },
  { "duet.PairDelta:close", {}, nil, "Gives the memory back.", c = "duet_pair_delta_destroy" },

  { "duet.DevicePair:contact_query", { "def?: { share?: number, dims?: integer, shape?: string, margin?: number }" },
    "duet.ContactQuery",
    "Readies both devices to find where pairs of poses, rounded boxes or spheres touch; points are kept up to a separation of margin.",
    fails = true, c = "duet_contact_query_create" },
  { "duet.ContactQuery:run", { "objects: duet.Poses|duet.RoundedBoxes|duet.Spheres|string|number[]|number[][]",
      "pairs: duet.Pairs|string|number[]|number[][]" },
    "duet.Contacts, duet.ContactQueryResult", "A contact for each pair, in their order; its n is 0 where boxes do not touch.",
    fails = true, c = "duet_contact_query_run" },
  { "duet.ContactQuery:close", {}, nil, "Gives the devices' memory back.", c = "duet_contact_query_destroy" },

  { "duet.kernels", { "limits?: { max_group?: integer, local_bytes?: integer, fp64?: boolean, cpu?: boolean }" },
    "duet.Kernel[]", "The kernels, and what their cards let vary on a device of these limits.", fails = true },
  { "duet.source", { "kernel: string", "settings?: table<string, integer>", "limits?: table" }, "duet.Source",
    "The exact text of a kernel with a config; what is not set takes the card's default.", fails = true },
  { "duet.effects", {}, "string[]", "All that a scene can call for.", c = "duet_effect_name" },
  { "duet.game_motion_def", { "dims?: integer" }, "table",
    "A def for an ordinary game in metres and seconds, z up, in 2D y: { dims, gravity, slop, wants } with all that its bodies " ..
    "may call for at any time, but radii.", c = "duet_game_motion_def" },
  { "duet.Scene:bodies", {}, "duet.Bodies?", "A view of what the scene says of motion; nil where that is nothing.",
    c = "duet_scene_get_bodies" },
  { "duet.DevicePair:motion", { "objects: duet.Scene|duet.Poses|string|any[]", "bodies?: duet.Bodies|string|any[]|table",
    "def?: table" },
    "duet.Motion", "Objects that move: of a scene, with def second, or poses with bodies. A def { plan, dims, wants, doubles, origin, origin_edge, gravity, attraction, centre, drag, " ..
    "boundary, lower, upper, heights, mesh, dt, substeps, integrator, skin, slop, max_push_speed, restitution_threshold, sleep_speed, sleep_after, hit_speed, event_mask, materials, material_pairs, stage_times, script }; " ..
    "heights is a ground, { nx, ny, spacing, origin, values, material }, or mesh, { file, scale } or { vertices, triangles }, with origin, material and carrier " ..
    "(docs/effects.md); " ..
    "wants is a list of effects, boundary none, walls or periodic, integrator euler, verlet or yoshida. Before each step script(step, motion) is called, " ..
    "with the number of the step that comes.",
    fails = true, c = { "duet_motion_create", "duet_motion_create_from_scene", "duet_scene_motion_def" } },
  { "duet.Motion:advance", {}, "duet.MotionResult", "Advances all objects by dt.", fails = true,
    c = "duet_motion_advance" },
  { "duet.Motion:advance_begin", {}, "true", "Begins a step that a thread of Duet's carries while the script goes on.",
    fails = true, c = "duet_motion_advance_begin" },
  { "duet.Motion:advance_end", {}, "duet.MotionResult",
    "Waits for the step that began; nothing else can be done to the motion before.", fails = true,
    c = "duet_motion_advance_end" },
  { "duet.Motion:plan", {}, "duet.Plan?", "The plan by which it seeks pairs; nil where it seeks none, and while a step is under way.",
    c = "duet_motion_get_plan" },
  { "duet.Motion:set_plan", { "plan: duet.Plan" }, "true",
    "What the table leaves out stays. variant_b may set LANES, WG and PER_ITEM of a motion's kernels; no bit changes.",
    fails = true, c = "duet_motion_set_plan" },
  { "duet.Motion:load_profile", { "path?: string" }, "duet.Profile",
    "Takes the best plan that a store of profiles knows for such a motion, at its start; the user's store without a path.",
    fails = true, c = "duet_motion_load_profile" },
  { "duet.Motion:effects", {}, "string[]", "Those that run. #motion is the number of objects.",
    c = { "duet_motion_get_effects", "duet_motion_get_count" } },
  { "duet.Motion:step", {}, "integer", "Steps since the start.", c = "duet_motion_get_step" },
  { "duet.Motion:read", { "into?: duet.States" }, "duet.States", "The state of all objects.", fails = true,
    c = "duet_motion_get_states" },
  { "duet.Motion:poses", {}, "duet.Poses", "A copy of where all objects are, as a tree or a world takes them.",
    fails = true, c = "duet_motion_get_poses" },
  { "duet.Motion:rounded_boxes", {}, "duet.RoundedBoxes", "The same with the bodies' radii.", fails = true,
    c = "duet_motion_get_rounded_boxes" },
  { "duet.Motion:asleep", {}, "duet.Answers", "Which objects sleep, as the last step left them: 1 or 0.", fails = true,
    c = "duet_motion_get_asleep" },
  { "duet.Motion:hash", {}, "string", "A sum over the state's bits, the same at any share.", fails = true,
    c = "duet_motion_get_hash" },
  { "duet.Motion:energy", {}, "duet.Energy", "Energies and momenta.", fails = true, c = "duet_motion_get_energy" },
  { "duet.Motion:read_of", { "places: duet.Places|string|integer[]" }, "duet.States", "The states of the objects in these places.",
    fails = true, c = "duet_motion_get_states_of" },
  { "duet.Motion:moved", {}, "duet.Places, duet.States",
    "The objects whose centre or rotation changed since the last call; all the first time.", fails = true,
    c = "duet_motion_get_moved" },
  { "duet.states_between", { "from: duet.States", "to: duet.States", "fraction: number" }, "duet.States",
    "States from one step's (0) to the next one's (1), for drawing.", c = "duet_state_between" },
  { "duet.Motion:contacts", {}, "duet.Contacts", "Where objects touched in the last step; ascending.", fails = true,
    c = "duet_motion_get_contacts" },
  { "duet.Motion:save", { "path: string" }, "true", "Writes the motion to a file.", fails = true,
    c = "duet_motion_save" },
  { "duet.Motion:load", { "path: string" }, "true", "Goes on from there bit for bit.", fails = true,
    c = "duet_motion_load" },
  { "duet.Motion:record", {}, "true", "Records commands and steps from here on.", fails = true,
    c = "duet_motion_record" },
  { "duet.Motion:save_recording", { "path: string" }, "true", "Writes what was recorded so far.", fails = true,
    c = "duet_motion_save_recording" },
  { "duet.replay", { "path: string" }, "duet.Replay", "Recorded commands, from a file.", fails = true,
    c = "duet_replay_create" },
  { "duet.Replay:advance", { "motion: duet.Motion" }, "duet.MotionResult",
    "Gives a motion the commands before the next recorded step, and advances it; after the last the hashes are compared.",
    fails = true, c = "duet_replay_advance" },
  { "duet.Replay:info", {}, "duet.ReplayInfo", "How many steps and commands were recorded, and how many steps are done.",
    c = "duet_replay_get_info" },
  { "duet.Replay:close", {}, nil, "Gives the memory back.", c = "duet_replay_destroy" },
  { "duet.Motion:explain", {}, "duet.Effect[]",
    "Every effect, and what calls for it, or would; last, how positions are kept.", c = "duet_motion_explain" },
  { "duet.Motion:explain_substeps", {}, "duet.SubstepInfo",
    "How many substeps a step has, and why.", c = "duet_motion_explain_substeps" },
  { "duet.Motion:map_states", { "part: string", "access: string", "first?: integer", "n?: integer" },
    "duet.StateRows|duet.DoubleStateRows",
    "The motion's own rows of centres, rotations, velocities or angular_velocities, to read or to write; until they are unmapped the motion does nothing else.",
    fails = true, c = { "duet_motion_map_states", "duet_state_part_name" } },
  { "duet.Motion:unmap_states", { "part: string" }, "true", "What was written is what the next step begins with.",
    fails = true, c = "duet_motion_unmap_states" },
  { "duet.Motion:add_bodies", { "poses: duet.Poses|string|any[]", "bodies?: duet.Bodies|string|any[]" }, "duet.Ids",
    "Bodies that come; their ids. Where a parameter is called ids it is a duet.Ids, a list, one id, or " ..
    "{ first = place, n = count }.", fails = true, c = "duet_motion_add_bodies" },
  { "duet.Motion:remove_bodies", { ids }, "true",
    "What touched them wakes. A removed body's id never is another's.", fails = true, c = "duet_motion_remove_bodies" },
  { "duet.Motion:disable_bodies", { ids }, "true",
    "They take no part until they are enabled.", fails = true, c = "duet_motion_disable_bodies" },
  { "duet.Motion:enable_bodies", { ids }, "true", "They come back, at rest.",
    fails = true, c = "duet_motion_enable_bodies" },
  { "duet.Motion:wake_bodies", { ids }, "true", "With the effect sleep.", fails = true, c = "duet_motion_wake_bodies" },
  { "duet.Motion:sleep_bodies", { ids }, "true",
    "They sleep unless they touch something that moves.", fails = true, c = "duet_motion_sleep_bodies" },
  { "duet.Motion:ids", { "first?: integer", "n?: integer" }, "duet.Ids",
    "The ids of the bodies at some places, or all; duet.NO_BODY where there is none.", fails = true,
    c = "duet_motion_get_ids" },
  { "duet.Motion:has_body", { "id: integer" }, "boolean", "Whether it is the id of a body that is there.",
    c = "duet_motion_has_body" },
  { "duet.Motion:set_user_data", { ids, "data: duet.Ids|integer[]" }, "true",
    "Keeps a whole number of 64 bits for each.", fails = true, c = "duet_motion_set_user_data" },
  { "duet.Motion:user_data", { ids }, "duet.Ids", "Those numbers; 0 at first.",
    fails = true, c = "duet_motion_get_user_data" },
  { "duet.Motion:set_bodies", { ids, "fields: string|string[]", "bodies: duet.Bodies|string|any[]" }, "true",
    "Sets velocity, angular_velocity, mass, restitution, friction, filter, fixed_rotation, radius, rolling_resistance, surface_velocity or material; the other columns are not read.",
    fails = true, c = { "duet_motion_set_bodies", "duet_body_field_name" } },
  { "duet.Motion:set_poses", { ids, "poses: duet.Poses|string|any[]" }, "true",
    "Puts them elsewhere, with these sizes.", fails = true, c = "duet_motion_set_poses" },
  { "duet.Motion:set_targets", { ids, "targets: duet.Transforms|string|any[]" },
    "true", "The next step moves these bodies of mass 0 there, and what they touch feels it.", fails = true,
    c = "duet_motion_set_targets" },
  { "duet.Motion:set_def", { "changes: table" }, "true",
    "Changes gravity, attraction, centre, drag, lower, upper, max_push_speed, restitution_threshold, sleep_speed, sleep_after.",
    fails = true, c = "duet_motion_set_def" },
  { "duet.Motion:def", {}, "table", "What set_def can change, as it is.", c = "duet_motion_get_def" },
  { "duet.Motion:apply_forces", { ids, "forces: duet.Forces|string|any[]" },
    "true", "For the next step; with the effect forces.", fails = true, c = "duet_motion_apply_forces" },
  { "duet.Motion:apply_impulses", { ids, "impulses: duet.Impulses|string|any[]" },
    "true", "Changes velocities at once.", fails = true, c = "duet_motion_apply_impulses" },
  { "duet.NO_BODY", "integer", "the id where a place has no body" },
  { "duet.Motion:close", {}, nil, "Gives the devices' memory back.", c = "duet_motion_destroy" },
  { "duet.MotionResult:events", {}, "fun(): integer, integer, boolean", "for a, b, begins in result:events() do" },
  { "duet.MotionResult:stays", {}, "fun(): integer, integer", "for a, b in result:stays() do" },
  { "duet.MotionResult:hits", {},
    "fun(): integer, integer, number, number, number, number, number, number, number, number",
    "for a, b, x, y, z, nx, ny, nz, speed, impulse in result:hits() do" },
  { "duet.MotionResult:stages", {}, "duet.Stage[]", "Where the time went, by effect." },
  { "duet.MotionResult:close", {}, nil, "Forgets the motion." },

}

-- Without patterns, which the prompt's sandbox has none of.
local function split(text, by)
  local parts, at = {}, 1
  local from, to = text:find(by, at, true)
  while from do
    parts[#parts + 1] = text:sub(at, from - 1)
    at = to + 1
    from, to = text:find(by, at, true)
  end
  parts[#parts + 1] = text:sub(at)
  return parts
end

-- A line has the names of fields, their type and, after two spaces, what they are.
local function add_fields(class, lines)
  for _, line in ipairs(split(lines, "\n")) do
    local colon = line:find(": ", 1, true)
    if colon then
      local about = split(line:sub(colon + 2), "  ")
      for _, field in ipairs(split(line:sub(5, colon - 1), ", ")) do
        table.insert(api.names, { class .. "." .. field, about[1], about[2] or "" })
      end
    end
  end
end

-- Arrays are made, read and written alike; a letter says what a column is.
local letters = { f = "number", d = "number", i = "integer", I = "integer", Q = "integer", h = "integer", C = "integer", B = "boolean" }

-- "duet.LargeRays" as "duet.large_rays".
local function snake_case(class)
  local letters = {}
  for i = 1, #class do
    local c = class:sub(i, i)
    letters[i] = (i > 6 and c ~= c:lower() and "_" or "") .. c:lower()
  end
  return table.concat(letters)
end

local function add_array(class, about, columns)
  local types = {}
  for i = 1, #columns do types[i] = letters[columns:sub(i, i)] end
  local row = table.concat(types, ", ")
  for _, name in ipairs {
    { snake_case(class), { "from: integer|string|any[]" }, class,
      about .. " Made of a number of rows, or as a copy of rows, of numbers or of packed rows." },
    { class .. ":get", { "place: integer" }, row, "The row at a place from 0." },
    { class .. ":set", { "place: integer", "...: any" }, nil, ("Writes a row: %d values."):format(#columns) },
    { class .. ":each", {}, "fun(): integer, " .. row, "for place, ... in it:each() do" },
    { class .. ":bytes", {}, "string", "All rows as they lie in memory, packed." },
    { class .. ":close", {}, nil, "Gives the memory back." },
  } do
    table.insert(api.names, name)
  end
end

for _, class in ipairs(api.classes) do
  local name, about, fields = table.unpack(class)
  if fields then add_fields(name, fields) end
  if class.columns then add_array(name, about, class.columns) end
end

-- A cluster's motion takes the commands of a motion.
local of_cluster = {
  set_def = { "duet_cluster_set_def", "duet_cluster_get_motion_def" }, user_data = "duet_cluster_get_user_data",
}
for _, name in ipairs {
  "add_bodies", "remove_bodies", "disable_bodies", "enable_bodies", "wake_bodies", "sleep_bodies", "set_user_data",
  "user_data", "set_bodies", "set_poses", "set_def", "apply_forces", "apply_impulses", "set_targets",
} do
  for k = 1, #api.names do
    local row = api.names[k]
    if row[1] == "duet.Motion:" .. name then
      api.names[#api.names + 1] = { "duet.Cluster:" .. name, row[2], row[3],
        row[4] .. " On all ranks; what rank 0 gives counts.", fails = true,
        c = of_cluster[name] or "duet_cluster_" .. name }
    end
  end
end

-- In one order.
table.sort(api.names, function(a, b) return a[1] < b[1] end)

return api
