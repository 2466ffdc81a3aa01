// SPDX-License-Identifier: MIT
// Ten thousand steps with a skin.
#include "support/skin.h"
#include "support/test.h"

TEST(a_skin_misses_no_contact_in_ten_thousand_steps)
{
    skin_run(10000);
}
