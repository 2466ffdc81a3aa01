// SPDX-License-Identifier: MIT
#include "cli/frame_folder.h"

#include "base/error.h"

#include <errno.h>
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
