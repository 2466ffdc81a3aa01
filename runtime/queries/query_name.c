// SPDX-License-Identifier: MIT
#include "runtime/queries/query_name.h"

#include "base/error.h"
#include "runtime/duet_point_query.h"

#include <stdio.h>
#include <string.h>

static const char *const items[] = {"rays", "sweeps", "boxes", "points"};

enum { N_ITEMS = sizeof items / sizeof *items };

static const char *const wants_names[] = {"closest", "any", "every"};

enum { N_WANTS = sizeof wants_names / sizeof *wants_names };

const char *duet_query_wants_name(duet_query_wants wants)
{
    return (unsigned)wants < N_WANTS ? wants_names[wants] : NULL;
}

void query_name_write(const query_name *name, char text[QUERY_NAME])
{
    const char *item = items[name->item];
    if (name->item == QUERY_RAYS || name->item == QUERY_SWEEPS)
        snprintf(text, QUERY_NAME, "%s %s", item, duet_query_wants_name(name->wants));
    else if (name->nearest > 0)
        snprintf(text, QUERY_NAME, "%s nearest %u", item, name->nearest);
    else
        snprintf(text, QUERY_NAME, "%s%s", item, name->itself ? " itself" : "");
}

static bool read_wants(const char *word, query_name *name)
{
    for (int wants = 0; duet_query_wants_name((duet_query_wants)wants); ++wants) {
        name->wants = (duet_query_wants)wants;
        if (strcmp(word, duet_query_wants_name(name->wants)) == 0)
            return true;
    }
    name->wants = DUET_QUERY_CLOSEST;
    return *word == '\0';
}

static bool read_nearest(const char *words, query_name *name)
{
    int end = 0;
    if (*words == '\0')
        return true;
    return sscanf(words, "nearest %4u%n", &name->nearest, &end) == 1 && words[end] == '\0' &&
           name->nearest > 0 && name->nearest <= DUET_MOST_NEAREST;
}

// Reads the words that follow the item.
static bool read_rest(const char *words, query_name *name)
{
    switch (name->item) {
    case QUERY_RAYS:
    case QUERY_SWEEPS:
        return read_wants(words, name);
    case QUERY_BOXES:
        name->itself = *words != '\0';
        return !name->itself || strcmp(words, "itself") == 0;
    case QUERY_POINTS:
        return read_nearest(words, name);
    }
    return false;
}

bool query_name_read(const char *text, query_name *name, duet_error *err)
{
    size_t length = strcspn(text, " ");
    bool is_alone = text[length] == '\0';
    const char *rest = text + length + !is_alone;
    for (int item = 0; item < N_ITEMS; ++item) {
        *name = (query_name){.item = (query_item)item};
        if (strlen(items[item]) == length && strncmp(text, items[item], length) == 0 &&
            (is_alone || *rest) && read_rest(rest, name))
            return true;
    }
    return bad_argument(err,
                        "query '%s': expected 'rays closest', 'rays any', 'rays every', the same "
                        "of sweeps, 'boxes', 'boxes itself', 'points' or 'points nearest K'",
                        text);
}
