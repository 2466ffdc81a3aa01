// SPDX-License-Identifier: MIT
// All public headers are C++ too, and what C begins with {0} begins with {}.
#include <duet/duet.h>
#include <duet/duet_lua.h>
#include <duet/duet_profiles.h>
#include <duet/duet_tune.h>

duet_error empty_error();
duet_profile empty_profile();

duet_error empty_error()
{
    duet_error err = {};
    return err;
}

duet_profile empty_profile()
{
    duet_profile profile = {};
    return profile;
}
