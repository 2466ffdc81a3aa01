// SPDX-License-Identifier: MIT
// Values of options: numbers, counts, shares and settings.
#include "cli/option.h"
#include "runtime/duet.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool read_number(const char *written, double *number)
{
    char *end = NULL;
    if (*written == '\0' || isspace((unsigned char)*written))
        return false;
    *number = strtod(written, &end);
    return *end == '\0' && isfinite(*number);
}

static double read_suffix(const char **at)
{
    static const char suffixes[] = "kMG";
    const char *found = **at ? strchr(suffixes, **at == 'K' ? 'k' : **at) : NULL;
    *at += found != NULL;
    return found ? pow(1e3, (double)(found - suffixes + 1)) : 1;
}

// Digits alone are read exactly; with a point, an exponent or a suffix as a double.
const char *options_read_count(const char *written, uint64_t *count)
{
    char *end = NULL;
    if (!isdigit((unsigned char)*written))
        return NULL;
    errno = 0;
    *count = strtoull(written, &end, 10);
    if (!*end || !strchr(".eEkKMG", *end))
        return errno == 0 ? end : NULL;
    double number = strtod(written, &end);
    const char *after = end;
    number *= read_suffix(&after);
    if (!(number < 0x1p64) || number != floor(number))
        return NULL;
    *count = (uint64_t)number;
    return after;
}

static bool read_count(const char *written, uint64_t *count)
{
    const char *after = options_read_count(written, count);
    return after && *after == '\0';
}

// "0.25", "1/4", "1" -> out of DUET_SHARE_ONE, to the nearest.
static bool options_read_share(const char *written, uint32_t *share)
{
    char first[64];
    double parts = 1;
    double whole = 1;
    const char *slash = strchr(written, '/');
    size_t length = slash ? (size_t)(slash - written) : strlen(written);
    if (length >= sizeof first)
        return false;
    memcpy(first, written, length);
    first[length] = '\0';
    if (!read_number(first, &parts) || (slash && !read_number(slash + 1, &whole)))
        return false;
    if (!(whole > 0) || !(parts >= 0) || !(parts <= whole))
        return false;
    *share = (uint32_t)lround(parts / whole * DUET_SHARE_ONE);
    return true;
}

static bool refuse_range(const command_line *line, const option *o, const char *written,
                         const char *what)
{
    if (o->most > 0)
        return REFUSE(line, "--%s '%s': give %s from %.10g to %.10g", o->name, written, what,
                      o->least, o->most);
    return REFUSE(line, "--%s '%s': give %s of at least %.10g", o->name, written, what, o->least);
}

static bool is_within(const option *o, double value)
{
    return value >= o->least && (o->most == 0 || value <= o->most);
}

bool option_list_add(option_list *list, const char *written)
{
    const char *equals = strchr(written, '=');
    const size_t length = equals ? (size_t)(equals - written) : 0;
    if (length == 0 || length >= sizeof list->items[0].name || list->n == OPTION_LIST_MOST)
        return false;
    option_setting *s = &list->items[list->n++];
    *s = (option_setting){.written = written, .value = equals + 1};
    memcpy(s->name, written, length);
    return true;
}

static bool add_setting(const command_line *line, const option *o, const char *written,
                        option_list *list)
{
    if (list->n == OPTION_LIST_MOST)
        return REFUSE(line, "--%s is given more than %d times", o->name, OPTION_LIST_MOST);
    return option_list_add(list, written) ||
           REFUSE(line, "--%s '%s': give a name and a value, as seed=7", o->name, written);
}

bool option_set(const command_line *line, const option *o, const char *written, void *args)
{
    void *at = (char *)args + o->at;
    double number = 0;
    uint64_t count = 0;
    switch (o->kind) {
    case KIND_FLAG:
        *(bool *)at = true;
        return true;
    case KIND_TEXT:
    case KIND_INPUT:
    case KIND_OUTPUT:
    case KIND_LATER:
        if (!*written)
            return REFUSE(line, "--%s '': the value is empty; expected --%s %s", o->name, o->name,
                          o->value);
        *(const char **)at = written;
        return true;
    case KIND_SETTINGS:
        return add_setting(line, o, written, at);
    case KIND_COUNT:
        if (!read_count(written, &count) || !is_within(o, (double)count))
            return refuse_range(line, o, written, "a whole number");
        *(uint64_t *)at = count;
        return true;
    case KIND_NUMBER:
        if (!read_number(written, &number) || !is_within(o, number))
            return refuse_range(line, o, written, "a number");
        *(double *)at = number;
        return true;
    case KIND_SHARE:
        if (!options_read_share(written, at))
            return REFUSE(line, "--%s '%s': give a part from 0 to 1, as 0.25 or 1/4", o->name,
                          written);
        return true;
    }
    return false;
}
