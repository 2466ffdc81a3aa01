// SPDX-License-Identifier: MIT
#include "cli/draw/chart_rows.h"

#include "cli/draw/page.h"

// In the units of the viewBox: a phone shows about one a pixel.
static const double width = 400;
static const double names_width = 98;  // "contact_response"
static const double words_width = 102; // of a column, behind the longest bar
static const double row_height = 22;
static const double bar_height = 12;

static double column_x(const chart_rows *rows, uint32_t column)
{
    return names_width + column * (width - names_width) / rows->n_columns;
}

static double longest_bar(const chart_rows *rows)
{
    return (width - names_width) / rows->n_columns - words_width;
}

static void add_words(const chart_rows *rows, double x, const char *words)
{
    text_add(rows->page, "<text x=\"%.1f\" y=\"%.1f\">", x, rows->y + bar_height - 2);
    page_words(rows->page, "%s", words);
    text_add(rows->page, "</text>\n");
}

chart_rows chart_rows_begin(text *page, const char *title, const char *const *heads,
                            uint32_t n_columns, uint32_t n_rows)
{
    chart_rows rows = {.page = page, .n_columns = n_columns, .y = 4};
    text_add(page, "<figure><figcaption>");
    page_words(page, "%s", title);
    text_add(page,
             "</figcaption>\n<svg class=\"chart\" viewBox=\"0 0 %.0f %.0f\" role=\"img\" "
             "aria-label=\"",
             width, row_height * (n_rows + 1) + 4);
    page_words(page, "%s", title);
    text_add(page, "\">\n");
    for (uint32_t i = 0; i < n_columns; ++i)
        add_words(&rows, column_x(&rows, i), heads[i]);
    rows.y += row_height;
    return rows;
}

static void add_cell(const chart_rows *rows, double x, const chart_cell *cell)
{
    double length = longest_bar(rows) * cell->part;
    if (length > 0)
        text_add(rows->page,
                 "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.2f\" height=\"%.0f\" rx=\"1.5\" "
                 "fill=\"var(--%s)\"%s/>\n",
                 x, rows->y, length, bar_height, cell->colour, cell->pale ? " opacity=\".4\"" : "");
    add_words(rows, x + length + (length > 0 ? 5 : 0), cell->words);
}

void chart_rows_add(chart_rows *rows, const char *name, const char *says, const chart_cell *cells)
{
    text_add(rows->page, "<g><title>");
    page_words(rows->page, "%s", says);
    text_add(rows->page, "</title>\n");
    text_add(rows->page, "<text class=\"name\" x=\"2\" y=\"%.1f\">", rows->y + bar_height - 2);
    page_words(rows->page, "%s", name);
    text_add(rows->page, "</text>\n");
    for (uint32_t i = 0; i < rows->n_columns; ++i)
        add_cell(rows, column_x(rows, i), &cells[i]);
    text_add(rows->page, "</g>\n");
    rows->y += row_height;
}

void chart_rows_end(chart_rows *rows)
{
    text_add(rows->page, "</svg></figure>\n");
}
