// SPDX-License-Identifier: MIT
// Charts as inline SVG, for a page: points over x, and bars of stages. Colours
// are the page's, so that they follow light and dark.
#ifndef CLI_CHART_H
#define CLI_CHART_H

#include "base/text.h"

#include <stdbool.h>
#include <stdint.h>

enum { CHART_SERIES_MOST = 8 };

typedef struct chart_point {
    double x;
    double y;
    char says[96]; // where a person points at it
} chart_point;

typedef struct chart_series {
    const char *name;
    const char *colour;        // of the page: "a", "b", "step", "s0"
    const chart_point *points; // a line goes through them in this order
    uint32_t n;
    bool loose; // no line
} chart_series;

typedef struct chart {
    const char *title;
    const char *x_label;
    const char *y_label; // y begins at 0
    bool counted;        // x counts things: no ticks between whole numbers
    bool marked;
    double mark; // a line up from this x
    chart_series series[CHART_SERIES_MOST];
    uint32_t n_series;
} chart;

// x goes from its least to its greatest; series without points are passed over.
void chart_draw(text *page, const chart *c);

// A bar cut into stages.
typedef struct chart_part {
    const char *name;
    double value;
    uint32_t colour; // s0 to s11
} chart_part;

typedef struct chart_bars {
    text *page;
    double most; // value as long as the chart is wide
    const char *unit;
    double y;
} chart_bars;

// Space for n_rows rows of two bars each.
chart_bars chart_bars_begin(text *page, const char *title, double most, const char *unit,
                            uint32_t n_rows);
void chart_bars_row(chart_bars *bars, const char *label);
void chart_bar(chart_bars *bars, const char *label, const chart_part *parts, uint32_t n);
void chart_bars_end(chart_bars *bars);

#endif
