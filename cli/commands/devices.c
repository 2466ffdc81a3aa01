// SPDX-License-Identifier: MIT
// duet devices: what OpenCL offers here, and the selectors for --pair.
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"

typedef struct arguments {
    bool json;
} arguments;

static const option options[] = {
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line line = {
    .name = "devices",
    .about = "Lists the OpenCL devices here. A CPU can be cut into parts, which are devices\n"
             "too: pocl:0[2-3] is units 2 and 3 of pocl:0, pocl:0[1/4] the first quarter.\n"
             "--pair takes two selectors with a comma between them, one, or halves; cpu and\n"
             "gpu are the strongest of their kind. A quirk is a flaw of the driver, and what\n"
             "Duet does about it.",
    .options = options,
};

static const char *const kinds[] = {
    [DUET_KIND_CPU] = "CPU", [DUET_KIND_GPU] = "GPU", [DUET_KIND_ACCELERATOR] = "accelerator"};

static void add_device(cJSON *list, const duet_device_info *d)
{
    cJSON *o = json_add_row(list);
    json_add(o, STRING("selector", d->selector), STRING("name", d->name),
             STRING("kind", kinds[d->kind]), STRING("platform", d->platform),
             STRING("platform_version", d->platform_version), STRING("vendor", d->vendor),
             STRING("driver", d->driver), STRING("cl_version", d->cl_version),
             NUMBER("units", d->units), NUMBER("clock_mhz", d->clock_mhz),
             NUMBER("max_group", d->max_group), NUMBER("global_bytes", d->global_bytes),
             NUMBER("local_bytes", d->local_bytes), NUMBER("max_buffer_bytes", d->max_buffer_bytes),
             FLAG("host_memory", d->host_memory), FLAG("fp64", d->fp64),
             FLAG("can_cut", d->can_cut));
    cJSON *quirks = cJSON_AddArrayToObject(o, "quirks");
    const char *quirk;
    for (uint32_t i = 0; (quirk = duet_device_info_get_quirk(d, i)); ++i)
        cJSON_AddItemToArray(quirks, cJSON_CreateString(quirk));
}

static cJSON *describe(const duet_device_list *list, const duet_device_pair *pair)
{
    cJSON *o = cJSON_CreateObject();
    cJSON *devices = cJSON_AddArrayToObject(o, "devices");
    for (uint32_t i = 0; i < duet_device_list_get_count(list); ++i)
        add_device(devices, duet_device_list_get_info(list, i));
    cJSON *absent = cJSON_AddArrayToObject(o, "absent");
    const char *why;
    for (uint32_t i = 0; (why = duet_device_list_get_absent(list, i)); ++i)
        cJSON_AddItemToArray(absent, cJSON_CreateString(why));
    json_add_pair(o, "default_pair", pair);
    return o;
}

static bool run(void *given, char **operands, duet_error *err)
{
    (void)operands;
    const arguments *args = given;
    duet_device_list *list = duet_device_list_create(err);
    duet_device_pair *pair = list ? inputs_open_pair(NULL, err) : NULL;
    bool ok =
        pair && rendering_tell(describe(list, pair), args->json, "cli/report/devices.lua", err);
    duet_device_pair_destroy(pair);
    duet_device_list_destroy(list);
    return ok;
}

SUBCOMMAND(devices, 0)
