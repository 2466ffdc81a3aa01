// SPDX-License-Identifier: MIT
// However the kernels of a motion are launched, its state is the same bit by
// bit, and nothing is written beside its buffers.
//
// The calls that build kernels are led here, and their launches are drawn. By
// itself the program draws once; --all draws often and takes more scenes.
#include "guard/guard.h"
#include "support/mover.h"
#include "support/test.h"

#include "runtime/opencl/program.h"

enum { STEPS = 6, MOST_OFFERS = 64 };

static bool are_round; // every other body, a sphere

// ---------------------------------------------------------------- launches

static const char *const names[] = {
    "integrate_free_flight", "fat_aabbs",      "contact_graph",  "build_manifolds",
    "match_contacts",        "update_sleep",   "bodies",         "graph_colour",
    "prepare_contacts",      "solve_contacts", "solve_substeps", "integrate_positions",
    "contact_events",        "awake"};

enum { KERNELS = sizeof names / sizeof *names };

typedef struct launch {
    int64_t group, per_item; // 0: the card's own
    int64_t lanes;           // 0: it has none
} launch;

static launch launches[KERNELS];
static gen *generator;

bool __wrap_program_set_kernels(program_set *set, const kernel_request *list, size_t n,
                                const gen_offer *offers, uint32_t n_offers, duet_error *err);
bool __real_program_set_kernels(program_set *set, const kernel_request *list, size_t n,
                                const gen_offer *offers, uint32_t n_offers, duet_error *err);

static launch *launch_of(const char *name)
{
    for (int i = 0; i < KERNELS; ++i)
        if (strcmp(names[i], name) == 0 && launches[i].group > 0)
            return &launches[i];
    return NULL;
}

bool __wrap_program_set_kernels(program_set *set, const kernel_request *list, size_t n,
                                const gen_offer *offers, uint32_t n_offers, duet_error *err)
{
    gen_offer all[MOST_OFFERS + 3 * KERNELS];
    assert_true(n_offers <= MOST_OFFERS);
    if (n_offers > 0)
        memcpy(all, offers, n_offers * sizeof *all);
    for (int i = 0; i < KERNELS; ++i) {
        const launch *l = &launches[i];
        if (l->group == 0)
            continue;
        all[n_offers++] = (gen_offer){names[i], "WG", l->group, GEN_REQUIRED, NULL};
        all[n_offers++] = (gen_offer){names[i], "PER_ITEM", l->per_item, GEN_REQUIRED, NULL};
        if (l->lanes)
            all[n_offers++] = (gen_offer){names[i], "LANES", l->lanes, GEN_REQUIRED, NULL};
    }
    return __real_program_set_kernels(set, list, n, all, n_offers, err);
}

// B holds the state.
static gen_limits limits_of_b(void)
{
    return program_limits(duet_device_pair_get_info(default_pair(), 1));
}

// One of the values of a parameter; 0 where the kernel has it not.
static int64_t draw_value(const char *kernel_name, const char *param, rng *r)
{
    const gen_limits limits = limits_of_b();
    const gen_param *params = NULL;
    uint32_t n = 0;
    must(gen_params(generator, kernel_name, &limits, &params, &n, ERR));
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(params[i].name, param) == 0)
            return params[i].values[rng_below(r, params[i].n_values)];
    return 0;
}

static launch draw_launch(const char *kernel_name, rng *r)
{
    const gen_limits limits = limits_of_b();
    for (int again = 0; again < 100; ++again) {
        duet_error err = {0};
        gen_variant v;
        launch l = {draw_value(kernel_name, "WG", r), draw_value(kernel_name, "PER_ITEM", r),
                    draw_value(kernel_name, "LANES", r)};
        const gen_setting settings[] = {
            {"WG", l.group}, {"PER_ITEM", l.per_item}, {"LANES", l.lanes}};
        if (gen_make(generator, kernel_name, settings, l.lanes ? 3 : 2, &limits, &v, &err)) {
            gen_variant_free(&v);
            return l;
        }
    }
    fail_msg("%s has no valid launch", kernel_name);
    return (launch){0};
}

static void draw_launches(rng *r)
{
    for (int i = 0; i < KERNELS; ++i)
        launches[i] = draw_launch(names[i], r);
    while (launch_of("prepare_contacts")->lanes < launch_of("solve_contacts")->lanes ||
           launch_of("prepare_contacts")->lanes < launch_of("solve_substeps")->lanes)
        *launch_of("prepare_contacts") = draw_launch("prepare_contacts", r); // it fills them
}

static void tell_launches(char *chars, size_t capacity)
{
    size_t n = 0;
    for (int i = 0; i < KERNELS && n < capacity; ++i)
        n += (size_t)snprintf(chars + n, capacity - n, "%s WG=%d PER_ITEM=%d LANES=%d ", names[i],
                              (int)launches[i].group, (int)launches[i].per_item,
                              (int)launches[i].lanes);
}

// ---------------------------------------------------------------- scenes

// Boxes that fall, turn, slide and come to rest between walls; or fly freely.
static mover *make_scene(uint32_t dims, bool pushes)
{
    mover *m = mover_new(dims);
    double apart = pushes ? 1.02 : 6.0;
    if (pushes)
        m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS;
    m->def.gravity[1] = -3.0;
    m->def.drag = 0.3;
    m->def.skin = pushes ? 0.1 : 0.0;
    mover_wall_in(m, pushes ? -0.51 : -10.0, pushes ? 2.7 : 30.0);
    for (int i = 0; i < (dims == 3 ? 27 : 9); ++i) {
        uint32_t id = mover_add_cube(m, apart * (i % 3), apart * (i / 3 % 3), apart * (i / 9), 1);
        duet_body *b = &m->bodies[id];
        for (uint32_t k = 0; k < dims; ++k)
            b->velocity[k] = 0.3f * (float)sin(3 * i + 7 * (int)k);
        b->angular_velocity[dims == 3 ? i % 3 : 2] = 0.5f + 0.1f * (float)i;
        b->friction = pushes ? 0.4f : 0.0f;
        b->group = 1u << i % 2;
        b->mask = 1u << i % 2 | 1u << i % 3;
        if (are_round && i % 2) {
            b->radius = 0.5f;
            memset(m->poses[id].half_extents, 0, sizeof m->poses[id].half_extents);
        }
    }
    m->bodies[8].velocity[0] = -200.0f;
    return m;
}

static uint64_t run(uint32_t dims, bool pushes, const char *what)
{
    mover *m = make_scene(dims, pushes);
    mover_run(m, STEPS);
    uint64_t hash = mover_hash(m);
    mover_free(m);
    guard_assert_whole(what);
    return hash;
}

static void try_launches(uint32_t dims, bool pushes, rng *r)
{
    memset(launches, 0, sizeof launches);
    uint64_t truth = run(dims, pushes, "the cards' launches");
    for (int i = 0; i < (test_takes_all() ? 12 : 1); ++i) {
        char what[700];
        draw_launches(r);
        tell_launches(what, sizeof what);
        if (run(dims, pushes, what) != truth)
            fail_msg("%uD, pushes %d, round %d: another state with %s", dims, pushes, are_round,
                     what);
    }
}

TEST(any_launch_gives_the_same_state_and_writes_nothing_else)
{
    rng r = rng_seed(test_seed());
    generator = kept(gen_open(NULL, ERR));
    are_round = rng_below(&r, 2) > 0;
    try_launches(3, true, &r);
    for (int round = 0; test_takes_all() && round < 4; ++round) {
        are_round = round % 2 > 0;
        try_launches(round / 2 ? 3 : 2, false, &r);
        try_launches(round / 2 ? 3 : 2, true, &r);
    }
}

// Two cubes that meet after a few steps.
static uint64_t run_two(void)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    mover_add_cube(m, 0.0, 0.0, 0.0, 1);
    m->bodies[mover_add_cube(m, 0.0, 6.0, 0.0, 1)].velocity[1] = -20.0f;
    mover_run(m, 30);
    uint64_t hash = mover_hash(m);
    mover_free(m);
    return hash;
}

// Then there are no colours yet, and nothing that says how they lie.
TEST(a_group_solves_bodies_that_touch_nothing_at_first)
{
    memset(launches, 0, sizeof launches);
    uint64_t truth = run_two();
    for (int i = 0; i < KERNELS; ++i)
        if (strcmp(names[i], "solve_substeps") == 0)
            launches[i] = (launch){128, 64, 1};
    assert_int_equal(run_two(), truth);
}

// 100 cubes that lie on a floor and fall asleep, then woken in part by one that falls.
static uint64_t run_sleepers(uint32_t dims)
{
    mover *m = mover_new(dims);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP;
    m->def.gravity[1] = -10.0;
    mover_wall_in(m, -0.5, 300.0);
    for (int i = 0; i < 100; ++i)
        mover_add_cube(m, 2.0 * i + 1.0, 0.0, 1.0, 1);
    mover_add_cube(m, 21.2, 6.0, 1.0, 1);
    mover_run(m, 80);
    uint64_t hash = mover_hash(m);
    mover_free(m);
    return hash;
}

// Two groups of a GPU's size take the bodies, and have work-items without one.
TEST(groups_have_bodies_that_sleep_and_work_items_without_a_body)
{
    static const char *const of_bodies[] = {"bodies", "update_sleep", "awake"};
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        memset(launches, 0, sizeof launches);
        uint64_t truth = run_sleepers(dims);
        for (int i = 0; i < KERNELS; ++i)
            for (int k = 0; k < 3; ++k)
                if (strcmp(names[i], of_bodies[k]) == 0)
                    launches[i] = (launch){64, k == 2 ? 8 : 1, 0};
        assert_int_equal(run_sleepers(dims), truth);
    }
}
