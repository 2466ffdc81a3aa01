// SPDX-License-Identifier: MIT
// A motion's plan: how its world finds pairs, and with which parameters B runs the kernels that
// only a motion has.
//
// Both stand in the text of a variant. A world knows no kernels of motions, so it is given the
// text without these; what the text sets of them for device A has no meaning, since B has the
// state. What is set of the motion itself stands there too, as "motion.skin": how long pairs last,
// and how often ranks exchange ghosts, is a matter of time, and changes no bit.
#define _POSIX_C_SOURCE 200809L // strtok_r
#include "runtime/dynamics/motion_plan.h"

#include "base/error.h"
#include "runtime/dynamics/motion.h"

#include <stdio.h>
#include <string.h>

const motion_plan_kernel motion_plan_kernels[MOTION_PLAN_KERNELS] = {
    {"solve_contacts", {"solve_contacts"}},   {"build_manifolds", {"manifolds"}},
    {"integrate_positions", {"integrate"}},   {"bodies", {"integrate"}},
    {"prepare_contacts", {"solve_contacts"}}, {"graph_colour", {"graph_colour"}},
    {"fat_aabbs", {"fat_aabbs", "grid"}},     {"contact_graph", {"contact_graph"}},
    {"match_contacts", {"match_contacts"}},   {"update_sleep", {"sleep"}},
    {"contact_events", {"events"}},           {"integrate_free_flight", {"integrate"}},
    {"solve_shocks", {"solve_contacts"}},
};

enum { MOST_SKIN = 1000, MOST_COLOURS = COLOUR_OVERFLOW };

// ---------------------------------------------------------------- text

// "solve_contacts.WG=64"
static bool is_of_motion(const char *word)
{
    size_t n = strcspn(word, ".");
    if (word[n] == '.' && n == strlen(MOTION_PLAN_WORD) && strncmp(word, MOTION_PLAN_WORD, n) == 0)
        return true;
    for (int i = 0; word[n] == '.' && i < MOTION_PLAN_KERNELS; ++i)
        if (strlen(motion_plan_kernels[i].name) == n &&
            strncmp(word, motion_plan_kernels[i].name, n) == 0)
            return true;
    return false;
}

static void add_word(char to[DUET_VARIANT], const char *word)
{
    size_t n = strlen(to);
    snprintf(to + n, DUET_VARIANT - n, "%s%s", n ? " " : "", word);
}

// Splits a text that variant_parse takes, or would refuse as too long.
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

typedef struct own_setting {
    const char *name;
    uint32_t *value, most;
} own_setting;

// What is set of the motion itself, and of no kernel.
static bool take_own(motion_plan *p, const variant_setting *s, duet_error *err)
{
    const own_setting all[] = {{"skin", &p->skin, MOST_SKIN},
                               {"colours", &p->colours, MOST_COLOURS}};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        if (strcmp(s->name, all[i].name) == 0 && s->value >= 0 && s->value <= all[i].most) {
            *all[i].value = (uint32_t)s->value;
            return true;
        }
    return bad_argument(
        err,
        "variant: %s.%s=%lld; expected motion.skin in percent of the bodies' mean least extent, "
        "from 0 to %d, or motion.colours between exchanges of ranks, from 0 to %d",
        s->kernel, s->name, (long long)s->value, MOST_SKIN, MOST_COLOURS);
}

// Leaves the kernels' settings.
static bool take_own_settings(motion_plan *p, duet_error *err)
{
    variant *v = &p->settings;
    uint32_t n = 0;
    bool ok = true;
    p->skin = p->colours = 0;
    for (uint32_t i = 0; ok && i < v->n_settings; ++i) {
        if (strcmp(v->settings[i].kernel, MOTION_PLAN_WORD) == 0)
            ok = take_own(p, &v->settings[i], err);
        else
            v->settings[n++] = v->settings[i];
    }
    v->n_settings = n;
    return ok;
}

// Settings that may be chosen freely change no bit of the state. prepare_contacts fills the lanes
// that solve_contacts solves, and keeps all of them.
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
            return bad_argument(err,
                                "variant: %s.%s cannot be set; expected WG, PER_ITEM or LANES (but "
                                "of prepare_contacts) of a motion's kernel",
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
    return variant_parse(&p->settings, text, b, err) && take_own_settings(p, err) &&
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
        return bad_argument(
            err, "variant: motion.skin=%u; expected a motion whose def has a skin above 0",
            p->skin);
    for (uint32_t i = 0; i < p->settings.n_settings; ++i) {
        const variant_setting *s = &p->settings.settings[i];
        if (!s->used)
            return bad_argument(err,
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
    m->def.plan = m->graph.world ? *duet_world_get_plan(m->graph.world) : m->plan.search;
    if (*m->plan.own)
        add_word(m->def.plan.variant_b, m->plan.own);
}

const duet_plan *duet_motion_get_plan(const duet_motion *m)
{
    return m && m->graph.world && m->phase != MOTION_STEPPING ? &m->def.plan : NULL;
}
