// SPDX-License-Identifier: MIT
// Ten thousand steps with a skin.
#include "support/skin.h"
#include "support/test.h"

static void a_skin_misses_no_contact_in_ten_thousand_steps(void **state)
{
    (void)state;
    skin_run(10000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_skin_misses_no_contact_in_ten_thousand_steps),
    };
    return cmocka_run_group_tests(tests, mover_open_pair, mover_close_pair);
}
