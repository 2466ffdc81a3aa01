// SPDX-License-Identifier: MIT
// A motion's plan: how its world finds pairs, and with which parameters B runs the kernels that
// only a motion has.
//
// Both stand in the text of a variant. A world knows no kernels of motions, so it is given the
// text without these; what the text sets of them for device A has no meaning, since B has the
// state. The skin stands there too, as "motion.skin": how long pairs last is a matter of time, and
// changes no bit.
#define _POSIX_C_SOURCE 200809L // strtok_r
#include "runtime/dynamics/motion_plan.h"

#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// In the order in which a step mostly spends its time on them, with the stages of a step that
// the time is in.
static const struct {
    const char *name;
    const char *stages[KERNEL_SPACE_STAGES];
} kernels[] = {
    {"solve_contacts", {"solve_contacts"}},   {"build_manifolds", {"manifolds"}},
    {"integrate_positions", {"integrate"}},   {"bodies", {"integrate"}},
    {"prepare_contacts", {"solve_contacts"}}, {"graph_colour", {"graph_colour"}},
    {"fat_aabbs", {"fat_aabbs", "grid"}},     {"contact_graph", {"contact_graph"}},
    {"match_contacts", {"match_contacts"}},   {"update_sleep", {"sleep"}},
    {"contact_events", {"events"}},           {"integrate_free_flight", {"integrate"}},
};

enum { N_KERNELS = sizeof kernels / sizeof kernels[0] };

static const char motion_word[] = "motion";
static const int64_t skins[] = {0, 5, 10, 20, 40, 80}; // in percent; 0: the def's

enum { N_SKINS = sizeof skins / sizeof skins[0], MOST_SKIN = 1000 };

// ---------------------------------------------------------------- text

// "solve_contacts.WG=64"
static bool is_of_motion(const char *word)
{
    size_t n = strcspn(word, ".");
    if (word[n] == '.' && n == strlen(motion_word) && strncmp(word, motion_word, n) == 0)
        return true;
    for (int i = 0; word[n] == '.' && i < N_KERNELS; ++i)
        if (strlen(kernels[i].name) == n && strncmp(word, kernels[i].name, n) == 0)
            return true;
    return false;
}

static void add_word(char to[DUET_VARIANT], const char *word)
{
    size_t n = strlen(to);
    snprintf(to + n, DUET_VARIANT - n, "%s%s", n ? " " : "", word);
}

// Of a text that variant_parse takes, or would refuse as too long.
static void part_text(const char text[DUET_VARIANT], char search[DUET_VARIANT],
                      char own[DUET_VARIANT])
{
    char words[DUET_VARIANT];
    char *rest = NULL;
    snprintf(words, sizeof words, "%s", text);
    *search = *own = '\0';
    for (char *word = strtok_r(words, " ,", &rest); word; word = strtok_r(NULL, " ,", &rest))
        add_word(is_of_motion(word) ? own : search, word);
}

static bool take_skin(motion_plan *p, const variant_setting *s, duet_error *err)
{
    if (strcmp(s->name, "skin") != 0 || s->value < 0 || s->value > MOST_SKIN)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "variant: %s.%s=%lld; expected motion.skin in percent of the bodies' mean "
                         "least extent, from 0 to %d",
                         s->kernel, s->name, (long long)s->value, MOST_SKIN);
    p->skin = (uint32_t)s->value;
    return true;
}

// Leaves the kernels' settings.
static bool take_skins(motion_plan *p, duet_error *err)
{
    variant *v = &p->settings;
    uint32_t n = 0;
    bool ok = true;
    p->skin = 0;
    for (uint32_t i = 0; ok && i < v->n_settings; ++i) {
        if (strcmp(v->settings[i].kernel, motion_word) == 0)
            ok = take_skin(p, &v->settings[i], err);
        else
            v->settings[n++] = v->settings[i];
    }
    v->n_settings = n;
    return ok;
}

// What may be chosen freely changes no bit of the state. prepare_contacts fills the lanes that
// solve_contacts solves, and keeps all of them.
static bool is_free(const variant_setting *s)
{
    bool lanes = strcmp(s->name, "LANES") == 0;
    return (lanes && strcmp(s->kernel, "prepare_contacts") != 0) || strcmp(s->name, "WG") == 0 ||
           strcmp(s->name, "PER_ITEM") == 0;
}

static bool check_settings(const variant *v, duet_error *err)
{
    for (uint32_t i = 0; i < v->n_settings; ++i) {
        const variant_setting *s = &v->settings[i];
        if (!is_free(s))
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "variant: %s.%s cannot be set; expected WG, PER_ITEM or LANES (but of "
                             "prepare_contacts) of a motion's kernel",
                             s->kernel, s->name);
    }
    return true;
}

bool motion_plan_read(motion_plan *p, const duet_plan *plan, const duet_device_info *b,
                      duet_error *err)
{
    // A search's name is at least as long.
    char text[DUET_VARIANT + sizeof "gpu "], none[DUET_VARIANT];
    p->search = *plan;
    part_text(plan->variant_a, p->search.variant_a, none);
    part_text(plan->variant_b, p->search.variant_b, p->own);
    snprintf(text, sizeof text, "gpu %s", p->own);
    return variant_parse(&p->settings, text, b, err) && take_skins(p, err) &&
           check_settings(&p->settings, err);
}

// ---------------------------------------------------------------- a motion's

uint32_t motion_plan_offer(motion_plan *p, gen_offer offers[VARIANT_SETTINGS])
{
    for (uint32_t i = 0; i < p->settings.n_settings; ++i) {
        variant_setting *s = &p->settings.settings[i];
        offers[i] = (gen_offer){s->kernel, s->name, s->value, GEN_REQUIRED, &s->used};
    }
    return p->settings.n_settings;
}

bool motion_plan_is_used(const duet_motion *m, duet_error *err)
{
    const motion_plan *p = &m->plan;
    if (p->skin > 0 && !(m->effects & DUET_EFFECT_SKIN))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "variant: motion.skin=%u; expected a motion whose def has a skin above 0",
                         p->skin);
    for (uint32_t i = 0; i < p->settings.n_settings; ++i) {
        const variant_setting *s = &p->settings.settings[i];
        if (!s->used)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "variant: no kernel that the motion runs has a parameter '%s.%s'",
                             s->kernel, s->name);
    }
    return true;
}

double motion_skin(const duet_motion *m)
{
    if (!(m->effects & DUET_EFFECT_SKIN))
        return 0.0;
    return m->plan.skin > 0 ? m->plan.skin / 100.0 * m->extent : m->def.skin;
}

void motion_plan_note(duet_motion *m)
{
    m->def.plan = m->world ? *duet_world_get_plan(m->world) : m->plan.search;
    if (*m->plan.own)
        add_word(m->def.plan.variant_b, m->plan.own);
}

// After a failure the motion has the plan before.
static bool prepare_with(duet_motion *m, const motion_plan *plan, duet_error *err)
{
    const motion_plan before = m->plan;
    m->plan = *plan;
    if (motion_prepare_again(m, err)) {
        m->rows_stale = m->rows_stale || plan->skin != before.skin;
        return true;
    }
    m->plan = before;
    return false;
}

// As it was given: a mode that is left to the grid stays so.
static duet_plan plan_of(const duet_world *world)
{
    duet_plan plan = world->def.plan;
    plan.mode = world->mode_open ? DUET_MODE_DEFAULT : plan.mode;
    return plan;
}

bool duet_motion_set_plan(duet_motion *m, const duet_plan *plan, duet_error *err)
{
    motion_plan read;
    if (!motion_is_whole(m, __func__, err) || !error_given(plan, __func__, "plan", err) ||
        !motion_plan_read(&read, plan, &m->device->info, err))
        return false;
    const duet_plan before = m->world ? plan_of(m->world) : m->plan.search;
    if (m->world && !duet_world_set_plan(m->world, &read.search, err))
        return false;
    bool ok = prepare_with(m, &read, err);
    if (!ok && m->world)
        duet_world_set_plan(m->world, &before, NULL);
    motion_plan_note(m);
    return ok;
}

const duet_plan *duet_motion_get_plan(const duet_motion *m)
{
    return m && m->world && !m->background.under_way ? &m->def.plan : NULL;
}

// ---------------------------------------------------------------- what is free

// The one that the motion has built; NULL where it has none of that name.
static const kernel *find_kernel(const duet_motion *m, const char *name)
{
    const kernel *const *all = (const kernel *const *)&m->kernels;
    for (size_t i = 0; i < sizeof m->kernels / sizeof *all; ++i)
        if (kernel_is(all[i], name))
            return all[i];
    return NULL;
}

// Varied like a kernel's parameter: what a skin takes and saves is in these stages.
static kernel_space space_of_skin(const duet_motion *m)
{
    kernel_space space = {.stages = {"pairs", "contact_graph", "manifolds"}, .n_params = 1};
    snprintf(space.kernel, sizeof space.kernel, "%s", motion_word);
    snprintf(space.params[0].name, sizeof space.params[0].name, "skin");
    memcpy(space.params[0].values, skins, sizeof skins);
    space.params[0].n_values = space.n_configs = N_SKINS;
    for (uint8_t i = 0; i < N_SKINS; ++i) {
        space.configs[i][0] = i;
        space.now = skins[i] == m->plan.skin ? i : space.now;
    }
    return space;
}

static bool read_spaces(duet_motion *m, kernel_space *spaces, uint32_t *n, duet_error *err)
{
    if (m->effects & DUET_EFFECT_SKIN)
        spaces[(*n)++] = space_of_skin(m);
    gen_offer offers[MOTION_OFFERS + 2];
    uint32_t n_offers = motion_offers(m, false, offers);
    // Kernels that share the blocks have one size of them.
    offers[n_offers++] = (gen_offer){NULL, "BLOCK", m->layout.block, GEN_OFFERED, NULL};
    if (m->kernels.prepare_contacts)
        offers[n_offers++] =
            (gen_offer){"prepare_contacts", "LANES",
                        kernel_param(m->kernels.prepare_contacts, "LANES"), GEN_OFFERED, NULL};
    const kernel_space_source from = {m->gen, program_set_limits(m->programs), offers, n_offers};
    bool ok = true;
    for (int i = 0; ok && i < N_KERNELS; ++i) {
        const kernel *k = find_kernel(m, kernels[i].name);
        ok =
            !k || kernel_space_read(&from, kernels[i].name, kernels[i].stages, k, &spaces[*n], err);
        *n += ok && k && spaces[*n].n_configs > 1;
    }
    return ok;
}

bool motion_kernel_spaces(duet_motion *m, kernel_space **spaces, uint32_t *n, duet_error *err)
{
    *n = 0;
    *spaces = malloc((1 + N_KERNELS) * sizeof **spaces);
    return *spaces ? read_spaces(m, *spaces, n, err)
                   : error_set(err, DUET_STATUS_NO_MEMORY, "no memory for kernels' configs");
}
