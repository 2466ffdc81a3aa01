// SPDX-License-Identifier: MIT
#include "tuner/cli/say.h"

#include "runtime/base/error.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

int say_failed(const duet_error *err)
{
    fflush(stdout);
    fprintf(stderr, "duet: %s\n", err->text);
    return err->status == DUET_BAD_ARGUMENT ? EXIT_WRONG : EXIT_FAILED;
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
    char *text = cJSON_Print(object);
    cJSON_Delete(object);
    if (!text)
        return error_set(err, DUET_NO_MEMORY, "the JSON object: no memory");
    puts(text);
    cJSON_free(text);
    return true;
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
