// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/say.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/text_file.h"
#include "base/visible.h"
#include "cli/report/json.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

int say_failed(const duet_error *err)
{
    fflush(stdout);
    fprintf(stderr, "duet: %s\n", err->text);
    return say_status(err);
}

int say_status(const duet_error *err)
{
    return err->status == DUET_STATUS_BAD_ARGUMENT  ? EXIT_WRONG
           : err->status == DUET_STATUS_INTERRUPTED ? EXIT_INTERRUPTED
                                                    : EXIT_FAILED;
}

static void print_line(const char *before, const char *format, va_list args)
{
    char line[1024];
    visible_write(line, sizeof line, format, args);
    visible_line(line, sizeof line);
    fprintf(stderr, "duet%s: %s\n", before, line);
}

int say_wrong(const char *command, const char *format, ...)
{
    char before[64];
    va_list args;
    snprintf(before, sizeof before, " %s", command);
    va_start(args, format);
    print_line(before, format, args);
    va_end(args);
    return EXIT_WRONG;
}

void say_note(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    print_line(": note", format, args);
    va_end(args);
}

bool say_json(cJSON *object, duet_error *err)
{
    text chars = {0};
    bool ok = json_write(object, &chars, err);
    cJSON_Delete(object);
    if (ok)
        puts(chars.chars);
    text_free(&chars);
    return ok;
}

said say_name(const char *name)
{
    said shown = {{0}};
    text whole = {0};
    text_add_visible(&whole, name ? name : "", name ? strlen(name) : 0, "");
    snprintf(shown.chars, sizeof shown.chars, "%s", text_chars(&whole));
    text_free(&whole);
    return shown;
}

counted say_count(uint64_t n)
{
    char digits[32];
    counted grouped = {{0}};
    int length = snprintf(digits, sizeof digits, "%" PRIu64, n);
    char *to = grouped.chars;
    for (int i = 0; i < length; ++i) {
        if (i > 0 && (length - i) % 3 == 0)
            *to++ = ' ';
        *to++ = digits[i];
    }
    return grouped;
}

counted say_things(uint64_t n, const char *one, const char *many)
{
    counted s;
    snprintf(s.chars, sizeof s.chars, "%.40s %.40s", say_count(n).chars, n == 1 ? one : many);
    return s;
}

int say_terminal_width(int file)
{
    struct winsize size;
    return ioctl(file, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

void say_lines(const char *lines)
{
    text shown = {0};
    text_add_visible(&shown, lines, strlen(lines), "\n\t");
    fputs(text_chars(&shown), stdout);
    text_free(&shown);
}

bool say_to_file(text *chars, const char *path, duet_error *err)
{
    bool ok = text_ok(chars, err) && text_write_file(path, text_chars(chars), chars->length, err);
    text_free(chars);
    return ok;
}

bool say_finish(void)
{
    errno = 0;
    bool failed_before = ferror(stdout);
    if (fclose(stdout) == 0 && !failed_before)
        return true;
    fprintf(stderr, "duet: stdout: %s\n", errno ? strerror(errno) : "cannot be written");
    return false;
}

// ---------------------------------------------------------------- how far it is

// The time that is left is told once one of so many parts is done: the first step compiles, and
// says nothing of the others.
enum { LEAST_NS_BETWEEN = 100000000, LINE_MOST = 200, TOLD_OF = 200 };

static bool shows_on_terminal;
static int depth;             // counts works that are one a part of another
static char whole[LINE_MOST]; // how far the outermost is, without its rate
static bool drawn;            // a line of progress stands on the terminal

// The library counts in units of its own, so that a part or seconds are shown.
static int add_part(const progress *p, uint64_t done, double seconds, char *to, size_t size)
{
    if (p->total >= done && p->total > 0)
        return snprintf(to, size, "%s: %.0f %%", p->what, 100 * (double)done / (double)p->total);
    return snprintf(to, size, "%s: %.0f s", p->what, seconds);
}

static int add_count(const progress *p, uint64_t done, char *to, size_t size)
{
    if (done == 0 && p->total == 0)
        return snprintf(to, size, "%s", p->what);
    int n = snprintf(to, size, "%s %" PRIu64, p->what, done);
    if (p->total > 0)
        n += snprintf(to + n, size - (size_t)n, " of %" PRIu64, p->total);
    return n;
}

static void write_line(const progress *p, uint64_t done, bool rate, char line[LINE_MOST])
{
    double seconds = (double)(clock_steady_ns() - p->begun_ns) * 1e-9;
    int n = p->follows ? add_part(p, done, seconds, line, LINE_MOST)
                       : add_count(p, done, line, LINE_MOST);
    if (rate && !p->follows && done > 0 && seconds > 0)
        n += snprintf(line + n, LINE_MOST - (size_t)n, ", %.3g a second", (double)done / seconds);
    if (p->total > done && done > 0 && done >= p->total / TOLD_OF)
        n += snprintf(line + n, LINE_MOST - (size_t)n, ", %.0f s left",
                      seconds * (double)(p->total - done) / (double)done);
    if (*p->note)
        snprintf(line + n, LINE_MOST - (size_t)n, "; %s", p->note);
}

void say_on_terminal(void)
{
    shows_on_terminal = true;
}

progress progress_begin(const char *what, uint64_t total)
{
    progress p = {
        .what = what,
        .total = total,
        .begun_ns = clock_steady_ns(),
        .on_terminal = shows_on_terminal || isatty(STDERR_FILENO),
        .is_part = depth++ > 0,
    };
    if (!p.is_part)
        write_line(&p, 0, false, whole);
    return p;
}

// A line that reached the last column would wrap, and could not be cleared.
void progress_line(const char *line)
{
    const int width = say_terminal_width(STDERR_FILENO);
    fprintf(stderr, "\r\033[K%.*s", (width > 0 ? width : 80) - 1, line);
    fflush(stderr);
    drawn = true;
}

static void show_line(const char *before, const char *line)
{
    char shown[2 * LINE_MOST + 2];
    snprintf(shown, sizeof shown, "%s%s%s", before, *before ? "; " : "", line);
    progress_line(shown);
}

void progress_show(progress *p, uint64_t done)
{
    uint64_t now = clock_steady_ns();
    char line[LINE_MOST];
    if (!p->on_terminal || now - p->shown_ns < LEAST_NS_BETWEEN)
        return;
    p->shown_ns = now;
    write_line(p, done, !p->is_part, line);
    if (!p->is_part)
        write_line(p, done, false, whole);
    show_line(p->is_part ? whole : "", line);
}

static void hear(void *listener, uint64_t done, uint64_t total)
{
    progress *p = listener;
    p->total = total;
    progress_show(p, done);
}

void progress_follow(progress *p)
{
    p->follows = true;
    budget_listen(hear, p);
}

void progress_hide(progress *p)
{
    if (p->on_terminal && drawn)
        fputs("\r\033[K", stderr);
    drawn = false;
    p->shown_ns = 0;
}

// The work that this was a part of goes on, and is told until it tells itself.
void progress_end(progress *p)
{
    bool was_shown = p->shown_ns > 0;
    progress_hide(p);
    if (p->is_part && was_shown)
        progress_line(whole);
    if (p->follows)
        budget_listen(NULL, NULL);
    --depth;
}
