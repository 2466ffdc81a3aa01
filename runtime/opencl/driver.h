// SPDX-License-Identifier: MIT
// What is known of drivers that Duet works round.
//
// Copies of programs: PoCL before 6.0 keeps loaded kernels of all contexts in one list. When a
// launch ends it looks its kernel up there by the program's hash and the group's size alone,
// although entries also differ by the launch's width and offset. Two devices that launch one
// program over different ranges at once then release each other's entries: the driver aborts, or
// unloads a kernel that still runs. So no two open devices of such a driver have programs of one
// hash: the second builds them with another definition. One device never has two launches under
// way, because its queue runs them in order.
#ifndef RUNTIME_DRIVER_H
#define RUNTIME_DRIVER_H

#include "runtime/duet.h"

// Which copy of all programs an opened device builds: the least that no other
// open device has, 0 first; always 0 where the driver needs none. To be given
// back when the device closes.
uint32_t driver_copy_take(const duet_device_info *info);
void driver_copy_return(const duet_device_info *info, uint32_t copy);

// Whether the driver keeps what it compiled itself and compiles all again when it is asked
// for a binary, as PoCL does: 5.7 s of processor time instead of 3.2 for a first run, and
// 0.1 instead of 0.2 for the next.
bool driver_keeps_kernels(const duet_device_info *info);

// Whether several threads are not to compile at once: PoCL compiles under one lock, and a
// thread more would only wait; Oclgrind's programs share a state of LLVM that no lock guards.
bool driver_compiles_one_by_one(const duet_device_info *info);

// The option that leaves out the header of OpenCL's functions, where the driver reads one for each
// program: the program must then declare what it calls. NULL where the driver reads none. A first
// run takes 3.2 s of processor time instead of 4.6, and the next 0.2 instead of 0.4.
const char *driver_header_option(const duet_device_info *info);

#endif
