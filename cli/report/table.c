// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // TIOCGWINSZ
#include "cli/report/table.h"

#include "base/text.h"

#include <ctype.h>
#include <limits.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ioctl.h>

table table_begin(const char *align)
{
    return (table){.align = align};
}

void table_cell(table *t, const char *format, ...)
{
    char cell[512];
    va_list args;
    va_start(args, format);
    vsnprintf(cell, sizeof cell, format, args);
    va_end(args);
    text_add_visible(&t->cells, cell, strlen(cell), "");
    text_add_bytes(&t->cells, "", 1);
    ++t->n_cells;
}

void table_words(table *t, const char *first, ...)
{
    va_list args;
    va_start(args, first);
    for (const char *words = first; words; words = va_arg(args, const char *))
        table_cell(t, "%s", words);
    va_end(args);
}

// Characters, not bytes: what follows the first byte of a character does not
// count.
static int width_of_bytes(const char *cell, size_t n)
{
    int width = 0;
    for (size_t i = 0; i < n; ++i)
        width += ((unsigned char)cell[i] & 0xc0) != 0x80;
    return width;
}

static int width_of(const char *cell)
{
    return width_of_bytes(cell, strlen(cell));
}

// Output that no terminal shows keeps its rows whole, as grep wants them.
static int width_to_fill(FILE *out)
{
    struct winsize size;
    bool known = ioctl(fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    return known ? size.ws_col : INT_MAX;
}

enum { FOLDED_LEAST = 12, GAP = 2 };

// Whether a line may end after that byte of a cell.
static bool is_break(const char *at)
{
    return *at == ' ' || *at == ',' || (*at == '.' && isalpha((unsigned char)at[1]));
}

static int longest_word(const char *cell)
{
    int longest = 0;
    for (int length = 1; *cell; ++cell, ++length) {
        longest = length > longest ? length : longest;
        if (is_break(cell))
            length = 0;
    }
    return longest;
}

// Sets the greatest size of each column's cells.
static void measure(const table *t, uint32_t n_columns, int (*size_of)(const char *cell),
                    int *greatest)
{
    const char *cell = text_chars(&t->cells);
    for (uint32_t i = 0; i < t->n_cells; ++i) {
        int size = size_of(cell);
        int *most = &greatest[i % n_columns];
        *most = size > *most ? size : *most;
        cell += strlen(cell) + 1;
    }
}

// The widest columns of words become narrower, each down to its least width at most, until
// a row fits.
static void fit(const char *align, uint32_t n_columns, int *widths, const int *least, int most)
{
    int all = -GAP;
    for (uint32_t i = 0; i < n_columns; ++i)
        all += widths[i] + GAP;
    while (all > most) {
        uint32_t widest = n_columns;
        for (uint32_t i = 0; i < n_columns; ++i)
            if (align[i] == 'l' && widths[i] > least[i] &&
                (widest == n_columns || widths[i] > widths[widest]))
                widest = i;
        if (widest == n_columns)
            return;
        --widths[widest];
        --all;
    }
}

// Between words where that does, else through them.
static void fold(const table *t, uint32_t n_columns, int *widths, int most)
{
    int least[TABLE_COLUMNS_MOST] = {0};
    measure(t, n_columns, longest_word, least);
    fit(t->align, n_columns, widths, least, most);
    for (uint32_t i = 0; i < n_columns; ++i)
        least[i] = FOLDED_LEAST;
    fit(t->align, n_columns, widths, least, most);
}

// The bytes of a cell that fill a line of its column: up to where a word ends, or else as
// many characters as fit.
static size_t line_length(const char *cell, int width)
{
    size_t n = 0;
    size_t whole = 0;
    int shown = 0;
    while (cell[n] && (shown < width || ((unsigned char)cell[n] & 0xc0) == 0x80)) {
        shown += ((unsigned char)cell[n] & 0xc0) != 0x80;
        whole = is_break(&cell[n]) ? n + 1 : whole;
        ++n;
    }
    return cell[n] && cell[n] != ' ' && whole > 0 ? whole : n;
}

static void print_cell(FILE *out, const char *cell, size_t n, int width, char align, bool is_last)
{
    while (n > 0 && cell[n - 1] == ' ')
        --n;
    int pad = width - width_of_bytes(cell, n);
    fprintf(out, "%*s", align == 'r' ? pad : 0, "");
    fwrite(cell, 1, n, out);
    fprintf(out, "%*s", align == 'r' || is_last ? 0 : pad, "");
    fputs(is_last ? "\n" : "  ", out);
}

// The last cell of a line that is not blank.
static uint32_t find_last(const char *const *rests, uint32_t n_columns)
{
    uint32_t last = n_columns - 1;
    while (last > 0 && !rests[last][strspn(rests[last], " ")])
        --last;
    return last;
}

// Cells that are wider than their column go on in the lines below.
static void print_row(FILE *out, const char **rests, const char *align, const int *widths,
                      uint32_t n_columns)
{
    bool more = true;
    while (more) {
        uint32_t last = find_last(rests, n_columns);
        more = false;
        for (uint32_t i = 0; i <= last; ++i) {
            size_t n = line_length(rests[i], widths[i]);
            print_cell(out, rests[i], n, widths[i], align[i], i == last);
            rests[i] += n + strspn(rests[i] + n, " ");
            more |= *rests[i] != '\0';
        }
    }
}

void table_print(table *t, FILE *out)
{
    uint32_t n_columns = (uint32_t)strlen(t->align);
    int widths[TABLE_COLUMNS_MOST] = {0};
    const char *row[TABLE_COLUMNS_MOST];
    const char *cell = text_chars(&t->cells);
    if (!t->cells.failed) {
        measure(t, n_columns, width_of, widths);
        fold(t, n_columns, widths, width_to_fill(out));
        for (uint32_t i = 0; i < t->n_cells; ++i) {
            row[i % n_columns] = cell;
            cell += strlen(cell) + 1;
            if (i % n_columns + 1 == n_columns)
                print_row(out, row, t->align, widths, n_columns);
        }
    }
    text_free(&t->cells);
    t->n_cells = 0;
}

table_text table_count(uint64_t n)
{
    char digits[32];
    table_text grouped = {{0}};
    int length = snprintf(digits, sizeof digits, "%llu", (unsigned long long)n);
    char *to = grouped.chars;
    for (int i = 0; i < length; ++i) {
        if (i > 0 && (length - i) % 3 == 0)
            *to++ = ' ';
        *to++ = digits[i];
    }
    return grouped;
}

table_text table_things(uint64_t n, const char *one, const char *many)
{
    table_text t;
    snprintf(t.chars, sizeof t.chars, "%.40s %.40s", table_count(n).chars, n == 1 ? one : many);
    return t;
}
