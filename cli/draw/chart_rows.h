// SPDX-License-Identifier: MIT
// A chart of rows, as inline SVG: a name, and beside it a bar with words behind
// it in each of one or two columns.
#ifndef CLI_CHART_ROWS_H
#define CLI_CHART_ROWS_H

#include "base/text.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct chart_cell {
    double part;        // of the longest bar, 0 to 1
    const char *colour; // of the page: "a", "mark"
    bool pale;
    char words[32];
} chart_cell;

typedef struct chart_rows {
    text *page;
    uint32_t n_columns;
    double y;
} chart_rows;

// heads [n_columns]
chart_rows chart_rows_begin(text *page, const char *title, const char *const *heads,
                            uint32_t n_columns, uint32_t n_rows);
// says is what a person sees who points at the row; cells [n_columns].
void chart_rows_add(chart_rows *rows, const char *name, const char *says, const chart_cell *cells);
void chart_rows_end(chart_rows *rows);

#endif
