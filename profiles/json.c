// SPDX-License-Identifier: MIT
#include "profiles/json.h"

#include <cjson/cJSON.h>

bool json_check_object(const char *what, const char *chars, duet_error *err)
{
    cJSON *json = cJSON_ParseWithOpts(chars, NULL, true);
    bool ok = cJSON_IsObject(json);
    cJSON_Delete(json);
    return ok || error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s must be one JSON object, not: %.60s",
                           what, chars);
}
