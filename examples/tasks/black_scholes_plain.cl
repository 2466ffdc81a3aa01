// SPDX-License-Identifier: MIT
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

// The normal distribution function, by Abramowitz and Stegun's formula 26.2.17.
static inline double normal(double x)
{
    double t = 1.0 / (1.0 + 0.2316419 * fabs(x));
    double sum = t * (0.319381530 + t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))));
    double above = exp(-0.5 * x * x) * 0.3989422804014327 * sum;
    return x < 0.0 ? above : 1.0 - above;
}

__kernel void black_scholes_plain(BLACK_SCHOLES_PLAIN_ARGS)
{
    ulong i = first + get_global_id(0);
    if (i >= last)
        return;
    double s = volatility, r = rate, spread = s * sqrt((double)years[i]);
    double d1 = (log((double)price[i] / strike[i]) + (r + 0.5 * s * s) * years[i]) / spread;
    double d2 = d1 - spread, paid = strike[i] * exp(-r * years[i]);
    call[i] = (float)(price[i] * normal(d1) - paid * normal(d2));
    put[i] = (float)(paid * normal(-d2) - price[i] * normal(-d1));
}
