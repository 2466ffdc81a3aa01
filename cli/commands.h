// SPDX-License-Identifier: MIT
// The subcommands of `duet`, each a file. argv[0] is the subcommand's name; each returns the exit
// status.
#ifndef CLI_COMMANDS_H
#define CLI_COMMANDS_H

// clang-format off
#define COMMANDS(X) \
    X(accuracy, "measure what each level of accuracy costs, and gets wrong") \
    X(bench, "run a standard set of measurements, or compare two") \
    X(cluster, "find all pairs of a scene on several machines or devices") \
    X(devices, "list the OpenCL devices here, with selectors for --pair") \
    X(explain, "show the effects or kernels of a scene, and what each costs") \
    X(lua, "run a script that uses all of this, or a prompt") \
    X(picture, "draw a scene, its cells and its pairs") \
    X(profiles, "manage what was measured, and what applications load") \
    X(query, "test pairs of boxes from a file: colliding or separated") \
    X(report, "write one HTML page with all that was measured") \
    X(run, "find all pairs of a scene, move it, or run a kernel of your own") \
    X(scenes, "list the scenes that come with Duet") \
    X(source, "print the exact text of a kernel, or its parameters") \
    X(tune, "find how two devices share a scene's work best, and store it") \
    X(verify, "run a moving scene twice, and show the first bit that differs")
// clang-format on

#define DECLARE_COMMAND(name, about) int command_##name(int argc, char **argv);
COMMANDS(DECLARE_COMMAND)

#endif
