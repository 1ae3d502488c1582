/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the surfaces of a frame are worth, against the true hand and object.
 */
#ifndef TASKS_HOGS_RESULTS_SURFACES_H
#define TASKS_HOGS_RESULTS_SURFACES_H

#include "tasks/hogs/score.h"

/* GOF's level, with its minimum rule, for the object alone */
#define HOGS_ISO_MIN 0.5

/* Which of them */
typedef struct {
    bool shapes;                    /* hand and object by samples of their surfaces                [Tables 2 and 9] */
    bool vertices;                  /* the object by its vertices, after a similarity                     [Table 3] */
    bool pose;                      /* the object with its pose                                           [Table 3] */
} hogs_surfaces_wanted;

typedef struct {
    double model[HOGS_SCORES];      /* hand as seen from its wrist, object after a similarity, and with the pose */
    double no_rotation[HOGS_SCORES];        /* the object after translation and scale */
    double minimum[HOGS_SCORES];    /* the object's by the minimum rule, after a similarity */
    int failed;                     /* surfaces that there are none of: nothing is opaque enough */
} hogs_surface_scores;

/* hogs_score_surfaces - of what a graph that draws has made of a frame whose truth is known. What has no surface leaves
 * its scores NaN. Errors: LT_ENOMEM, a true mesh that cannot be sampled. */
lt_status hogs_score_surfaces(const hogs_touch *truth, const hogs *m, const hogs_frame *f, const compiled *c,
                              hogs_surfaces_wanted wanted, hogs_surface_scores *out);

#endif
