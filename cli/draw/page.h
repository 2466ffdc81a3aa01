// SPDX-License-Identifier: MIT
// A self-contained HTML page, light and dark, that grows in a text. Whatever
// comes from outside goes through page_words.
#ifndef CLI_PAGE_H
#define CLI_PAGE_H

#include "base/text.h"

void page_begin(text *page, const char *title);
void page_end(text *page);

void page_section(text *page, const char *heading); // until page_section_end
void page_section_end(text *page);
void page_paragraph(text *page, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Charts between these lie side by side where there is space.
void page_charts(text *page);
void page_charts_end(text *page);

// A table that scrolls by itself where the page is narrow. align has a letter
// a column, l or r; cells come row by row, the heads first.
typedef struct page_table {
    text *page;
    const char *align;
    size_t n; // cells so far
} page_table;

page_table page_table_begin(text *page, const char *align);
void page_cell(page_table *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
void page_table_end(page_table *t);

// Adds what was formatted as words: & < > and quotes are no markup.
void page_words(text *page, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
