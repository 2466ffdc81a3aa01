// SPDX-License-Identifier: MIT
#include "runtime/opencl/program_build.h"

#include "base/error.h"
#include "base/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- the set

gen_limits program_limits(const duet_device_info *info)
{
    return (gen_limits){
        .max_group = info->max_group,
        .local_bytes = info->local_bytes,
        .fp64 = info->fp64,
        .cpu = info->kind == DUET_KIND_CPU,
        .units = info->units,
    };
}

program_set *program_set_open(const device *d, gen *g, const program_builder *builder,
                              duet_error *err)
{
    program_set *set = calloc(1, sizeof *set);
    if (!set)
        return null_no_memory(err, "the kernels of %s", d->info.selector);
    set->device = d;
    set->gen = g;
    set->limits = program_limits(&d->info);
    if (builder)
        set->builder = *builder;
    if (program_builder_keeps(&set->builder, &d->info))
        set->cache_dir = set->builder.cache_dir;
    return set;
}

void program_set_close(program_set *set)
{
    while (set && set->first) {
        program *p = set->first;
        set->first = p->next;
        program_close(p);
    }
    free(set);
}

gen_limits program_set_limits(const program_set *set)
{
    return set->limits;
}

// ---------------------------------------------------------------- arguments

// other: the type under which the host knows the name, if that differs from the argument's.
static const binding *find_binding(bindings from, const gen_arg *arg, const char **other)
{
    for (; from->name; ++from) {
        if (strcmp(from->name, arg->name) != 0)
            continue;
        if (strcmp(from->type, arg->type) == 0)
            return from;
        *other = *other ? *other : from->type;
    }
    return NULL;
}

static bool bind_entry(launcher *l, const char *name, const gen_entry *entry, bindings from,
                       duet_error *err)
{
    l->n = 0;
    for (uint32_t i = 0; i < entry->n_args; ++i) {
        const gen_arg *arg = &entry->args[i];
        const char *other = NULL;
        const binding *b = find_binding(from, arg, &other);
        if (!b && other)
            return error_set(err, DUET_STATUS_BUILD_FAILED,
                             "kernel %s: argument '%s' of %s is of type '%s'; expected '%s'", name,
                             arg->name, entry->name, arg->type, other);
        if (!b)
            return error_set(err, DUET_STATUS_BUILD_FAILED,
                             "kernel %s: %s has an argument '%s' that its launcher does not know",
                             name, entry->name, arg->name);
        l->args[l->n].at = b->at;
        l->args[l->n++].bytes = arg->bytes ? arg->bytes : (uint32_t)sizeof(cl_mem);
    }
    return true;
}

// All entries of the program are checked before it is compiled: a compiler would say less about
// what is wrong with a card.
static bool bind(const program_set *set, const gen_variant *variant, const char *entry,
                 bindings from, launcher *l, duet_error *err)
{
    bool found = false;
    for (uint32_t i = 0; i < variant->n_entries; ++i) {
        launcher other;
        bool is_meant = strcmp(variant->entries[i].name, entry) == 0;
        if (!bind_entry(is_meant ? l : &other, variant->name, &variant->entries[i], from, err))
            return false;
        found = found || is_meant;
    }
    return found || error_set(err, DUET_STATUS_BUILD_FAILED,
                              "%s on %s: has no kernel '%s' in its card's args", variant->name,
                              set->device->info.selector, entry);
}

// ---------------------------------------------------------------- kernels

static program *new_program(const program_set *set, const gen_variant *variant, duet_error *err)
{
    const bool two_widths = set->device->quirks & DRIVER_TWO_WIDTHS;
    text all = {0};
    text_add(&all, "%s%s", two_widths ? driver_third_axis(variant->n_axes) : "", variant->text);
    program *p = text_ok(&all, NULL) ? calloc(1, sizeof *p) : NULL;
    if (!p) {
        text_free(&all);
        return null_no_memory(err, "the program %s", variant->name);
    }
    memcpy(p->sha256, variant->sha256, sizeof p->sha256);
    memcpy(p->name, variant->name, sizeof p->name);
    p->text = all.chars;
    return p;
}

static program *find_or_add(program_set *set, const gen_variant *variant, duet_error *err)
{
    for (program *p = set->first; p; p = p->next)
        if (strcmp(p->sha256, variant->sha256) == 0)
            return p;
    program *p = new_program(set, variant, err);
    if (p) {
        p->next = set->first;
        set->first = p;
    }
    return p;
}

static kernel_groups groups_of(const kernel *k)
{
    return kernel_param(k, "MEET") == 1                    ? GROUPS_MEET
           : k->group == 1 && kernel_param(k, "TEAM") == 1 ? GROUPS_TEAM
                                                           : GROUPS_APART;
}

static kernel *find_or_add_entry(const program_set *set, program *p, const char *entry,
                                 const gen_variant *variant, const launcher *l, duet_error *err)
{
    for (int i = 0; i < p->n_entries; ++i)
        if (strcmp(p->entries[i].entry, entry) == 0) {
            kernel_ask(&p->entries[i].k);
            return &p->entries[i].k;
        }
    if (p->n_entries == PROGRAM_MOST_ENTRIES)
        return error_null(err, DUET_STATUS_BUILD_FAILED, "%s on %s: has more than %d kernels",
                          variant->name, set->device->info.selector, PROGRAM_MOST_ENTRIES);
    kernel *k = &p->entries[p->n_entries].k;
    k->launcher = *l;
    k->group = variant->group;
    k->per_item = variant->per_item;
    k->n_axes = variant->n_axes;
    memcpy(k->more, variant->more, sizeof k->more);
    snprintf(k->name, sizeof k->name, "%s", variant->name);
    k->groups = groups_of(k);
    snprintf(p->entries[p->n_entries].entry, sizeof p->entries[0].entry, "%s", entry);
    ++p->n_entries;
    return k;
}

static kernel *add_kernel(program_set *set, const gen_variant *variant, const char *entry,
                          bindings from, duet_error *err)
{
    launcher l;
    bool bound = bind(set, variant, entry, from, &l, err);
    program *p = bound ? find_or_add(set, variant, err) : NULL;
    return p ? find_or_add_entry(set, p, entry, variant, &l, err) : NULL;
}

kernel *program_set_kernel(program_set *set, const char *kernel_name, const char *entry,
                           const gen_setting *settings, uint32_t n_settings, bindings from,
                           duet_error *err)
{
    gen_variant variant = {0};
    if (!gen_make(set->gen, kernel_name, settings, n_settings, &set->limits, &variant, err))
        return NULL;
    kernel *k = add_kernel(set, &variant, entry, from, err);
    gen_variant_free(&variant);
    return k;
}

static kernel *make_kernel(program_set *set, const kernel_request *r, const gen_offer *offers,
                           uint32_t n_offers, duet_error *err)
{
    gen_variant variant;
    if (!gen_make_offered(set->gen, r->name, offers, n_offers, &set->limits, &variant, err))
        return NULL;
    kernel *k = add_kernel(set, &variant, r->entry, r->from, err);
    gen_variant_free(&variant);
    return k;
}

bool program_set_kernels(program_set *set, const kernel_request *list, size_t n,
                         const gen_offer *offers, uint32_t n_offers, duet_error *err)
{
    bool ok = true;
    for (size_t i = 0; i < n; ++i) {
        bool asks = ok && list[i].wanted;
        *list[i].at = asks ? make_kernel(set, &list[i], offers, n_offers, err) : NULL;
        ok = ok && (*list[i].at || !asks);
    }
    for (size_t i = 0; !ok && i < n; ++i)
        *list[i].at = NULL;
    return ok;
}

bool program_set_check(program_set *set, const char *kernel_name, const gen_setting *settings,
                       uint32_t n_settings, duet_error *err)
{
    gen_variant variant = {0};
    if (!gen_make(set->gen, kernel_name, settings, n_settings, &set->limits, &variant, err))
        return false;
    program *p = new_program(set, &variant, err);
    bool ok = p && program_compile(set, p, err);
    if (p)
        program_close(p);
    gen_variant_free(&variant);
    return ok;
}
