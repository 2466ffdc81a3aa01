// SPDX-License-Identifier: MIT
#include "cli/say.h"

#include "base/error.h"
#include "base/visible.h"
#include "cli/report/json.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

int say_failed(const duet_error *err)
{
    fflush(stdout);
    fprintf(stderr, "duet: %s\n", err->text);
    return err->status == DUET_STATUS_BAD_ARGUMENT ? EXIT_WRONG : EXIT_FAILED;
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

bool say_finish(void)
{
    errno = 0;
    bool failed_before = ferror(stdout);
    if (fclose(stdout) == 0 && !failed_before)
        return true;
    fprintf(stderr, "duet: stdout: %s\n", errno ? strerror(errno) : "cannot be written");
    return false;
}
