// SPDX-License-Identifier: MIT
// Two expected texts of each kernel that is a template: the others are compiled as
// they stand. A change to a template shows here what is really compiled; DUET_UPDATE_GOLDEN=1
// writes the texts anew. Of a header only its #line is kept, because its text is that of its file.
#include "support/golden.h"
#include "support/test.h"

#include "base/blob.h"
#include "base/text.h"
#include "gen/gen.h"

#include <stdio.h>
#include <string.h>

static const gen_limits gpu = {.max_group = 1024, .local_bytes = 48 << 10, .fp64 = true};
static const gen_limits cpu = {
    .max_group = 4096, .local_bytes = 1 << 20, .fp64 = true, .cpu = true};

static bool has_dims(gen *g, const char *kernel)
{
    duet_error err = {0};
    const gen_param *params = NULL;
    uint32_t n = 0;
    assert_ok(gen_params(g, kernel, &gpu, &params, &n, &err), err);
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(params[i].name, "DIMS") == 0)
            return true;
    return false;
}

static bool ends_with(const char *row, size_t length, const char *end)
{
    return length > strlen(end) && strncmp(row + length - strlen(end), end, strlen(end)) == 0;
}

static bool begins_header(const char *row, size_t length)
{
    return strncmp(row, "#line 1 \"", 9) == 0 &&
           (ends_with(row, length, ".clh\"\n") || ends_with(row, length, ".h\"\n"));
}

static void leave_headers_out(const char *chars, text *out)
{
    bool in_header = false;
    for (size_t length; *chars; chars += length) {
        length = strcspn(chars, "\n") + 1;
        bool begins = begins_header(chars, length);
        if (begins || strncmp(chars, "#line", 5) == 0)
            in_header = false;
        if (!in_header)
            text_add_bytes(out, chars, length);
        in_header = in_header || begins;
    }
}

static void check(gen *g, const char *kernel, const char *which, const gen_limits *limits,
                  int64_t dims)
{
    duet_error err = {0};
    gen_setting setting = {"DIMS", dims};
    gen_variant v;
    char file[80];
    assert_ok(gen_make(g, kernel, &setting, has_dims(g, kernel), limits, &v, &err), err);
    snprintf(file, sizeof file, "%s.%s.cl", kernel, which);
    text shown = {0};
    leave_headers_out(v.text, &shown);
    golden_check(file, shown.chars);
    text_free(&shown);
    gen_variant_free(&v);
}

static bool is_template(const char *kernel)
{
    char end[80];
    int length = snprintf(end, sizeof end, "/%s.cl.in", kernel);
    for (const blob *b = blobs; b->path; ++b) {
        size_t path = strlen(b->path);
        if (path > (size_t)length && strcmp(b->path + path - length, end) == 0)
            return true;
    }
    return false;
}

static void templates_have_the_expected_text(void **state)
{
    (void)state;
    duet_error err = {0};
    gen *g = gen_open(NULL, &err);
    assert_ok(g, err);
    int checked = 0;
    for (uint32_t i = 0; gen_kernel(g, i); ++i) {
        if (!is_template(gen_kernel(g, i)))
            continue;
        ++checked;
        check(g, gen_kernel(g, i), "gpu", &gpu, 3);
        check(g, gen_kernel(g, i), "cpu", &cpu, 2);
    }
    assert_true(checked > 10);
    gen_close(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(templates_have_the_expected_text)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
