// SPDX-License-Identifier: MIT
// Numbers with a decimal point, read and written, in an application whose language has a comma.
#ifndef BASE_PLAIN_NUMBERS_H
#define BASE_PLAIN_NUMBERS_H

// From here on this thread has the locale "C", unless its numbers have points already. Give the
// result, which may be NULL, to the end.
void *plain_numbers_begin(void);
void plain_numbers_end(void *before);

#endif
