// SPDX-License-Identifier: MIT
// duet lua, as a person calls it, and what a hostile script can do with it.
#define _DEFAULT_SOURCE
#include "support/program.h"
#include "support/test.h"

#include "base/clock.h"
#include "base/text.h"

#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#define SCRIPT "test_lua.script.lua"

static void assert_prints(const char *arguments, const char *output)
{
    program p = program_done(program_run("%s", arguments));
    assert_string_equal(p.out, output);
    assert_string_equal(p.err, "");
}

TEST(text_file_and_arguments_run)
{
    assert_prints("lua -e 'print(1 + 1, duet.version)'", "2\t0.9.0\n");
    test_write_file(SCRIPT,
                    "#!/usr/bin/env duet\nprint(arg[0], #arg, arg[1], require 'duet' == duet)\n");
    assert_prints("lua -e 'x = 1' " SCRIPT " --json b", SCRIPT "\t2\t--json\ttrue\n");
    assert_prints("lua " SCRIPT " '' b", SCRIPT "\t2\t\ttrue\n");
    program_assert_refused(program_run("lua '' b"), 2, "FILE is ''; 'duet lua --help' says");
}

TEST(trust_gives_the_whole_language)
{
    assert_prints("lua --trust -e 'io.write(type(os.time), type(load), type(pcall))'",
                  "functionfunctionfunction");
    assert_prints("lua -e 'print(io, os, load, dofile, pcall, debug, package, coroutine)'",
                  "nil\tnil\tnil\tnil\tnil\tnil\tnil\tnil\n");
}

TEST(what_is_typed_is_run_and_shown)
{
    test_write_file(SCRIPT, "x = { 3, 4, name = 'a b' }\n"
                            "x\n"
                            "function twice(n)\n"
                            "  return 2 * n\n"
                            "end\n"
                            "twice(\n"
                            "  21), 'text'\n"
                            "40 +\n"
                            "2\n"
                            "{ { n = 1, s = 'a' }, { n = 100, s = 'b' } }\n");
    assert_prints("lua -i <" SCRIPT,
                  "{ 3, 4, name = \"a b\" }\n42\ttext\n42\nn    s\n  1  a\n100  b\n");
}

TEST(what_is_shown_says_what_it_is)
{
    test_write_file(
        SCRIPT, "p = duet.device_pair('halves')\n"
                "a, b = p:device('A'), p:device('B')\n"
                "one = ('duet.device_pair { A = B = %s %s }'):format(a.selector, a.name)\n"
                "two = ('duet.device_pair { A = %s %s, B = %s %s }'):format(\n"
                "a.selector, a.name, b.selector, b.name)\n"
                "tostring(p) == (a.selector == b.selector and one or two)\n"
                "tostring(duet.device_pair(a.selector)) == one\n"
                "p:world { plan = { share = 0.25, mode = 'own', variant_a = 'simd', variant_b = "
                "'gpu' } }\n"
                "s = duet.scene(duet.poses { { 0, 0, 0, 1, 1, 1, 0, 0, 0, 1 } }, 3)\n"
                "p:motion(s)\n"
                "s:close()\n"
                "s\n");
    assert_prints(
        "lua <" SCRIPT,
        "true\ntrue\n"
        "duet.world { share = 0.25, mode = own, variant_a = simd, variant_b = gpu, level = "
        "certified }\n"
        "duet.motion { objects = 1, effects = {  } }\n"
        "duet.scene (closed)\n");
    test_write_file(SCRIPT, "duet.bounds { { 0, 0, 0, 1, 2, 3.5 }, { -10, 0, 0, 1, 1, 1 } }\n"
                            "duet.pairs(9)\n"
                            "s = duet.scene(duet.bounds(2), 3)\n"
                            "s\n"
                            "duet.kernels()\n");
    program p = program_done(program_run("lua <" SCRIPT));
    static const char rows[] = "duet.bounds of 2 rows\n"
                               "  0    0  0  0  1  2  3.5\n"
                               "  1  -10  0  0  1  1    1\n"
                               "duet.pairs of 9 rows\n";
    assert_true(strncmp(p.out, rows, strlen(rows)) == 0);
    assert_says(p.out, "\n  7  0  0\n  ...\nduet.scene\n", "\n  shape         \"bounds\"\n",
                "\nname    ", "\nclear   ");
}

TEST(help_is_of_the_prompt)
{
    test_write_file(SCRIPT,
                    "help\nhelp(duet.scene)\nhelp(duet.bounds(1))\nhelp 'DevicePair'\nhelp 'no'\n");
    program p = program_done(program_run("lua <" SCRIPT));
    assert_says(p.out, "Tab completes names", "  duet.scene(from, settings?)  ",
                "  duet.Bounds:each(", "rows of lower xyz, upper xyz. Made of a number of rows",
                "\n  answers bodies bounds bounds_sweeps ");
    assert_null(strstr(p.out, "  duet.answers(from)")); // arrays have no rows of their own
    assert_says(p.out, "  duet.DevicePair:world(scene?, def?)  ", "there is no help on 'no'");
    assert_prints("lua -e 'print(help)'", "nil\n");
}

// ---------------------------------------------------------------- a terminal

typedef struct terminal {
    pid_t process;
    int end;
    text seen;
} terminal;

// The prompt on a terminal, with its history below a folder.
static terminal terminal_open(const char *state_home)
{
    terminal t = {0};
    skip_without_terminal();
    t.process = forkpty(&t.end, NULL, NULL, NULL);
    assert_true(t.process >= 0);
    if (t.process == 0) {
        setenv("XDG_STATE_HOME", state_home, 1);
        setenv("TERM", "vt100", 1);
        execl(getenv("DUET_PROGRAM"), "duet", "lua", (char *)NULL);
        _exit(127);
    }
    return t;
}

// Reads until the terminal has shown this after what it was waited for before.
static void terminal_wait(terminal *t, const char *shown)
{
    char chars[256];
    struct pollfd one = {.fd = t->end, .events = POLLIN};
    while (!t->seen.chars || !strstr(t->seen.chars, shown)) {
        assert_true(poll(&one, 1, 60000) > 0);
        ssize_t n = read(t->end, chars, sizeof chars);
        if (n <= 0)
            fail_msg("no '%s' in '%s'", shown, text_chars(&t->seen));
        text_add_bytes(&t->seen, chars, (size_t)n);
    }
    t->seen.length = 0;
}

static void terminal_type(terminal *t, const char *keys)
{
    assert_int_equal(write(t->end, keys, strlen(keys)), (ssize_t)strlen(keys));
}

// Empties the line and types Ctrl-D until the program ends: a key that comes before the line
// is edited may be lost. Its output is read, so that it never waits for that.
static int terminal_close(terminal *t)
{
    int status = 0;
    int tries = 0;
    for (pid_t ended = 0; ended == 0; ended = waitpid(t->process, &status, WNOHANG)) {
        struct pollfd one = {.fd = t->end, .events = POLLIN};
        char shown[256];
        assert_true(++tries < 600);
        terminal_type(t, "\025\004");
        if (poll(&one, 1, 100) > 0 && read(t->end, shown, sizeof shown) <= 0)
            poll(NULL, 0, 10); // it is about to end
    }
    close(t->end);
    text_free(&t->seen);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

#define HISTORY "test_lua.state/duet/lua_history"

TEST(tab_completes_and_history_is_kept)
{
    char here[4096];
    own(text) home = {0};
    text_add(&home, "%s/test_lua.state", getcwd(here, sizeof here));
    terminal t = terminal_open(home.chars);
    terminal_wait(&t, "> ");
    terminal_type(&t, "duet.strat\t()[1].name .. 6 * 7\r");
    terminal_wait(&t, "balance42");
    terminal_wait(&t, "> ");
    terminal_type(&t, "kept = 4000; half typed\003"); // dropped, and the prompt goes on
    terminal_wait(&t, "> ");
    terminal_type(&t, "kept, 5000 + 5\r");
    terminal_wait(&t, "5005");
    terminal_type(&t, "b = duet.bounds(3)\r");
    terminal_type(&t, "#b:by\t() // 24 + 2000\r");
    terminal_wait(&t, "2003");
    terminal_type(&t, "#duet.bou\t(5) + 1000\r");
    terminal_wait(&t, "1005");
    assert_int_equal(terminal_close(&t), 0);

    t = terminal_open(home.chars);
    terminal_wait(&t, "> ");
    terminal_type(&t, "\033[A\r"); // the last line of the session before
    terminal_wait(&t, "1005");
    assert_int_equal(terminal_close(&t), 0);
    assert_int_equal(remove(HISTORY), 0);
    rmdir("test_lua.state/duet");
    rmdir("test_lua.state");

    t = terminal_open("/dev/null"); // no place for it
    terminal_wait(&t, "> ");
    terminal_type(&t, "6 * 700\r");
    terminal_wait(&t, "4200");
    assert_int_equal(terminal_close(&t), 0);
}

TEST(a_step_can_be_made_without_trust)
{
    test_write_file(SCRIPT, "local pair <close> = assert(duet.device_pair())\n"
                            "local world <close> = assert(pair:world { dims = 3 })\n"
                            "assert(world:set_poses { 0, 0, 0, 1, 1, 1, 0, 0, 0, 1,\n"
                            "                         1, 0, 0, 1, 1, 1, 0, 0, 0, 1 })\n"
                            "for a, b in assert(world:step()):pairs() do print(a, b) end\n");
    assert_prints("lua " SCRIPT, "0\t1\n");
}

// ---------------------------------------------------------------- refusals

static void assert_refused(const char *arguments, int exit_code, const char *says)
{
    program_assert_refused(program_run("%s", arguments), exit_code, says);
}

TEST(a_wrong_command_line_is_refused)
{
    assert_refused("lua nowhere.lua", 1, "nowhere.lua: No such file");
    assert_refused("lua -e 'x x'", 1, "-e:1: syntax error near 'x'");
    assert_refused("lua --trust -e 'x x'", 1, "-e:1: syntax error near 'x'");
    assert_refused("lua --trust -e 'error {}'", 1, "an error that is not a text");
}

TEST(a_hostile_script_ends_with_its_line)
{
    static const refusal cases[] = {
        {"\nwhile true do end", ":2: runs for more than the 0.5 s"},
        {"\nlocal t = {}\nfor i = 1, 1e9 do t[i] = { i } end", ":3: needs more than the 16 MiB"},
        {"local s = 'x'\n\nfor i = 1, 60 do s = s .. s end", ":3: needs more than the 16 MiB"},
        {"print(('x'):rep(1 << 60))", ":1: resulting string too large"},
        {"print(('x'):rep(1 << 30))", ":1: needs more than the 16 MiB"},
        {"\nlocal function f() return 1 + f() end\nf()", ":2: needs more than the 16 MiB"},
        {"('x'):rep(30000):find(('.-'):rep(30) .. 'y')", ":1: find: '.' makes a pattern"},
        {"setmetatable({}, { __gc = function() while true do end end })", ":1: attempt to call"},
        {"getmetatable('').__index = nil", ":1: attempt to call"},
        {"string.rep = nil\nprint(('x'):dump())", ":2: attempt to call"},
        {"os.exit(3)",
         ":1: attempt to index a nil value (global 'os'); 'duet lua --trust' gives 'os'"},
        {"require 'os'", ":1: require 'os': without --trust"},
        {"duet.poses(1 << 40)", ":1: needs more than the 16 MiB"},
        {"duet.poses(1 << 62)", ":1: duet.poses of"},
        {"duet.scene('/etc/passwd')", ":1: '/etc/passwd' is not below the current folder"},
        {"duet.scene('../x.csv')", ":1: '../x.csv' is not below"},
        {"duet.scene('x/../../x.csv')", ":1: 'x/../../x.csv' is not below"},
        {"duet.device_pair { kernel_dir = '.' }", ":1: choosing kernel_dir or cache_dir needs"},
        {"duet.device_pair { cache_dir = '.' }", ":1: choosing kernel_dir or cache_dir needs"},
        {"local p = duet.poses(1)\np.get(duet)", ":2: bad argument #1 to 'get'"},
        {"local p = duet.poses(1)\np:close()\np:get(0)",
         ":3: calling 'get' on bad self (the array is closed)"},
        {"\33Lua", ": attempt to load a binary chunk"},
        {"error(setmetatable)", ": raises a nil as its error"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char says[160];
        snprintf(says, sizeof says, SCRIPT "%s", cases[i].says);
        test_write_file(SCRIPT, cases[i].given);
        bool by_time = strstr(says, "0.5 s");
        assert_refused(by_time ? "lua --seconds 0.5 --memory 16 " SCRIPT
                               : "lua --seconds 30 --memory 16 " SCRIPT,
                       1, says);
    }
}

#define CROWD                                                  \
    "local boxes = duet.bounds(20000)\n"                       \
    "for i = 0, 19999 do boxes:set(i, 0, 0, 0, 1, 1, 1) end\n" \
    "local scene = assert(duet.scene(boxes, 3))\n"

// Each of 20000 boxes touches each: 1.6 GB of pairs.
TEST(work_of_the_host_is_held_to_the_limits)
{
    test_write_file(SCRIPT, CROWD "assert(scene:reference())\n");
    assert_refused("lua --seconds 60 --memory 16 " SCRIPT, 1,
                   SCRIPT ":4: needs more than the 16 MiB of the host's memory it may take");
    assert_refused("lua --seconds 0.3 --memory 8192 " SCRIPT, 1,
                   SCRIPT ":4: runs for more than the 0.3 s it may take");
    test_write_file(SCRIPT,
                    "local kept = {}\n"
                    "for i = 1, 100 do kept[i] = assert(duet.scene(duet.bounds(100000), 3)) end\n");
    assert_refused("lua --memory 64 " SCRIPT, 1, SCRIPT ":2: needs more than the 64 MiB");
}

// Memory that is kept fills the limit; what is dropped is collected before it does.
TEST(what_a_script_opens_counts_as_its_memory)
{
    static const char *const makers[] = {
        "duet.device_pair()",   "pair:world { dims = 3 }",
        "pair:tree()",          "pair:motion(poses, bodies, { wants = { 'contact_response' } })",
        "world:step():pairs()",
    };
    for (size_t i = 0; i < sizeof makers / sizeof *makers; ++i) {
        char script[1024];
        const char *begin = "local pair = duet.device_pair()\n"
                            "local poses = duet.poses(1)\n"
                            "local bodies = duet.bodies(1)\n"
                            "poses:set(0, 0, 0, 0, 1, 1, 1, 0, 0, 0, 1)\n"
                            "bodies:set(0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, false, false)\n"
                            "local world = pair:world { dims = 3 }\n"
                            "assert(world:set_poses(poses))\n";
        bool holds_devices = i + 1 < sizeof makers / sizeof *makers;
        snprintf(script, sizeof script,
                 "%slocal kept = {}\nwhile true do kept[#kept + 1] = assert(%s) end\n", begin,
                 makers[i]);
        test_write_file(SCRIPT, script);
        if (holds_devices)
            assert_refused("lua --seconds 600 --memory 16 " SCRIPT, 1,
                           "needs more than the 16 MiB of the host's memory it may take");
        snprintf(script, sizeof script, "%sfor i = 1, %d do assert(%s) end\nprint(7)\n", begin,
                 holds_devices ? 50 : 5000, makers[i]);
        test_write_file(SCRIPT, script);
        assert_prints("lua --seconds 600 --memory 16 " SCRIPT, "7\n");
    }
}

// A step on devices cannot be ended by the library; this one takes seconds.
TEST(a_script_that_goes_on_in_the_host_is_ended_by_the_program)
{
    test_write_file(SCRIPT, CROWD "local world = assert(assert(duet.device_pair()):world(scene))\n"
                                  "while true do assert(world:step()) end\n");
    uint64_t begun = clock_steady_ns();
    program p = program_run("lua --seconds 0.5 " SCRIPT);
    double seconds = (double)(clock_steady_ns() - begun) * 1e-9;
    assert_int_equal(p.exit_code, 1);
    bool by_limit = strstr(p.err, SCRIPT ":5: runs for more than the 0.5 s it may take");
    if (!by_limit &&
        strcmp(p.err, "duet: a script ran on for 2 s after its limit, and was ended\n"))
        fail_msg("said '%s'", p.err);
    if (seconds > 15)
        fail_msg("took %g s", seconds);
}

// The first signal is heard, whatever the script does; a second one would end
// the program without a line.
TEST(a_signal_is_heard_whatever_runs)
{
    static const struct {
        const char *options;
        const char *script;
    } cases[] = {
        {"", "while true do end"},
        {"", "local s = ('x'):rep(5e7) while true do s:reverse() end"},
        {"--trust", "while true do pcall(function() while true do end end) end"},
        {"--trust", "print(('a'):rep(1e7):find(('a'):rep(5e6) .. 'b', 1, true))"},
        {"--trust", "print(pcall(coroutine.wrap(function() while true do end end)))\n"
                    "while true do end"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        test_write_file(SCRIPT, cases[i].script);
        uint64_t begun = clock_steady_ns();
        program p = program_run_with("timeout --foreground --preserve-status -s TERM 0.5",
                                     "lua %s " SCRIPT, cases[i].options);
        double seconds = (double)(clock_steady_ns() - begun) * 1e-9;
        if (p.exit_code != 128 + SIGTERM || !strstr(p.err, "stopped\n") || seconds > 0.5 + 2 + 8)
            fail_msg("%s: exit %d after %g s, '%s'", cases[i].script, p.exit_code, seconds, p.err);
    }
}

TEST(a_file_named_on_the_command_line_can_be_read)
{
    char path[512];
    snprintf(path, sizeof path, "lua /dev/stdin '%s/paper.lua' <" SCRIPT,
             getenv("DUET_TEST_SCENES"));
    test_write_file(SCRIPT, "print(#assert(duet.scene(arg[1], { n = 7 })))\n");
    assert_prints(path, "7\n");
}
