-- SPDX-License-Identifier: MIT
-- Every name of the Lua API, once: definitions/duet.lua is made from this list
-- by define.lua, and tests hold it against the module and the C headers.
--
-- A row is { name, parameters, results, about, c = names of the C API that it
-- stands for }. A parameter is "name: type" or "name?: type"; a result with
-- fails = true may be nil, message, "STATUS" instead. "Class:method" is a
-- method, "Class.field" a value that is read from an object or a table.

local api = {}

api.classes = {
  { "duet.Device", "A table: one device as OpenCL presents it." },
  { "duet.Plan", "A table: how a step is to be done." },
  { "duet.Profile", "A table: what a store of profiles knows of a world." },
  { "duet.Stage", "A table: one kernel or transfer of a step." },
  { "duet.DevicePair", "An ordered device pair: A takes the share, B the rest." },
  { "duet.Poses", "Oriented boxes: rows of centre xyz, half extents xyz, quaternion xyzw." },
  { "duet.Bounds", "Axis-aligned boxes: rows of lower xyz, upper xyz." },
  { "duet.Pairs", "Collisions: rows of two ids a < b, from 0." },
  { "duet.Search", "A strategy that looks for the best share, asked and told by a script." },
  { "duet.Strategy", "A table: a way to search." },
  { "duet.Tuning", "A table: what a tuning found." },
  { "duet.Bodies", "What objects are besides: rows of velocity xyz, spin xyz, mass, restitution, friction, group, mask, upright." },
  { "duet.States", "Where objects are and how they move: rows of centre xyz, rotation xyzw, velocity xyz, spin xyz." },
  { "duet.Contacts", "Where objects touch: rows of a, b, normal xyz, n, and four times arm xyz, gap, push." },
  { "duet.Motion", "Objects that move." },
  { "duet.MotionResult", "What a motion's step did; holds until the next." },
  { "duet.Energy", "A table: energies and momenta of a motion." },
  { "duet.Effect", "A table: one effect of a motion, and what calls for it." },
  { "duet.Scene", "Objects with the world they live in." },
  { "duet.World", "Objects on a device pair, stepped again and again." },
  { "duet.Online", "Keeps a world's share near its best while frames go by." },
  { "duet.Result", "What a step found; holds until the world's next step." },
}

-- What stands for C names that no single Lua name does.
api.others = {
  ["the third result of a failed call"] = { "duet_status_name" },
  ["the garbage collector"] = { "duet_free" },
  ["fields that a table leaves out"] = {
    "duet_default_device_pair_def", "duet_default_world_def", "duet_default_tune_def",
    "duet_default_online_def", "duet_default_motion_def", "duet_default_body",
  },
  ["require"] = {
    "luaopen_duet", "luaopen_duet_frame", "luaopen_duet_lab", "luaopen_duet_plot",
  },
}

api.names = {
  { "duet.version", "string", "\"1.0.0\"", c = "duet_version" },
  { "duet.devices", {}, "duet.Device[]", "All root devices of all platforms.", fails = true,
    c = { "duet_device_list_open", "duet_device_list_close", "duet_device_list_count",
          "duet_device_list_at" } },
  { "duet.device_pair", { "def?: { a?: string, b?: string, kernel_dir?: string, cache_dir?: string }" },
    "duet.DevicePair", "Opens two devices by their selectors; the default pair without.",
    fails = true, c = "duet_device_pair_open" },
  { "duet.scene", { "from: string|duet.Poses|duet.Bounds", "settings?: table|integer" }, "duet.Scene",
    "Loads a scene from a file, with settings for a Lua scene; or copies rows, with dims 2 or 3.",
    fails = true,
    c = { "duet_scene_load", "duet_scene_from_poses", "duet_scene_from_bounds" } },
  { "duet.modes", {}, "string[]", "The modes that a plan can have.", c = "duet_mode_name" },
  { "duet.search", { "def?: { strategy?: string, launches?: integer, points?: integer, rounds?: integer, " ..
    "quantum?: number, start?: number, probe_cost?: number }" }, "duet.Search",
    "Begins a search for the share; the default strategy without.", fails = true },
  { "duet.strategies", {}, "duet.Strategy[]", "The strategies there are, the default first.",
    c = { "duet_strategy", "duet_strategy_about" } },
  { "duet.Strategy.name", "string", "" },
  { "duet.Strategy.about", "string", "what it does, in a line" },
  { "duet.Search:ask", {}, "number?", "The share to measure next; nothing once the search is done.", fails = true },
  { "duet.Search:tell", { "share: number", "total_ms: number", "a_ms: number", "b_ms: number" }, "true",
    "What was measured there: wall-clock times of the step and of the devices.", fails = true },
  { "duet.Search:pick", {}, "number", "The share to use after what was told so far." },
  { "duet.Search:bracket", {}, "number, number", "Where the strategy believes the best share to lie." },
  { "duet.Search:close", {}, nil, "Forgets the samples." },

  { "duet.DevicePair:device", { "which: \"A\"|\"B\"" }, "duet.Device", "One of the two devices.",
    c = "duet_device_pair_info" },
  { "duet.DevicePair:plan", {}, "duet.Plan", "What is done here where nothing was measured.",
    c = "duet_default_plan" },
  { "duet.DevicePair:world", { "scene?: duet.Scene|table", "def?: table" }, "duet.World",
    "A world by a def { plan, dims, shape, rotated, cell, cell_fixed, lower, upper, keep_bad, " ..
    "max_pairs }; given a scene, with its objects and, where the def says nothing, its settings.",
    fails = true, c = { "duet_world_create", "duet_scene_world_def" } },
  { "duet.DevicePair:tune", { "scene: duet.Scene", "def?: table" }, "duet.Tuning",
    "Chooses variants, mode and share for the scene and keeps them in a store. A def { store, keep, fresh, " ..
    "strategy, strategy_lua, variants, modes, budget_seconds, budget_trials, repeats, seed, script, watch }; " ..
    "watch(progress) is called after each trial and stops the tuning with false.",
    fails = true, c = "duet_tune_run" },
  { "duet.Tuning.plan", "duet.Plan", "to use" },
  { "duet.Tuning.best", "duet.Plan", "the best that shares the work; taken only where it is faster" },
  { "duet.Tuning.objects", "integer", "" },
  { "duet.Tuning.gain", "number", "of the best plan over the better single device: 0.25 is a quarter faster" },
  { "duet.Tuning.gain_low", "number", "" },
  { "duet.Tuning.gain_high", "number", "" },
  { "duet.Tuning.verdict", "string", "of the best plan: \"faster\", \"same\", \"slower\", \"ambiguous\"" },
  { "duet.Tuning.step_ms", "number", "by the plan to use, the median" },
  { "duet.Tuning.step_low_ms", "number", "" },
  { "duet.Tuning.step_high_ms", "number", "" },
  { "duet.Tuning.single_ms", "number", "by the better single device" },
  { "duet.Tuning.terms", "table<string, number>", "of equations 4 to 6: t1, cpu1, cpu2, gpu1 ... bus3, imbalance" },
  { "duet.Tuning.trials", "integer", "" },
  { "duet.Tuning.launches", "integer", "all, of interrupted sessions too" },
  { "duet.Tuning.seconds", "number", "" },
  { "duet.Tuning.known", "boolean", "finished before: nothing was measured" },
  { "duet.Tuning.resumed", "boolean", "continued an interrupted session" },

  { "duet.DevicePair:close", {}, nil, "Worlds made on it stay until they are closed.",
    c = "duet_device_pair_close" },

  { "duet.Scene:poses", {}, "duet.Poses?", "A view of the objects; nil where they are bounds.",
    c = "duet_scene_poses" },
  { "duet.Scene:bounds", {}, "duet.Bounds?", "A view of the objects; nil where they are poses.",
    c = "duet_scene_bounds" },
  { "duet.Scene:reference", {}, "duet.Pairs", "All pairs, exactly, by the plain C twin; ascending.",
    fails = true, c = "duet_reference" },
  { "duet.Scene:close", {}, nil, "Gives the objects back.", c = "duet_scene_destroy" },
  { "duet.Scene.name", "string", "of the file or the scene's own", c = "duet_scene_describe" },
  { "duet.Scene.dims", "integer", "2 or 3" },
  { "duet.Scene.shape", "\"poses\"|\"bounds\"", "what its rows are" },
  { "duet.Scene.n", "integer", "objects; also #scene" },
  { "duet.Scene.rotated", "boolean", "some object has a rotation" },
  { "duet.Scene.cell", "number", "cell edge asked for; 0: chosen from the objects" },
  { "duet.Scene.cell_fixed", "boolean", "a cell that is too small is refused" },
  { "duet.Scene.has_world", "boolean", "lower and upper were given" },
  { "duet.Scene.lower", "number[]", "of the world" },
  { "duet.Scene.upper", "number[]", "of the world" },

  { "duet.World:set_poses", { "poses: duet.Poses|string|number[]|number[][]" }, "true",
    "Copies the objects in.", fails = true, c = "duet_world_set_poses" },
  { "duet.World:set_bounds", { "bounds: duet.Bounds|string|number[]|number[][]" }, "true",
    "Copies the objects in.", fails = true, c = "duet_world_set_bounds" },
  { "duet.World:set_scene", { "scene: duet.Scene" }, "true", "Copies the scene's objects in.",
    fails = true, c = "duet_world_set_scene" },
  { "duet.World:map_poses", { "n: integer" }, "duet.Poses",
    "Room for n poses that the devices read without a copy: map, write, then step.", fails = true,
    c = "duet_world_map_poses" },
  { "duet.World:map_bounds", { "n: integer" }, "duet.Bounds", "The same for bounds.", fails = true,
    c = "duet_world_map_bounds" },
  { "duet.World:plan", {}, "duet.Plan", "The plan of the next step.", c = "duet_world_plan" },
  { "duet.World:set_plan", { "plan: duet.Plan" }, "true", "What the table leaves out stays.",
    fails = true, c = "duet_world_set_plan" },
  { "duet.World:load_profile", { "path?: string" }, "duet.Profile",
    "Takes the best plan that a store of profiles knows for the objects; the user's store without a path.",
    fails = true, c = { "duet_world_load_profile", "duet_grade_name" } },
  { "duet.World:step", {}, "duet.Result", "Finds all pairs.", fails = true, c = "duet_world_step" },
  { "duet.World:online", { "def?: { most_extra?: number, keep?: boolean, store?: string }" }, "duet.Online",
    "Begins to watch the frames' times.", fails = true, c = "duet_online_open" },
  { "duet.Online:step", {}, "duet.Result", "In the place of world:step.", fails = true, c = "duet_online_step" },
  { "duet.Online:tunings", {}, "integer", "How often the share was tuned again.", c = "duet_online_tunings" },
  { "duet.Online:close", {}, "true", "Stores what was learned, where that was asked for.", fails = true,
    c = "duet_online_close" },
  { "duet.World:close", {}, nil, "Gives the devices' memory back.", c = "duet_world_destroy" },

  { "duet.Result:pairs", {}, "fun(): integer, integer", "for a, b in result:pairs() do" },
  { "duet.Result:pair", { "place: integer" }, "integer, integer", "The pair at a place from 0.",
    c = "duet_result_pair" },
  { "duet.Result:copy", {}, "duet.Pairs", "The pairs in memory of their own." },
  { "duet.Result:stages", {}, "duet.Stage[]", "Where the time went." },
  { "duet.Result:hash", {}, "string", "The pair hash, 16 hex digits.", c = "duet_result_hash" },
  { "duet.Result:close", {}, nil, "Forgets the world." },
  { "duet.Result.objects", "integer", "in the step" },
  { "duet.Result.bad", "integer", "objects left out (keep_bad)" },
  { "duet.Result.first_bad", "integer", "the least id among them" },
  { "duet.Result.candidates", "integer", "pairs whose bounds overlap" },
  { "duet.Result.undecided", "integer", "pairs that float left open and the host decided" },
  { "duet.Result.total_ms", "number", "wall clock, poses in to pairs on the host" },
  { "duet.Result.device_ms", "number[]", "of A and of B" },
  { "duet.Result.kernel_ms", "number[]", "of A and of B, from the first kernel to the last one's end" },
  { "duet.Result.bytes", "integer[]", "memory held on A and on B" },
  { "duet.Result.cells", "integer[]", "the grid" },
  { "duet.Result.cell", "number", "its least edge" },
  { "duet.Result.cell_widened", "boolean", "the edge asked for was below the largest object" },
  { "duet.Result.runs", "integer", "1, or more where a buffer had to grow" },

  { "duet.Pairs:hash", {}, "string", "The pair hash, 16 hex digits.", c = "duet_pairs_hash" },
  { "duet.Poses:collide", { "a: integer", "b: integer", "dims?: integer" }, "boolean",
    "Whether the exact boxes of two rows share a point.", c = "duet_poses_collide" },

  { "duet.effects", {}, "string[]", "All that a scene can call for.", c = "duet_effect_name" },
  { "duet.DevicePair:motion", { "poses: duet.Poses|string|any[]", "bodies?: duet.Bodies|string|any[]", "def?: table" },
    "duet.Motion", "Objects that move, by a def { plan, dims, wants, doubles, origin, gravity, attraction, centre, drag, " ..
    "edge, lower, upper, dt, substeps, integrator, skin, slop, push_speed, bounce_speed, sleep_speed, sleep_after }; " ..
    "wants is a list of effects, edge none, walls or periodic, integrator euler, verlet or yoshida.",
    fails = true, c = "duet_motion_create" },
  { "duet.Motion:advance", {}, "duet.MotionResult", "Advances all objects by dt.", fails = true,
    c = "duet_motion_advance" },
  { "duet.Motion:effects", {}, "string[]", "Those that run. #motion is the number of objects.",
    c = { "duet_motion_effects", "duet_motion_count" } },
  { "duet.Motion:read", { "into?: duet.States" }, "duet.States", "The state of all objects.", fails = true,
    c = "duet_motion_read" },
  { "duet.Motion:hash", {}, "string", "A sum over the state's bits, the same at any share.", fails = true,
    c = "duet_motion_hash" },
  { "duet.Motion:energy", {}, "duet.Energy", "Energies and momenta.", fails = true, c = "duet_motion_energy" },
  { "duet.Motion:contacts", {}, "duet.Contacts", "Where objects touched in the last step; ascending.", fails = true,
    c = "duet_motion_contacts" },
  { "duet.Motion:save", { "path: string" }, "true", "Writes the motion to a file.", fails = true,
    c = "duet_motion_save" },
  { "duet.Motion:load", { "path: string" }, "true", "Goes on from there bit for bit.", fails = true,
    c = "duet_motion_load" },
  { "duet.Motion:explain", {}, "duet.Effect[]", "Every effect, and what calls for it, or would.",
    c = "duet_motion_explain" },
  { "duet.Motion:close", {}, nil, "Gives the devices' memory back.", c = "duet_motion_destroy" },
  { "duet.MotionResult:events", {}, "fun(): integer, integer, boolean", "for a, b, begins in result:events() do" },
  { "duet.MotionResult:stages", {}, "duet.Stage[]", "Where the time went, by effect." },
  { "duet.MotionResult:close", {}, nil, "Forgets the motion." },
  { "duet.MotionResult.step", "integer", "steps since the start" },
  { "duet.MotionResult.time", "number", "step * dt" },
  { "duet.MotionResult.pairs", "integer", "that may touch" },
  { "duet.MotionResult.contacts", "integer", "that push" },
  { "duet.MotionResult.colours", "integer", "rounds of a solution" },
  { "duet.MotionResult.rebuilt", "boolean", "pairs were searched in this step" },
  { "duet.MotionResult.n_events", "integer", "contacts that began or ended" },
  { "duet.MotionResult.total_ms", "number", "" },
  { "duet.Energy.kinetic", "number", "of objects with a mass" },
  { "duet.Energy.turning", "number", "of their spin" },
  { "duet.Energy.potential", "number", "" },
  { "duet.Energy.momentum", "number[]", "" },
  { "duet.Energy.angular", "number[]", "momentum about the origin" },
  { "duet.Effect.name", "string", "" },
  { "duet.Effect.active", "boolean", "" },
  { "duet.Effect.called_by", "string", "what calls for it, or would" },
  { "duet.Effect.kernels", "string", "those that have code for it" },
  { "duet.Effect.bytes", "integer", "of state an object, on B" },

  { "duet.Device.selector", "string", "\"pocl:0\"; a part of a CPU is \"pocl:0[0-1]\"" },
  { "duet.Device.platform", "string", "" },
  { "duet.Device.platform_version", "string", "" },
  { "duet.Device.name", "string", "" },
  { "duet.Device.vendor", "string", "" },
  { "duet.Device.driver", "string", "" },
  { "duet.Device.cl_version", "string", "" },
  { "duet.Device.kind", "\"CPU\"|\"GPU\"|\"accelerator\"", "" },
  { "duet.Device.units", "integer", "compute units" },
  { "duet.Device.clock_mhz", "integer", "" },
  { "duet.Device.max_group", "integer", "work-items in a work-group" },
  { "duet.Device.global_bytes", "integer", "" },
  { "duet.Device.local_bytes", "integer", "" },
  { "duet.Device.max_buffer_bytes", "integer", "" },
  { "duet.Device.host_memory", "boolean", "works on host memory without copies" },
  { "duet.Device.fp64", "boolean", "has double" },
  { "duet.Device.can_cut", "boolean", "its units can be cut into parts with [first-last]" },

  { "duet.Plan.share", "number", "A's part of the work, 0 to 1, in steps of 1/65536" },
  { "duet.Plan.mode", "string", "how grids are built: one of duet.modes()" },
  { "duet.Plan.variant_a", "string", "A's kernels: \"rows\", or with settings: \"rows sort=radix\"" },
  { "duet.Plan.variant_b", "string", "B's kernels" },

  { "duet.Profile.grade", "string", "\"exact\", \"other driver\", \"interpolated\", \"transferred\", \"stale\", \"default\"" },
  { "duet.Profile.plan", "duet.Plan", "the world's, from the call on" },
  { "duet.Profile.step_ms", "number", "by that plan; 0 where nothing is known" },
  { "duet.Profile.gain", "number", "over the best single device: 0.25 is a quarter faster" },
  { "duet.Profile.gain_low", "number", "" },
  { "duet.Profile.gain_high", "number", "" },
  { "duet.Profile.verdict", "string", "\"faster\", \"same\", \"slower\", \"ambiguous\"; empty where nothing is known" },
  { "duet.Profile.measured_s", "integer", "since 1970, UTC; 0: predicted" },

  { "duet.Stage.name", "string", "\"hash\", \"sort\" ..." },
  { "duet.Stage.device", "\"A\"|\"B\"", "" },
  { "duet.Stage.ms", "number", "from OpenCL events; a host stage from the clock" },
  { "duet.Stage.transfer", "boolean", "" },
}

-- Arrays are made, read and written alike; a letter says what a column is.
local letters = { f = "number", d = "number", I = "integer", B = "boolean" }

for class, columns in pairs {
  Poses = ("f"):rep(10),
  Bounds = ("f"):rep(6),
  Pairs = "II",
  Bodies = ("f"):rep(9) .. "IIB",
  States = ("d"):rep(13),
  Contacts = "IIfffI" .. ("f"):rep(20),
} do
  local types = {}
  for letter in columns:gmatch "." do types[#types + 1] = letters[letter] end
  local row = table.concat(types, ", ")
  for _, name in ipairs {
    { "." .. class:lower(), { "from: integer|string|any[]" }, "duet." .. class,
      "Room for so many rows, or a copy of packed rows, of numbers one after the other, or of rows." },
    { "." .. class .. ":get", { "place: integer" }, row, "The row at a place from 0." },
    { "." .. class .. ":set", { "place: integer", "...: any" }, nil, ("Writes a row: %d values."):format(#columns) },
    { "." .. class .. ":each", {}, "fun(): integer, " .. row, "for place, ... in it:each() do" },
    { "." .. class .. ":bytes", {}, "string", "All rows as they lie in memory, packed." },
    { "." .. class .. ":close", {}, nil, "Gives the memory back." },
  } do
    name[1] = "duet" .. name[1]
    table.insert(api.names, name)
  end
end

-- In one order, whatever pairs did above.
table.sort(api.names, function(a, b) return a[1] < b[1] end)

return api
