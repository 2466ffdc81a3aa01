// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "gen/sandbox.h"

static void assert_says(const char *chunk, const char *wanted)
{
    duet_error err = {0};
    script *s = sandbox_open(NULL, &err);
    must(s && script_run(s, "card.lua", chunk, strlen(chunk), 1, ERR));
    assert_string_equal(lua_tostring(script_lua(s), -1), wanted);
    script_close(s);
}

TEST(find_finds_plain_text_as_lua_does)
{
    assert_says("local s, out = 'aXbXc', {}\n"
                "for i, row in ipairs({ { 'X' }, { 'X', 3 }, { 'X', -2 }, { 'X', -9 }, { '' },\n"
                "                       { '', 6 }, { '', 7 }, { 'Xc', 0 }, { 'x' },\n"
                "                       { 'c', math.mininteger }, { 'c', math.maxinteger } }) do\n"
                "  local from, to = s:find(row[1], row[2])\n"
                "  out[i] = tostring(from) .. '-' .. tostring(to)\n"
                "end\n"
                "return table.concat(out, ' ')",
                "2-2 4-4 4-4 2-2 1-0 6-5 nil-nil 4-5 nil-nil 5-5 nil-nil");
    assert_says("return ('1+1'):find('+', 1, true) .. ''", "2");
}

TEST(patterns_are_refused_with_their_line)
{
    static const char *const chunks[] = {"('a'):find('a*')", "('a'):match('a')",
                                         "for x in ('a'):gmatch('a') do end",
                                         "string.gsub('a', 'a', 'b')"};
    for (size_t i = 0; i < sizeof chunks / sizeof *chunks; ++i) {
        script *s = kept(sandbox_open(NULL, ERR));
        must_fail(script_run(s, "card.lua", chunks[i], strlen(chunks[i]), 0, ERR),
                  DUET_STATUS_BAD_INPUT, "card.lua:1: ");
        assert_non_null(strstr(ERR->text, "find(s, text, 1, true) finds plain text"));
    }
}

TEST(sort_keeps_equal_values_in_their_order)
{
    assert_says("local t = {}\n"
                "for i = 1, 1000 do t[i] = { key = i * 7 % 10, place = i } end\n"
                "table.sort(t, function(a, b) return a.key < b.key end)\n"
                "for i = 2, 1000 do\n"
                "  local a, b = t[i - 1], t[i]\n"
                "  assert(a.key < b.key or a.key == b.key and a.place < b.place)\n"
                "end\n"
                "return #t .. ''",
                "1000");
    assert_says("local t = { 3, 1.5, -2, 10, 1 } table.sort(t) return table.concat(t, ' ')",
                "-2 1 1.5 3 10");
    assert_says("local t = { 'b', 'a', 'ab', '' } table.sort(t) return table.concat(t, ' ')",
                " a ab b");
}

TEST(move_moves_as_lua_does)
{
    assert_says("local t = table.move({ 1, 2, 3, 4, 5 }, 1, 4, 2) return table.concat(t, ' ')",
                "1 1 2 3 4");
    assert_says("local t = table.move({ 1, 2, 3, 4, 5 }, 2.0, 5, 1) return table.concat(t, ' ')",
                "2 3 4 5 5");
    assert_says("local t = table.move({ 1, 2 }, 1, 2, 3, { 8, 9 }) return table.concat(t, ' ')",
                "8 9 1 2");
}

TEST(no_address_is_shown)
{
    assert_says("local t, f = {}, function() end\n"
                "return table.concat({ tostring(t), tostring(f), tostring(t), tostring(print),\n"
                "                      ('%s %5s %%s %q'):format({}, 'x', 'y') }, ', ')",
                "table: 1, function: 2, table: 1, nil, table: 3     x %s \"y\"");
    assert_says("return tostring(1) .. tostring(1.5) .. tostring('a') .. tostring(nil) ..\n"
                "       tostring(true)",
                "11.5aniltrue");
}

TEST_MAIN(NULL, NULL)
