// SPDX-License-Identifier: MIT
#include "base/nearest.h"

#include <ctype.h>
#include <stdbool.h>
#include <string.h>

enum { LONGEST = 32 };

static unsigned least(unsigned a, unsigned b)
{
    return a < b ? a : b;
}

static bool same(char a, char b)
{
    return tolower((unsigned char)a) == tolower((unsigned char)b);
}

// Characters to insert, remove or replace, and neighbours to swap: the optimal
// string alignment distance. Capitals are as good as small letters.
static unsigned count_edits(const char *a, const char *b)
{
    unsigned rows[3][LONGEST + 1];
    unsigned *before = rows[0], *last = rows[1], *row = rows[2];
    size_t n = strlen(b);
    for (unsigned j = 0; j <= n; ++j)
        last[j] = j;
    for (unsigned i = 1; a[i - 1]; ++i) {
        row[0] = i;
        for (unsigned j = 1; j <= n; ++j) {
            row[j] = least(last[j - 1] + !same(a[i - 1], b[j - 1]), least(last[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
                row[j] = least(row[j], before[j - 2] + 1);
        }
        unsigned *free = before;
        before = last;
        last = row;
        row = free;
    }
    return last[n];
}

nearest nearest_begin(const char *typed)
{
    return (nearest){.typed = typed};
}

// A third of the characters may be wrong. A beginning counts as one edit.
void nearest_try(nearest *n, const char *name)
{
    size_t length = strlen(n->typed);
    if (length < 2 || length > LONGEST || strlen(name) > LONGEST)
        return;
    unsigned edits = strncmp(name, n->typed, length) == 0 ? 1 : count_edits(n->typed, name);
    if (edits <= (length + 2) / 3 && (!n->name || edits < n->edits)) {
        n->name = name;
        n->edits = edits;
    }
}
