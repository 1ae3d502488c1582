/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/take/rig.h"

#include "libtensor/base/rng.h"
#include "synth/take/picture.h"
#include "synth/take/view.h"

#include <math.h>

enum { LENS = 0x4c454e53, STAND = 0x53544e44 };

static const double RADIUS = 0.8, LOW = 0.3, HIGH = 0.7;        /* metres */
static const double SPREAD = 1.25;                              /* radians to either side of the middle */

static void set_lens(uint64_t seed, int i, synth_camera *c)
{
    lt_rng rng = lt_rng_make(seed, lt_rng_mix(LENS, (uint64_t)i));

    c->fx = lt_rng_range(&rng, 600, 620);
    c->fy = c->fx * 1.001;
    c->cx = SYNTH_WIDTH / 2 + lt_rng_range(&rng, -10, 10);
    c->cy = SYNTH_HEIGHT / 2 + lt_rng_range(&rng, -10, 10);
    c->width = SYNTH_WIDTH;
    c->height = SYNTH_HEIGHT;
}

void synth_rig_new(uint64_t seed, int session, int n, synth_camera *out)
{
    lt_rng rng = lt_rng_make(seed, lt_rng_mix(STAND, (uint64_t)session));

    for (int i = 0; i < n; i++) {
        const double share = n > 1 ? (double)i / (n - 1) : 0.5;
        const double around = SPREAD * (2 * share - 1) + lt_rng_range(&rng, -0.06, 0.06);
        const double height = (i % 2 ? HIGH - 0.15 : LOW) + lt_rng_range(&rng, 0, 0.15);
        const double eye[3] = { RADIUS * sin(around), -RADIUS * cos(around), height };
        double target[3];

        for (int k = 0; k < 3; k++)
            target[k] = (k == 2 ? 0.12 : 0) + lt_rng_range(&rng, -0.02, 0.02);
        set_lens(seed, i, &out[i]);
        synth_view_look(eye, target, 0, &out[i]);
    }
}

void synth_rig_mirror(synth_camera *camera, int n)
{
    static const int sign[9] = { 1, -1, -1, -1, 1, 1, -1, 1, 1 };

    for (int i = 0; i < n; i++) {
        synth_camera *c = &camera[i];
        for (int k = 0; k < 9; k++)
            c->R_cam_world[k] *= sign[k];
        c->t_cam_world[0] = -c->t_cam_world[0];
        c->cx = c->width - 1 - c->cx;
    }
}
