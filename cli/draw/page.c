// SPDX-License-Identifier: MIT
#include "cli/draw/page.h"

#include "base/visible.h"

#include <stdio.h>
#include <string.h>

// A bar's colour is s0 to s11; the rest are roles: a and b for the devices.
static const char style[] =
    ":root{--paper:#fff;--ink:#1d2430;--dim:#5d6878;--line:#d5dbe3;--card:#f6f8fa;--a:#1f6fc4;"
    "--b:#d1600a;--step:#2d3646;--mark:#b3122f;--s0:#4e79a7;--s1:#f28e2b;--s2:#59a14f;"
    "--s3:#e15759;--s4:#76b7b2;--s5:#b59a1d;--s6:#b07aa1;--s7:#ff9da7;--s8:#9c755f;--s9:#8f8a87;"
    "--s10:#2f8f9d;--s11:#7a5cc0}\n"
    "@media(prefers-color-scheme:dark){:root{--paper:#14181f;--ink:#e3e8ef;--dim:#9aa6b6;"
    "--line:#333c49;--card:#1b212a;--a:#6cb0f5;--b:#f59a52;--step:#d6dde8;--mark:#ff6b81}}\n"
    "*{box-sizing:border-box}\n"
    "body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,sans-serif}\n"
    "main{max-width:1200px;margin:0 auto;padding:16px}\n"
    "h1{font-size:1.6rem;margin:.4em 0}h2{font-size:1.2rem;margin:1.8em 0 .5em;"
    "border-bottom:1px solid var(--line)}\n"
    "p{margin:.4em 0;color:var(--dim);overflow-wrap:anywhere}\n"
    ".wide{overflow-x:auto}table{border-collapse:collapse;font-size:.85rem;white-space:nowrap}\n"
    "th,td{padding:.25em .7em;border-bottom:1px solid var(--line);text-align:left}\n"
    "th{color:var(--dim);font-weight:600}.r{text-align:right;font-variant-numeric:tabular-nums}\n"
    ".charts{display:grid;gap:14px;grid-template-columns:repeat(auto-fill,minmax(min(340px,100%),"
    "1fr));align-items:start}\n"
    "figure{margin:0;padding:10px;background:var(--card);border:1px solid var(--line);"
    "border-radius:8px}\n"
    "figcaption{font-size:.85rem;overflow-wrap:anywhere}\n"
    ".key{display:inline-block;margin-right:.9em;white-space:nowrap;font-size:.8rem}\n"
    ".key i{display:inline-block;width:.8em;height:.8em;margin-right:.3em;border-radius:2px}\n"
    "svg{display:block;width:100%;height:auto;margin-top:6px}\n"
    "svg text{fill:var(--dim);font:11px system-ui,sans-serif}\n"
    "svg .name{fill:var(--ink)}svg .axis{stroke:var(--line)}svg "
    "polyline{fill:none;stroke-width:2}\n";

void page_words(text *page, const char *format, ...)
{
    char words[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(words, sizeof words, format, args);
    va_end(args);
    text shown = {0};
    visible_add(&shown, words, strlen(words), "\n\t");
    for (const char *c = text_chars(&shown); *c; ++c) {
        static const char special[] = "&<>\"";
        static const char *const entities[] = {"&amp;", "&lt;", "&gt;", "&quot;"};
        const char *found = strchr(special, *c);
        if (found)
            text_add(page, "%s", entities[found - special]);
        else
            text_add_bytes(page, c, 1);
    }
    text_free(&shown);
}

void page_begin(text *page, const char *title)
{
    text_add(page, "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                   "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
                   "<meta name=\"color-scheme\" content=\"light dark\">\n<title>");
    page_words(page, "%s", title);
    text_add(page, "</title>\n<style>\n%s</style></head>\n<body><main>\n<h1>", style);
    page_words(page, "%s", title);
    text_add(page, "</h1>\n");
}

void page_end(text *page)
{
    text_add(page, "</main></body></html>\n");
}

void page_section(text *page, const char *heading)
{
    text_add(page, "<section><h2>");
    page_words(page, "%s", heading);
    text_add(page, "</h2>\n");
}

void page_section_end(text *page)
{
    text_add(page, "</section>\n");
}

void page_paragraph(text *page, const char *format, ...)
{
    char words[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(words, sizeof words, format, args);
    va_end(args);
    text_add(page, "<p>");
    page_words(page, "%s", words);
    text_add(page, "</p>\n");
}

void page_charts(text *page)
{
    text_add(page, "<div class=\"charts\">\n");
}

void page_charts_end(text *page)
{
    text_add(page, "</div>\n");
}

page_table page_table_begin(text *page, const char *align)
{
    text_add(page, "<div class=\"wide\"><table>\n");
    return (page_table){.page = page, .align = align};
}

void page_cell(page_table *t, const char *format, ...)
{
    char words[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(words, sizeof words, format, args);
    va_end(args);
    size_t columns = strlen(t->align);
    size_t column = t->n % columns;
    const char *tag = t->n < columns ? "th" : "td";
    text_add(t->page, "%s<%s%s>", column == 0 ? "<tr>" : "", tag,
             t->align[column] == 'r' ? " class=\"r\"" : "");
    page_words(t->page, "%s", words);
    text_add(t->page, "</%s>%s", tag, column + 1 == columns ? "</tr>\n" : "");
    ++t->n;
}

void page_table_end(page_table *t)
{
    text_add(t->page, "</table></div>\n");
}
