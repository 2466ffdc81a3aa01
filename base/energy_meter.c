// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "base/energy_meter.h"

#include "base/clock.h"
#include "base/text.h"

#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PACKAGES = 16, GPUS = 16, GPU_NAME = 96 };

// A GPU's counter was seen to move every 20 to 100 ms, a package's every millisecond.
#define GPU_WINDOW_NS UINT64_C(400000000)
#define PACKAGE_WINDOW_NS UINT64_C(100000000)

typedef struct package {
    char path[256];
    uint64_t last_uj;
    uint64_t range_uj; // it begins again at 0 behind this
    double joules;
} package;

// The part of NVML that is called.
typedef void *nvml_device;
typedef struct nvml {
    void *library;
    int (*init)(void);
    int (*shut_down)(void);
    int (*count)(unsigned *n);
    int (*device_at)(unsigned i, nvml_device *device);
    int (*name_of)(nvml_device device, char *name, unsigned size);
    int (*energy_of)(nvml_device device, unsigned long long *millijoules);
} nvml;

struct energy_meter {
    char *file;
    uint64_t opened_ns;
    package packages[PACKAGES];
    int n_packages;
    nvml nvml;
    nvml_device gpus[GPUS];
    int n_gpus;
    text what;
};

energy_meter_def energy_meter_default_def(void)
{
    return (energy_meter_def){.file = getenv("DUET_ENERGY"),
                              .powercap = "/sys/class/powercap",
                              .nvml = "libnvidia-ml.so.1"};
}

static void describe(energy_meter *m, const char *name)
{
    text_add(&m->what, "%s%s", m->what.length > 0 ? ", " : "", name);
}

// ---------------------------------------------------------------- a file

static bool read_file(const energy_meter *m, double *joules)
{
    double number = 0;
    char unit = 0;
    FILE *file = fopen(m->file, "r");
    bool ok = file && fscanf(file, "%lf %c", &number, &unit) == 2 && number >= 0 &&
              (unit == 'J' || unit == 'W');
    if (file)
        fclose(file);
    *joules = unit == 'W' ? number * (double)(clock_steady_ns() - m->opened_ns) * 1e-9 : number;
    return ok;
}

static bool open_file(energy_meter *m, const char *path, duet_error *err)
{
    double joules;
    m->file = strdup(path);
    if (!m->file)
        return no_memory(err, "the name of %s", path);
    describe(m, path);
    return read_file(m, &joules) ||
           error_set(err, DUET_STATUS_NOT_FOUND,
                     "energy: %s: expected a number, then J (joules so far) or W (watts)", path);
}

// ---------------------------------------------------------------- packages

static bool read_count(const char *folder, const char *name, uint64_t *count)
{
    char path[320];
    unsigned long long value = 0;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    bool ok = file && fscanf(file, "%llu", &value) == 1;
    if (file)
        fclose(file);
    *count = value;
    return ok;
}

static void read_package(package *p)
{
    uint64_t now;
    if (!read_count(p->path, "energy_uj", &now))
        return;
    uint64_t by = now >= p->last_uj ? now - p->last_uj : p->range_uj - p->last_uj + now;
    p->joules += (double)by * 1e-6;
    p->last_uj = now;
}

// Zones within a package are part of it.
static void open_packages(energy_meter *m, const char *folder, text *tried)
{
    errno = 0;
    for (int i = 0; i < PACKAGES; ++i) {
        package *p = &m->packages[m->n_packages];
        char name[32];
        snprintf(p->path, sizeof p->path, "%s/intel-rapl:%d", folder, i);
        snprintf(name, sizeof name, "package-%d", i);
        if (!read_count(p->path, "energy_uj", &p->last_uj))
            break;
        read_count(p->path, "max_energy_range_uj", &p->range_uj);
        p->joules = 0;
        describe(m, name);
        ++m->n_packages;
    }
    if (m->n_packages == 0)
        text_add(tried, "%s/intel-rapl:0/energy_uj: %s", folder, strerror(errno));
}

// ---------------------------------------------------------------- GPUs

// A function pointer's bytes come from dlsym's, as POSIX has it.
static bool find(nvml *n, void *to, const char *name)
{
    void *function = dlsym(n->library, name);
    memcpy(to, &function, sizeof function);
    return function;
}

static bool load(nvml *n, const char *library)
{
    n->library = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    if (!n->library)
        return false;
    bool ok = find(n, &n->init, "nvmlInit_v2") && find(n, &n->shut_down, "nvmlShutdown") &&
              find(n, &n->count, "nvmlDeviceGetCount_v2") &&
              find(n, &n->device_at, "nvmlDeviceGetHandleByIndex_v2") &&
              find(n, &n->name_of, "nvmlDeviceGetName") &&
              find(n, &n->energy_of, "nvmlDeviceGetTotalEnergyConsumption") && n->init() == 0;
    if (!ok) {
        dlclose(n->library);
        *n = (nvml){0};
    }
    return ok;
}

static bool is_wanted(const energy_meter_def *def, const char *name)
{
    return (def->gpus[0] && strcmp(def->gpus[0], name) == 0) ||
           (def->gpus[1] && strcmp(def->gpus[1], name) == 0);
}

static void open_gpus(energy_meter *m, const energy_meter_def *def, text *tried)
{
    unsigned n = 0;
    if (!load(&m->nvml, def->nvml)) {
        text_add(tried, "; %s: it cannot be loaded", def->nvml);
        return;
    }
    m->nvml.count(&n);
    for (unsigned i = 0; i < n && m->n_gpus < GPUS; ++i) {
        char name[GPU_NAME] = "";
        unsigned long long millijoules;
        nvml_device device;
        bool ok = m->nvml.device_at(i, &device) == 0 &&
                  m->nvml.name_of(device, name, sizeof name) == 0 && is_wanted(def, name) &&
                  m->nvml.energy_of(device, &millijoules) == 0;
        if (!ok)
            continue;
        describe(m, name);
        m->gpus[m->n_gpus++] = device;
    }
    if (m->n_gpus == 0)
        text_add(tried, "; %s: no GPU of the device pair counts its energy", def->nvml);
}

// ---------------------------------------------------------------- owner

static bool open_counters(energy_meter *m, const energy_meter_def *def, duet_error *err)
{
    text tried = {0};
    open_packages(m, def->powercap, &tried);
    if (def->gpus[0] || def->gpus[1])
        open_gpus(m, def, &tried);
    bool ok = m->n_packages + m->n_gpus > 0 ||
              error_set(err, DUET_STATUS_NOT_FOUND, "energy: nothing can be read: %s",
                        text_chars(&tried));
    text_free(&tried);
    return ok;
}

energy_meter *energy_meter_open(const energy_meter_def *def, duet_error *err)
{
    energy_meter *m = calloc(1, sizeof *m);
    if (!m)
        return null_no_memory(err, "the energy");
    m->opened_ns = clock_steady_ns();
    if (def->file ? open_file(m, def->file, err) : open_counters(m, def, err))
        return m;
    energy_meter_close(m);
    return NULL;
}

void energy_meter_close(energy_meter *m)
{
    if (!m)
        return;
    if (m->nvml.library) {
        m->nvml.shut_down();
        dlclose(m->nvml.library);
    }
    text_free(&m->what);
    free(m->file);
    free(m);
}

static double read_gpus(const energy_meter *m)
{
    double joules = 0;
    for (int i = 0; i < m->n_gpus; ++i) {
        unsigned long long millijoules = 0;
        m->nvml.energy_of(m->gpus[i], &millijoules);
        joules += (double)millijoules * 1e-3;
    }
    return joules;
}

double energy_meter_read(energy_meter *m)
{
    double joules = read_gpus(m), of_file = 0;
    if (m->file)
        read_file(m, &of_file);
    for (int i = 0; i < m->n_packages; ++i) {
        read_package(&m->packages[i]);
        joules += m->packages[i].joules;
    }
    return joules + of_file;
}

double energy_meter_slowest(energy_meter *m)
{
    return m->n_gpus > 0 ? read_gpus(m) : energy_meter_read(m);
}

const char *energy_meter_describe(const energy_meter *m)
{
    return text_chars(&m->what);
}

uint64_t energy_meter_window_ns(const energy_meter *m)
{
    return m->n_gpus > 0 ? GPU_WINDOW_NS : m->n_packages > 0 ? PACKAGE_WINDOW_NS : 0;
}
