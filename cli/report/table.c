// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/report/table.h"

#include "base/visible.h"
#include "runtime/duet.h"

#include <langinfo.h>
#include <stdarg.h>
#include <string.h>

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
    visible_add(&t->cells, cell, strlen(cell), "");
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
static int width_of(const char *cell)
{
    int width = 0;
    for (; *cell; ++cell)
        width += ((unsigned char)*cell & 0xc0) != 0x80;
    return width;
}

static void measure(const table *t, uint32_t n_columns, int *widths)
{
    const char *cell = text_chars(&t->cells);
    for (uint32_t i = 0; i < t->n_cells; ++i) {
        int width = width_of(cell);
        int *widest = &widths[i % n_columns];
        *widest = width > *widest ? width : *widest;
        cell += strlen(cell) + 1;
    }
}

static void print_cell(FILE *out, const char *cell, int width, char align, bool is_last)
{
    int pad = width - width_of(cell);
    if (align == 'r')
        fprintf(out, "%*s%s", pad, "", cell);
    else
        fprintf(out, "%s%*s", cell, is_last ? 0 : pad, "");
    fputs(is_last ? "\n" : "  ", out);
}

void table_print(table *t, FILE *out)
{
    uint32_t n_columns = (uint32_t)strlen(t->align);
    int widths[TABLE_COLUMNS_MOST] = {0};
    const char *cell = text_chars(&t->cells);
    if (!t->cells.failed) {
        measure(t, n_columns, widths);
        for (uint32_t i = 0; i < t->n_cells; ++i) {
            uint32_t column = i % n_columns;
            print_cell(out, cell, widths[column], t->align[column], column + 1 == n_columns);
            cell += strlen(cell) + 1;
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

table_text table_bytes(uint64_t bytes)
{
    static const char *const units[] = {"B", "kB", "MB", "GB", "TB", "PB", "EB"};
    double size = (double)bytes;
    size_t unit = 0;
    while (size >= 999.5 && unit + 1 < sizeof units / sizeof units[0]) {
        size /= 1000;
        ++unit;
    }
    table_text t;
    snprintf(t.chars, sizeof t.chars, "%.*f %s", unit > 0 && size < 99.5 ? 1 : 0, size,
             units[unit]);
    return t;
}

table_text table_gain(uint32_t share, double gain, double low, double high, const char *verdict)
{
    bool alone = share == 0 || share == DUET_SHARE_ONE;
    table_text t;
    snprintf(t.chars, sizeof t.chars, "%s%+.1f %% (%+.1f to %+.1f)%s: %s",
             alone ? "one device alone; sharing gains " : "", 100 * gain, 100 * low, 100 * high,
             alone ? "" : " over the best single device", verdict);
    return t;
}

table_text table_bar(double part, int width)
{
    // Eighths of a character, where the terminal has them.
    static const char *const eighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"};
    bool fine = strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
    int left = (int)((part < 0 ? 0 : part > 1 ? 1 : part) * width * 8 + 0.5);
    table_text bar = {{0}};
    char *to = bar.chars;
    while (left >= (fine ? 1 : 4)) {
        const char *piece = fine ? eighths[left < 8 ? left : 8] : "#";
        size_t length = strlen(piece);
        memcpy(to, piece, length);
        to += length;
        left -= 8;
    }
    return bar;
}
