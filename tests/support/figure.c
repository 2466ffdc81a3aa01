// SPDX-License-Identifier: MIT
#include "support/figure.h"

#include "support/test.h"

#include "base/text_file.h"

#include <ctype.h>

// Three digits after a blank belong to the digits before it.
static bool continues(const char *at)
{
    bool three = at[0] == ' ' && isdigit((unsigned char)at[1]) && isdigit((unsigned char)at[2]) &&
                 isdigit((unsigned char)at[3]);
    return three && !isdigit((unsigned char)at[4]);
}

// The number at `at`; NULL where there is none, else what follows it.
static const char *read_number(const char *at, double *value)
{
    char digits[64];
    size_t n = 0;
    if (*at == '+' || *at == '-')
        digits[n++] = *at++;
    if (!isdigit((unsigned char)*at))
        return NULL;
    while (n + 1 < sizeof digits && (isdigit((unsigned char)*at) || continues(at))) {
        at += *at == ' ';
        digits[n++] = *at++;
    }
    bool fraction = *at == '.' && isdigit((unsigned char)at[1]);
    for (; n + 1 < sizeof digits && fraction && (*at == '.' || isdigit((unsigned char)*at)); ++at)
        digits[n++] = *at;
    digits[n] = '\0';
    char *end;
    *value = strtod(digits, NULL);
    if (*at == 'e' && (at[1] == '-' || isdigit((unsigned char)at[1]))) {
        long power = strtol(at + 1, &end, 10);
        snprintf(digits + n, sizeof digits - n, "e%ld", power);
        *value = strtod(digits, NULL);
        at = end;
    } else if (*at == '^') {
        *value = pow(*value, (double)strtol(at + 1, &end, 10));
        at = end;
    }
    return at;
}

enum { MOST = 16 };

// Whether the text at `at` reads like the pattern, with n numbers.
static bool reads_like(const char *at, const char *pattern, int n, double *out)
{
    int found = 0;
    for (; *pattern; ++pattern) {
        if (*pattern != '#') {
            if (*at++ != *pattern)
                return false;
            continue;
        }
        double value;
        at = read_number(at, &value);
        if (!at)
            return false;
        if (found < n)
            out[found] = value;
        ++found;
    }
    return found == n && !isdigit((unsigned char)*at);
}

// With one blank where there were some, or a line's end.
static void join_lines(text *t)
{
    size_t to = 0;
    for (size_t i = 0; i < t->length; ++i) {
        bool blank = isspace((unsigned char)t->chars[i]);
        if (blank && to > 0 && t->chars[to - 1] == ' ')
            continue;
        t->chars[to++] = blank ? ' ' : t->chars[i];
    }
    t->length = to;
    t->chars[to] = '\0';
}

void figures(const char *document, const char *pattern, int n, double *out)
{
    char path[512];
    snprintf(path, sizeof path, "%s/../../docs/%s", getenv("DUET_TEST_SCENES"), document);
    assert_true(n <= MOST);
    text t = test_read_file(path);
    join_lines(&t);
    int places = 0;
    for (const char *at = t.chars; *at; ++at) {
        double found[MOST];
        bool within = at > t.chars && isdigit((unsigned char)at[-1]) && *pattern == '#';
        if (within || !reads_like(at, pattern, n, found))
            continue;
        memcpy(out, found, (size_t)n * sizeof *out);
        ++places;
    }
    if (places != 1)
        fail_msg("docs/%s says '%s' in %d places, not in one", document, pattern, places);
}

double figure(const char *document, const char *pattern)
{
    double value = NAN;
    figures(document, pattern, 1, &value);
    return value;
}
