// SPDX-License-Identifier: MIT
// What is known of drivers that Duet works round.
//
// One width: PoCL compiles a kernel anew for launches of 65,535 work-items and more along an axis,
// and for those that do not begin at 0. Before 6.0 it also mixes such kernels up: when a launch
// ends it looks its kernel up by the program's hash and the group's size alone, so that two devices
// that launch one program over different ranges at once release each other's kernels, and the
// driver aborts, or unloads one that still runs. It does not count the third axis. So on its CPUs
// our groups lie along the third axis, one behind the other, and every launch begins at 0: a kernel
// is compiled once for each size of group, whatever the range, and shared by all devices.
#ifndef RUNTIME_DRIVER_H
#define RUNTIME_DRIVER_H

#include "runtime/duet.h"

// Quirks of a driver: a set of these.
typedef enum driver_quirk {
    // It compiles a kernel for each width of launch, so that groups lie along the third axis.
    DRIVER_TWO_WIDTHS = 1 << 0,

    // It reads a header of OpenCL's functions for each program, which then declares what it calls.
    // A first run takes 3.2 s of processor time instead of 4.6, and the next 0.2 instead of 0.4.
    DRIVER_READS_HEADER = 1 << 1,

    // It keeps what it compiled itself and compiles all again when it is asked for a binary, as
    // PoCL does: 5.7 s of processor time instead of 3.2 for a first run, and 0.1 instead of 0.2
    // for the next.
    DRIVER_KEEPS_KERNELS = 1 << 2,

    // Kernels work on wrapped host memory itself, so that a map only orders commands, which one
    // queue does already. PoCL makes a command of each map and each unmap, and wakes all threads
    // of the device for it, as for a kernel: up to ten in a step, beside six kernels.
    DRIVER_IN_PLACE = 1 << 3,

    // It compiles under one lock, as PoCL does, so that a thread more would only wait.
    DRIVER_ONE_COMPILER = 1 << 4,

    // Its programs share a state of LLVM that no lock guards, as Oclgrind's do.
    DRIVER_CRASHES = 1 << 5,

    // The groups of a launch that are no more than the device's units run all at once, as on
    // NVIDIA's GPUs, so that they may wait for each other.
    DRIVER_MEETS = 1 << 6,
} driver_quirk;

uint32_t driver_quirks(const duet_device_info *info);

// Text before a kernel that is launched along so many axes, for DRIVER_TWO_WIDTHS: the functions of
// OpenCL by which it asks for its place along the last one.
const char *driver_third_axis(uint32_t n_axes);

// The option that leaves out the header for DRIVER_READS_HEADER.
extern const char driver_header_option[];

// Makes the folder that PoCL keeps built kernels in, as PoCL does: where it cannot, it lists no
// device and does not say why. NO_DEVICE with the reason then.
bool driver_check_pocl_folder(duet_error *err);

#endif
