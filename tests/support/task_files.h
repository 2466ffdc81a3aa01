// SPDX-License-Identifier: MIT
// Kernels of a user's, as files in the test's folder.
#ifndef TESTS_TASK_FILES_H
#define TESTS_TASK_FILES_H

// Writes FOLDER/NAME.lua and FOLDER/NAME.cl: a kernel with the arguments `first`, `last` and those
// of args, a line each, whose body does item i. Its parameter WG is 1, 4 or 16.
void task_files_write(const char *folder, const char *name, const char *args, const char *body);

#endif
