// SPDX-License-Identifier: MIT
// Objects as NumPy writes them: an array of floats of shape (n, columns).
//
// A file is a magic, a version, a header that is a Python literal, and the array. The sizes are
// checked against the file's length before anything is taken from it, so that a wrong header never
// leads past the end. Only the rows that a scene keeps are read from a large file.
#define _POSIX_C_SOURCE 200809L // pread
#include "runtime/scene/scene_source.h"

#include "base/budget.h"
#include "base/error.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    ROWS_AT_ONCE = 1 << 14, // between two looks at the budget
    HEADER_MOST = 1 << 16   // bytes, as NumPy itself has it
};

typedef struct npy {
    const scene_source *source;
    const char *path;
    const char *header; // the literal
    size_t header_length;
    size_t data_at; // in the file
    size_t data_length;
    uint32_t item_bytes; // 4 or 8; 0: not read yet
    bool big_endian;
    bool fortran_order;
    uint32_t n_shape; // 0: not read yet
    uint64_t shape[2];
} npy;

static bool refuse(const npy *file, duet_error *err, const char *what)
{
    return bad_input(err, "%s: %s", file->path, what);
}

// ----------------------------------------------------------------- literal

// The rest of the literal.
typedef struct cursor {
    const char *at;
    const char *end;
} cursor;

static void skip_blanks(cursor *c)
{
    while (c->at < c->end && isspace((unsigned char)*c->at))
        ++c->at;
}

// Takes the word where it comes next.
static bool take(cursor *c, const char *word)
{
    skip_blanks(c);
    size_t length = strlen(word);
    if ((size_t)(c->end - c->at) < length || memcmp(c->at, word, length) != 0)
        return false;
    c->at += length;
    return true;
}

// Takes a quoted string of less than size characters.
static bool take_string(cursor *c, char *out, size_t size)
{
    const char *quote = take(c, "'") ? "'" : take(c, "\"") ? "\"" : NULL;
    if (!quote)
        return false;
    size_t n = 0;
    while (c->at < c->end && *c->at != *quote && n + 1 < size)
        out[n++] = *c->at++;
    out[n] = '\0';
    return take(c, quote);
}

static bool take_count(cursor *c, uint64_t *count)
{
    skip_blanks(c);
    const char *start = c->at;
    *count = 0;
    for (; c->at < c->end && isdigit((unsigned char)*c->at); ++c->at) {
        uint64_t digit = (uint64_t)(*c->at - '0');
        if (*count > (UINT64_MAX - digit) / 10)
            return false;
        *count = 10 * *count + digit;
    }
    return c->at > start;
}

// ------------------------------------------------------------------ header

static bool read_descr(cursor *c, npy *file, duet_error *err)
{
    static const struct {
        const char *name;
        uint32_t item_bytes;
        bool big_endian;
    } types[] = {{"<f4", 4, false}, {"<f8", 8, false}, {">f4", 4, true}, {">f8", 8, true}};
    char name[16];
    bool plain = take_string(c, name, sizeof name);
    for (size_t i = 0; plain && i < sizeof types / sizeof types[0]; ++i)
        if (strcmp(name, types[i].name) == 0) {
            file->item_bytes = types[i].item_bytes;
            file->big_endian = types[i].big_endian;
            return true;
        }
    return bad_input(err, "%s: the numbers are %s%s%s; they must be float32 or float64", file->path,
                     plain ? "'" : "", plain ? name : "records", plain ? "'" : "");
}

static bool read_order(cursor *c, npy *file, duet_error *err)
{
    file->fortran_order = take(c, "True");
    return file->fortran_order || take(c, "False") ||
           refuse(file, err, "fortran_order is neither True nor False");
}

static bool read_shape(cursor *c, npy *file, duet_error *err)
{
    bool ok = take(c, "(");
    while (ok && !take(c, ")")) {
        uint64_t length = 0;
        ok = take_count(c, &length);
        if (file->n_shape < 2)
            file->shape[file->n_shape] = length;
        ++file->n_shape;
        ok = ok && (take(c, ",") || (c->at < c->end && *c->at == ')'));
    }
    if (!ok)
        return refuse(file, err, "the header's shape is not a list of numbers");
    if (file->n_shape != 2)
        return bad_input(err, "%s: the array has %u dimensions; its shape must be (n, columns)",
                         file->path, file->n_shape);
    return true;
}

static bool read_entry(cursor *c, npy *file, duet_error *err)
{
    static const struct {
        const char *key;
        bool (*read)(cursor *c, npy *file, duet_error *err);
    } entries[] = {{"descr", read_descr}, {"fortran_order", read_order}, {"shape", read_shape}};
    char key[32];
    if (!take_string(c, key, sizeof key) || !take(c, ":"))
        return refuse(file, err, "the header is not a Python dictionary as NumPy writes it");
    for (size_t i = 0; i < sizeof entries / sizeof entries[0]; ++i)
        if (strcmp(key, entries[i].key) == 0)
            return entries[i].read(c, file, err);
    return refuse(file, err, "the header has a key other than descr, fortran_order and shape");
}

// {'descr': '<f4', 'fortran_order': False, 'shape': (3, 10), }
static bool read_header(npy *file, duet_error *err)
{
    cursor c = {file->header, file->header + file->header_length};
    bool ok = take(&c, "{");
    while (ok && !take(&c, "}")) {
        if (!read_entry(&c, file, err))
            return false;
        ok = take(&c, ",") || (c.at < c.end && *c.at == '}');
    }
    skip_blanks(&c);
    if (!ok || c.at != c.end)
        return refuse(file, err, "the header is not a Python dictionary as NumPy writes it");
    if (file->item_bytes == 0 || file->n_shape == 0)
        return refuse(file, err, "the header lacks descr or shape");
    return true;
}

// ------------------------------------------------------------------- parts

static uint64_t read_little(const unsigned char *bytes, size_t n)
{
    uint64_t value = 0;
    while (n > 0)
        value = value << 8 | bytes[--n];
    return value;
}

static bool fetch(const npy *file, uint64_t at, void *to, size_t n, duet_error *err)
{
    unsigned char *bytes = to;
    if (file->source->bytes) {
        memcpy(to, file->source->bytes + at, n);
        return true;
    }
    while (n > 0) {
        errno = 0;
        ssize_t got = pread(file->source->file, bytes, n, (off_t)at);
        if (got <= 0 && errno != EINTR)
            return error_set(err, DUET_STATUS_IO_FAILED, "%s: %s", file->path,
                             errno ? strerror(errno) : "became shorter while it was read");
        size_t done = got > 0 ? (size_t)got : 0;
        bytes += done;
        at += done;
        n -= done;
    }
    return true;
}

// Finds header and data, of which the first `length` bytes are there. The header's length has two
// bytes in version 1 and four in those after it.
static bool cut_parts(npy *file, const unsigned char *bytes, size_t length, duet_error *err)
{
    if (length < 8 || memcmp(bytes, "\x93NUMPY", 6) != 0)
        return refuse(file, err, "does not begin as a .npy file does");
    unsigned version = bytes[6];
    if (version < 1 || version > 3)
        return bad_input(err, "%s: is .npy version %u; versions 1, 2 and 3 are read", file->path,
                         version);
    size_t start = version == 1 ? 10 : 12;
    if (length < start || length - start < read_little(bytes + 8, start - 8))
        return refuse(file, err,
                      length < file->source->length ? "has a header of more than 64 KiB"
                                                    : "ends within its header");
    file->header = (const char *)bytes + start;
    file->header_length = read_little(bytes + 8, start - 8);
    file->data_at = start + file->header_length;
    file->data_length = file->source->length - file->data_at;
    return true;
}

static bool check_size(const npy *file, const duet_scene *scene, duet_error *err)
{
    uint64_t n = file->shape[0];
    uint64_t columns = file->shape[1];
    if (!scene_columns_fit(scene, columns))
        return bad_input(err, "%s: the shape is (%llu, %llu); the second number must be %s",
                         file->path, (unsigned long long)n, (unsigned long long)columns,
                         scene_columns_right(scene));
    if (n > DUET_MOST_OBJECTS / scene->per_row)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         scene->per_row == 1 ? "%s: %llu objects; a scene holds at most %u"
                                             : "%s: %llu pairs; a file of pairs holds at most %u",
                         file->path, (unsigned long long)n, DUET_MOST_OBJECTS / scene->per_row);
    uint64_t wanted = n * columns * file->item_bytes;
    if (file->data_length != wanted)
        return bad_input(
            err,
            "%s: %s: the shape (%llu, %llu) needs %llu bytes of data, and %zu follow the header",
            file->path, file->data_length < wanted ? "cut short" : "too long",
            (unsigned long long)n, (unsigned long long)columns, (unsigned long long)wanted,
            file->data_length);
    return true;
}

// -------------------------------------------------------------------- data

static double read_item(const npy *file, const unsigned char *item)
{
    uint64_t bits = 0;
    for (uint32_t i = 0; i < file->item_bytes; ++i)
        bits = bits << 8 | item[file->big_endian ? i : file->item_bytes - 1 - i];
    if (file->item_bytes == 8) {
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    uint32_t low = (uint32_t)bits;
    float value;
    memcpy(&value, &low, sizeof value);
    return value;
}

// Some rows, as they lie in the file: each whole, or each column of them.
static bool fetch_rows(const npy *file, uint64_t first, uint64_t n, unsigned char *to,
                       duet_error *err)
{
    uint64_t columns = file->shape[1], item = file->item_bytes;
    if (!file->fortran_order)
        return fetch(file, file->data_at + first * columns * item, to, n * columns * item, err);
    bool ok = true;
    for (uint64_t k = 0; ok && k < columns; ++k)
        ok = fetch(file, file->data_at + (k * file->shape[0] + first) * item, to + k * n * item,
                   n * item, err);
    return ok;
}

static bool add_rows(duet_scene *scene, const npy *file, uint64_t n, const unsigned char *rows,
                     duet_error *err)
{
    uint64_t columns = file->shape[1];
    bool ok = true;
    for (uint64_t i = 0; ok && i < n; ++i) {
        double row[SCENE_MAX_NUMBERS];
        for (uint64_t k = 0; k < columns; ++k) {
            uint64_t item = file->fortran_order ? k * n + i : i * columns + k;
            row[k] = read_item(file, rows + item * file->item_bytes);
        }
        ok = scene_add_row(scene, row, (scene_place){.path = file->path}, err);
    }
    return ok;
}

// Rows, from `first` on, that are of interest at once; 0 at the end. Other rows are passed over.
static uint64_t next_rows(duet_scene *scene, uint64_t *first, uint64_t end)
{
    for (uint64_t passed = 1; scene->per_row == 1 && passed > 0; *first += passed)
        passed = scene_pass_over(scene, end - *first);
    uint64_t n = end - *first < ROWS_AT_ONCE ? end - *first : ROWS_AT_ONCE;
    if (scene->per_row == 1 && n > scene->end - scene->n_read)
        n = scene->end - scene->n_read;
    if (!scene->defers || n == 0)
        return n;
    if (*first == 0)
        return 1;
    scene->n_deferred = end - *first;
    scene->n_read += scene->n_deferred;
    return 0;
}

static bool add_objects(duet_scene *scene, const npy *file, duet_error *err)
{
    uint64_t n = file->shape[0];
    uint64_t kept = scene->defers ? 1 : scene->end - scene->first;
    kept = n * scene->per_row < kept ? n * scene->per_row : kept;
    unsigned char *rows = malloc((size_t)ROWS_AT_ONCE * file->shape[1] * file->item_bytes);
    bool ok = rows || no_memory(err, "%s", file->path);
    ok = ok &&
         scene_set_columns(scene, (uint32_t)file->shape[1], (scene_place){.path = file->path}, err);
    ok = ok && scene_reserve(scene, kept, err);
    uint64_t at = 0;
    for (uint64_t some; ok && (some = next_rows(scene, &at, n)) > 0; at += some) {
        budget_tell(at, n);
        ok = budget_check(err) && fetch_rows(file, at, some, rows, err) &&
             add_rows(scene, file, some, rows, err);
    }
    free(rows);
    return ok;
}

bool scene_read_npy(duet_scene *scene, const scene_source *source, duet_error *err)
{
    npy file = {.source = source, .path = source->name};
    size_t length = source->length < HEADER_MOST ? source->length : HEADER_MOST;
    unsigned char *begin = malloc(length + 1);
    bool ok = begin || no_memory(err, "%s", file.path);
    ok = ok && fetch(&file, 0, begin, length, err) && cut_parts(&file, begin, length, err) &&
         read_header(&file, err) && check_size(&file, scene, err) && add_objects(scene, &file, err);
    free(begin);
    return ok;
}
