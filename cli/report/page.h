// SPDX-License-Identifier: MIT
// The page of `duet report`: what it shows is gathered in a JSON object, and
// cli/report/page.lua makes HTML of it.
#ifndef CLI_PAGE_H
#define CLI_PAGE_H

#include "cli/report/json.h"
#include "profiles/store.h"

// Makes the contents of a page, with an empty list of results, the earliest first. NULL without
// memory.
cJSON *page_begin(cJSON **files);

// Adds the store's profiles, live or replaced; live ones with their trials.
bool page_add_store(cJSON *shown, store *s, duet_error *err);

bool page_write(const char *path, const cJSON *shown, duet_error *err);

#endif
