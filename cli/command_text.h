// SPDX-License-Identifier: MIT
// A command line that is printed to be pasted: what a shell runs as it stands, whatever the
// environment says. Each call adds words, with a blank before each.
#ifndef CLI_COMMAND_TEXT_H
#define CLI_COMMAND_TEXT_H

#include "cli/inputs.h"

// Adds "--name value".
void command_text_option(text *t, const char *name, const char *value);

// Adds the scene's path and its options.
void command_text_scene(text *t, const char *path, const scene_options *options);

// Adds the options alone.
void command_text_settings(text *t, const scene_options *options);

// Adds --pair with the devices that were opened, not the words that chose them.
void command_text_pair(text *t, const duet_device_pair *pair);

// Adds the plan; one: A and B are one device, which has one variant.
void command_text_plan(text *t, double share, const char *mode, const char *variant_a,
                       const char *variant_b, bool one);

// Adds --level, or --missed and --false-rate, if they were given.
void command_text_level(text *t, const level_options *options);

#endif
