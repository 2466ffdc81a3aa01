// SPDX-License-Identifier: MIT
#include "support/task_files.h"

#include "support/test.h"

void task_files_write(const char *folder, const char *name, const char *args, const char *body)
{
    char path[160], text[2048];
    snprintf(path, sizeof path, "%s/%s.lua", folder, name);
    snprintf(text, sizeof text,
             "return { about = 'test', params = { { 'WG', values = { 1, 4, 16 }, about = 'group' "
             "} }, args = { %s = [[\nulong first\nulong last\n%s]] }, launch = function(p) return "
             "{ group = p.WG, per_item = 1 } end }",
             name, args);
    test_write_file(path, text);
    char upper[48] = "";
    for (size_t i = 0; name[i]; ++i)
        upper[i] = name[i] >= 'a' && name[i] <= 'z' ? (char)(name[i] - 32) : name[i];
    snprintf(path, sizeof path, "%s/%s.cl", folder, name);
    snprintf(text, sizeof text,
             "__kernel void %s(%s_ARGS)\n{\n    ulong i = first + get_global_id(0);\n    if (i >= "
             "last)\n        return;\n    %s\n}\n",
             name, upper, body);
    test_write_file(path, text);
}
