// SPDX-License-Identifier: MIT
#include "runtime/commands/motion_check.h"

#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_state.h"

#include <math.h>
#include <stdlib.h>

// A step keeps lengths far nearer to 1.
#define MOST_OFF 1e-3

static const uint32_t *words_of(const motion_saved *s, motion_buffer which)
{
    return s->at[which];
}

static const float *floats_of(const motion_saved *s, motion_buffer which)
{
    return s->at[which];
}

static double real_of(const duet_motion *m, const motion_saved *s, motion_buffer which, size_t i)
{
    return m->def.doubles ? ((const double *)s->at[which])[i] : (double)floats_of(s, which)[i];
}

static bool bad_object(const motion_saved *s, uint32_t id, const char *what, duet_error *err)
{
    return bad_input(err, "%s: the saved motion's object %u: %s", s->path, id, what);
}

static bool bad_contact(const motion_saved *s, uint32_t i, const char *what, duet_error *err)
{
    return bad_input(err, "%s: the saved motion's contact %u: %s", s->path, i, what);
}

// ---------------------------------------------------------------- objects

static bool moves(const duet_motion *m, uint32_t id)
{
    return id < m->n && m->bodies[id].mass > 0.0f && !motion_is_hidden(m, id);
}

static bool are_finite(const duet_motion *m, const motion_saved *s, uint32_t id)
{
    static const motion_buffer reals[] = {CENTRES, VELOCITIES, ROTATIONS, ANGULAR_VELOCITIES};
    for (size_t i = 0; i < sizeof reals / sizeof reals[0]; ++i)
        for (size_t k = 0; s->at[reals[i]] && k < 4; ++k)
            if (!isfinite(real_of(m, s, reals[i], 4 * (size_t)id + k)))
                return false;
    return true;
}

static bool has_right_mass(const duet_motion *m, const motion_saved *s, uint32_t id)
{
    float mass = m->bodies[id].mass;
    double right = moves(m, id) ? 1.0 / (double)mass : 0.0;
    double saved = real_of(m, s, VELOCITIES, 4 * (size_t)id + 3);
    return saved == (m->def.doubles ? right : (double)(float)right);
}

static bool is_turned(const duet_motion *m, const motion_saved *s, uint32_t id)
{
    double norm = 0.0;
    for (size_t k = 0; s->at[ROTATIONS] && k < 4; ++k)
        norm += pow(real_of(m, s, ROTATIONS, 4 * (size_t)id + k), 2.0);
    return !s->at[ROTATIONS] || fabs(norm - 1.0) <= MOST_OFF;
}

// Offsets are multiples of 2^-24 of an edge, from 0 up to below it, in cells up to
// 2^30 from 0 (origin.h).
static bool is_in_cell(const duet_motion *m, const motion_saved *s, uint32_t id)
{
    const int32_t *cells = s->at[CELLS];
    for (uint32_t k = 0; cells && k < m->def.dims; ++k) {
        double quanta = real_of(m, s, CENTRES, 4 * (size_t)id + k) * (0x1p24 / m->def.origin_edge);
        if (!(quanta >= 0.0 && quanta < 0x1p24) || quanta != rint(quanta) ||
            fabs((double)cells[4 * (size_t)id + k]) > 0x1p30)
            return false;
    }
    return true;
}

static bool has_box(const duet_motion *m, const motion_saved *s, uint32_t id)
{
    const float *boxes = floats_of(s, BOXES);
    bool empty = s->rows_stale || motion_is_hidden(m, id);
    for (uint32_t k = 0; boxes && k < 3; ++k) {
        float lower = boxes[6 * (size_t)id + k], upper = boxes[6 * (size_t)id + 3 + k];
        if (!isfinite(lower) || !isfinite(upper) || (!empty && k < m->def.dims && lower > upper))
            return false;
    }
    return true;
}

static bool has_rest(const motion_saved *s, uint32_t id)
{
    const float *rests = floats_of(s, RESTS);
    return !rests || (isfinite(rests[id]) && (rests[id] >= 0.0f || rests[id] == RESTS_CHANGED));
}

static bool check_object(const duet_motion *m, const motion_saved *s, uint32_t id, duet_error *err)
{
    if (!are_finite(m, s, id))
        return bad_object(s, id, "a number of its state is not finite", err);
    if (!has_right_mass(m, s, id))
        return bad_object(s, id, "its mass is another than the motion's", err);
    if (!is_turned(m, s, id))
        return bad_object(s, id, "its rotation is not of length 1", err);
    if (!is_in_cell(m, s, id))
        return bad_object(s, id, "it is at no place of its origin cell", err);
    if (!has_box(m, s, id))
        return bad_object(s, id, "its bounds are not finite or not rising", err);
    if (!has_rest(s, id))
        return bad_object(s, id, "its time at rest is not finite, or below 0 and not -1", err);
    if (s->at[ASLEEP] && words_of(s, ASLEEP)[id] > (SLEEPS | WOKE | PRESSED))
        return bad_object(s, id, "whether it sleeps is said by no such word", err);
    return true;
}

// ---------------------------------------------------------------- rows

static bool check_counts(const duet_motion *m, const motion_saved *s, duet_error *err)
{
    bool contact = m->effects & DUET_EFFECT_CONTACT;
    uint64_t most = motion_most_contacts(m, s->n_pairs);
    if (s->has_graph > contact || (!s->has_graph && (s->n_contacts > 0 || s->n_pairs > 0)))
        return bad_input(err, "%s: the saved motion has %u contacts, but nothing that finds them",
                         s->path, s->n_contacts);
    return (s->n_pairs < UINT32_MAX && s->n_contacts <= most) ||
           bad_input(err, "%s: the saved motion has %u contacts of %llu pairs", s->path,
                     s->n_contacts, (unsigned long long)s->n_pairs);
}

// Starts rise from 0 to `last`.
static bool check_starts(const duet_motion *m, const motion_saved *s, motion_buffer which,
                         uint32_t last, duet_error *err)
{
    const uint32_t *starts = words_of(s, which);
    bool ok = starts[0] == 0 && starts[m->n] == last;
    for (uint32_t id = 0; ok && id < m->n; ++id)
        ok = starts[id] <= starts[id + 1];
    return ok ||
           bad_input(err, "%s: the saved motion's rows do not rise from 0 to the %u that there are",
                     s->path, last);
}

static bool may_touch(const duet_motion *m, uint32_t a, uint32_t b)
{
    const duet_body *x = &m->bodies[a], *y = &m->bodies[b];
    return !(m->effects & DUET_EFFECT_FILTER) || ((x->group & y->mask) && (y->group & x->mask));
}

static bool is_sensor(const duet_motion *m, uint32_t id)
{
    return id < m->n && m->bodies[id].sensor;
}

// Whether there is such a wall, or contact with the ground.
static bool is_fixed(const duet_motion *m, uint32_t k)
{
    return k < AT_GROUND ? motion_touches_walls(m) && k < 2 * m->def.dims
                         : motion_touches_ground(m) && k < FIXED;
}

// The first of two bodies with a mass owns the contact; a body without mass owns one only as a
// sensor, with another body without mass. Sensors meet no walls and no sensors.
static bool can_meet(const duet_motion *m, uint32_t owner, uint32_t other)
{
    if (is_sensor(m, owner) && (other >= m->n || is_sensor(m, other)))
        return false;
    if (!moves(m, owner) && (!is_sensor(m, owner) || moves(m, other)))
        return false;
    if (other >= m->n)
        return is_fixed(m, other - m->n);
    return other != owner && (!moves(m, other) || owner < other) && may_touch(m, owner, other);
}

static bool check_row(const duet_motion *m, const motion_saved *s, uint32_t owner, duet_error *err)
{
    const uint32_t *starts = words_of(s, STARTS), *others = words_of(s, OTHERS);
    const uint32_t *links = words_of(s, LINKS);
    for (uint32_t i = starts[owner]; i < starts[owner + 1]; ++i) {
        if (!can_meet(m, owner, others[i]))
            return bad_contact(s, i, "its objects cannot touch", err);
        if (i > starts[owner] && others[i] <= others[i - 1])
            return bad_contact(s, i, "its row is not ascending", err);
        if (links[2 * (size_t)i] != owner || links[2 * (size_t)i + 1] != others[i])
            return bad_contact(s, i, "its link is not its row's", err);
    }
    return true;
}

// ---------------------------------------------------------------- contacts

// Axes that separate boxes have numbers (kernels/dynamics/box_contact.clh); only those that
// are turned keep one.
static uint32_t most_axis(const duet_motion *m)
{
    return !(m->effects & DUET_EFFECT_ROTATION) ? 0 : m->def.dims == 3 ? 15 : 5;
}

static bool has_record(const duet_motion *m, const motion_saved *s, uint32_t i, uint32_t points)
{
    const float *record = floats_of(s, CONTACTS) + (size_t)i * m->layout.record;
    for (uint32_t k = 0; points > 0 && k < m->layout.head + points * m->layout.point; ++k)
        if (!isfinite(record[k]))
            return false;
    return true;
}

static bool check_contact(const duet_motion *m, const motion_saved *s, uint32_t i, duet_error *err)
{
    uint32_t touch = words_of(s, TOUCHES)[i], points = touch & TOUCH_POINTS;
    if (points > m->layout.points || touch >> TOUCH_AXIS > most_axis(m))
        return bad_contact(s, i, "it has more points, or another axis, than boxes have", err);
    return has_record(m, s, i, points) ||
           bad_contact(s, i, "a number of its points is not finite", err);
}

// Contacts of one colour are solved at the same time: they share no object that
// moves. taken [n] has a bit for each colour.
static bool take_colour(const duet_motion *m, uint32_t *taken, uint32_t id, uint32_t colour)
{
    uint32_t bit = UINT32_C(1) << colour;
    if (!moves(m, id))
        return true;
    bool is_free = !(taken[id] & bit);
    taken[id] |= bit;
    return is_free;
}

static bool check_colour(const duet_motion *m, const motion_saved *s, uint32_t i, uint32_t *taken,
                         duet_error *err)
{
    const uint32_t *link = words_of(s, LINKS) + 2 * (size_t)i;
    uint32_t colour = words_of(s, COLOUR_OF)[i];
    if (colour > COLOUR_NONE)
        return bad_contact(s, i, "there is no such colour", err);
    return colour >= COLOUR_OVERFLOW ||
           (take_colour(m, taken, link[0], colour) && take_colour(m, taken, link[1], colour)) ||
           bad_contact(s, i, "another contact of its object has its colour", err);
}

static bool check_colours(const duet_motion *m, const motion_saved *s, uint32_t *taken,
                          duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < s->n_contacts; ++i)
        ok = check_colour(m, s, i, taken, err);
    return ok;
}

// Checks for each object that moves the contacts that it is the other of, ascending. places [n] is
// where in its row the next one is expected.
static bool check_returns(const duet_motion *m, const motion_saved *s, uint32_t *places,
                          duet_error *err)
{
    const uint32_t *starts = words_of(s, RETURN_STARTS), *others = words_of(s, OTHERS);
    uint32_t n = 0;
    for (uint32_t id = 0; id < m->n; ++id)
        places[id] = starts[id];
    for (uint32_t i = 0; i < s->n_contacts; ++i) {
        uint32_t other = others[i];
        if (!moves(m, other))
            continue;
        if (places[other] == starts[other + 1] || words_of(s, RETURNS)[places[other]++] != i)
            return bad_contact(s, i, "its other object does not list it", err);
        ++n;
    }
    return n == starts[m->n] ||
           bad_input(err, "%s: the saved motion's objects list %u contacts, and there are %u",
                     s->path, starts[m->n], n);
}

// That links, from which contacts are taken over, are of objects that there are.
static bool check_links(const duet_motion *m, const motion_saved *s, duet_error *err)
{
    const uint32_t *links = words_of(s, LINKS);
    for (uint32_t i = 0; i < s->n_contacts; ++i)
        if (links[2 * (size_t)i] >= m->n || links[2 * (size_t)i + 1] >= m->n + FIXED ||
            links[2 * (size_t)i] == links[2 * (size_t)i + 1])
            return bad_contact(s, i, "its objects cannot touch", err);
    return true;
}

static bool check_rows(const duet_motion *m, const motion_saved *s, uint32_t *places,
                       duet_error *err)
{
    uint32_t n_returns = words_of(s, RETURN_STARTS)[m->n];
    bool ok = check_starts(m, s, STARTS, s->n_contacts, err) &&
              check_starts(m, s, RETURN_STARTS,
                           n_returns < s->n_contacts ? n_returns : s->n_contacts, err);
    for (uint32_t id = 0; ok && id < m->n; ++id)
        ok = check_row(m, s, id, err);
    return ok && check_returns(m, s, places, err);
}

static bool check_contacts(const duet_motion *m, const motion_saved *s, duet_error *err)
{
    uint32_t *words = calloc((size_t)m->n + 1, 2 * sizeof *words);
    if (!words)
        return no_memory(err, "%u rows of %s", m->n, s->path);
    bool ok = s->rows_stale ? check_links(m, s, err) : check_rows(m, s, words, err);
    for (uint32_t i = 0; ok && i < s->n_contacts; ++i)
        ok = check_contact(m, s, i, err);
    ok = ok && (!s->at[COLOUR_OF] || check_colours(m, s, words + m->n, err));
    free(words);
    return ok;
}

bool motion_check(const duet_motion *m, const motion_saved *s, duet_error *err)
{
    bool ok = check_counts(m, s, err);
    for (uint32_t id = 0; ok && id < m->n; ++id)
        ok = check_object(m, s, id, err);
    return ok && (!(m->effects & DUET_EFFECT_CONTACT) || check_contacts(m, s, err));
}
