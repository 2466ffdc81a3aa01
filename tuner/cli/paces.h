// SPDX-License-Identifier: MIT
// What the pace of a scene that moves costs - its dt, substeps and integrator -
// and how far the scene then comes from where it should.
#ifndef CLI_PACES_H
#define CLI_PACES_H

#include "runtime/duet.h"

enum { PACES_MOST = 20 };

typedef struct pace {
    double dt;
    uint32_t substeps;
    duet_integrator integrator;
    bool own;      // the scene's
    bool finite;   // no number was lost; else the rest but ms says nothing
    double ms;     // that a second of the scene takes
    double error;  // root mean square of the centres' distances from the reference's
    double energy; // less the reference's, in the greatest kinetic energy
    double gain;   // greatest rise of energy over what it was before, in the same
    double depth;  // of the deepest contact
    bool front;    // nothing is both faster and nearer to the reference
} pace;

typedef struct paces {
    pace rows[PACES_MOST]; // the cheapest first
    uint32_t n;            // that were run
    uint32_t n_asked;
    pace reference; // the error is 0
    bool contact;   // contacts are looked for, so that there is a depth
    double time;    // that each run lasts, of the scene
} paces;

// Runs the scene for `time` seconds, rounded to whole steps, once as a reference
// that is finer than all others and then at each pace. After `limit` seconds,
// or Ctrl-C, no other pace is begun; INTERRUPTED where none was run.
bool paces_measure(paces *p, duet_device_pair *pair, const duet_scene *scene, double time,
                   double limit, duet_error *err);

// Whether something moves, so that it has a pace.
bool paces_has(duet_device_pair *pair, const duet_scene *scene, bool *moves, duet_error *err);

#endif
