// SPDX-License-Identifier: MIT
#include "cli/vtk/vtk_file.h"

#include "base/output.h"

#include <inttypes.h>
#include <string.h>

static const struct {
    const char *name;
    uint32_t size;
} types[] = {
    [VTK_FLOAT32] = {"Float32", 4},
    [VTK_FLOAT64] = {"Float64", 8},
    [VTK_INT64] = {"Int64", 8},
    [VTK_UINT8] = {"UInt8", 1},
};

static uint64_t bytes_of(const vtk_array *a)
{
    return a->n * a->components * types[a->type].size;
}

// ---------------------------------------------------------------- the head

void vtk_file_begin(FILE *to, const char *kind)
{
    const bool little = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
    fprintf(to,
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"%s\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\">\n",
            kind, little ? "LittleEndian" : "BigEndian");
}

void vtk_file_end(FILE *to)
{
    fputs("</VTKFile>\n", to);
}

// " ComponentName0="x" ComponentName1="y" ..."
static void write_labels(FILE *to, const char *labels)
{
    for (uint32_t k = 0; labels && *labels; ++k) {
        int length = (int)strcspn(labels, " ");
        fprintf(to, " ComponentName%" PRIu32 "=\"%.*s\"", k, length, labels);
        labels += length + (labels[length] == ' ');
    }
}

static void begin_declaration(FILE *to, const char *element, const vtk_array *a)
{
    fprintf(to, "<%s type=\"%s\" Name=\"%s\" NumberOfComponents=\"%" PRIu32 "\"", element,
            types[a->type].name, a->name, a->components);
    write_labels(to, a->labels);
}

// Whether array i is the first of its section, or with step 1 the last.
static bool is_at_border(const vtk_piece *p, uint32_t i, uint32_t step)
{
    uint32_t next = step > 0 ? i + 1 : i - 1;
    return next >= p->n || strcmp(p->arrays[next].section, p->arrays[i].section) != 0;
}

static void write_declarations(FILE *to, const vtk_piece *p)
{
    uint64_t offset = 0;
    for (uint32_t i = 0; i < p->n; ++i) {
        const char *section = p->arrays[i].section;
        if (is_at_border(p, i, 0))
            fprintf(to, "<%s>\n", section);
        begin_declaration(to, "DataArray", &p->arrays[i]);
        fprintf(to, " format=\"appended\" offset=\"%" PRIu64 "\"/>\n", offset);
        if (is_at_border(p, i, 1))
            fprintf(to, "</%s>\n", section);
        offset += sizeof offset + bytes_of(&p->arrays[i]);
    }
}

static void write_time(FILE *to, double time)
{
    fprintf(to,
            "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
            "format=\"ascii\">%.17g</DataArray>\n</FieldData>\n",
            time);
}

static void write_head(FILE *to, const vtk_piece *p)
{
    vtk_file_begin(to, p->kind);
    fprintf(to, "<%s>\n", p->kind);
    write_time(to, p->time);
    fprintf(to, "<Piece NumberOfPoints=\"%" PRIu64 "\" NumberOf%s=\"%" PRIu64 "\">\n", p->n_points,
            p->cells, p->n_cells);
    write_declarations(to, p);
    fprintf(to, "</Piece>\n</%s>\n", p->kind);
}

// ---------------------------------------------------------------- values

void vtk_write_int64(FILE *to, int64_t value)
{
    fwrite(&value, sizeof value, 1, to);
}

static void write_rows(FILE *to, const vtk_array *a)
{
    size_t size = (size_t)a->components * types[a->type].size;
    for (uint64_t i = 0; i < a->n; ++i)
        fwrite((const char *)a->rows + i * a->stride, size, 1, to);
}

static void write_numbers(FILE *to, const vtk_array *a)
{
    for (uint64_t i = 0; i < a->n; ++i)
        vtk_write_int64(to, a->first + (int64_t)i * a->step);
}

static void write_values(FILE *to, const vtk_piece *p)
{
    fputs("<AppendedData encoding=\"raw\">\n_", to);
    for (uint32_t i = 0; i < p->n; ++i) {
        uint64_t bytes = bytes_of(&p->arrays[i]);
        fwrite(&bytes, sizeof bytes, 1, to);
        if (p->arrays[i].write)
            p->arrays[i].write(to, p->of);
        else
            (p->arrays[i].rows ? write_rows : write_numbers)(to, &p->arrays[i]);
    }
    fputs("\n</AppendedData>\n", to);
}

bool vtk_file_write(const char *path, const vtk_piece *piece, duet_error *err)
{
    output o;
    bool ok = output_open(&o, path, err);
    if (ok) {
        write_head(o.stream, piece);
        write_values(o.stream, piece);
        vtk_file_end(o.stream);
    }
    return output_close(&o, ok, err);
}

// ---------------------------------------------------------------- files of pieces

static bool is_of_cells(const vtk_array *a)
{
    return strcmp(a->section, "Cells") == 0;
}

static void write_pieces(FILE *to, const vtk_piece *p, const char *stem, uint32_t n)
{
    fprintf(to, "<P%s GhostLevel=\"0\">\n", p->kind);
    write_time(to, p->time);
    for (uint32_t i = 0; i < p->n && !is_of_cells(&p->arrays[i]); ++i) {
        if (is_at_border(p, i, 0))
            fprintf(to, "<P%s>\n", p->arrays[i].section);
        begin_declaration(to, "PDataArray", &p->arrays[i]);
        fputs("/>\n", to);
        if (is_at_border(p, i, 1))
            fprintf(to, "</P%s>\n", p->arrays[i].section);
    }
    for (uint32_t k = 0; k < n; ++k)
        fprintf(to, "<Piece Source=\"%s_%" PRIu32 ".vtu\"/>\n", stem, k);
    fprintf(to, "</P%s>\n", p->kind);
}

bool vtk_file_write_parallel(const char *path, const vtk_piece *piece, const char *stem, uint32_t n,
                             duet_error *err)
{
    output o;
    char kind[64];
    bool ok = output_open(&o, path, err);
    snprintf(kind, sizeof kind, "P%s", piece->kind);
    if (ok) {
        vtk_file_begin(o.stream, kind);
        write_pieces(o.stream, piece, stem, n);
        vtk_file_end(o.stream);
    }
    return output_close(&o, ok, err);
}
