// SPDX-License-Identifier: MIT
#include "cli/draw/chart.h"

#include "cli/draw/page.h"

#include <math.h>
#include <stdio.h>

// The frame of a chart in the units of its viewBox.
static const double width = 400;
static const double height = 250;
static const double left = 48;
static const double right = 388;
static const double top = 14;
static const double bottom = 208;

typedef struct scale {
    double low;
    double high;
    double step; // between ticks
} scale;

// About five ticks at 1, 2 or 5 times a power of ten.
static double step_for(double span)
{
    double rough = span / 5;
    double power = pow(10, floor(log10(rough)));
    double times = rough / power;
    return power * (times <= 1 ? 1 : times <= 2 ? 2 : times <= 5 ? 5 : 10);
}

static void find_scales(const chart *c, scale *x, scale *y)
{
    *x = (scale){INFINITY, -INFINITY, 0};
    *y = (scale){0, 0, 0};
    for (uint32_t s = 0; s < c->n_series; ++s)
        for (uint32_t i = 0; i < c->series[s].n; ++i) {
            const chart_point *p = &c->series[s].points[i];
            x->low = fmin(x->low, p->x);
            x->high = fmax(x->high, p->x);
            y->high = fmax(y->high, p->y);
        }
    if (c->marked) {
        x->low = fmin(x->low, c->mark);
        x->high = fmax(x->high, c->mark);
    }
    if (!(x->high > x->low)) {
        x->low -= 0.5;
        x->high += 0.5;
    }
    y->high = y->high > 0 ? y->high * 1.05 : 1;
    x->step = fmax(step_for(x->high - x->low), c->counted ? 1 : 0);
    y->step = step_for(y->high);
}

static double x_at(const scale *s, double x)
{
    return left + (right - left) * (x - s->low) / (s->high - s->low);
}

static double y_at(const scale *s, double y)
{
    return bottom - (bottom - top) * (y - s->low) / (s->high - s->low);
}

static void draw_x_axis(text *page, const scale *s, const char *label)
{
    for (double at = ceil(s->low / s->step - 1e-9) * s->step; at <= s->high + 1e-9 * s->step;
         at += s->step) {
        text_add(page,
                 "<line class=\"axis\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>"
                 "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.6g</text>\n",
                 x_at(s, at), bottom, x_at(s, at), bottom + 4, x_at(s, at), bottom + 17,
                 fabs(at) < 1e-9 * s->step ? 0 : at);
    }
    text_add(page, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", (left + right) / 2,
             height - 6);
    page_words(page, "%s", label);
    text_add(page, "</text>\n");
}

static void draw_y_axis(text *page, const scale *s, const char *label)
{
    for (int i = 0; i * s->step <= s->high; ++i) {
        double at = i * s->step;
        text_add(page,
                 "<line class=\"axis\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>"
                 "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%.6g</text>\n",
                 left, y_at(s, at), right, y_at(s, at), left - 5, y_at(s, at) + 4, at);
    }
    text_add(page,
             "<text x=\"12\" y=\"%.1f\" text-anchor=\"middle\" transform=\"rotate(-90 12 %.1f)\">",
             (top + bottom) / 2, (top + bottom) / 2);
    page_words(page, "%s", label);
    text_add(page, "</text>\n");
}

static void draw_series(text *page, const chart_series *s, const scale *x, const scale *y)
{
    if (!s->loose) {
        text_add(page, "<polyline stroke=\"var(--%s)\" points=\"", s->colour);
        for (uint32_t i = 0; i < s->n; ++i)
            text_add(page, "%.1f,%.1f ", x_at(x, s->points[i].x), y_at(y, s->points[i].y));
        text_add(page, "\"/>\n");
    }
    for (uint32_t i = 0; i < s->n; ++i) {
        text_add(page, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%s\" fill=\"var(--%s)\"><title>",
                 x_at(x, s->points[i].x), y_at(y, s->points[i].y), s->loose ? "2" : "3", s->colour);
        page_words(page, "%s", s->points[i].says);
        text_add(page, "</title></circle>\n");
    }
}

static void draw_key(text *page, const char *colour, const char *name)
{
    text_add(page, "<span class=\"key\"><i style=\"background:var(--%s)\"></i>", colour);
    page_words(page, "%s", name);
    text_add(page, "</span>");
}

static void draw_caption(text *page, const char *title)
{
    text_add(page, "<figure><figcaption>");
    page_words(page, "%s", title);
    text_add(page, "</figcaption>\n");
}

static void draw_frame(text *page, const char *title, double tall)
{
    text_add(page, "<svg class=\"chart\" viewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"",
             width, tall);
    page_words(page, "%s", title);
    text_add(page, "\">\n");
}

void chart_draw(text *page, const chart *c)
{
    scale x;
    scale y;
    find_scales(c, &x, &y);
    draw_caption(page, c->title);
    for (uint32_t i = 0; i < c->n_series; ++i)
        if (c->series[i].n > 0)
            draw_key(page, c->series[i].colour, c->series[i].name);
    draw_frame(page, c->title, height);
    draw_x_axis(page, &x, c->x_label);
    draw_y_axis(page, &y, c->y_label);
    if (c->marked)
        text_add(page,
                 "<line stroke=\"var(--mark)\" stroke-dasharray=\"4 3\" x1=\"%.1f\" y1=\"%.1f\" "
                 "x2=\"%.1f\" y2=\"%.1f\"/>\n",
                 x_at(&x, c->mark), top, x_at(&x, c->mark), bottom);
    for (uint32_t i = 0; i < c->n_series; ++i)
        if (c->series[i].n > 0)
            draw_series(page, &c->series[i], &x, &y);
    text_add(page, "</svg></figure>\n");
}

// ---------------------------------------------------------------- bars

static const double bar_height = 8;
static const double row_height = 40;

chart_bars chart_bars_begin(text *page, const char *title, double most, const char *unit,
                            uint32_t n_rows)
{
    draw_caption(page, title);
    draw_frame(page, title, row_height * n_rows + 6);
    return (chart_bars){.page = page, .most = most > 0 ? most : 1, .unit = unit};
}

void chart_bars_row(chart_bars *bars, const char *label)
{
    text_add(bars->page, "<text x=\"2\" y=\"%.1f\">", bars->y + 14);
    page_words(bars->page, "%s", label);
    text_add(bars->page, "</text>\n");
    bars->y += 18;
}

void chart_bar(chart_bars *bars, const char *label, const chart_part *parts, uint32_t n)
{
    double x = 16;
    text_add(bars->page, "<text x=\"2\" y=\"%.1f\">", bars->y + bar_height);
    page_words(bars->page, "%s", label);
    text_add(bars->page, "</text>\n");
    for (uint32_t i = 0; i < n; ++i) {
        double wide = (width - 18) * parts[i].value / bars->most;
        text_add(bars->page,
                 "<rect x=\"%.2f\" y=\"%.1f\" width=\"%.2f\" height=\"%.1f\" "
                 "fill=\"var(--s%u)\"><title>",
                 x, bars->y, wide, bar_height, parts[i].colour);
        page_words(bars->page, "%s: %.3f %s", parts[i].name, parts[i].value, bars->unit);
        text_add(bars->page, "</title></rect>\n");
        x += wide;
    }
    bars->y += bar_height + 3;
}

void chart_bars_end(chart_bars *bars)
{
    text_add(bars->page, "</svg></figure>\n");
}
