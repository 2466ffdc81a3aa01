// SPDX-License-Identifier: MIT
// The public calls of all commands: a function for each row of commands.inl, by its form. Before
// including this, define
//   CALL(name)          the function's name
//   SUBJECT             its first parameter
//   GIVE(number, ...)   its body, with the members of a command that it is given
#define CALL_LIST(number, name, type, given)                             \
    bool CALL(name)(SUBJECT, duet_body_list list, duet_error *err)       \
        GIVE(number, .list = list)
#define CALL_ROWS(number, name, type, given)                                                \
    bool CALL(name)(SUBJECT, duet_body_list list, const type *given, duet_error *err)       \
        GIVE(number, .list = list, .rows = given)
#define CALL_FIELDS(number, name, type, given)                                         \
    bool CALL(name)(SUBJECT, duet_body_list list, uint32_t set, const type *given,     \
                    duet_error *err)                                                   \
        GIVE(number, .list = list, .fields = set, .rows = given)
#define CALL_ADD(number, name, type, given)                                                  \
    bool CALL(name)(SUBJECT, const type *given, const duet_body *come, uint32_t n_come,      \
                    uint64_t *named, duet_error *err)                                        \
        GIVE(number, .list.n = n_come, .rows = given, .new_bodies = come, .new_ids = named)
#define CALL_DEF(number, name, type, given)                            \
    bool CALL(name)(SUBJECT, const type *given, duet_error *err)       \
        GIVE(number, .list.n = 1, .rows = given)
#define COMMAND(number, name, form, bodies, effect, type, rows) \
    CALL_##form(number, name, type, rows)
#include "runtime/commands/commands.inl"
