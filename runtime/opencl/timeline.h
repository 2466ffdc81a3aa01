// SPDX-License-Identifier: MIT
// What was sent to one device's queue in a step, and how long each took.
#ifndef RUNTIME_TIMELINE_H
#define RUNTIME_TIMELINE_H

#include "runtime/opencl/buffer.h"
#include "runtime/opencl/program.h"

// TIMED_EVERY: one step in so many has times where asking for them costs a device time. TIED: so
// many commands are asked when they were queued.
enum {
    TIMELINE_EVENTS = 192,
    TIMELINE_STAGES = 24,
    TIMELINE_SEEN = 4,
    TIMELINE_TIMED_EVERY = 16,
    TIMELINE_TIED = 4,
    TIMELINE_ASKED = 4
};

// The commands that were sent, as far as the host knows.
typedef enum timeline_sent {
    SENT_TOLD,   // each of those under way has an event
    SENT_UNTOLD, // some without an event may be under way
    SENT_SEEN,   // it has seen the end of all of them
} timeline_sent;

typedef struct timeline {
    const device *device;
    struct {
        int stage;
        cl_event event;
        uint64_t sent_ns; // by the host's clock; not before it was queued
    } events[TIMELINE_EVENTS];
    int n_events;
    struct {
        const char *from;
        void *to;
        size_t bytes;
    } asked[TIMELINE_ASKED]; // reads of memory that the host has, done when it waits
    int n_asked;
    duet_stage stages[TIMELINE_STAGES]; // in order of first appearance
    bool on_host[TIMELINE_STAGES];      // stages that the host timed
    int n_stages;
    bool untimed; // commands on the device's memory have no events
    timeline_sent sent;
    uint32_t n_launches;  // launches of kernels
    uint32_t n_waits;     // reads that the host waited for
    uint64_t all_launches, all_waits; // since it was made, those for the end of all included
    cl_ulong first_begin; // begin of the first kernel, on the device's clock; 0: none ran
    cl_ulong last_end;
    uint64_t begun_ns; // by the host's clock, from which stages' begins and ends are counted
    cl_ulong queued;   // when the first command was, by the device's clock
    int64_t first_ns;  // and since begun_ns, by the host's clock, as well as that is known
    int n_tied;        // commands that say so
    cl_event held;     // what commands wait for until the host does; NULL: nothing
    bool beside;       // something was written beside the kernels
    cl_int lost;       // the device did not say how a command stands; the step has failed
} timeline;

// Forgets the last step. Without times the stages, and the kernels' first begin and last end, stay
// those of the last step that had them; launches and fills have no events then, which were
// measured to cost NVIDIA's driver 7 microseconds each.
void timeline_begin(timeline *t, const device *d, bool timed);

// The same for a step, so many after one whose times were asked for: that one is timed, on a CPU
// each is; elsewhere the first, and then one in TIMED_EVERY.
void timeline_begin_step(timeline *t, const device *d, uint64_t step);

// Sends a kernel over `work` objects, pairs or values; none for work = 0. values: the
// struct with its arguments, of the kind that its bindings describe.
bool timeline_launch(timeline *t, const char *stage, const kernel *k, uint64_t work,
                     const void *values, duet_error *err);

// The same once `after` is over (NULL: at once).
bool timeline_launch_after(timeline *t, const char *stage, const kernel *k, uint64_t work,
                           cl_event after, const void *values, duet_error *err);

// The same over units along each of the kernel's axes; none if there are none along its last one.
bool timeline_launch_grid(timeline *t, const char *stage, const kernel *k, const uint64_t units[3],
                          const void *values, duet_error *err);

// Sets words [from, to) of a buffer to a value.
bool timeline_fill(timeline *t, const char *stage, buffer *b, uint32_t value, size_t from,
                   size_t to, duet_error *err);

// Copies between host and device. If the device works on host memory and the bytes are already in
// place, nothing is moved; the device has then at least seen the host's writes, or the host the
// device's. A read is complete on return, a write may still be under way.
bool timeline_write(timeline *t, const char *stage, buffer *b, const void *from, size_t bytes,
                    duet_error *err);
bool timeline_write_at(timeline *t, const char *stage, buffer *b, size_t at, const void *from,
                       size_t bytes, duet_error *err); // always copies, to byte `at`
bool timeline_read(timeline *t, const char *stage, buffer *b, void *to, size_t bytes,
                   duet_error *err);
bool timeline_read_at(timeline *t, const char *stage, buffer *b, size_t at, void *to, size_t bytes,
                      duet_error *err); // from byte `at`

// Copies to byte `at` beside the kernels, which do not wait for it unless they
// are launched after its event. Nothing else may use the buffer's bytes meanwhile.
bool timeline_write_beside(timeline *t, const char *stage, buffer *b, size_t at, const void *from,
                           size_t bytes, duet_error *err);

// Reads from byte 0 on beside the kernels, once `after` is over (NULL: at once), without waiting.
bool timeline_read_beside(timeline *t, const char *stage, buffer *b, void *to, size_t bytes,
                          cl_event after, duet_error *err);

// Kernels that are launched from now on wait for what was sent beside them.
bool timeline_follow(timeline *t, cl_event beside, duet_error *err);

// Reads from byte `at` without waiting: the bytes are there once a later read has
// waited, or the timeline has finished. No kernel may change them before that. Memory that is no
// host_block is filled by a thread of the driver, for which a read right behind waits: 0.05 to 0.3
// ms on an H200.
bool timeline_start_read(timeline *t, const char *stage, buffer *b, size_t at, void *to,
                         size_t bytes, duet_error *err);

// Waits, and the host sees these buffers where the device works on them: all with one wait, which
// costs a CPU's driver two wake-ups. Buffers that there are none of are passed over, the last one
// apart. Earlier commands are over then.
bool timeline_see(timeline *t, const char *stage, const buffer *const list[], int n,
                  duet_error *err);

// Returns the event of the last command in the queue; the timeline's until it finishes.
cl_event timeline_last_event(const timeline *t);

// Says whether a command is over, without waiting. If the device does not say, it counts as over,
// and the next collection fails.
bool timeline_is_over(timeline *t, cl_event event);

// Waits for a flushed event without sleeping: waiting for the queue or the event
// instead was measured to take 0.15 ms longer on a GPU.
void timeline_spin(timeline *t, cl_event event);

// Reads the times up to an event that is over, while the host would wait anyway:
// asking for one takes a driver more than a microsecond.
bool timeline_collect_to(timeline *t, cl_event last, duet_error *err);

// Commands that are sent from now on begin once the host waits: a CPU's thread, which wakes for the
// first of them, otherwise sleeps again before the next one is there. Nothing on other devices.
bool timeline_hold(timeline *t, duet_error *err);

bool timeline_flush(timeline *t, duet_error *err);
bool timeline_finish(timeline *t, duet_error *err); // waits and reads the times

// Adds time that the host has just spent on a stage of this device.
void timeline_add_host(timeline *t, const char *stage, double ms);

// From the begin of the first kernel to the end of the last one.
double timeline_kernel_ms(const timeline *t);

// Writes the stages behind the n of a list, as those of device A or B; returns how many it has
// then.
int timeline_list_stages(const timeline *t, int side, duet_stage *list, int n);

// For timeline.c: the place of the stage of that name; adds to their stages the times of the first
// n events, which are over.
int timeline_stage(timeline *t, const char *name, bool transfer);
void timeline_add_times(timeline *t, int n);

// Waits for what a failed step left under way, and releases it.
void timeline_clear(timeline *t);

#endif
