// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/say.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/visible.h"
#include "cli/report/json.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

int say_failed(const duet_error *err)
{
    fflush(stdout);
    fprintf(stderr, "duet: %s\n", err->text);
    return err->status == DUET_STATUS_BAD_ARGUMENT  ? EXIT_WRONG
           : err->status == DUET_STATUS_INTERRUPTED ? EXIT_INTERRUPTED
                                                    : EXIT_FAILED;
}

int say_wrong(const char *command, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fprintf(stderr, "duet %s: ", command);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    return EXIT_WRONG;
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
    visible_add(&whole, name ? name : "", name ? strlen(name) : 0, "");
    snprintf(shown.chars, sizeof shown.chars, "%s", text_chars(&whole));
    text_free(&whole);
    return shown;
}

void say_lines(const char *lines)
{
    text shown = {0};
    visible_add(&shown, lines, strlen(lines), "\n\t");
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

enum { LEAST_NS_BETWEEN = 100000000 };

progress progress_begin(const char *what, uint64_t total)
{
    return (progress){
        .what = what,
        .total = total,
        .begun_ns = clock_steady_ns(),
        .on_terminal = isatty(STDERR_FILENO),
    };
}

void progress_show(progress *p, uint64_t done)
{
    uint64_t now = clock_steady_ns();
    if (!p->on_terminal || now - p->shown_ns < LEAST_NS_BETWEEN)
        return;
    p->shown_ns = now;
    double seconds = (double)(now - p->begun_ns) * 1e-9;
    double rate = seconds > 0 ? (double)done / seconds : 0;
    fprintf(stderr, "\r\033[K%s %llu", p->what, (unsigned long long)done);
    if (p->total > 0)
        fprintf(stderr, " of %llu", (unsigned long long)p->total);
    if (done > 0)
        fprintf(stderr, ", %.3g a second", rate);
    if (done > 0 && p->total > done)
        fprintf(stderr, ", %.0f s left", (double)(p->total - done) / rate);
    fflush(stderr);
}

void progress_end(progress *p)
{
    if (p->on_terminal && p->shown_ns > 0)
        fputs("\r\033[K", stderr);
}
