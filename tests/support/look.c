// SPDX-License-Identifier: MIT
#include "support/look.h"

#include "profiles/sql.h"
#include "support/test.h"

look_fixture look_open(void)
{
    look_fixture f = {.folder = test_folder_make(), .pair = test_pair()};
    f.s = kept(store_open(f.folder.store, STORE_WRITE, ERR));
    return f;
}

void look_tune(look_fixture *f, uint64_t n)
{
    profile_workload workload = test_workload(n);
    test_tune(f->s, &f->pair, &workload);
}

void look_change(look_fixture *f, const char *statements)
{
    must(sql_script(f->s, statements, ERR));
}

profile_found look_up(store *s, const profile_request *request)
{
    profile_found found;
    own(text) why = {0};
    must(profile_lookup(s, request, &found, &why, ERR));
    return found;
}

void look_assert_why(store *s, const profile_request *request, const char *says)
{
    profile_found found;
    own(text) why = {0};
    must(profile_lookup(s, request, &found, &why, ERR));
    if (!strstr(text_chars(&why), says))
        fail_msg("'%s' is not in:\n%s", says, text_chars(&why));
}

profile_found look_in_files(const char *user, const char *system, uint64_t n)
{
    profile_request request = test_usual_request(n);
    profile_found found;
    must(profile_lookup_files(user, system, &request, &found, NULL, ERR));
    return found;
}

profile_found look_for(look_fixture *f, const profile_pair *pair, uint64_t n)
{
    profile_workload workload = test_workload(n);
    profile_request request = test_request(pair, &workload);
    return look_up(f->s, &request);
}
