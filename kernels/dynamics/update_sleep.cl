// SPDX-License-Identifier: MIT
// Sleep.
//
// Invariant: a body sleeps if it has rested for `sleep_after` seconds and touches no body that moves.
//
//   awake --- rested, touches none that moves ---> asleep --- deep in others ---> pressed: pushed out
//     ^                                              |                              |  (push_sleepers.cl)
//     +---- touches a body that moves, or lost a contact, which set its rest to 0 --+
//
//   rests, asleep  as rest.clh has them

// Finds what a body touches: whether all of it rests, and whether some of it is deep in the body.
typedef struct {
    bool rests;
    bool deep;
} touch;

static inline void add_touch(const scene *s, uint word, uint other, touch *so_far)
{
    if (!so_far->rests || !(word & TOUCH_POINTS) || IS_SENSOR(s, other))
        return;
    so_far->rests = is_at_rest(s, other);
    so_far->deep = so_far->deep || (word & TOUCH_DEEP);
}

// As far as something that moves is found.
static inline touch touch_of(const scene *s, uint id)
{
    touch found = {true, false};
    if (IS_SENSOR(s, id))
        return found;
    const body_row row = row_of(s->starts, s->return_starts, s->returns, id);
    for (uint k = 0; found.rests && k < row.n; k += ROW_AHEAD) {
        const contacts_ahead next = look_ahead(&row, k, s->links, s->touches);
        EACH_AHEAD(j, next)
            add_touch(s, next.words[j], other_of(next.links[j], id), &found);
    }
    return found;
}

__kernel void update_sleep(UPDATE_SLEEP_ARGS)
{
    const scene s = {UPDATE_SLEEP_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    bool any_awake = false, any_pressed = false;
    for (uint k = first; k < last; ++k) {
        uint id = AWAKE_AT(k);
        bool slept = asleep[id] & SLEEPS, sleeps = has_rested(&s, id), pressed = false;
        if (sleeps) {
            touch found = touch_of(&s, id);
            sleeps = found.rests;
            pressed = found.rests && found.deep && rests[id] < sleep_after + PRESSED_STEPS * dt;
        }
        if (sleeps != slept)
            atomic_or(flags + FLAG_FELL_ASLEEP, 1u);
        if (slept && !sleeps)
            atomic_or(flags + FLAG_WOKE, 1u);
        asleep[id] = (sleeps ? SLEEPS : 0u) | (pressed ? PRESSED : 0u) | (slept && !sleeps ? WOKE : 0u);
        any_pressed = any_pressed || pressed;
        any_awake = any_awake || pressed || !(sleeps || (!(velocities[id].w > 0) && is_at_rest(&s, id)));
    }
    if (any_awake)
        atomic_or(flags + FLAG_AWAKE, 1u);
    if (any_pressed)
        atomic_or(flags + FLAG_PRESSED, 1u);
}

static inline void wake_across(const scene *s, volatile __global uint *asleep, uint word, uint other)
{
    if (other < s->n && (word & TOUCH_POINTS) && !IS_SENSOR(s, other) && (asleep[other] & SLEEPS))
        atomic_xchg(asleep + other, WOKE);
}

// A sleeper that lost a contact in this step wakes what it touches, which may be in no list yet.
__kernel void wake_touching(WAKE_TOUCHING_ARGS)
{
    const scene s = {WAKE_TOUCHING_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    for (uint k = first; k < last; ++k) {
        uint id = AWAKE_AT(k);
        if (!(asleep[id] & WOKE) || is_at_rest(&s, id) || IS_SENSOR(&s, id))
            continue;
        const body_row row = row_of(starts, return_starts, returns, id);
        for (uint i = 0; i < row.n; i += ROW_AHEAD) {
            const contacts_ahead next = look_ahead(&row, i, links, touches);
            EACH_AHEAD(j, next)
                wake_across(&s, asleep, next.words[j], other_of(next.links[j], id));
        }
    }
}
