// SPDX-License-Identifier: MIT
// The folder of a motion's frames, and which times have one: 30 for each second.
#ifndef CLI_FRAME_FOLDER_H
#define CLI_FRAME_FOLDER_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

// Makes the folder, unless it is there.
bool frame_folder_make(const char *folder, duet_error *err);

// Whether frame n is due at a time of the scene.
bool frame_is_due(uint64_t n, double time);

#endif
