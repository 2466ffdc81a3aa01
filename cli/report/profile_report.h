// SPDX-License-Identifier: MIT
// A profile as `duet profiles` and `duet report` tell it: as JSON, or to a person.
#ifndef CLI_PROFILE_REPORT_H
#define CLI_PROFILE_REPORT_H

#include "cli/report/json.h"
#include "cli/report/table.h"
#include "profiles/profile.h"

// "2026-11-21 08:17", UTC; empty for 0.
typedef struct profile_report_date {
    char chars[32];
} profile_report_date;

profile_report_date profile_report_when(int64_t calendar_ns);

// The context of a visit of one entry, which prints it while it is there.
typedef struct profile_showing {
    store *s;
    bool json;
    bool ok;
    duet_error *err;
} profile_showing;

cJSON *profile_report_json(const profile_entry *e);

// Adds the session; nothing for a profile that has none.
void profile_report_add_session(cJSON *o, const profile_entry_session *s);

// Adds the trials of a session, which may be NULL.
bool profile_report_add_trials(cJSON *o, store *s, const char *session, duet_error *err);

// Adds the device under that name.
void profile_report_add_device(cJSON *o, const char *name, const profile_entry_device *d);

#endif
