// SPDX-License-Identifier: MIT
// What a kernel's bound of error allows a compiler to be told.
#include "support/test.h"

#include "gen/gen.h"
#include "runtime/device_pair.h"
#include "runtime/program.h"

static duet_device_pair *devices;
static gen *kernels;

static int open_devices(void **state)
{
    (void)state;
    duet_error err = {0};
    duet_device_pair_def def = duet_default_device_pair_def();
    devices = duet_device_pair_open(&def, &err);
    assert_ok(devices, err);
    kernels = gen_open(NULL, &err);
    assert_ok(kernels, err);
    return 0;
}

static int close_devices(void **state)
{
    (void)state;
    gen_close(kernels);
    duet_device_pair_close(devices);
    return 0;
}

static bool builds_with(const char *name, const char *options)
{
    duet_error err = {0};
    gen_variant variant;
    const device *d = &devices->devices[1];
    gen_limits limits = {.max_group = d->info.max_group,
                         .local_bytes = d->info.local_bytes,
                         .cpu = d->info.kind == DUET_KIND_CPU};
    assert_ok(gen_make(kernels, name, NULL, 0, &limits, &variant, &err), err);
    const char *text = variant.text;
    cl_program program = clCreateProgramWithSource(d->context, 1, &text, NULL, NULL);
    assert_non_null(program);
    cl_int code = clBuildProgram(program, 1, &d->id, options, NULL, NULL);
    clReleaseProgram(program);
    gen_variant_free(&variant);
    return code == CL_SUCCESS;
}

static void relaxed_arithmetic_is_refused(void **state)
{
    (void)state;
    assert_true(builds_with("narrow", "-cl-std=CL1.2"));
    assert_false(builds_with("narrow", "-cl-std=CL1.2 -cl-fast-relaxed-math"));
    assert_false(builds_with("bounds", "-cl-std=CL1.2 -cl-fast-relaxed-math"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(relaxed_arithmetic_is_refused),
    };
    return cmocka_run_group_tests(tests, open_devices, close_devices);
}
