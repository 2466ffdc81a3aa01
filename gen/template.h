// SPDX-License-Identifier: MIT
// A kernel template (NAME.cl.in): kernel text whose shape is computed.
//
// Each template has a Lua state of its own, so that none can disturb another.
#ifndef GEN_TEMPLATE_H
#define GEN_TEMPLATE_H

#include "gen/card.h"

typedef struct template template;

// chars: the template. path: what Lua's messages call it. line_name: what the
// compiler's do; NULL for headers and a plain kernel, whose lines name their files.
// emit: modules gen/emit/NAME.lua that it finds as globals; NULL: none.
// BUILD_FAILED with path:line where it is no template.
template *template_open(const text *chars, const char *path, const char *line_name,
                        const card_names *emit, duet_error *err);

void template_close(template *t);

// Whether some line is Lua, so that the text is to be expanded.
bool template_has_lua(const text *chars);

// Appends the expanded text; every parameter is a global.
bool template_expand(template *t, const gen_setting *config, uint32_t n, text *out,
                     duet_error *err);

#endif
