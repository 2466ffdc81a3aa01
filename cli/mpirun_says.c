// SPDX-License-Identifier: MIT
// Open MPI's own lines begin with "[host:pid] ", "[host][[job,rank],..." or "mpirun: ", or stand
// between two lines of dashes. They come in between those of ranks, and behind progress that has no
// line's end. Lines that begin with "duet" are of ranks, wherever they come.
#include "cli/mpirun_says.h"

#include "base/visible.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

// States: the first bytes of a line, and what it then is.
enum { BEGINS, PASSES, IS_OURS, MAY_BE_MPIS, IS_MPIS };

typedef enum verdict { NO, MAYBE, YES } verdict;

// How lines of ranks begin, and what clears a line of progress: of one length.
static const char ours[] = "duet", clear[] = "\r\033[K";
static const char own_name[] = "mpirun: ";

enum { MARK = sizeof ours - 1, RULE = 40 }; // dashes; Open MPI's lines have more

// ---------------------------------------------------------------- what a line is

static verdict is_rule(const char *line, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        if (line[i] != '-')
            return NO;
    return n < RULE ? MAYBE : YES;
}

// "[name:12] " or "[name][[".
static verdict is_tagged(const char *line, size_t n)
{
    size_t i = 1, digits = 0;
    while (i < n && (isalnum((unsigned char)line[i]) || memchr("._-", line[i], 3)))
        ++i;
    if (i == n)
        return MAYBE;
    if (i == 1)
        return NO;
    const char *rest = line + i;
    size_t left = n - i;
    if (*rest == ']')
        return strncmp(rest, "][[", left < 3 ? left : 3) != 0 ? NO : left < 3 ? MAYBE : YES;
    while (1 + digits < left && isdigit((unsigned char)rest[1 + digits]))
        ++digits;
    const char *end = rest + 1 + digits;
    left -= 1 + digits;
    if (*rest != ':' || (left > 0 && digits == 0))
        return NO;
    return strncmp(end, "] ", left < 2 ? left : 2) != 0 ? NO : left < 2 ? MAYBE : YES;
}

// As mpirun tells of signals.
static verdict is_named(const char *line, size_t n)
{
    size_t all = sizeof own_name - 1;
    return strncmp(line, own_name, n < all ? n : all) != 0 ? NO : n < all ? MAYBE : YES;
}

static verdict is_mpis(const char *line, size_t n)
{
    if (n == MPIRUN_LINE)
        return NO;
    return (*line == '[' ? is_tagged : *line == '-' ? is_rule : is_named)(line, n);
}

// ---------------------------------------------------------------- what a line tells

// What others say, ssh for one, is nearer to the cause than MPI's blocks.
static void keep_why(mpirun_says *s, size_t n)
{
    if (*s->why && (s->in_block || !s->why_is_of_block))
        return;
    memcpy(s->why, s->line, n + 1);
    visible_line(s->why, sizeof s->why);
    s->why_is_of_block = s->in_block;
}

static void learn(mpirun_says *s)
{
    s->line[s->n < MPIRUN_LINE ? s->n : MPIRUN_LINE - 1] = '\0';
    size_t n = strlen(s->line);
    const char *noticed = strstr(s->line, "noticed that process rank ");
    const char *lost = strstr(s->line, "Remote daemon: [["), *node = strstr(s->line, "] on node ");
    if (noticed && !s->names_rank)
        s->names_rank = sscanf(noticed, "noticed that process rank %lu with PID %*u on node %255s",
                               &s->rank, s->host) == 2;
    else if (lost && node && !*s->host)
        sscanf(node, "] on node %255s", s->host);
    visible_line(s->host, sizeof s->host);
    if (!*s->peer)
        sscanf(s->line, " Peer host: %255s", s->peer);
    visible_line(s->peer, sizeof s->peer);
    if (is_rule(s->line, n) == YES)
        s->in_block = !s->in_block;
    else if (!s->begun && n > 0 && is_mpis(s->line, n) != YES)
        keep_why(s, n);
}

// ---------------------------------------------------------------- byte by byte

static void hold(mpirun_says *s, char byte)
{
    if (s->n < MPIRUN_LINE)
        s->line[s->n++] = byte;
}

static void let_out(mpirun_says *s, size_t n, text *out)
{
    if (!s->passes_all)
        text_add_bytes(out, s->line, n);
    memmove(s->line, s->line + n, s->n - n);
    s->n -= n;
}

static bool is_for_nobody(const mpirun_says *s)
{
    return s->in_block || !s->begun;
}

// A line that is no rule goes out up to the next '[' or 'm'.
static void judge_inside(mpirun_says *s, text *out)
{
    verdict v = s->state == MAY_BE_MPIS ? is_mpis(s->line, s->n) : NO;
    if (v == YES)
        s->state = IS_MPIS;
    if (v != NO)
        return;
    char last = s->line[s->n - 1];
    size_t opens = last == '[' || last == *own_name;
    let_out(s, s->n - opens, out);
    s->state = opens ? MAY_BE_MPIS : PASSES;
}

static void judge_begin(mpirun_says *s, text *out)
{
    bool may_be_ours = strncmp(s->line, ours, s->n) == 0;
    if (may_be_ours || strncmp(s->line, clear, s->n) == 0) {
        s->state = may_be_ours && s->n == MARK ? IS_OURS : BEGINS;
        if (s->n == MARK)
            let_out(s, MARK, out);
    } else if (is_for_nobody(s) && *s->line != '\r') {
        s->state = IS_MPIS;
    } else {
        s->state = *s->line == '-' || *s->line == *own_name ? MAY_BE_MPIS : PASSES;
        judge_inside(s, out);
    }
}

// A line of progress ends where the next one clears it.
static void end_line(mpirun_says *s, char byte, text *out)
{
    bool is_blank = s->state == BEGINS && (s->n == 0 || *s->line == '\r');
    if (s->state == IS_MPIS)
        learn(s);
    if (s->state == IS_MPIS || (is_blank && is_for_nobody(s)))
        s->n = 0;
    else if (byte == '\n')
        hold(s, byte);
    let_out(s, s->n, out);
    s->state = BEGINS;
    if (byte == '\r')
        hold(s, byte);
}

static void hear_byte(mpirun_says *s, char byte, text *out)
{
    if (byte == '\n' || byte == '\r') {
        end_line(s, byte, out);
        return;
    }
    hold(s, byte);
    if (s->state == BEGINS)
        judge_begin(s, out);
    else if (s->state == IS_OURS)
        let_out(s, s->n, out);
    else if (s->state != IS_MPIS)
        judge_inside(s, out);
}

void mpirun_hear(mpirun_says *s, const char *bytes, size_t n, text *out)
{
    for (size_t i = 0; i < n; ++i) {
        if (bytes[i] == *MPIRUN_BEGUN) {
            s->begun = true;
            continue;
        }
        if (bytes[i] == *MPIRUN_STOPPED) {
            s->stopped = true;
            continue;
        }
        if (bytes[i] == '\0') // with which Open MPI 5 ends its blocks
            continue;
        if (s->passes_all)
            text_add_bytes(out, &bytes[i], 1);
        hear_byte(s, bytes[i], out);
    }
}

void mpirun_hear_end(mpirun_says *s, text *out)
{
    if (s->state == IS_MPIS)
        learn(s);
    else
        let_out(s, s->n, out);
    *s->line = '\0';
    s->n = 0;
    s->state = BEGINS;
}
