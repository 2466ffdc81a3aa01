// SPDX-License-Identifier: MIT
// Saved motions that someone forged: the sum at their end is right, what it sums is
// not. Each is refused with one line and leaves the motion as it was, or it is
// loaded and steps without a byte written beside a buffer. With --all a hundred
// thousand are forged.
#define _POSIX_C_SOURCE 200809L
#include "guard/guard.h"
#include "support/mover.h"
#include "support/test.h"

#include "base/text_file.h"
#include "runtime/dynamics/motion.h"

#include <unistd.h>

static const char path[] = "forged"; // name of the file

// ------------------------------------------------------------ motions

// Has every kind of buffer that a file can have.
typedef enum kind {
    PILE,
    FLAT_GROUPS,
    PLACED,
    DOUBLES,
    ONLY_CONTACTS,
    FLIGHT,
    COMMANDED,
    AIMED,
    GROUND,
    KINDS
} kind;

static const char *const kind_names[KINDS] = {"pile",      "flat groups",   "placed",
                                              "doubles",   "only contacts", "flight",
                                              "commanded", "aimed",         "ground"};

static void add_walls(mover *m, double half)
{
    mover_wall_in(m, -half, half);
}

static const float heights[] = {-1, -2, 0, -1.5f, -1, -1};
static const duet_heights ground = {
    .nx = 3, .ny = 2, .origin = {-2, -4, 0}, .spacing = {2.5, 8}, .heights = heights};

static mover *make_mover(kind of)
{
    mover *m = mover_new(of == FLAT_GROUPS ? 2 : 3);
    rng r = rng_seed(77 + of);
    m->def.wants = of == FLIGHT ? 0 : DUET_EFFECT_CONTACT;
    if (of != ONLY_CONTACTS && of != FLIGHT)
        m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS;
    m->def.wants |= of == COMMANDED ? DUET_EFFECT_FORCES : 0;
    m->def.skin = of == PILE || of == ONLY_CONTACTS ? 0.3 : 0.0;
    m->def.gravity[1] = -5.0;
    m->def.heights = of == GROUND ? &ground : NULL;
    m->def.doubles = of == DOUBLES || of == FLIGHT;
    m->def.sleep_after = of == PILE ? 0.05 : 0.5;
    if (of == PLACED || of == AIMED)
        m->def.origin_edge = 4.0f;
    else
        add_walls(m, 4.0);
    for (uint32_t i = 0; i < 24; ++i) {
        uint32_t id = mover_add_cube(m, 0.97 * (i % 3) - 1, 0.97 * (i / 3 % 3) - 1,
                                     of == FLAT_GROUPS ? 0 : 0.97 * (i / 9) - 1, 1);
        duet_body *b = &m->bodies[id];
        b->mass = i % 7 == 0 ? 0.0f : 1.0f + (float)i / 8;
        b->friction = 0.4f;
        b->velocity[0] = i % 7 == 0 ? 0.0f : (float)rng_between(&r, -0.2, 0.2);
        b->fixed_rotation = of == ONLY_CONTACTS;
        if (of == FLAT_GROUPS && i % 2)
            b->group = b->mask = 3;
        if (of != ONLY_CONTACTS && of != FLIGHT)
            mover_turn(m, id, 0, 0, 1, 0.02 * i);
    }
    return m;
}

// Every kind of command, some before a step and some after it.
static void command(mover *m)
{
    const duet_body_list going = {.first = 3, .n = 2}, some = {.first = 7, .n = 1};
    const duet_transform there = {.centre = {-1, 0.1f, 1}, .rotation = {0, 0, 0, 1}};
    const duet_force force = {.force = {1, 2, 3}, .torque = {0, 0, 1}};
    const duet_pose pose = {
        .centre = {0, 3, 0}, .half_extents = {0.3f, 0.4f, 0.5f}, .rotation = {0, 0, 0, 1}};
    must(duet_motion_add_bodies(m->motion, &pose, NULL, 1, NULL, ERR));
    must(duet_motion_remove_bodies(m->motion, going, ERR));
    mover_run(m, 1);
    must(duet_motion_add_bodies(m->motion, &pose, NULL, 1, NULL, ERR));
    must(duet_motion_disable_bodies(m->motion, some, ERR));
    const duet_body_list kinematic = {.first = 14, .n = 1}, pushed = {.first = 9, .n = 1};
    must(duet_motion_set_targets(m->motion, kinematic, &there, ERR));
    must(duet_motion_apply_forces(m->motion, pushed, &force, ERR));
}

// A target alone, which is the last of the file.
static void aim(mover *m)
{
    const duet_body_list kinematic = {.first = 14, .n = 1};
    const duet_transform there = {.centre = {-1, 0.1f, 1}, .rotation = {0, 0, 0, 1}};
    must(duet_motion_set_targets(m->motion, kinematic, &there, ERR));
}

// ------------------------------------------------------------ files

enum {
    HEADER = 240,
    AT_N_CONTACTS = 36,
    AT_HAS_ROWS = 40,
    AT_NX = 60,
    PLACE = 136,
    TARGET = 32,
    FIELD = 40, // origin and spacing
    HEIGHTS = 4 * 6
};

// The order of a file (docs/formats.md), and how many words one contact has; 0 for
// what objects have.
static const struct {
    motion_buffer which;
    const char *name;
    uint32_t words;
} sections[] = {
    {CENTRES, "centres", 0},
    {CELLS, "cells", 0},
    {VELOCITIES, "speeds", 0},
    {ROTATIONS, "rotations", 0},
    {ANGULAR_VELOCITIES, "angular_velocities", 0},
    {RESTS, "rests", 0},
    {ASLEEP, "asleep", 0},
    {BOXES, "boxes", 0},
    {STARTS, "starts", 0},
    {RETURN_STARTS, "return starts", 0},
    {RETURNS, "returns", 1},
    {LINKS, "links", 2},
    {OTHERS, "others", 1},
    {CONTACTS, "contacts", UINT32_MAX},
    {TOUCHES, "touches", 1},
    {COLOUR_OF, "colours", 1},
};

enum { SECTIONS = sizeof sections / sizeof sections[0] };

typedef struct forger {
    mover *m;
    text right;  // the file as it was saved
    char *bytes; // a copy that is changed
    size_t n;
    uint32_t n_contacts;
    uint64_t hash;
} forger;

static size_t words_of(const forger *f, int i)
{
    const duet_motion *m = f->m->motion;
    uint32_t each = sections[i].words == UINT32_MAX ? m->layout.record : sections[i].words;
    if (each == 0)
        return ((size_t)m->n + 1) * motion_words(m, sections[i].which);
    if (!(m->effects & DUET_EFFECT_CONTACT) ||
        (sections[i].which == COLOUR_OF && !(m->effects & DUET_EFFECT_CONTACT_RESPONSE)))
        return 0;
    return (size_t)f->n_contacts * each;
}

// The place where a section begins in the file.
static size_t place_of(const forger *f, int section)
{
    size_t at = HEADER;
    for (int i = 0; i < section; ++i)
        at += 4 * words_of(f, i);
    return at;
}

static void put_sum(forger *f)
{
    uint64_t sum = text_checksum((const char *)f->bytes, f->n - sizeof(uint64_t));
    memcpy(f->bytes + f->n - sizeof sum, &sum, sizeof sum);
}

static void write_forged(forger *f)
{
    put_sum(f);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(f->bytes, 1, f->n, file), f->n);
    assert_int_equal(fclose(file), 0);
}

static void begin_copy(forger *f)
{
    f->n = f->right.length;
    memcpy(f->bytes, f->right.chars, f->n);
}

static void load_right(forger *f)
{
    begin_copy(f);
    write_forged(f);
    must(duet_motion_load(f->m->motion, path, ERR));
}

static forger open_forger(kind of)
{
    forger f = {.m = make_mover(of)};
    mover_run(f.m, 5);
    if (of == COMMANDED)
        command(f.m);
    if (of == AIMED)
        aim(f.m);
    must(duet_motion_save(f.m->motion, path, ERR));
    must(text_read_file(&f.right, path, ERR));
    f.bytes = malloc(f.right.length + 64);
    assert_non_null(f.bytes);
    memcpy(&f.n_contacts, f.right.chars + AT_N_CONTACTS, 4);
    must(duet_motion_get_hash(f.m->motion, &f.hash, ERR));
    assert_true(of == FLIGHT || f.n_contacts > 10);
    if (of != COMMANDED)
        assert_int_equal(place_of(&f, SECTIONS) + f.m->n * PLACE + (of == AIMED ? TARGET : 0) +
                             (of == GROUND ? FIELD + HEIGHTS : 0) + sizeof(uint64_t),
                         f.right.length);
    load_right(&f);
    return f;
}

static void close_forger(forger *f, const char *what)
{
    mover_free(f->m);
    free(f->bytes);
    text_free(&f->right);
    guard_assert_whole(what);
}

// ------------------------------------------------------------ one at a time

static void assert_refused(forger *f, const char *what, const char *said)
{
    uint64_t hash = 0;
    write_forged(f);
    print_message("%s\n", what);
    must_fail(duet_motion_load(f->m->motion, path, ERR), DUET_STATUS_BAD_INPUT, said);
    assert_says(ERR->text, path);
    must(duet_motion_get_hash(f->m->motion, &hash, ERR));
    assert_true(hash == f->hash);
}

static int section_of(motion_buffer which)
{
    int i = 0;
    while (sections[i].which != which)
        ++i;
    return i;
}

// Each kind of index, count and number, one wrong at a time.
TEST(what_a_step_would_believe_is_refused)
{
    static const uint32_t nan_bits = 0x7fc00000, minus_two = 0xc0000000, one = 0x3f800000;
    const struct {
        motion_buffer which;
        uint32_t word;
        uint32_t value;
        const char *said;
    } forged[] = {
        {CENTRES, 5, nan_bits, "object 1: a number of its state is not finite"},
        {ANGULAR_VELOCITIES, 4, 0x7f800000, "object 1: a number of its state is not finite"},
        {VELOCITIES, 3, one, "object 0: its mass"},
        {ROTATIONS, 7, 0x40000000, "object 1: its rotation is not of length 1"},
        {RESTS, 2, minus_two, "object 2: its time at rest"},
        {ASLEEP, 3, 8, "object 3: whether it sleeps"},
        {BOXES, 6, 0x7f800000, "object 1: its bounds"},
        {STARTS, 0, 1, "rows do not rise from 0"},
        {STARTS, 3, 1000000000, "rows do not rise from 0"},
        {STARTS, 24, 5, "rows do not rise from 0"},
        {RETURN_STARTS, 2, UINT32_MAX, "rows do not rise from 0"},
        {RETURN_STARTS, 24, 0, "rows do not rise from 0"},
        {RETURNS, 0, 900000000, "its other object does not list it"},
        {OTHERS, 0, 1u << 30, "contact 0: its objects cannot touch"},
        {OTHERS, 0, 24 + 6, "contact 0: its objects cannot touch"},
        {LINKS, 0, 1u << 30, "contact 0: its link is not its row's"},
        {LINKS, 1, 1u << 30, "contact 0: its link is not its row's"},
        {CONTACTS, 0, nan_bits, "a number of its points is not finite"},
        {TOUCHES, 0, 7, "more points, or another axis"},
        {TOUCHES, 0, 16 << 4, "more points, or another axis"},
        {COLOUR_OF, 0, 34, "contact 0: there is no such colour"},
        {COLOUR_OF, 1, UINT32_MAX, "contact 1: there is no such colour"},
    };
    forger f = open_forger(PILE);
    // The numbers of the first contact's points count where it has some.
    size_t touches = place_of(&f, section_of(TOUCHES));
    memcpy(f.right.chars + touches, &(uint32_t){1}, 4);
    for (size_t i = 0; i < sizeof forged / sizeof forged[0]; ++i) {
        int section = section_of(forged[i].which);
        begin_copy(&f);
        memcpy(f.bytes + place_of(&f, section) + 4 * forged[i].word, &forged[i].value, 4);
        assert_refused(&f, sections[section].name, forged[i].said);
    }
    begin_copy(&f);
    memcpy(f.bytes + AT_HAS_ROWS, &(uint32_t){2}, 4);
    assert_refused(&f, "has_graph", "nothing that finds them");
    begin_copy(&f);
    memcpy(f.bytes + AT_HAS_ROWS, &(uint32_t){0}, 4);
    assert_refused(&f, "has_graph", "nothing that finds them");
    begin_copy(&f);
    memcpy(f.bytes + AT_N_CONTACTS, &(uint32_t){UINT32_MAX}, 4);
    assert_refused(&f, "n_contacts", "cut short or damaged");
    close_forger(&f, "pile");
}

// Far away, but a finite number: no origin cell is there.
TEST(a_target_beyond_the_origin_cells_is_refused)
{
    static const float beyond[] = {1e30f, -1e30f, 0x1p32f};
    for (size_t i = 0; i < sizeof beyond / sizeof beyond[0]; ++i)
        for (size_t k = 0; k < 3; ++k) {
            forger f = open_forger(AIMED);
            size_t target = f.right.length - sizeof(uint64_t) - TARGET;
            begin_copy(&f);
            memcpy(f.bytes + target + sizeof(uint32_t) * (1 + k), &beyond[i], sizeof(float));
            assert_refused(&f, "target", "no such body can have a target");
            close_forger(&f, "aimed");
        }
}

// Changes a word at `at`, or two that make a double.
static void refuse_bytes(forger *f, size_t at, const void *bytes, size_t n, const char *said)
{
    begin_copy(f);
    memcpy(f->bytes + at, bytes, n);
    assert_refused(f, "ground", said);
}

TEST(a_ground_that_no_motion_can_have_is_refused)
{
    static const uint32_t none = 0, one = 1, many = 1u << 31, nan_bits = 0x7fc00000;
    forger f = open_forger(GROUND);
    size_t at = f.right.length - sizeof(uint64_t) - HEIGHTS - FIELD;
    refuse_bytes(&f, AT_NX, &none, 4, "grounds: 0 in the file, 1 in the motion");
    refuse_bytes(&f, AT_NX, &one, 4, "cut short or damaged");
    refuse_bytes(&f, AT_NX, &many, 4, "cut short or damaged");
    refuse_bytes(&f, AT_NX + 4, &none, 4, "cut short or damaged");
    refuse_bytes(&f, AT_NX + 4, &many, 4, "cut short or damaged");
    refuse_bytes(&f, AT_NX, (uint32_t[]){1, 6}, 8, "the ground has 1 x 6 heights");
    refuse_bytes(&f, AT_NX, (uint32_t[]){0x80000003, 0x80000002}, 8, "cut short or damaged");
    refuse_bytes(&f, AT_NX + 8, &one, 4, "meshes: 1 in the file, 0 in the motion");
    refuse_bytes(&f, at, &(double){NAN}, 8, "x of the ground's origin is nan");
    refuse_bytes(&f, at + 24, &(double){0}, 8, "the ground's spacing along x is 0");
    refuse_bytes(&f, at + FIELD + 16, &nan_bits, 4, "height 1, 1 of the ground is nan");
    close_forger(&f, "ground");
    f = open_forger(PILE);
    refuse_bytes(&f, AT_NX, (uint32_t[]){3, 2}, 8, "grounds: 1 in the file, 0 in the motion");
    close_forger(&f, "pile");
}

TEST(two_contacts_of_an_object_have_two_colours)
{
    forger f = open_forger(PILE);
    char *colours = f.bytes + place_of(&f, section_of(COLOUR_OF));
    begin_copy(&f);
    for (uint32_t i = 0; i < f.n_contacts; ++i)
        memcpy(colours + 4 * i, &(uint32_t){3}, 4);
    assert_refused(&f, "colours", "another contact of its object has its colour");
    close_forger(&f, "pile");
}

// One word shorter, two, and so on, down to the header; the sum is right each time.
TEST(a_file_that_ends_early_is_refused)
{
    static const kind of[] = {ONLY_CONTACTS, COMMANDED, GROUND};
    for (size_t i = 0; i < sizeof of / sizeof of[0]; ++i) {
        forger f = open_forger(of[i]);
        for (size_t n = f.right.length - 4; n >= HEADER + sizeof(uint64_t); n -= 4) {
            begin_copy(&f);
            f.n = n;
            assert_refused(&f, kind_names[of[i]], "cut short or damaged");
        }
        close_forger(&f, kind_names[of[i]]);
    }
}

// ------------------------------------------------------------ at random

static uint32_t random_word(rng *r, const forger *f, uint32_t before)
{
    static const uint32_t floats[] = {0x7fc00000, 0x7f800000, 0xff800000, 0x7f7fffff, 0xff7fffff,
                                      0x00000001, 0x80000000, 0x3f800000, 0xbf800000, 0x5f000000};
    switch (rng_below(r, 8)) {
    case 0:
        return rng_next(r);
    case 1:
        return before + 1;
    case 2:
        return before - 1;
    case 3:
        return before ^ 1u << rng_below(r, 32);
    case 4:
        return rng_below(r, 2 * f->m->n);
    case 5:
        return rng_below(r, 2 * f->n_contacts + 2);
    case 6:
        return UINT32_MAX - rng_below(r, 3);
    default:
        return floats[rng_below(r, sizeof floats / sizeof floats[0])];
    }
}

// A word of the header behind the magic, of a section, or of what commands left.
static size_t random_place(rng *r, const forger *f)
{
    size_t end = place_of(f, SECTIONS), left = f->right.length - sizeof(uint64_t) - end;
    if (left > 0 && rng_below(r, 2))
        return end + 4 * rng_below(r, (uint32_t)left / 4);
    int section = (int)rng_below(r, SECTIONS + 1) - 1;
    if (section < 0)
        return 16 + 4 * rng_below(r, (HEADER - 16) / 4);
    size_t words = words_of(f, section);
    return words > 0 ? place_of(f, section) + 4 * rng_below(r, (uint32_t)words) : 16;
}

static void change_words(rng *r, forger *f)
{
    for (uint32_t i = 0, n = 1 + rng_below(r, 3); i < n; ++i) {
        char *at = f->bytes + random_place(r, f), *other = f->bytes + random_place(r, f);
        uint32_t word, second;
        memcpy(&word, at, 4);
        memcpy(&second, other, 4);
        bool swap = rng_below(r, 4) == 0;
        uint32_t changed = swap ? second : random_word(r, f, word);
        memcpy(at, &changed, 4);
        if (swap)
            memcpy(other, &word, 4);
    }
}

static void change_length(rng *r, forger *f)
{
    uint32_t by = 4 * (1 + rng_below(r, 12));
    if (rng_below(r, 2) && f->n > by + HEADER) {
        f->n -= by;
    } else {
        memset(f->bytes + f->n, (int)rng_below(r, 256), by);
        f->n += by;
    }
}

static bool are_finite(const duet_state *states, uint32_t n)
{
    for (size_t i = 0; i < n * sizeof *states / sizeof(double); ++i)
        if (!isfinite(((const double *)states)[i]))
            return false;
    return true;
}

// Numbers that grow beyond all bounds are told, by a step or by whoever reads them.
static void step_forged(forger *f)
{
    duet_error err = {0};
    bool ok = true;
    for (int k = 0; ok && k < 3; ++k)
        ok = duet_motion_advance(f->m->motion, &f->m->last, &err);
    ok = ok && duet_motion_get_states(f->m->motion, f->m->states, &err);
    if (ok)
        assert_true(are_finite(f->m->states, f->m->n));
    else
        assert_true(err.text[0] && !strchr(err.text, '\n'));
    load_right(f);
}

static void forge(rng *r, forger *f, uint32_t *n_loaded)
{
    duet_error err = {0};
    begin_copy(f);
    change_words(r, f);
    if (rng_below(r, 50) == 0)
        change_length(r, f);
    write_forged(f);
    if (duet_motion_load(f->m->motion, path, &err)) {
        ++*n_loaded;
        step_forged(f);
        return;
    }
    uint64_t hash = 0;
    assert_true(err.status == DUET_STATUS_BAD_INPUT && !strchr(err.text, '\n'));
    assert_says(err.text, path);
    err = (duet_error){0};
    must(duet_motion_get_hash(f->m->motion, &hash, ERR));
    assert_true(hash == f->hash);
}

// Forgeries of all kinds together.
static uint32_t count_forged(void)
{
    const char *number = test_argument(1);
    return test_takes_all() ? 114750 : number ? (uint32_t)strtoul(number, NULL, 10) : 2700;
}

TEST(forged_files_are_refused_or_step)
{
    const uint32_t n_forged = count_forged();
    rng r = rng_seed(test_seed());
    for (int of = 0; of < KINDS; ++of) {
        forger f = open_forger((kind)of);
        uint32_t n_loaded = 0;
        for (uint32_t i = 0; i < n_forged / KINDS; ++i)
            forge(&r, &f, &n_loaded);
        print_message("%s: %u forged, %u loaded\n", kind_names[of], n_forged / KINDS, n_loaded);
        close_forger(&f, kind_names[of]);
    }
}
