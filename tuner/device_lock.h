// SPDX-License-Identifier: MIT
// One tuning at a time on a device of this machine: two of them would disturb each other's
// times, whatever their workloads, stores and users are.
//
// The lock of a device is a socket with an abstract name that the tuning process listens on. The
// system takes it away with the process, and tells who holds it.
#ifndef TUNER_DEVICE_LOCK_H
#define TUNER_DEVICE_LOCK_H

#include "tuner/duet_tune.h"

typedef struct device_lock {
    int sockets[2]; // one for each device as a whole; 0: none
} device_lock;

// Takes both devices of the def's pair. While another process has one of them, it waits and tells
// the def's watch so; INTERRUPTED if that says to stop. A def that does not wait for other programs
// goes on without the lock.
bool device_lock_take(device_lock *lock, const duet_tune_def *def, duet_error *err);
void device_lock_release(device_lock *lock);

#endif
