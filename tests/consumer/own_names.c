// SPDX-License-Identifier: MIT
// Names that the library uses within itself are the application's to define.
void text_free(void);
void device_open(void);
void store_close(void);
void clock_steady_ns(void);

void text_free(void)
{
}

void device_open(void)
{
}

void store_close(void)
{
}

void clock_steady_ns(void)
{
}
