// SPDX-License-Identifier: MIT
#include "runtime/task/task.h"

#include "base/text_file.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/program.h"

#include <sha256.h>
#include <string.h>

// The files of a kernel in a folder: one that is not there counts as empty.
static void hash_file(SHA2_CTX *sha, const char *folder, const char *name, const char *end)
{
    text path = {0}, bytes = {0};
    text_add(&path, "%s/%s%s", folder, name, end);
    if (text_ok(&path, NULL) && text_read_file(&bytes, path.chars, NULL))
        SHA256Update(sha, (const uint8_t *)bytes.chars, bytes.length);
    text_free(&path);
    text_free(&bytes);
}

static void hash_files(SHA2_CTX *sha, const char *folder, const char *name)
{
    static const char *const ends[] = {".lua", ".cl", ".cl.in"};
    for (size_t i = 0; folder && i < sizeof ends / sizeof *ends; ++i)
        hash_file(sha, folder, name, ends[i]);
}

static void hash_kernel(SHA2_CTX *sha, const task *t, const duet_device_pair *pair)
{
    for (uint32_t i = 0; i < t->n_kernels; ++i) {
        const task_kernel *k = &t->kernels[i];
        if (strcmp(k->name, t->kernel) != 0)
            continue;
        SHA256Update(sha, (const uint8_t *)k->card, strlen(k->card));
        SHA256Update(sha, (const uint8_t *)k->text, strlen(k->text));
        return;
    }
    hash_files(sha, task_kernel_dir(t, pair), t->kernel);
}

bool task_kernel_hash(const task *t, const duet_device_pair *pair, char hash[65], duet_error *err)
{
    gen_limits limits = program_limits(&pair->devices[1].info);
    gen *g = gen_open(task_kernel_dir(t, pair), err);
    gen_variant v = {0};
    bool ok = g && task_add_kernels(t, g, err) && gen_make(g, t->kernel, NULL, 0, &limits, &v, err);
    if (ok) {
        SHA2_CTX sha;
        SHA256Init(&sha);
        SHA256Update(&sha, (const uint8_t *)v.sha256, strlen(v.sha256));
        hash_kernel(&sha, t, pair);
        SHA256End(&sha, hash);
    }
    gen_variant_free(&v);
    gen_close(g);
    return ok;
}
