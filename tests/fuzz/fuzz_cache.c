// SPDX-License-Identifier: MIT
// Entries of the cache of built kernels: what comes out is what was put in, and
// an entry of another's making only where its line says truly what follows.
#include "support/fuzz.h"

#include "runtime/opencl/cache.h"

#include <sha256.h>
#include <stdio.h>
#include <string.h>

static const char key[65] = "00000000000000000000000000000000000000000000000000000000000000fe";

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t n, size_t most, unsigned seed);

static size_t line_length(const uint8_t *data, size_t n)
{
    const uint8_t *end = n > 0 ? memchr(data, '\n', n) : NULL;
    return end ? (size_t)(end - data) + 1 : 0;
}

// Every other change is signed again, or no changed entry would be taken.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t n, size_t most, unsigned seed)
{
    n = LLVMFuzzerMutate(data, n, most);
    size_t begin = line_length(data, n);
    char sum[65], line[256];
    SHA256Data(data + begin, n - begin, sum);
    size_t length =
        (size_t)snprintf(line, sizeof line, "duet program 1 %s %zu %s\n", key, n - begin, sum);
    if (seed % 2 || length + n - begin > most)
        return n;
    memmove(data + length, data + begin, n - begin);
    memcpy(data, line, length);
    return length + n - begin;
}

static void require_entry(const uint8_t *data, size_t n, const text *found)
{
    size_t begin = line_length(data, n);
    char sum[65];
    fuzz_require(begin > 64 && found->length == n - begin);
    fuzz_require(memcmp(found->chars, data + begin, n - begin) == 0);
    SHA256Data(data + begin, n - begin, sum);
    fuzz_require(memcmp(data + begin - 65, sum, 64) == 0);
}

void fuzz_one(const uint8_t *data, size_t n)
{
    char name[80];
    text found = {0}, back = {0};
    snprintf(name, sizeof name, "%s.bin", key);
    fuzz_file(name, data, n);
    if (cache_get(fuzz_folder(), key, &found))
        require_entry(data, n, &found);
    fuzz_require(cache_put(fuzz_folder(), key, (const char *)data, n));
    fuzz_require(cache_get(fuzz_folder(), key, &back));
    fuzz_require(back.length == n && (n == 0 || memcmp(back.chars, data, n) == 0));
    text_free(&found);
    text_free(&back);
}
