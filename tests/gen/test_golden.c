// SPDX-License-Identifier: MIT
// What the generator makes of each template, for a CPU in 2D and a GPU in 3D, in one file: lines
// of only one of them stand as `diff -D GPU` writes them. Lines that a template has as they are
// come as their count, and of a header comes its #line alone, since their texts are those files.
// DUET_UPDATE_GOLDEN=1 writes the files anew.
#define _POSIX_C_SOURCE 200809L // popen
#include "support/golden.h"
#include "support/test.h"

#include "base/blob.h"
#include "base/text_file.h"
#include "gen/gen.h"

static const gen_limits gpu = {.max_group = 1024, .local_bytes = 48 << 10, .fp64 = true};
static const gen_limits cpu = {
    .max_group = 4096, .local_bytes = 1 << 20, .fp64 = true, .cpu = true};

static const char *next_row(const char *row)
{
    row += strcspn(row, "\n");
    return *row ? row + 1 : row;
}

static const char *find_row(const char *chars, unsigned number)
{
    while (number-- > 1)
        chars = next_row(chars);
    return chars;
}

static bool same_row(const char *a, const char *b)
{
    size_t length = strcspn(a, "\n");
    return *b && length == strcspn(b, "\n") && memcmp(a, b, length) == 0;
}

static void add_count(text *out, unsigned *n)
{
    if (*n > 0)
        text_add(out, "// as in the template: %u\n", *n);
    *n = 0;
}

// NULL, unless the row is a #line into a file; that file then, from the line it names.
static const char *read_directive(const char *row, bool *is_header)
{
    unsigned number;
    char path[128];
    if (sscanf(row, "#line %u \"%127[^\"]\"", &number, path) != 2)
        return NULL;
    *is_header = strcmp(path + strlen(path) - 2, ".h") == 0 || strstr(path, ".clh");
    const blob *file = blob_find(path);
    return file ? find_row(file->bytes, number) : "";
}

static void add_what_is_made(const char *chars, text *out)
{
    const char *template = "";
    bool in_header = false;
    unsigned n_same = 0;
    for (const char *row = chars; *row; row = next_row(row)) {
        const char *file = read_directive(row, &in_header);
        if (!file && in_header)
            continue;
        bool same = !file && same_row(row, template);
        if (!same) {
            add_count(out, &n_same);
            text_add_bytes(out, row, (size_t)(next_row(row) - row));
        }
        n_same += same;
        template = file ? file : next_row(template);
    }
    add_count(out, &n_same);
}

static bool has_dims(gen *g, const char *kernel)
{
    const gen_param *params = NULL;
    uint32_t n = 0;
    must(gen_params(g, kernel, &gpu, &params, &n, ERR));
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(params[i].name, "DIMS") == 0)
            return true;
    return false;
}

static void write_made(gen *g, const char *kernel, const gen_limits *limits, int64_t dims,
                       const char *path)
{
    gen_setting setting = {"DIMS", dims};
    own(gen_variant) v;
    own(text) made = {0};
    must(gen_make(g, kernel, &setting, has_dims(g, kernel), limits, &v, ERR));
    add_what_is_made(v.text, &made);
    must(text_write_file(path, made.chars, made.length, ERR));
}

static void check(gen *g, const char *kernel)
{
    char file[80], bytes[4096];
    own(text) both = {0};
    write_made(g, kernel, &cpu, 2, "golden.cpu.cl");
    write_made(g, kernel, &gpu, 3, "golden.gpu.cl");
    FILE *diff = popen("diff -d -D GPU golden.cpu.cl golden.gpu.cl", "r");
    assert_non_null(diff);
    for (size_t n; (n = fread(bytes, 1, sizeof bytes, diff)) > 0;)
        text_add_bytes(&both, bytes, n);
    assert_true(pclose(diff) >= 0);
    snprintf(file, sizeof file, "%s.cl", kernel);
    golden_check(file, text_chars(&both));
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

TEST(templates_have_the_expected_text)
{
    gen *g = kept(gen_open(NULL, ERR));
    int checked = 0;
    for (uint32_t i = 0; gen_kernel(g, i); ++i)
        if (is_template(gen_kernel(g, i))) {
            check(g, gen_kernel(g, i));
            ++checked;
        }
    assert_true(checked >= 2);
}
