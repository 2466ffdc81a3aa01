// SPDX-License-Identifier: MIT
#include "cli/frames.h"

#include "base/error.h"
#include "cli/draw/snapshot.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>
#include <sys/stat.h>

enum { FRAMES_A_SECOND = 30 };

bool frame_folder_make(const char *folder, duet_error *err)
{
    return mkdir(folder, 0777) == 0 || errno == EEXIST ||
           error_set(err, DUET_STATUS_IO_FAILED, "--frames: the folder %s cannot be made: %s",
                     folder, strerror(errno));
}

bool frame_is_due(uint64_t n, double time)
{
    return time * FRAMES_A_SECOND >= (double)n;
}

bool frames_format_named(const char *name, frames_format *format)
{
    static const char *const names[] = {[FRAMES_PNG] = "png", [FRAMES_VTU] = "vtu"};
    for (int i = FRAMES_PNG; i <= FRAMES_VTU; ++i)
        if (strcmp(name, names[i]) == 0) {
            *format = (frames_format)i;
            return true;
        }
    return false;
}

bool frames_begin(frames *f, const char *folder, frames_format format, duet_motion *motion,
                  const struct snapshot *pictures, duet_error *err)
{
    f->folder = folder;
    f->format = format;
    f->motion = motion;
    f->pictures = pictures;
    if (folder && format == FRAMES_VTU)
        vtk_frames_begin(&f->vtk, folder, motion);
    return !folder || frame_folder_make(folder, err);
}

static bool add_picture(frames *f, double time, duet_error *err)
{
    text path = {0};
    text_add(&path, "%s/%05" PRIu64 ".png", f->folder, f->n);
    bool ok =
        text_ok(&path, err) && snapshot_frame(f->pictures, text_chars(&path), f->motion, time, err);
    text_free(&path);
    return ok;
}

bool frames_add(frames *f, double time, duet_error *err)
{
    if (!f->folder || !frame_is_due(f->n, time))
        return true;
    bool ok =
        f->format == FRAMES_PNG ? add_picture(f, time, err) : vtk_frames_add(&f->vtk, time, err);
    ++f->n;
    return ok;
}

void frames_end(frames *f)
{
    vtk_frames_end(&f->vtk);
}
