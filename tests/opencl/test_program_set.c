// SPDX-License-Identifier: MIT
// The states of a kernel: asked for, spared and built.
#include "support/kernel_args.h"
#include "support/kernels.h"
#include "support/test.h"

#include "runtime/opencl/buffer.h"
#include "runtime/opencl/program.h"

#define FOLDER "test_program_set.kernels"

static device opened;
static uint32_t compiled;

static void count_compiled(void *context, const duet_device_info *d, const char *name, uint32_t k,
                           uint32_t n)
{
    (void)context, (void)d, (void)k, (void)n;
    compiled += name != NULL;
}

// A set with the kernels of the folder; NULL: those that the library carries.
static program_set *open_set(const char *folder)
{
    const program_builder builder = {.on_compile = count_compiled};
    compiled = 0;
    must(device_open(&opened, "pocl:0", ERR));
    gen *g = kept(gen_open(folder, ERR));
    return must(program_set_open(&opened, g, &builder, ERR));
}

static void close_set(program_set *set)
{
    program_set_close(set);
    device_close(&opened);
}

static kernel *ask_cell_start(program_set *set)
{
    return must(
        program_set_kernel(set, "cell_start", "cell_start", NULL, 0, cell_start_bindings, ERR));
}

static kernel *ask_clear(program_set *set)
{
    return must(program_set_kernel(set, "clear", "clear", NULL, 0, clear_bindings, ERR));
}

static void assert_state(const kernel *k, kernel_state state)
{
    assert_int_equal(k->state, state);
    assert_int_equal(k->cl != NULL, state == KERNEL_BUILT);
}

TEST(a_spared_kernel_is_built_once_it_is_asked_for_again)
{
    program_set *set = open_set(NULL);
    kernel *k = ask_cell_start(set);
    assert_state(k, KERNEL_ASKED);
    kernel_spare(k);
    must(program_set_build(set, ERR));
    assert_state(k, KERNEL_SPARED);
    assert_int_equal(compiled, 0);
    assert_ptr_equal(ask_cell_start(set), k);
    must(program_set_build(set, ERR));
    assert_state(k, KERNEL_BUILT);
    assert_int_equal(compiled, 1);
    kernel_spare(k);
    assert_state(k, KERNEL_BUILT);
    close_set(set);
}

// Neither what is built nor what was spared before is lost, and nothing is built of what failed.
TEST(a_failed_build_spares_what_is_not_built)
{
    test_kernels_write(FOLDER, "grid/cell_start.cl", "", "this is no OpenCL C;\n");
    program_set *set = open_set(FOLDER);
    kernel *built = ask_clear(set);
    must(program_set_build(set, ERR));
    cl_kernel cl = built->cl;
    kernel *broken = ask_cell_start(set);
    must_fail(program_set_build(set, ERR), DUET_STATUS_BUILD_FAILED, "cell_start");
    assert_state(broken, KERNEL_SPARED);
    assert_state(built, KERNEL_BUILT);
    assert_ptr_equal(built->cl, cl);
    must(program_set_build(set, ERR));
    assert_ptr_equal(ask_cell_start(set), broken);
    must_fail(program_set_build(set, ERR), DUET_STATUS_BUILD_FAILED, "cell_start");
    assert_state(built, KERNEL_BUILT);
    close_set(set);
}

TEST_EACH(NULL, test_leaves_no_object)
