// SPDX-License-Identifier: MIT
// Expected texts, in tests/golden. DUET_UPDATE_GOLDEN=1 writes them instead, to
// be read in review.
#ifndef TESTS_GOLDEN_H
#define TESTS_GOLDEN_H

// Fails the test at the first line of chars that differs from the file.
void golden_check(const char *name, const char *chars);

#endif
