// SPDX-License-Identifier: MIT
// What the time step of a moving scene costs - its dt, substeps and integrator -
// and how far the scene then comes from where it should.
#ifndef CLI_TIMESTEP_STUDY_H
#define CLI_TIMESTEP_STUDY_H

#include "cli/report/json.h"
#include "runtime/duet.h"

enum { TIMESTEP_RUNS = 20 };

typedef struct timestep_run {
    double dt;
    uint32_t substeps;
    duet_integrator integrator;
    bool own;      // the scene's
    bool finite;   // no number was lost; else the rest but ms says nothing
    double ms;     // that a second of the scene takes
    double noise;  // the noise of ms: less between two runs tells nothing; INFINITY: not known,
                   // for lack of steps
    double error;  // root mean square of the centres' distances from the reference's
    double energy; // less the reference's, in the greatest kinetic energy
    double gain;   // greatest rise of energy over what it was before, in the same
    double depth;  // the deepest contact's
    bool front;    // no other is nearer to the reference in a time that is not longer beyond noise
} timestep_run;

typedef struct timestep_study {
    timestep_run rows[TIMESTEP_RUNS]; // the cheapest first
    uint32_t n;                       // that were run
    uint32_t n_asked;
    timestep_run reference; // the error is 0
    bool contact;           // contacts are looked for, so that there is a depth
    double time;            // that each run lasts, of the scene
} timestep_study;

// Runs the scene for `time` seconds, rounded to whole steps, once as a reference
// that is finer than all others and then at each other time step. After `limit` seconds,
// or Ctrl-C, no other run is begun; INTERRUPTED if none was run.
bool timestep_study_measure(timestep_study *p, duet_device_pair *pair, const duet_scene *scene,
                            double time, double limit, duet_error *err);

// Whether something moves, so that a study applies.
bool timestep_study_applies(duet_device_pair *pair, const duet_scene *scene, bool *moves,
                            duet_error *err);

cJSON *timestep_study_json(const timestep_study *p, const duet_scene_info *scene,
                           const duet_device_pair *pair);

#endif
