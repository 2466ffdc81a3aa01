// SPDX-License-Identifier: MIT
// A VTK XML file: a head of XML that says which arrays there are, and their values behind it as
// raw bytes, each array's behind 8 bytes with its length. VTK and ParaView read it.
//
//     <VTKFile ...> ... <DataArray Name="id" offset="0"/> ... <AppendedData>_ LENGTH VALUES ...
//
#ifndef CLI_VTK_FILE_H
#define CLI_VTK_FILE_H

#include "duet_error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef enum vtk_type { VTK_FLOAT32, VTK_FLOAT64, VTK_INT64, VTK_UINT8 } vtk_type;

// n rows of values, which lie `stride` bytes apart in memory, which `write` makes, or else the
// numbers `first`, `first + step` and so on.
typedef struct vtk_array {
    const char *section; // "CellData"; arrays of one follow each other
    const char *name;
    vtk_type type;
    uint32_t components; // a row has
    const char *labels;  // the components' names: "x y z"; NULL: none
    uint64_t n;
    const void *rows;
    size_t stride;
    void (*write)(FILE *to, const void *of);
    int64_t first, step;
} vtk_array;

typedef struct vtk_piece {
    const char *kind; // "UnstructuredGrid"
    uint64_t n_points;
    const char *cells; // what they are: "Cells", "Verts"
    uint64_t n_cells;
    double time;
    const vtk_array *arrays; // [n]
    uint32_t n;
    const void *of; // the argument of `write`
} vtk_piece;

bool vtk_file_write(const char *path, const vtk_piece *piece, duet_error *err);

// A file that names n files of pieces, STEM_0.vtu and so on, each with the arrays of `piece`.
bool vtk_file_write_parallel(const char *path, const vtk_piece *piece, const char *stem, uint32_t n,
                             duet_error *err);

// Begins a file of that kind, as every file of VTK begins; vtk_file_end ends it.
void vtk_file_begin(FILE *to, const char *kind);
void vtk_file_end(FILE *to);

void vtk_write_int64(FILE *to, int64_t value);

#endif
