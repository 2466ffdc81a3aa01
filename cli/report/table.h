// SPDX-License-Identifier: MIT
// A table for people: cells are added row by row and printed in columns that
// are as wide as their widest cell.
#ifndef CLI_TABLE_H
#define CLI_TABLE_H

#include "base/text.h"

#include <stdint.h>
#include <stdio.h>

enum { TABLE_COLUMNS_MOST = 24 };

typedef struct table {
    const char *align; // a letter a column: l or r
    text cells;        // each ends with a NUL
    uint32_t n_cells;
} table;

// align "lrr" makes three columns, the first to the left.
table table_begin(const char *align);
void table_cell(table *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
// Cells that are words, up to a NULL.
void table_words(table *t, const char *first, ...) __attribute__((sentinel));
// Prints what was added, a newline after every full row, and frees it. Columns of words
// are folded where rows are wider than the terminal that shows them.
void table_print(table *t, FILE *out);

typedef struct table_text {
    char chars[128];
} table_text;

// "1 677 345"
table_text table_count(uint64_t n);

// "1 box", "2 000 boxes"
table_text table_things(uint64_t n, const char *one, const char *many);

#endif
