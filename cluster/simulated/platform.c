// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // memfd_create
#include "cluster/simulated/platform.h"

#include "base/error.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

// CM02 has no factors of its own, and gamma 0 does not cut the bandwidth of long ways. A message
// between hosts passes two links.
static int print_platform(int file, const platform *p)
{
    return dprintf(file,
                   "<?xml version=\"1.0\"?>\n"
                   "<!DOCTYPE platform SYSTEM \"https://simgrid.org/simgrid.dtd\">\n"
                   "<platform version=\"4.1\">\n<config>\n"
                   "<prop id=\"network/model\" value=\"CM02\"/>\n"
                   "<prop id=\"network/TCP-gamma\" value=\"0\"/>\n"
                   "</config>\n<zone id=\"all\" routing=\"Full\">\n"
                   "<cluster id=\"hosts\" prefix=\"host\" suffix=\"\" radical=\"0-%u\" "
                   "speed=\"1Gf\" bw=\"%.9gBps\" lat=\"%.9gs\" loopback_bw=\"%.9gBps\" "
                   "loopback_lat=\"%.9gs\"/>\n</zone>\n</platform>\n",
                   p->hosts - 1, p->bytes_a_second, p->latency_s / 2, p->bytes_a_second,
                   p->latency_s);
}

bool platform_write(platform_file *f, const platform *p, duet_error *err)
{
    f->file = memfd_create("platform", MFD_CLOEXEC);
    if (f->file < 0 || print_platform(f->file, p) < 0) {
        platform_close(f);
        return error_set(err, DUET_STATUS_IO_FAILED, "a platform of %u hosts: %s", p->hosts,
                         strerror(errno));
    }
    snprintf(f->path, sizeof f->path, "/proc/self/fd/%d", f->file);
    return true;
}

void platform_close(platform_file *f)
{
    if (f->file >= 0)
        close(f->file);
    f->file = -1;
}
