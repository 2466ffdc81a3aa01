// SPDX-License-Identifier: MIT
// The parameters of a card, and the values that they may have.
#include "gen/card.h"

#include "base/error.h"

#include <inttypes.h>
#include <string.h>

const gen_param *card_param(const card *c, const char *name)
{
    for (uint32_t i = 0; i < c->n_params; ++i)
        if (strcmp(c->params[i].name, name) == 0)
            return &c->params[i];
    return NULL;
}

bool card_has_value(const gen_param *param, int64_t value)
{
    if (param->is_range)
        return value >= param->least && value <= param->most;
    for (uint32_t i = 0; i < param->n_values; ++i)
        if (param->values[i] == value)
            return true;
    return false;
}

// A number is checked here, a function when it is asked.
static bool check_value(const card *c, const gen_param *param, int64_t value, duet_error *err)
{
    if (card_has_value(param, value))
        return true;
    if (param->is_range)
        return bad_argument(err, "%s: %s=%" PRId64 " is not in %" PRId64 " .. %" PRId64, c->kernel,
                            param->name, value, param->least, param->most);
    text all = {0};
    for (uint32_t i = 0; i < param->n_values; ++i)
        text_add(&all, "%s%" PRId64, i > 0 ? ", " : "", param->values[i]);
    bad_argument(err, "%s: %s=%" PRId64 " is not one of %s", c->kernel, param->name, value,
                 text_chars(&all));
    text_free(&all);
    return false;
}

static bool refuse_name(const card *c, const char *name, duet_error *err)
{
    text all = {0};
    for (uint32_t i = 0; i < c->n_params; ++i)
        text_add(&all, "%s%s", i > 0 ? ", " : "", c->params[i].name);
    bad_argument(err, "%s: no parameter '%s': there are %s", c->kernel, name, text_chars(&all));
    text_free(&all);
    return false;
}

bool card_take(const card *c, const gen_offer *offer, gen_setting *config, duet_error *err)
{
    const gen_param *param = card_param(c, offer->name);
    if (offer->kernel && *offer->kernel && strcmp(offer->kernel, c->kernel) != 0)
        return true;
    if (!param)
        return offer->manner != GEN_REQUIRED || refuse_name(c, offer->name, err);
    int64_t greatest = param->is_range ? param->most : param->values[param->n_values - 1];
    bool above = offer->manner == GEN_CAPPED && offer->value > greatest;
    int64_t *value = &config[param - c->params].value;
    *value = above ? greatest : offer->value;
    if (offer->taken)
        *offer->taken = true;
    return check_value(c, param, *value, err);
}

// A range without values does not vary by itself.
static uint32_t radix(const gen_param *param)
{
    return param->n_values > 0 ? param->n_values : 1;
}

uint64_t card_size(const card *c)
{
    uint64_t size = 1;
    for (uint32_t i = 0; i < c->n_params && size <= CARD_MAX_CONFIGS; ++i)
        size *= radix(&c->params[i]);
    return size;
}

void card_config(const card *c, uint64_t index, gen_setting *config)
{
    for (uint32_t i = c->n_params; i-- > 0;) {
        const gen_param *param = &c->params[i];
        uint32_t digit = (uint32_t)(index % radix(param));
        index /= radix(param);
        config[i].name = param->name;
        config[i].value = param->n_values > 0 ? param->values[digit] : param->fallback;
    }
}
