// SPDX-License-Identifier: MIT
// Energy is read from a file, from packages of CPUs and from GPUs.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "base/clock.h"
#include "base/energy_meter.h"

#include <sys/stat.h>

#define FILE_NAME "test_energy_meter.txt"
#define FOLDER "test_energy_meter"

static energy_meter *open_meter(const energy_meter_def *def)
{
    return must(energy_meter_open(def, ERR));
}

static bool is_near(double a, double b)
{
    return fabs(a - b) < 1e-9;
}

TEST(a_file_says_joules_or_watts)
{
    const energy_meter_def def = {.file = FILE_NAME};
    test_write_file(FILE_NAME, "12.5 J\n");
    energy_meter *m = open_meter(&def);
    assert_true(is_near(energy_meter_read(m), 12.5));
    test_write_file(FILE_NAME, "13 J\n");
    assert_true(is_near(energy_meter_read(m), 13));
    energy_meter_close(m);
    test_write_file(FILE_NAME, "40 W\n");
    uint64_t begun = clock_steady_ns();
    m = open_meter(&def);
    double first = energy_meter_read(m);
    clock_sleep_ns(20000000);
    double by = energy_meter_read(m) - first;
    assert_true(by >= 0.8 && by <= 40e-9 * (double)(clock_steady_ns() - begun));
    assert_int_equal(energy_meter_window_ns(m), 0);
    energy_meter_close(m);
}

static void set_package(int i, const char *count)
{
    char path[100];
    mkdir(FOLDER, 0700);
    snprintf(path, sizeof path, FOLDER "/intel-rapl:%d", i);
    mkdir(path, 0700);
    snprintf(path, sizeof path, FOLDER "/intel-rapl:%d/energy_uj", i);
    test_write_file(path, count);
    snprintf(path, sizeof path, FOLDER "/intel-rapl:%d/max_energy_range_uj", i);
    test_write_file(path, "10000000\n");
}

// The first begins again behind its range.
TEST(packages_are_added_and_begin_again)
{
    const energy_meter_def def = {.powercap = FOLDER, .nvml = "none.so"};
    set_package(0, "9000000\n");
    set_package(1, "500000\n");
    energy_meter *m = open_meter(&def);
    assert_string_equal(energy_meter_describe(m), "package-0, package-1");
    assert_true(is_near(energy_meter_read(m), 0));
    set_package(0, "9900000\n");
    set_package(1, "700000\n");
    assert_true(is_near(energy_meter_read(m), 0.9 + 0.2));
    set_package(0, "300000\n");
    assert_true(is_near(energy_meter_read(m), 1.3 + 0.2));
    assert_true(energy_meter_window_ns(m) > 0);
    energy_meter_close(m);
}

// The file that the build puts beside this program.
TEST(gpus_of_the_pair_are_added)
{
    energy_meter_def def = {.powercap = "none", .nvml = DUET_FAKE_NVML, .gpus = {"Slow", NULL}};
    energy_meter *m = open_meter(&def);
    assert_string_equal(energy_meter_describe(m), "Slow");
    double before = energy_meter_read(m);
    assert_true(is_near(energy_meter_read(m) - before, 0.01));
    energy_meter_close(m);
    def.gpus[1] = "Fast";
    m = open_meter(&def);
    before = energy_meter_read(m);
    assert_true(is_near(energy_meter_read(m) - before, 1.01));
    energy_meter_close(m);
}

TEST(what_cannot_be_read_is_said_in_one_line)
{
    static const struct {
        energy_meter_def def;
        const char *says;
    } cases[] = {
        {{.file = "none.txt"}, "none.txt: expected a number, then J"},
        {{.file = FILE_NAME}, FILE_NAME ": expected a number, then J"},
        {{.powercap = "none", .nvml = "none.so"},
         "nothing can be read: none/intel-rapl:0/energy_uj: No such file or directory"},
        {{.powercap = "none", .nvml = "none.so", .gpus = {"Fast", NULL}},
         "; none.so: it cannot be loaded"},
        {{.powercap = "none", .nvml = DUET_FAKE_NVML, .gpus = {"Other", NULL}},
         "no GPU of the device pair counts its energy"},
    };
    test_write_file(FILE_NAME, "much\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        must_fail(energy_meter_open(&cases[i].def, ERR), DUET_STATUS_NOT_FOUND, cases[i].says);
}
