// SPDX-License-Identifier: MIT
// Makes kernel text: a kernel with a config becomes a variant.
//
// A kernel is kernels/NAME.cl (or NAME.cl.in, a template) and its card
// kernels/NAME.lua, which says what may vary and which values are valid. The
// same kernel, config and limits give the same bytes on every machine.
#ifndef GEN_H
#define GEN_H

#include "base/error.h"

#include <stdbool.h>
#include <stdint.h>

// All kernels that can be generated, with a private Lua state that has no io,
// no os, and a memory and an instruction limit. Not for two threads at once.
typedef struct gen gen;

// kernel_dir: a folder with the kernels, cards and common.clh, or NULL for the
// carried ones.
gen *gen_open(const char *kernel_dir, duet_error *err);
void gen_close(gen *g);

// Adds a kernel that no file has, in the place of one of that name. Card and text are copied. All
// that was read of the kernels before is invalid.
bool gen_add(gen *g, const char *name, const char *card_text, const char *body, duet_error *err);

// Limits of a device, which decide which configs are valid.
typedef struct gen_limits {
    uint32_t max_group;
    uint64_t local_bytes;
    bool fp64;
    bool cpu;
    uint32_t units; // 0: few
} gen_limits;

// One parameter of a config.
typedef struct gen_setting {
    const char *name;
    int64_t value;
} gen_setting;

// An offer for a parameter, by a caller that makes several kernels. The last of several offers
// counts.
typedef enum gen_manner {
    GEN_REQUIRED, // the kernel must have the parameter
    GEN_OFFERED,  // a kernel that has it not is made without
    GEN_CAPPED,   // likewise; one whose greatest value is less takes that
} gen_manner;

typedef struct gen_offer {
    const char *kernel; // the one that it is for; NULL or empty: all of them
    const char *name;
    int64_t value;
    gen_manner manner;
    bool *taken; // becomes true if a kernel has the parameter; NULL: nobody asks
} gen_offer;

enum { GEN_NAME = 48, GEN_MAX_ARGS = 48 };

// Ways in which a kernel may use a buffer, each the less.
typedef enum gen_memory {
    GEN_WRITTEN,  // __global
    GEN_READ,     // __global const
    GEN_CONSTANT, // __constant const
} gen_memory;

// An argument of a kernel.
typedef struct gen_arg {
    char name[GEN_NAME];
    char type[24];     // type as the card writes it, with " *" behind it for a buffer: "real4 *"
    uint32_t bytes;    // bytes of a value under the config; 0: a buffer
    gen_memory memory; // of a buffer
    bool is_volatile, is_double; // is_double: real is double
    bool is_only;                // left out, it is no member of ARG_FIELDS either
} gen_arg;

// An entry point of a kernel: its arguments in the order of its parameters, and behind them those
// that its config leaves out.
typedef struct gen_entry {
    char name[GEN_NAME];
    gen_arg args[GEN_MAX_ARGS];
    uint32_t n_args;
    uint32_t n_fields; // with those left out
} gen_entry;

// How a kernel is launched along an axis.
typedef struct gen_axis {
    uint32_t group;    // work-items a group
    uint32_t per_item; // work-units a work-item
} gen_axis;

typedef struct gen_variant {
    char name[192];     // "pair_search_gpu.DIMS3.WG128.BUF512"
    char sha256[65];    // hash of the text, lower-case hex
    char *text;         // OpenCL C; owned, given back by gen_variant_free
    uint32_t group;     // work-group size that the card asks for
    uint32_t per_item;  // work-units (objects, pairs, cells) one work-item does
    uint32_t n_axes;    // that its launches have: 1, and up to 3 for a task's kernel
    gen_axis more[2];   // along the second and the third
    gen_entry *entries; // owned like text
    uint32_t n_entries;
} gen_variant;

// Parameters that settings leaves out take the card's default, which may
// depend on limits. BUILD_FAILED with file:line where the card or template is
// wrong, BAD_ARGUMENT if a parameter or value is unknown or the config is
// not valid: the line says what would be.
bool gen_make(gen *g, const char *kernel, const gen_setting *settings, uint32_t n_settings,
              const gen_limits *limits, gen_variant *variant, duet_error *err);
// The same with what the offers say of this kernel.
bool gen_make_offered(gen *g, const char *kernel, const gen_offer *offers, uint32_t n_offers,
                      const gen_limits *limits, gen_variant *variant, duet_error *err);
void gen_variant_free(gen_variant *variant);

// The kernels there are: NULL past the end.
const char *gen_kernel(const gen *g, uint32_t i);

// The folder that a file was read from, which a text's #line names "kernels/FILE"; NULL: it was
// carried or added.
const char *gen_folder(const gen *g, const char *file);

// Declarations of all built-in functions that the carried kernels call; NULL if some kernels
// are a folder's or were added, which may call others.
const char *gen_built_ins(const gen *g);

// A parameter that a kernel lets vary. The strings and values are the gen's.
typedef struct gen_param {
    const char *name;
    const char *about; // one line of the card
    int64_t fallback;  // the value if none is set
    const int64_t *values;
    uint32_t n_values;
    bool silent;         // at 0 it is neither in the text nor in the name
    bool is_range;       // any value from least to most may be set; values, if
    int64_t least, most; // there are some, are those that configs are made of
} gen_param;

bool gen_params(gen *g, const char *kernel, const gen_limits *limits, const gen_param **params,
                uint32_t *n_params, duet_error *err);

// The line of a card that says what its kernel does.
bool gen_about(gen *g, const char *kernel, const char **about, duet_error *err);

// Valid configs are numbered 0 .. count-1 in mixed radix order, the last
// parameter fastest; a range without values stays at its fallback. config must
// hold n_params settings.
bool gen_count(gen *g, const char *kernel, const gen_limits *limits, uint64_t *count,
               duet_error *err);
bool gen_config(gen *g, const char *kernel, const gen_limits *limits, uint64_t index,
                gen_setting *config, duet_error *err);

#endif
