// SPDX-License-Identifier: MIT
// Kernels of the user's on two devices: what a task file may say, and what launches find.
#define _POSIX_C_SOURCE 200809L
#include "support/task_files.h"
#include "support/test.h"

#include "runtime/opencl/device_pair.h"
#include "runtime/task/task_launch.h"

// ---------------------------------------------------------------- files

static void write_kernel(const char *name, const char *args, const char *body)
{
    task_files_write(".", name, args, body);
}

static task *load(const char *lua)
{
    test_write_file("t.task.lua", lua);
    return kept(task_load("t.task.lua", NULL, 0, ERR));
}

static duet_device_pair *open_halves(void)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.kernel_dir = ".";
    return kept(duet_device_pair_create(&def, ERR));
}

static duet_plan plan_at(double share, const char *variant)
{
    duet_plan plan = {.share = (uint32_t)(share * DUET_SHARE_ONE), .mode = DUET_MODE_OWN};
    snprintf(plan.variant_a, sizeof plan.variant_a, "%s", variant);
    snprintf(plan.variant_b, sizeof plan.variant_b, "%s", variant);
    return plan;
}

// Launches the task at shares from one end to the other, with two variants, and unless it has a sum
// on parts of its items. copies: on devices that seem to have memory of their own.
static void launch_at_shares(const char *lua, const char *kernel_name, bool copies)
{
    static const double shares[] = {0, 1e-4, 0.1, 0.37, 0.5, 0.99, 1};
    char set[64];
    task *t = load(lua);
    duet_device_pair *pair = open_halves();
    for (int side = 0; copies && side < 2; ++side)
        pair->devices[side].info.host_memory = false;
    task_launcher *l = must(task_launcher_open(t, pair, ERR));
    snprintf(set, sizeof set, "auto %s.WG=16", kernel_name);
    for (size_t i = 0; i < sizeof shares / sizeof *shares; ++i)
        for (int k = 0; k < 2; ++k) {
            task_result r;
            duet_plan plan = plan_at(shares[i], k ? set : "auto");
            for (uint32_t part = DUET_SHARE_ONE; part > 0; part /= 7) {
                if (part < DUET_SHARE_ONE && task_launcher_estimate_ms(l) == 0)
                    break;
                task_launcher_set_part(l, part);
                must(task_launch(l, &plan, &r, ERR));
                assert_true(r.total_ms > 0 && r.n_stages > 0);
            }
        }
    task_launcher_close(l);
}

static void launch_everywhere(const char *lua, const char *kernel_name)
{
    launch_at_shares(lua, kernel_name, false);
    launch_at_shares(lua, kernel_name, true);
}

static void expect_open_fails(const char *lua, duet_status status, const char *says)
{
    task *t = load(lua);
    duet_device_pair *pair = open_halves();
    task_launcher *l = NULL;
    duet_plan plan = plan_at(0.5, "auto");
    task_result r;
    must_fail((l = task_launcher_open(t, pair, ERR)) && task_launch(l, &plan, &r, ERR), status,
              says);
    task_launcher_close(l);
}

// ---------------------------------------------------------------- launches

TEST(a_slice_is_read_and_written_by_items)
{
    write_kernel("saxpy", "float a\nconst float *x\nfloat *y\n", "y[i] = a * x[i] + y[i];");
    launch_everywhere(
        "local n = 1003 return { kernel = 'saxpy', items = n, tolerance = 1e-6, args = { a = 2.5, "
        "x = { 'float', n, init = 'random', min = -1, access = 'slice' }, y = { 'float', n, init = "
        "function(i) return i % 7 end, access = 'in out slice' } }, reference = function(v) for i "
        "= 0, n - 1 do v.y[i] = v.a * v.x[i] + i % 7 end end }",
        "saxpy");
}

TEST(a_halo_is_there_beside_the_slice)
{
    write_kernel("blur", "const int *x\nint *y\nulong n\n",
                 "y[i] = x[i] + (i > 0 ? x[i - 1] : 0) + (i + 1 < n ? x[i + 1] : 0);");
    launch_everywhere(
        "local n = 517 return { kernel = 'blur', items = n, args = { n = n, x = { 'int', n, init = "
        "'index', access = 'slice', halo = 1 }, y = { 'int', n, access = 'out slice' } }, "
        "reference = function(v) for i = 1, n - 2 do v.y[i] = 3 * i end v.y[0] = 1 v.y[n - 1] = 2 "
        "* n - 3 end }",
        "blur");
}

TEST(sums_of_both_devices_are_added)
{
    write_kernel("count", "const uchar *x\nuint *bins\n", "atomic_inc(&bins[x[i]]);");
    launch_everywhere(
        "local n = 4001 return { kernel = 'count', items = n, args = { x = { 'uchar', n, init = "
        "function(i) return i * i % 251 end, access = 'slice' }, bins = { 'uint', 256, access = "
        "'sum' } }, reference = function(v) for i = 0, n - 1 do local b = i * i % 251 v.bins[b] = "
        "v.bins[b] + 1 end end }",
        "count");
}

// A has items 0 to 499, and B 500 to 999.
TEST(a_part_of_the_items_is_done_and_checked)
{
    static const struct {
        int item;
        double part;
        bool is_found;
    } cases[] = {{124, 0.25, true}, {125, 0.25, false}, {499, 0.25, false}, {500, 0.25, true},
                 {624, 0.25, true}, {625, 0.25, false}, {999, 0.25, false}, {999, 1, true},
                 {1, 0.001, false}, {500, 0.001, true}};
    write_kernel("part", "int wrong\nint *y\n", "y[i] = i + ((long)i == wrong);");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char lua[300];
        snprintf(lua, sizeof lua,
                 "local n = 1000 return { kernel = 'part', items = n, args = { wrong = %d, y = { "
                 "'int', n, access = 'out slice' } }, reference = function(v) for i = 0, n - 1 do "
                 "v.y[i] = i end end }",
                 cases[i].item);
        task *t = load(lua);
        duet_device_pair *pair = open_halves();
        task_launcher *l = must(task_launcher_open(t, pair, ERR));
        duet_plan plan = plan_at(duet_device_pair_is_one(pair) ? 0 : 0.5, "auto");
        duet_error err = {0};
        task_result r;
        bool found = cases[i].is_found;
        if (plan.share == 0 && cases[i].part < 1)
            found = cases[i].item < 1000 * cases[i].part;
        task_launcher_set_part(l, (uint32_t)(cases[i].part * DUET_SHARE_ONE));
        assert_int_equal(task_launch(l, &plan, &r, &err), !found);
        assert_int_equal(err.status, found ? DUET_STATUS_WRONG_RESULT : DUET_STATUS_OK);
        task_launcher_close(l);
    }
}

// An item of three elements, each a vector, with several work-units.
TEST(an_item_may_be_a_row_with_units_of_its_own)
{
    write_kernel("rows", "const float4 *x\nfloat4 *y\n", "");
    test_write_file("rows.cl", "__kernel void rows(ROWS_ARGS)\n{\n    ulong u = first * 3 + "
                               "get_global_id(0);\n    if (u < last * 3)\n        y[u] = x[u] * "
                               "2.0f;\n}\n");
    launch_everywhere("return { kernel = 'rows', items = 41, work = 3, args = { x = { 'float4', "
                      "123, init = 'index', access = 'slice', send = 'once' }, y = { 'float4', "
                      "123, access = 'out slice' } }, reference = function(v) for i = 0, #v.y - 1 "
                      "do v.y[i] = 2 * i end end }",
                      "rows");
}

// ---------------------------------------------------------------- grids

static void write_grid(const char *name, const char *launch, const char *args, const char *text)
{
    char path[80], card[800];
    snprintf(path, sizeof path, "%s.lua", name);
    snprintf(card, sizeof card,
             "return { about = 'test', params = { { 'WG', values = { 1, 4, 16 }, about = 'group' } "
             "}, args = { %s = [[\nulong first\nulong last\n%s]] }, launch = function(p) return "
             "%s end }",
             name, args, launch);
    test_write_file(path, card);
    snprintf(path, sizeof path, "%s.cl", name);
    test_write_file(path, text);
}

// 37 columns to an item, in groups of two items, which read each other's numbers in local memory.
TEST(a_grid_of_two_dimensions_is_shared_along_the_second)
{
    write_grid("plane", "{ group = { p.WG, 2 }, per_item = 1 }", "uint width\nint *y\n",
               "__kernel void plane(PLANE_ARGS)\n{\n"
               "    __local int of_group[2][16];\n"
               "    uint column = get_global_id(0), k = get_local_id(0), m = get_local_id(1);\n"
               "    ulong item = first + get_global_id(1);\n"
               "    of_group[m][k] = (int)(item * 1000 + column);\n"
               "    barrier(CLK_LOCAL_MEM_FENCE);\n"
               "    bool ids = get_group_id(1) * get_local_size(1) + m == get_global_id(1) &&\n"
               "               get_global_size(1) == get_num_groups(1) * get_local_size(1) &&\n"
               "               get_global_id(2) == 0 && get_global_size(0) >= width &&\n"
               "               get_global_size(1) >= last - first;\n"
               "    if (column < width && item < last)\n"
               "        y[item * width + column] = ids ? of_group[m][k] + of_group[1 - m][k] -\n"
               "                                             of_group[1 - m][k] : -1;\n}\n");
    launch_everywhere("return { kernel = 'plane', items = 101, work = 37, args = { width = 37, y = "
                      "{ 'int', 101 * 37, access = 'out slice' } }, reference = function(v) for i "
                      "= 0, #v.y - 1 do v.y[i] = i // 37 * 1000 + i % 37 end end }",
                      "plane");
}

// Planes of 13 columns and 7 rows; a work-item does two columns.
TEST(a_grid_of_three_dimensions_is_shared_along_the_third)
{
    write_grid("space", "{ group = { p.WG, 2, 1 }, per_item = { 2, 1, 1 } }",
               "const int *x\nint *y\n",
               "__kernel void space(SPACE_ARGS)\n{\n"
               "    uint row = get_global_id(1);\n"
               "    ulong item = first + get_global_id(2);\n"
               "    for (uint c = 2 * get_global_id(0); c < 2 * get_global_id(0) + 2; ++c)\n"
               "        if (c < 13 && row < 7 && item < last)\n"
               "            y[(item * 7 + row) * 13 + c] = x[(item * 7 + row) * 13 + c] + (int)c;\n"
               "}\n");
    launch_everywhere("return { kernel = 'space', items = 19, work = { 13, 7 }, args = { x = { "
                      "'int', 19 * 91, init = 'index', access = 'slice' }, y = { 'int', 19 * 91, "
                      "access = 'out slice' } }, reference = function(v) for i = 0, #v.y - 1 do "
                      "v.y[i] = i + i % 13 end end }",
                      "space");
}

// The same work by a kernel of one dimension.
TEST(a_grid_may_have_a_reference_without_one)
{
    static const char text[] = "__kernel void %s(%s_ARGS)\n{\n    ulong u = first * 5 + %s;\n    "
                               "if (%s u < last * 5)\n        y[u] = (int)u;\n}\n";
    char lined[400];
    write_kernel("line", "int *y\n", "");
    snprintf(lined, sizeof lined, text, "line", "LINE", "get_global_id(0)", "");
    test_write_file("line.cl", lined);
    snprintf(lined, sizeof lined, text, "grid", "GRID", "get_global_id(1) * 5 + get_global_id(0)",
             "get_global_id(0) < 5 &&");
    write_grid("grid", "{ group = { p.WG, 4 }, per_item = 1 }", "int *y\n", lined);
    launch_everywhere("return { kernel = 'grid', items = 41, work = 5, reference = 'line', args = "
                      "{ y = { 'int', 205, access = 'out slice' } } }",
                      "grid");
}

TEST(a_launch_that_is_no_grid_is_refused)
{
    static const refusal cases[] = {
        {"{ group = {}, per_item = 1 }", "launch gives a list of 0 for group; expected 1 to 3"},
        {"{ group = { 1, 1, 1, 1 }, per_item = 1 }", "launch gives a list of 4 for group"},
        {"{ group = { 1, 0 }, per_item = 1 }", "launch gives no group of 1 or more"},
        {"{ group = { 65536, 65536 }, per_item = 1 }", "a group of 4294967296 is above"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        write_grid("bad", cases[i].given, "int *y\n", "__kernel void bad(BAD_ARGS)\n{\n}\n");
        expect_open_fails("return { kernel = 'bad', items = 4, args = { y = { 'int', 4, access = "
                          "'out slice' } } }",
                          i < 3 ? DUET_STATUS_BUILD_FAILED : DUET_STATUS_BAD_ARGUMENT,
                          cases[i].says);
    }
}

TEST(another_kernel_or_a_file_says_what_is_right)
{
    write_kernel("twice", "const float *x\nfloat *y\n", "y[i] = x[i] + x[i];");
    write_kernel("naive", "const float *x\nfloat *y\n", "y[i] = 2.0f * x[i];");
    float right[100];
    for (int i = 0; i < 100; ++i)
        right[i] = (float)(2 * i);
    FILE *file = fopen("right.bin", "wb");
    assert_int_equal(fwrite(right, sizeof *right, 100, file), 100);
    fclose(file);
    static const char *const references[] = {"'naive'", "'right.bin'", "nil"};
    for (size_t i = 0; i < 3; ++i) {
        char lua[400];
        snprintf(lua, sizeof lua,
                 "return { kernel = 'twice', items = 100, args = { x = { 'float', 100, init = "
                 "'index', access = 'slice' }, y = { 'float', 100, access = 'out slice' } }, "
                 "reference = %s }",
                 references[i]);
        launch_everywhere(lua, "twice");
    }
}

// ---------------------------------------------------------------- wrong kernels

#define TEN                                                                              \
    "items = 10, args = { x = { 'float', 10, init = 'index', access = 'slice' }, y = { " \
    "'float', 10, access = 'out slice' } }"

TEST(a_wrong_answer_names_the_item_both_values_and_the_bound)
{
    write_kernel("wrong", "const float *x\nfloat *y\n", "y[i] = i == 7 ? 3 : 2 * x[i];");
    expect_open_fails("return { kernel = 'wrong', tolerance = 0.001, reference = function(v) for i "
                      "= 0, 9 do v.y[i] = 2 * i end end, " TEN "}",
                      DUET_STATUS_WRONG_RESULT,
                      "task t: item 7: y[7] is 3; expected 14 within 0.014");
}

// A number as it may come up: what it is about, infinite, none, or of the other sign.
static float draw_float(rng *r)
{
    static const float rare[] = {0.0f, -0.0f, INFINITY, -INFINITY, NAN, 1.0f, -1.0f};
    uint32_t which = rng_below(r, 40);
    return which < sizeof rare / sizeof *rare ? rare[which] : (float)(8 * rng_unit(r) - 4);
}

// Most are right, some just within the bound or beyond it. Truth is a look at one number after the
// other in long double, and arrays are longer than what is looked at in one go.
TEST(the_first_wrong_number_of_many_is_found)
{
    enum { N = 3000 };
    rng r = rng_seed(test_seed());
    task t = {.name = "t", .tolerance = 0.25};
    for (int round = 0; round < 200; ++round) {
        task_arg arg = {.name = "y", .kind = TASK_ARG_ARRAY, .lanes = 1, .per_item = 1};
        own(task_values) found;
        must(task_values_make(&found, TASK_FLOAT, N, ERR));
        must(task_values_make(&arg.expected, TASK_FLOAT, N, ERR));
        float *is = found.bytes, *should = arg.expected.bytes;
        uint32_t wrong = N, chance = 1u << rng_below(&r, 14);
        for (uint32_t i = 0; i < N; ++i) {
            should[i] = draw_float(&r);
            is[i] = rng_below(&r, chance) ? should[i] : (float)(should[i] + 0.6 * rng_unit(&r));
            is[i] = rng_below(&r, chance) ? is[i] : draw_float(&r);
            long double bound = 0.25L * fmaxl(1, fabsl((long double)should[i]));
            bool right = is[i] == should[i] || (isnan(is[i]) && isnan(should[i])) ||
                         (isfinite(is[i]) && isfinite(should[i]) &&
                          fabsl((long double)is[i] - (long double)should[i]) <= bound);
            wrong = right || wrong < N ? wrong : i;
        }
        char says[32];
        snprintf(says, sizeof says, "item %u: y[%u] is ", wrong, wrong);
        if (wrong < N)
            must_fail(task_check_bytes(&t, &arg, &found, 0, found.size, ERR),
                      DUET_STATUS_WRONG_RESULT, says);
        else
            must(task_check_bytes(&t, &arg, &found, 0, found.size, ERR));
        task_values_free(&arg.expected);
    }
}

TEST(a_write_outside_the_items_is_found)
{
    static const refusal cases[] = {
        {"y[i] = x[i]; if (i == last - 1) y[last] = 1;", "the kernel writes y["},
        {"y[(long)i - 1] = x[i];", "the kernel writes y["},
        {"y[9 - i] = x[i];", "the kernel writes y["},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        write_kernel("stray", "const float *x\nfloat *y\n", cases[i].given);
        bool one = strcmp(getenv("DUET_PAIR") ? getenv("DUET_PAIR") : "", "cpu") == 0;
        if (!one || i < 2)
            expect_open_fails("return { kernel = 'stray', " TEN "}", DUET_STATUS_WRONG_RESULT,
                              cases[i].says);
    }
}

TEST(arguments_must_be_the_cards)
{
    static const refusal cases[] = {
        {"y = { 'float', 10, access = 'out slice' }", "args has no 'x', which the card of k has"},
        {"x = { 'double', 10 }, y = { 'float', 10, access = 'out slice' }",
         "args.x is an array of double; the card of k has 'float *'"},
        {"x = 1, y = { 'float', 10, access = 'out slice' }", "args.x is a number; the card"},
        {"x = { 'float', 10, access = 'in out slice' }, y = { 'float', 10, access = 'out slice' }",
         "args.x: access is in out slice, but the card of k says that it is const"},
        {"x = { 'float', 10 }, y = { 'float', 10 }, z = { 'float', 10, access = 'sum' }",
         "args.y: access is all, but the card of k says that it is written"},
        {"x = { 'float', 10 }, y = { 'float', 10, access = 'out slice' }, z = 1",
         "args.z: the card of k has no such argument"},
    };
    write_kernel("k", "const float *x\nfloat *y\n", "y[i] = x[i];");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char lua[400];
        snprintf(lua, sizeof lua, "return { kernel = 'k', items = 10, args = { %s } }",
                 cases[i].given);
        expect_open_fails(lua, DUET_STATUS_BAD_INPUT, cases[i].says);
    }
}

TEST(numbers_must_fit_the_cards_types)
{
    write_kernel("k", "uint m\nconst float *x\nfloat *y\n", "y[i] = x[i] + m;");
    static const char *const wrong[] = {"-1", "4294967296", "0.5"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        char lua[400];
        snprintf(lua, sizeof lua,
                 "return { kernel = 'k', items = 10, args = { m = %s, x = { 'float', 10 }, y = { "
                 "'float', 10, access = 'out slice' } } }",
                 wrong[i]);
        expect_open_fails(lua, DUET_STATUS_BAD_INPUT, "; the card of k has 'uint'");
    }
}

// ---------------------------------------------------------------- files that are wrong

TEST(a_bad_file_is_one_line_that_names_file_and_field)
{
    static const refusal cases[] = {
        {"return 5", "t.task.lua: a task file returns a table, not number"},
        {"x x", "t.task.lua:1: syntax error"},
        {"return {}", "kernel is missing"},
        {"return { kernel = 'k', args = {} }", "items is missing"},
        {"return { kernel = 'k', items = 10 }", "args is missing"},
        {"return { kernel = 'k',\n entry = '', items = 10 }",
         "t.task.lua:2: entry is ''; expected the name of a function of the kernel"},
        {"return { kernel = 'k\\0b', items = 10 }",
         "t.task.lua:1: kernel is 'k\\x00b'; expected a string without NUL"},
        {"return { kernel = 'k', items = 10, key = { a = 'b\\0c' } }",
         "key: 'a' is 'b\\x00c'; expected names and values of letters"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float\\0', 1 } } }",
         "args.x: the type is float\\x00; expected char"},
        {"return { kernel = 'k', items = 10, args = { x = { ('f'):rep(5000), 1 } } }",
         "f...; expected char, short"},
        {"return { kernel = 'k', items = 0, args = {} }",
         "t.task.lua:1: items is 0; expected a whole number from 1"},
        {"return { kernel = 'k', items = 10, foo = 1 }", "a task has no field 'foo'"},
        {"return { kernel = 'k', items = 2^30, work = 2^30 }", "work is 1073741824 for each of"},
        {"return { kernel = 'k', items = 2^30, work = { 2^20, 2^20 } }", "for each of"},
        {"return { kernel = 'k', items = 10, work = { 4 } }",
         "work is a list of 1; expected a number,"},
        {"return { kernel = 'k', items = 10, work = { 4, 0 } }",
         "work: [2] is 0; expected a whole number from 1"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float', 10 } } }",
         "args: no array is written"},
        {"return { kernel = 'k', items = 10, args = { 5 } }", "args has a field [1]"},
        {"return { kernel = 'k', items = 10, args = { x = 'a' } }", "args.x is a string"},
        {"return { kernel = 'k', items = 10, args = { x = { 'flot', 1 } } }",
         "args.x: the type is flot"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float', 1.5 } } }",
         "args.x: [2] is 1.5; expected a number of elements, from 1"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float', 11, access = 'slice' } } }",
         "args.x: 11 elements for 10 items"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float', 10, access = 'x' } } }",
         "args.x: access is 'x'; expected one of all, slice"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float', 10, halo = 1 } } }",
         "args.x: a halo with access all; expected slice"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float', 10, size = 1 } } }",
         "args.x has no field 'size'"},
        {"return { kernel = 'k', items = 10, args = { x = { 'int', 10, init = 0.5 } } }",
         "args.x: init gives 0.5 for number 0"},
        {"return { kernel = 'k', items = 10, args = { x = { 'uchar', 10, init = 256 } } }",
         "args.x: init gives 256"},
        {"return { kernel = 'k', items = 10, args = { x = { 'int', 10, init = 'random' } } }",
         "args.x: min is 0, max is nil"},
        {"return { kernel = 'k', items = 9, args = { x = { 'uchar', 9, access = 'sum' } } }",
         "args.x: a sum of uchar"},
        {"return { kernel = 'k', items = 10, args = { x = { 'float', 2^40 } } }", "it may take"},
        {"return { kernel = 'k', tolerance = -1, items = 10 }", "tolerance is -1"},
        {"return { kernel = 'k', key = { a = {} }, items = 10 }", "key: 'a' is 'table: 1'"},
        {"return { kernel = 'k', reference = 7, " TEN "}", "reference is 7; expected a function"},
        {"return { kernel = 'k', reference = 'k', " TEN "}",
         "t.task.lua:1: reference is 'k', the task's own kernel; expected another kernel's name"},
        {"return { kernel = 'k', reference = '../a.bin', " TEN "}", "expected a file beside"},
        {"return { kernel = 'k', reference = 'no.bin', " TEN "}", "no.bin: No such file"},
        {"return { kernel = 'k', reference = 't.task.lua', " TEN "}", "bytes; expected 40, as y"},
        {"return { kernel = 'k', reference = function(v) v.x[0] = 1 end, " TEN "}",
         "x is only read: its access is slice"},
        {"return { kernel = 'k', reference = function(v) v.y[10] = 1 end, " TEN "}",
         "y[10]: expected 0 to 9"},
        {"return { kernel = 'k', reference = function(v) error('no') end, " TEN "}", "1: no"},
        {"return { kernel = 'k', reference = function(v) while true do end end, " TEN "}",
         "it may take"},
        {"local s = 'x' while true do s = s .. s end", "t.task.lua:1: "},
        {"os.exit()", "t.task.lua:1: "},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        test_write_file("t.task.lua", cases[i].given);
        must_fail(task_load("t.task.lua", NULL, 0, ERR), DUET_STATUS_BAD_INPUT, cases[i].says);
        assert_says(ERR->text, "t.task.lua");
    }
}

TEST(parameters_are_set_from_outside)
{
    const duet_setting n = {"n", "25"}, other = {"m", "1"};
    test_write_file("t.task.lua",
                    "local p = parameters{ n = 10, seed = 3 } return { kernel = 'k', items = p.n, "
                    "args = { y = { 'float4', 2 * p.n, access = 'out slice' } }, key = { n = 7 * "
                    "p.n, width = 5, bins = 64 } }");
    task *t = kept(task_load("t.task.lua", &n, 1, ERR));
    char words[TASK_WORDS];
    task_write_words(t, words);
    assert_string_equal(words, "task k bins=64 width=5");
    assert_int_equal(t->items, 25);
    assert_int_equal(t->size, 175);
    assert_int_equal(t->args[0].initial.n, 200);
    assert_int_equal(t->args[0].per_item, 2);
    must_fail(task_load("t.task.lua", &other, 1, ERR), DUET_STATUS_BAD_ARGUMENT,
              "no parameter 'm'; the task has n, seed");
}

// Files of broken text, as a hostile or careless hand leaves them.
TEST(any_damage_of_a_file_is_refused_or_read)
{
    static const char whole[] =
        "local p = parameters{ n = 40 } return { kernel = 'k', items = p.n, work = 2, tolerance = "
        "0.5, key = { n = p.n, b = 2 }, args = { a = 2.0, x = { 'float', p.n, init = 'random', "
        "access = 'slice', halo = 1 }, y = { 'int4', p.n, access = 'out slice' } }, reference = "
        "function(v) for i = 0, #v.y - 1 do v.y[i] = i end end }";
    static const char odd[] = "{}()[]\"'=,.-#%@\n\x1b 0fe9";
    uint64_t seed = test_seed();
    rng r = rng_seed(seed);
    for (int round = 0; round < 400; ++round) {
        char chars[sizeof whole];
        duet_error err = {0};
        memcpy(chars, whole, sizeof whole);
        for (uint32_t i = rng_below(&r, 3) + 1; i > 0; --i)
            chars[rng_below(&r, sizeof whole - 1)] = odd[rng_below(&r, sizeof odd - 1)];
        test_write_file("t.task.lua", chars);
        task *t = task_load("t.task.lua", NULL, 0, &err);
        if (!t && (err.status == DUET_STATUS_OK || !strstr(err.text, "t.task.lua")))
            fail_msg("seed %llu: '%s' gives '%s'", (unsigned long long)seed, chars, err.text);
        task_destroy(t);
    }
}

TEST_EACH(test_enter_folder, NULL)
