// SPDX-License-Identifier: MIT
// Figures of the documents, so that a test compares with what is printed there
// and neither can change alone.
#ifndef TESTS_FIGURE_H
#define TESTS_FIGURE_H

// The numbers that stand for # in the one place of docs/DOCUMENT that reads like
// the pattern, however its lines are broken: "never # % above", 1. Fails the test
// where there is no such place, or a second one.
//
// Numbers are as the documents write them: 1 000, 0.5, -2.4, 1e-5, 2^-70.
void figures(const char *document, const char *pattern, int n, double *out);

// Given where there is one.
double figure(const char *document, const char *pattern);

#endif
