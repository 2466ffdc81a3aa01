// SPDX-License-Identifier: MIT
// What every fuzz target includes. A target is one file, fuzz_NAME.c, with one
// function, fuzz_one; entry.c hands it the inputs.
//
// An input is what a stranger's file could hold. Whatever it is, the reader
// either takes it, and what it took is sound, or refuses it with one line.
#ifndef TESTS_FUZZ_H
#define TESTS_FUZZ_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// The target's. It opens what it opens once, if anything, in fuzz_begin, where no
// time is taken.
void fuzz_one(const uint8_t *data, size_t n);
void fuzz_begin(void) __attribute__((weak));

// libFuzzer's: changes n bytes in place to at most `most` and returns how many.
size_t LLVMFuzzerMutate(uint8_t *data, size_t n, size_t most);

// A folder of this process alone, removed at its end.
const char *fuzz_folder(void);

typedef struct fuzz_path {
    char chars[192];
} fuzz_path;

// Gives where a file of that name lies in the folder, and that file with the input as
// its content.
fuzz_path fuzz_place(const char *name);
fuzz_path fuzz_file(const char *name, const uint8_t *data, size_t n);

// Ends the run where the fact does not hold, and the input is kept.
#define fuzz_require(fact) fuzz_require_at((fact), #fact, __FILE__, __LINE__)
void fuzz_require_at(bool holds, const char *fact, const char *file, int line);

// A call that succeeded leaves no error; one that failed leaves one line.
void fuzz_require_answer(bool ok, const duet_error *err);

#endif
