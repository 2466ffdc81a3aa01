// SPDX-License-Identifier: MIT
// Objects as text: a line an object, its numbers apart by blanks alone or by a comma each.
//
// Every wrong line is refused with its number; nothing is guessed, since a
// column passed over in silence would turn sizes into places.
#include "runtime/scene/scene_source.h"

#include "base/budget.h"
#include "base/error.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

// Lines between two looks at the budget.
enum { LINES_AT_ONCE = 1 << 12 };

// A line's numbers; n counts also those that do not fit.
typedef struct numbers {
    double value[SCENE_MAX_NUMBERS];
    uint32_t n;
} numbers;

static bool ends_line(char c)
{
    return c == '\0' || c == '\n' || c == '#';
}

static bool is_blank(char c)
{
    return c != '\n' && isspace((unsigned char)c);
}

static const char *skip_blanks(const char *at)
{
    while (is_blank(*at))
        ++at;
    return at;
}

static const char *field_end(const char *at)
{
    while (!ends_line(*at) && !is_blank(*at) && *at != ',')
        ++at;
    return at;
}

// The field's number, or false where it is none or only begins like one.
static bool read_number(const char *field, double *value)
{
    char *after = NULL;
    *value = strtod(field, &after);
    return after > field && after == field_end(field);
}

// Quotes a field as it is in the file, as far as it is short and printable.
static bool refuse_field(const char *field, uint32_t column, scene_place place, duet_error *err)
{
    char shown[25] = "";
    size_t n = 0;
    for (const char *at = field; at < field_end(field) && n + 1 < sizeof shown; ++at)
        shown[n++] = isprint((unsigned char)*at) ? *at : '?';
    if (n == 0)
        return bad_input(err, "%s:%llu: column %u is empty", place.path,
                         (unsigned long long)place.line, column);
    return bad_input(err, "%s:%llu: column %u: '%s' is not a number", place.path,
                     (unsigned long long)place.line, column, shown);
}

// A decimal comma looks like the comma between two columns; among blanks it is told.
static bool refuse_mixture(uint32_t column, bool comma, scene_place place, duet_error *err)
{
    return bad_input(err,
                     "%s:%llu: a %s after column %u, where %s separate those before it; expected "
                     "only blanks, or a comma between any two, and decimal points",
                     place.path, (unsigned long long)place.line, comma ? "comma" : "blank", column,
                     comma ? "blanks" : "commas");
}

static bool read_numbers(const char *line, scene_place place, numbers *row, duet_error *err)
{
    const char *at = skip_blanks(line);
    bool after_comma = false, after_first = false;
    while (!ends_line(*at) || after_comma) {
        if (row->n == 1)
            after_first = after_comma;
        if (row->n > 1 && after_comma != after_first)
            return refuse_mixture(row->n, after_comma, place, err);
        double value = 0;
        if (ends_line(*at) || !read_number(at, &value))
            return refuse_field(at, row->n + 1, place, err);
        if (row->n < SCENE_MAX_NUMBERS)
            row->value[row->n] = value;
        ++row->n;
        at = skip_blanks(field_end(at));
        after_comma = *at == ',';
        if (after_comma)
            at = skip_blanks(at + 1);
    }
    return true;
}

// A line of names has no number, and each of its fields begins like a name.
static bool is_header(const char *line)
{
    const char *at = skip_blanks(line);
    while (!ends_line(*at)) {
        double value = 0;
        bool like_name = isalpha((unsigned char)*at) || strchr("\"'_", *at) || *at & 0x80;
        if (!like_name || read_number(at, &value))
            return false;
        at = skip_blanks(field_end(at));
        if (*at == ',')
            at = skip_blanks(at + 1);
    }
    return true;
}

static bool read_line(duet_scene *scene, const char *line, scene_place place, duet_error *err)
{
    numbers row = {.n = 0};
    bool ok = read_numbers(line, place, &row, err);
    if (!ok || row.n == 0)
        return ok;
    return scene_set_columns(scene, row.n, place, err) &&
           scene_add_row(scene, row.value, place, err);
}

// Behind the UTF-8 byte order mark, where there is one.
static const char *first_line(const scene_source *source)
{
    return source->bytes + (strncmp(source->bytes, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0);
}

static uint32_t count_fields(const char *line)
{
    uint32_t n = 0;
    for (const char *at = skip_blanks(line); !ends_line(*at); ++n) {
        at = skip_blanks(field_end(at));
        at = *at == ',' ? skip_blanks(at + 1) : at;
    }
    return n;
}

// Names of pairs that nothing follows must be as many as the numbers that could.
static bool check_names(const duet_scene *scene, const char *names, scene_place place,
                        duet_error *err)
{
    return !names || scene->per_row == 1 || scene->columns != 0 ||
           scene_columns_fit(scene, count_fields(names)) ||
           refuse_field(skip_blanks(names), 1, place, err);
}

bool scene_read_text(duet_scene *scene, const scene_source *source, duet_error *err)
{
    const char *at = first_line(source);
    const char *names = NULL;
    scene_place named = {.path = source->name};
    bool may_be_header = true;
    for (scene_place place = {.path = source->name, .line = 1}; *at; ++place.line) {
        if (place.line % LINES_AT_ONCE == 0) {
            budget_tell((uint64_t)(at - source->bytes), source->length);
            if (!budget_check(err))
                return false;
        }
        bool blank = ends_line(*skip_blanks(at));
        bool header = may_be_header && !blank && is_header(at);
        if (!blank && !header && !read_line(scene, at, place, err))
            return false;
        names = header ? at : names;
        named.line = header ? place.line : named.line;
        may_be_header = may_be_header && blank;
        at += strcspn(at, "\n");
        at += *at == '\n';
    }
    return check_names(scene, names, named, err);
}

bool scene_is_text(const scene_source *source)
{
    bool header_seen = false;
    for (const char *at = first_line(source); *at; at += *at == '\n') {
        double value;
        const char *field = skip_blanks(at);
        bool header = !header_seen && !ends_line(*field) && is_header(at);
        if (!ends_line(*field) && !header)
            return read_number(field, &value);
        header_seen = header_seen || header;
        at += strcspn(at, "\n");
    }
    return true;
}
