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

// Whether it was measured on this machine.
bool profile_report_is_here(const profile_entry *e);

// Whether A and B are the same: a pair of one device.
bool profile_report_is_one(const profile_entry *e);

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

// "LABELname [part], driver ...".
void profile_report_device(const char *label, const profile_entry_device *d);

// The same as a row of a table of two columns.
void profile_report_device_row(table *t, const char *label, const profile_entry_device *d);

// All of it but its trials.
void profile_report_text(const profile_entry *e);

#endif
