// SPDX-License-Identifier: MIT
// A file is a magic, a version, the length of the header, the header, which is a
// Python literal padded so that the values begin on 64 bytes, and the values.
#include "base/npy.h"

#include "base/text_file.h"

#include <inttypes.h>

enum { PREFIX = 10, ALIGNMENT = 64 };

static const struct {
    const char *little, *big;
    size_t bytes;
} types[] = {
    [NPY_UINT8] = {"|u1", "|u1", 1},
    [NPY_FLOAT64] = {"<f8", ">f8", 8},
    [NPY_UINT64] = {"<u8", ">u8", 8},
};

static const char *name_here(npy_type type)
{
    const uint16_t one = 1;
    return *(const unsigned char *)&one == 1 ? types[type].little : types[type].big;
}

void npy_add_header(text *file, npy_type type, uint64_t rows, uint32_t columns)
{
    text literal = {0};
    text_add(&literal, "{'descr': '%s', 'fortran_order': False, 'shape': (%" PRIu64 ",",
             name_here(type), rows);
    if (columns > 0)
        text_add(&literal, " %" PRIu32, columns);
    text_add(&literal, "), }");
    size_t used = PREFIX + literal.length + 1; // a newline ends it
    size_t padding = (ALIGNMENT - used % ALIGNMENT) % ALIGNMENT;
    size_t length = literal.length + padding + 1;
    const char begin[PREFIX] = {
        '\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0, (char)(length & 255), (char)(length >> 8)};
    text_add_bytes(file, begin, PREFIX);
    text_add(file, "%s%*s\n", text_chars(&literal), (int)padding, "");
    file->failed |= literal.failed;
    text_free(&literal);
}

bool npy_write(const char *path, npy_type type, const void *values, uint64_t n, duet_error *err)
{
    text file = {0};
    npy_add_header(&file, type, n, 0);
    text_add_bytes(&file, values, n * types[type].bytes);
    bool ok = text_ok(&file, err) && text_write_file(path, file.chars, file.length, err);
    text_free(&file);
    return ok;
}
