// SPDX-License-Identifier: MIT
#include "support/scene_file.h"
#include "support/test.h"

#include "base/text_file.h"

const char scene_of_sliding_boxes[] =
    "add { centre = { 0, 0, -1 }, half_extents = { 60, 60, 1 }, mass = 0, friction = 0.5 }\n"
    "for i = 1, 24 do\n"
    "  add { centre = { i % 6 * 4, i // 6 * 4, 0.5 }, half_extents = { 0.5, 0.5, 0.5 },\n"
    "        velocity = { 1, 0, 0 }, friction = 0.5 }\n"
    "end\n"
    "return { dims = 3, gravity = { 0, 0, -10 }, skin = 0.1,\n"
    "         wants = { 'contact_response', 'friction', 'filter' } }\n";

duet_scene *scene_from_bytes(const char *name, const void *bytes, size_t n,
                             const duet_setting *settings, uint32_t n_settings, duet_error *err)
{
    must(text_write_file(name, bytes, n, ERR));
    duet_scene *scene = duet_scene_load(name, settings, n_settings, err);
    remove(name);
    return scene ? test_keep(scene, test_duet_scene_back) : NULL;
}

duet_scene *scene_from_text(const char *name, const char *chars, duet_error *err)
{
    return scene_from_bytes(name, chars, strlen(chars), NULL, 0, err);
}

void scene_assert_refused(const char *name, const char *chars, duet_status status, const char *says)
{
    duet_error err = {0};
    duet_scene *scene = scene_from_text(name, chars, &err);
    if (scene || err.status != status || !strstr(err.text, says))
        fail_msg("'%s' gives %s '%s', not '%s'", chars, duet_status_name(err.status), err.text,
                 says);
}
