// SPDX-License-Identifier: MIT
#include "cli/vtk/vtk_series.h"

#include "base/output.h"
#include "cli/vtk/vtk_file.h"

#include <inttypes.h>

const char *vtk_series_next(vtk_series *s, duet_error *err)
{
    text_free(&s->path);
    text_add(&s->path, "%s/%s_%05" PRIu64 ".%s", s->folder, s->name, s->n, s->ending);
    return text_ok(&s->path, err) ? text_chars(&s->path) : NULL;
}

static void write_entries(FILE *to, const text *entries)
{
    vtk_file_begin(to, "Collection");
    fprintf(to, "<Collection>\n%s</Collection>\n", text_chars(entries));
    vtk_file_end(to);
}

bool vtk_series_add(vtk_series *s, double time, duet_error *err)
{
    output o;
    text_add(&s->entries, "<DataSet timestep=\"%.17g\" file=\"%s_%05" PRIu64 ".%s\"/>\n", time,
             s->name, s->n++, s->ending);
    text_free(&s->path);
    text_add(&s->path, "%s/%s.pvd", s->folder, s->name);
    if (!text_ok(&s->entries, err) || !text_ok(&s->path, err))
        return false;
    bool ok = output_open(&o, text_chars(&s->path), err);
    if (ok)
        write_entries(o.stream, &s->entries);
    return output_close(&o, ok, err);
}

void vtk_series_free(vtk_series *s)
{
    text_free(&s->path);
    text_free(&s->entries);
}
