// SPDX-License-Identifier: MIT
// The error bounds of the example tasks, attacked: inputs are searched for with which a kernel is
// as wrong as it can be, beside sums and prices in double.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "runtime/task/task.h"

#include <float.h>

static const double u = 0x1p-24;

static char folder[512];
static duet_device_pair *pair;

static void open_pair(void)
{
    snprintf(folder, sizeof folder, "%s/../../examples/tasks", getenv("DUET_TEST_DATA"));
    duet_device_pair_def def = duet_default_device_pair_def();
    def.kernel_dir = folder;
    pair = kept(duet_device_pair_create(&def, ERR));
}

static const char *path_of(const char *name)
{
    static char path[600];
    snprintf(path, sizeof path, "%s/%s.task.lua", folder, name);
    return path;
}

// Device A runs the first variant, and B the second.
static duet_task *open_example(const char *name, const char *n, const char *a, const char *b)
{
    const duet_setting setting = {"n", n};
    duet_task_def def = duet_default_task_def();
    def.pair = pair;
    def.path = path_of(name);
    def.settings = &setting;
    def.n_settings = 1;
    strcpy(def.plan.variant_a, a);
    strcpy(def.plan.variant_b, b);
    return kept(duet_task_create(&def, ERR));
}

static task *load_example(const char *name, const char *n, const char *seed)
{
    const duet_setting settings[] = {{"n", n}, {"seed", seed}};
    return kept(duet_task_file_load(path_of(name), settings, 2, ERR));
}

static const task_arg *arg_of(const task *t, const char *name)
{
    return &t->args[task_find_arg(t, name)];
}

static void run(duet_task *t)
{
    duet_task_result result;
    must(duet_task_run(t, &result, ERR));
}

static const void *get(duet_task *t, const char *name)
{
    return must(duet_task_get_array(t, name, NULL, ERR));
}

// ---------------------------------------------------------------- matmul

enum { M = 256 };

static float a[M * M], b[M * M];

// How an element of c is off, as part of what n roundings may do to the products' sizes.
static double part_of_bound(const float *c, int row, int column)
{
    double sum = 0, sizes = 0;
    for (int k = 0; k < M; ++k) {
        double product = (double)a[row * M + k] * (double)b[k * M + column]; // exact
        sum += product;
        sizes += fabs(product);
    }
    return fabs((double)c[row * M + column] - sum) / (M * u * sizes * (1 + 2 * M * u) + DBL_MIN);
}

static double greatest_part(const float *c)
{
    double part = 0;
    for (int row = 0; row < M; ++row)
        for (int column = 0; column < M; ++column)
            part = fmax(part, part_of_bound(c, row, column));
    return part;
}

// A sum above 1 to which each of the others adds less than half a unit of its last place, in vain.
static void make_stubborn(rng *random)
{
    for (int row = 0; row < M; ++row)
        for (int k = 0; k < M; ++k)
            a[row * M + k] = k == 0 ? 1 + (float)(2 * u * row) : 1;
    for (int k = 0; k < M; ++k)
        for (int column = 0; column < M; ++column)
            b[k * M + column] = k == 0 ? 1 : (float)(u * rng_between(random, 0.9, 0.999));
}

static void make_random(rng *random)
{
    for (int i = 0; i < M * M; ++i) {
        a[i] = (float)rng_between(random, -1, 1);
        b[i] = (float)rng_between(random, -1, 1);
    }
}

// The kernel that the task takes for right, whose sums have as many roundings.
static duet_task *open_plain(void)
{
    static const duet_task_arg_def args[] = {
        {.name = "n", .number = M},
        {.name = "a", .type = "float", .elements = M * M, .access = "slice"},
        {.name = "b", .type = "float", .elements = M * M},
        {.name = "c", .type = "float", .elements = M * M, .access = "out slice"}};
    duet_task_def def = duet_default_task_def();
    def.pair = pair;
    def.kernel = "matmul_plain";
    def.args = args;
    def.n_args = sizeof args / sizeof *args;
    def.items = M;
    def.work = M;
    return kept(duet_task_create(&def, ERR));
}

static double attack_matmul(duet_task *t, void (*make)(rng *), rng *random)
{
    make(random);
    must(duet_task_set_array(t, "a", a, M * M, ERR));
    must(duet_task_set_array(t, "b", b, M * M, ERR));
    run(t);
    return greatest_part(get(t, "c"));
}

static void expect_within_bound(duet_task *t, rng *random)
{
    double stubborn = attack_matmul(t, make_stubborn, random);
    double usual = attack_matmul(t, make_random, random);
    print_message("of the bound: %.3f at worst, %.4f of random numbers\n", stubborn, usual);
    assert_true(stubborn <= 1 && usual <= 1);
    assert_true(stubborn > 0.8); // the search finds what the bound is for
}

TEST(an_element_of_matmul_is_within_n_roundings)
{
    rng random = rng_stream(test_seed(), 0);
    expect_within_bound(open_example("matmul", "256", "auto", "auto matmul.COLUMNS=1"), &random);
    expect_within_bound(open_plain(), &random);
}

// The sum of sizes that the task's tolerance is made from holds for the numbers that it draws.
static void expect_sizes(int n, const char *seed)
{
    char number[16];
    snprintf(number, sizeof number, "%d", n);
    task *t = load_example("matmul", number, seed);
    const float *left = arg_of(t, "a")->initial.bytes, *right = arg_of(t, "b")->initial.bytes;
    double most = 0;
    for (int row = 0; row < n; ++row)
        for (int column = 0; column < n; ++column) {
            double sizes = 0;
            for (int k = 0; k < n; ++k)
                sizes += fabs((double)left[row * n + k] * (double)right[k * n + column]);
            most = fmax(most, sizes);
        }
    double allowed = t->tolerance / (2 * n * u);
    print_message("n = %d: sizes %.1f of %.1f\n", n, most, allowed);
    assert_true(most <= allowed);
    assert_true(allowed < 3 * most || n < 100);
}

TEST(the_sizes_of_matmuls_products_are_as_its_tolerance_says)
{
    expect_sizes(1, "1");
    expect_sizes(7, "1");
    expect_sizes(53, "2");
    expect_sizes(256, "1");
    expect_sizes(256, "3");
    expect_sizes(400, "1");
}

// ---------------------------------------------------------------- Black-Scholes

enum { OPTIONS = 4096, ROUNDS = 24 };

typedef struct option {
    float price, strike, years;
} option;

typedef struct worth {
    double call, put;
} worth;

static double normal(double x)
{
    return 0.5 * erfc(-x * sqrt(0.5));
}

static worth price_option(const option *o)
{
    const double rate = 0.02, volatility = 0.3;
    double spread = volatility * sqrt((double)o->years);
    double d1 = (log((double)o->price / (double)o->strike) +
                 (rate + 0.5 * volatility * volatility) * (double)o->years) /
                spread;
    double d2 = d1 - spread, paid = (double)o->strike * exp(-rate * (double)o->years);
    return (worth){(double)o->price * normal(d1) - paid * normal(d2),
                   paid * normal(-d2) - (double)o->price * normal(-d1)};
}

static float draw(rng *random, float least, float most)
{
    return (float)rng_between(random, (double)least, (double)most);
}

static float within(double value, float least, float most)
{
    return fminf(fmaxf((float)value, least), most);
}

// One near the worst that was found, or anywhere; often at an end of a range.
static option next_option(rng *random, const option *worst, bool near)
{
    option o = {draw(random, 5, 30), draw(random, 1, 100), draw(random, 0.25f, 10)};
    double by = pow(10, rng_between(random, -7, -1));
    if (near)
        o = (option){
            within((double)worst->price * (1 + by * rng_between(random, -1, 1)), 5, 30),
            within((double)worst->strike * (1 + by * rng_between(random, -1, 1)), 1, 100),
            within((double)worst->years * (1 + by * rng_between(random, -1, 1)), 0.25f, 10)};
    switch (rng_below(random, 12)) {
    case 0:
        o.price = 30;
        break;
    case 1:
        o.years = 0.25f;
        break;
    case 2:
        o.years = 10;
        break;
    case 3:
        o.strike = o.price;
        break;
    default:
        break;
    }
    return o;
}

static double part_of(double found, double right)
{
    return fabs(found - right) / fmax(1, fabs(right));
}

static void price_all(duet_task *t, const option *options)
{
    static float price[OPTIONS], strike[OPTIONS], years[OPTIONS];
    for (int i = 0; i < OPTIONS; ++i) {
        price[i] = options[i].price;
        strike[i] = options[i].strike;
        years[i] = options[i].years;
    }
    must(duet_task_set_array(t, "price", price, OPTIONS, ERR));
    must(duet_task_set_array(t, "strike", strike, OPTIONS, ERR));
    must(duet_task_set_array(t, "years", years, OPTIONS, ERR));
    run(t);
}

// The greatest part of a price that the kernel is off, and whose it is.
static double find_worst(duet_task *t, const option *options, option *worst, double most)
{
    price_all(t, options);
    const float *call = get(t, "call"), *put = get(t, "put");
    for (int i = 0; i < OPTIONS; ++i) {
        worth right = price_option(&options[i]);
        double part =
            fmax(part_of((double)call[i], right.call), part_of((double)put[i], right.put));
        if (part > most) {
            most = part;
            *worst = options[i];
        }
    }
    return most;
}

// The reference's own error, of a formula for the normal distribution, is not the kernel's.
static double kernels_share(const task *t)
{
    return t->tolerance - 7.5e-8 * (30 + 100);
}

TEST(a_price_of_black_scholes_is_within_its_roundings)
{
    static option options[OPTIONS];
    rng random = rng_stream(test_seed(), 1);
    option worst = {30, 30, 10};
    double most = 0;
    task *file = load_example("black_scholes", "100", "1");
    double bound = kernels_share(file);
    duet_task *t = open_example("black_scholes", "4096", "auto", "auto black_scholes.PER_ITEM=16");
    for (int round = 0; round < ROUNDS; ++round) {
        for (int i = 0; i < OPTIONS; ++i)
            options[i] = next_option(&random, &worst, round > 0 && i % 2 == 0);
        most = find_worst(t, options, &worst, most);
    }
    print_message("off by %.3g of %.3g, at price %.9g, strike %.9g, years %.9g\n", most, bound,
                  (double)worst.price, (double)worst.strike, (double)worst.years);
    assert_true(most <= bound);
    assert_true(most > bound / 1000); // some are off by much more than the usual rounding
}

TEST_BEGIN(open_pair)
