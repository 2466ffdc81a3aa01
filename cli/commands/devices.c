// SPDX-License-Identifier: MIT
// duet devices: what OpenCL offers here, and the selectors for --pair.
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/report/json.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <stdio.h>

typedef struct arguments {
    bool json;
} arguments;

static const option options[] = {
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line line = {
    .name = "devices",
    .operands = "",
    .about = "Lists the OpenCL devices here. A CPU can be cut into parts, which are devices\n"
             "too: pocl:0[2-3] is units 2 and 3 of pocl:0, pocl:0[1/4] the first quarter.\n"
             "--pair takes two selectors with a comma between them, one, or halves; cpu and\n"
             "gpu are the strongest of their kind. A quirk is a flaw of the driver, and what\n"
             "Duet does about it.",
    .options = options,
};

static const char *const kinds[] = {
    [DUET_KIND_CPU] = "CPU", [DUET_KIND_GPU] = "GPU", [DUET_KIND_ACCELERATOR] = "accelerator"};

static void print_device(const duet_device_info *d)
{
    printf("%s  %s\n", d->selector, d->name);
    table t = table_begin("lll");
    table_words(&t, " ", "platform", d->platform, NULL);
    table_words(&t, " ", "", d->platform_version, NULL);
    table_words(&t, " ", "driver", d->driver, NULL);
    table_words(&t, " ", "version", d->cl_version, NULL);
    table_words(&t, " ", "kind", NULL);
    table_cell(&t, "%s, %u units at %u MHz, %sdouble precision", kinds[d->kind], d->units,
               d->clock_mhz, d->fp64 ? "" : "no ");
    table_words(&t, " ", "memory", NULL);
    table_cell(&t, "%s%s, a buffer at most %s, local %s", table_bytes(d->global_bytes).chars,
               d->host_memory ? " of the host" : "", table_bytes(d->max_buffer_bytes).chars,
               table_bytes(d->local_bytes).chars);
    table_words(&t, " ", "group", NULL);
    table_cell(&t, "at most %u work-items", d->max_group);
    table_words(&t, " ", "parts", NULL);
    if (d->can_cut)
        table_cell(&t, "%s[first-last], units 0 to %u", d->selector, d->units - 1);
    else
        table_cell(&t, "none, it cannot be cut");
    const char *quirk;
    for (uint32_t i = 0; (quirk = duet_device_info_get_quirk(d, i)); ++i)
        table_words(&t, " ", i == 0 ? "quirks" : "", quirk, NULL);
    table_print(&t, stdout);
    putchar('\n');
}

static void print_absent(const duet_device_list *list)
{
    const char *why;
    for (uint32_t i = 0; (why = duet_device_list_get_absent(list, i)); ++i)
        printf("%s\n\n", why);
}

static void print_default(const duet_device_pair *pair)
{
    const duet_device_info *a = duet_device_pair_get_info(pair, 0);
    const duet_device_info *b = duet_device_pair_get_info(pair, 1);
    bool one = duet_device_pair_is_one(pair);
    printf("without --pair: %s%s%s\n", a->selector, one ? "" : ",", one ? "" : b->selector);
}

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

static bool print_json(const duet_device_list *list, const duet_device_pair *pair, duet_error *err)
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
    return say_json(o, err);
}

static bool run(void *given, char **operands, duet_error *err)
{
    (void)operands;
    const arguments *args = given;
    duet_device_list *list = duet_device_list_create(err);
    duet_device_pair *pair = list ? inputs_open_pair(NULL, err) : NULL;
    bool ok = pair;
    for (uint32_t i = 0; !args->json && i < duet_device_list_get_count(list); ++i)
        print_device(duet_device_list_get_info(list, i));
    if (ok && args->json)
        ok = print_json(list, pair, err);
    else if (ok) {
        print_absent(list);
        print_default(pair);
    }
    duet_device_pair_destroy(pair);
    duet_device_list_destroy(list);
    return ok;
}

int command_devices(int argc, char **argv)
{
    arguments args = {0};
    return options_run(&line, argc, argv, &args, run);
}
