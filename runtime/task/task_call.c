// SPDX-License-Identifier: MIT
#include "runtime/task/task_call.h"

#include "base/error.h"

#include <stdio.h>
#include <string.h>

static const char *const ranges[2] = {"first", "last"};

// The argument's slot; TASK_SLOTS if the task has none of that name.
static uint32_t find_slot(const task *t, const char *name)
{
    uint32_t arg = task_find_arg(t, name);
    if (arg < t->n_args)
        return arg;
    for (uint32_t i = 0; i < 2; ++i)
        if (strcmp(ranges[i], name) == 0)
            return t->n_args + i;
    return TASK_SLOTS;
}

static bool is_range(const task *t, uint32_t slot)
{
    return slot >= t->n_args;
}

// ---------------------------------------------------------------- one argument

static bool check_array(const task_call *c, const task *t, const task_arg *arg, const gen_arg *card,
                        duet_error *err)
{
    size_t n = strlen(arg->type);
    if (strncmp(card->type, arg->type, n) != 0 || strcmp(card->type + n, " *") != 0)
        return bad_input(err, "%s: args.%s is an array of %s; the card of %s has '%s'", t->path,
                         arg->name, arg->type, c->kernel, card->type);
    bool is_read = card->memory != GEN_WRITTEN;
    if (is_read == task_arg_is_written(arg))
        return bad_input(err, "%s: args.%s: access is %s, but the card of %s says that it is %s",
                         t->path, arg->name, task_access_name(arg->access), c->kernel,
                         is_read ? "const" : "written; expected const in the card");
    return true;
}

// The type that the card gives a number; false if it is none that a task has.
static bool read_scalar(const gen_arg *card, task_scalar *scalar)
{
    static const task_scalar known[] = {TASK_INT,   TASK_UINT,  TASK_LONG,
                                        TASK_ULONG, TASK_FLOAT, TASK_DOUBLE};
    uint32_t lanes = 0;
    *scalar = card->is_double ? TASK_DOUBLE : TASK_FLOAT;
    if (strcmp(card->type, "real") == 0)
        return true;
    bool is_known = false;
    if (task_type_read(card->type, scalar, &lanes) && lanes == 1)
        for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
            is_known |= *scalar == known[i];
    return is_known;
}

// False if the type does not hold the number.
static bool set_whole(task_slot *slot, task_scalar scalar, int64_t value)
{
    switch (scalar) {
    case TASK_INT:
        slot->i = (cl_int)value;
        return value == slot->i;
    case TASK_UINT:
        slot->u = (cl_uint)value;
        return value == slot->u;
    default:
        slot->l = (cl_long)value;
        return scalar == TASK_LONG || value >= 0;
    }
}

static bool set_slot(task_slot *slot, task_scalar scalar, const task_arg *arg)
{
    if (task_scalar_is_whole(scalar))
        return arg->kind == TASK_ARG_WHOLE && set_whole(slot, scalar, arg->whole);
    if (scalar == TASK_FLOAT)
        slot->f = (cl_float)arg->value;
    else
        slot->d = arg->value;
    return true;
}

static bool set_value(task_call *c, const task *t, uint32_t i, const gen_arg *card, duet_error *err)
{
    const task_arg *arg = &t->args[i];
    return (read_scalar(card, &c->scalars[i]) && set_slot(&c->slots[i], c->scalars[i], arg)) ||
           bad_input(err, "%s: args.%s is %.17g; the card of %s has '%s'", t->path, arg->name,
                     arg->value, c->kernel, card->type);
}

bool task_call_set_number(task_call *c, const task *t, uint32_t i, duet_error *err)
{
    const task_arg *arg = &t->args[i];
    return set_slot(&c->slots[i], c->scalars[i], arg) ||
           bad_argument(err, "task %s: %s is %.17g; expected a number that %s holds", t->name,
                        arg->name, arg->value, c->types[i]);
}

// An item's number: of 32 bits only if all have one.
static bool check_range(task_call *c, const task *t, uint32_t slot, const gen_arg *card,
                        duet_error *err)
{
    task_slot most;
    return (read_scalar(card, &c->scalars[slot]) && task_scalar_is_whole(c->scalars[slot]) &&
            set_whole(&most, c->scalars[slot], (int64_t)t->items)) ||
           bad_input(err, "%s: items is %llu; the card of %s has '%s %s', expected ulong", t->path,
                     (unsigned long long)t->items, c->kernel, card->type, card->name);
}

static bool bind_arg(task_call *c, const task *t, const gen_arg *card, duet_error *err)
{
    uint32_t i = find_slot(t, card->name);
    if (i == TASK_SLOTS)
        return bad_input(err, "%s: args has no '%s', which the card of %s has", t->path, card->name,
                         c->kernel);
    const task_arg *arg = &t->args[i];
    bool is_array = arg->kind == TASK_ARG_ARRAY, is_buffer = strchr(card->type, '*');
    if (!is_range(t, i) && is_array != is_buffer)
        return bad_input(err, "%s: args.%s is a%s; the card of %s has '%s'", t->path, arg->name,
                         is_array ? "n array" : " number", c->kernel, card->type);
    snprintf(c->types[i], sizeof c->types[i], "%s", card->type);
    return is_range(t, i) ? check_range(c, t, i, card, err)
           : is_array     ? check_array(c, t, arg, card, err)
                          : set_value(c, t, i, card, err);
}

// ---------------------------------------------------------------- the call

static const gen_entry *find_entry(const gen_variant *v, const char *name)
{
    for (uint32_t i = 0; i < v->n_entries; ++i)
        if (strcmp(v->entries[i].name, name) == 0)
            return &v->entries[i];
    return NULL;
}

static bool bind_args(task_call *c, const task *t, const gen_entry *entry, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < entry->n_fields; ++i)
        ok = bind_arg(c, t, &entry->args[i], err);
    for (uint32_t i = 0; ok && i < 2; ++i)
        ok = *c->types[t->n_args + i] || bad_input(err,
                                                   "%s: the card of %s has no argument '%s'; "
                                                   "expected first and last, the items of a launch",
                                                   t->path, c->kernel, ranges[i]);
    for (uint32_t i = 0; ok && i < t->n_args; ++i)
        ok = *c->types[i] || strcmp(c->kernel, t->kernel) != 0 ||
             bad_input(err, "%s: args.%s: the card of %s has no such argument", t->path,
                       t->args[i].name, c->kernel);
    return ok;
}

static void list_bindings(task_call *c, const task *t)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < t->n_args + 2; ++i)
        if (*c->types[i])
            c->bindings[n++] =
                (binding){.name = is_range(t, i) ? ranges[i - t->n_args] : t->args[i].name,
                          .type = c->types[i],
                          .at = (uint32_t)(i * sizeof *c->slots)};
    c->bindings[n] = (binding){0};
}

bool task_call_read(task_call *c, const task *t, const char *kernel_name, const char *entry, gen *g,
                    const gen_limits *limits, duet_error *err)
{
    gen_variant v = {0};
    *c = (task_call){0};
    snprintf(c->kernel, sizeof c->kernel, "%s", kernel_name);
    snprintf(c->entry, sizeof c->entry, "%s", entry);
    if (!gen_make(g, kernel_name, NULL, 0, limits, &v, err))
        return false;
    const gen_entry *found = find_entry(&v, entry);
    bool ok =
        found ? bind_args(c, t, found, err)
              : bad_input(err, "%s: the card of %s has no entry '%s'", t->path, kernel_name, entry);
    gen_variant_free(&v);
    list_bindings(c, t);
    return ok;
}

void task_call_aim(task_call *c, const task *t, uint64_t first, uint64_t last)
{
    const uint64_t range[2] = {first, last};
    for (uint32_t i = 0; i < 2; ++i)
        set_whole(&c->slots[t->n_args + i], c->scalars[t->n_args + i], (int64_t)range[i]);
}
