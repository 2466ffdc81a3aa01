// SPDX-License-Identifier: MIT
// A language whose numbers have a decimal comma, which a test makes itself: systems need have none.
#ifndef TESTS_LOCALE_H
#define TESTS_LOCALE_H

#include <stdbool.h>

// Makes it in the folder one is in.
void test_make_comma_locale(void);

// false: as every program begins. If localedef made no language, the test is skipped, with a line.
void test_speak_with_comma(bool comma);

#endif
