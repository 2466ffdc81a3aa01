// SPDX-License-Identifier: MIT
// The JSON line of a row. One table has the fields of each type of line; the SQL that writes lines,
// reads them and knows their fields is made from it.
#ifndef PROFILES_ROW_LINE_H
#define PROFILES_ROW_LINE_H

#include "base/text.h"

typedef struct line_type {
    const char *name;   // the table's, too
    const char *fields; // words: what follows the type, in order. One that begins with "key" has a
                        // key that is made from its other fields
    const char *joins;  // joins the other tables that a line tells of to the row t
    const char *order;  // the order of the lines
    const char *parts;  // inserts the rows of ?2 in another table that line ?1 holds; NULL: none
} line_type;

enum { LINE_TYPES = 9 };

// In the order in which rows point at each other.
extern const line_type line_types[LINE_TYPES];

// NULL: there is no such type.
const line_type *line_type_named(const char *name);

// Adds a query that gives the type's lines. A column that should hold an object but does not, in a
// store that somebody tampered with, goes out as none.
void line_add_select(text *t, const line_type *type);

// Adds a statement that inserts the row of line ?1, unless it is there.
void line_add_insert(text *t, const line_type *type);

bool line_is_object(const line_type *type, const char *name); // whether a field holds one

#endif
