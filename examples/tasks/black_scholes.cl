// SPDX-License-Identifier: MIT
// The normal distribution function.
static inline float normal(float x)
{
    return 0.5f * erfc(-x * M_SQRT1_2_F);
}

__kernel void black_scholes(BLACK_SCHOLES_ARGS)
{
    ulong from = first + get_global_id(0) * PER_ITEM;
    for (ulong i = from; i < from + PER_ITEM && i < last; ++i) {
        float spread = volatility * sqrt(years[i]);
        float d1 = (log(price[i] / strike[i]) + (rate + 0.5f * volatility * volatility) * years[i]) / spread;
        float d2 = d1 - spread;
        float paid = strike[i] * exp(-rate * years[i]);
        call[i] = price[i] * normal(d1) - paid * normal(d2);
        put[i] = paid * normal(-d2) - price[i] * normal(-d1);
    }
}
