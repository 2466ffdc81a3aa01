// SPDX-License-Identifier: MIT
// A .vtp file of a motion's contacts: a point for each point at which two bodies touch.
#ifndef CLI_VTK_CONTACTS_H
#define CLI_VTK_CONTACTS_H

#include "cli/body_states.h"

bool vtk_contacts_write(const char *path, duet_motion *motion, const body_states *bodies,
                        double time, duet_error *err);

#endif
