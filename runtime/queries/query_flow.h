// SPDX-License-Identifier: MIT
// Chunks that follow each other: while a device with memory of its own traces one, the host copies
// and sends the next, and fetches and settles the one before.
#ifndef RUNTIME_QUERY_FLOW_H
#define RUNTIME_QUERY_FLOW_H

#include "runtime/queries/tree_query.h"

bool query_flows(const query_side *s); // whether it gains by that
uint64_t query_flow_items(const query_side *s);
bool query_run_flows(query_side *s, uint64_t chunk);

#endif
