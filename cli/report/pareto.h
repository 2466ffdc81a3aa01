// SPDX-License-Identifier: MIT
// The plans of a search that no other plan beats in both time and energy.
#ifndef CLI_PARETO_H
#define CLI_PARETO_H

#include "cli/report/json.h"

// Adds "pareto" to an object that has "trials": of the plans whose energy was measured, by the
// means of their trials, those on the front, the quickest first. Nothing if energy was not
// measured.
void pareto_add(cJSON *o);

#endif
