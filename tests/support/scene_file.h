// SPDX-License-Identifier: MIT
// Scenes that a test writes to a file and reads back.
#ifndef TESTS_SCENE_FILE_H
#define TESTS_SCENE_FILE_H

#include "runtime/duet.h"

// Body 0 is a floor. The 24 boxes on it are far from each other, and slide.
extern const char scene_of_sliding_boxes[];

// Reads bytes as a file of that name would be read. The file is gone after; the scene lasts until
// the test ends.
duet_scene *scene_from_bytes(const char *name, const void *bytes, size_t n,
                             const duet_setting *settings, uint32_t n_settings, duet_error *err);

// The same for a text, without settings.
duet_scene *scene_from_text(const char *name, const char *chars, duet_error *err);

// Fails the test unless the text is refused with that status and a line that
// says it.
void scene_assert_refused(const char *name, const char *chars, duet_status status,
                          const char *says);

#endif
