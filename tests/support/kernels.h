// SPDX-License-Identifier: MIT
// A folder with the carried kernels, of which one file is another.
#ifndef SUPPORT_KERNELS_H
#define SUPPORT_KERNELS_H

// Writes them all, as the source tree has them, with `before` and `after` around the
// text of the file `changed`, "grid/hash.cl".
void test_kernels_write(const char *folder, const char *changed, const char *before,
                        const char *after);

#endif
