/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The ground truth of HO3D's evaluation split: evaluation_xyz.json and evaluation_verts.json.
 */
#ifndef SYNTH_WRITE_TRUTH_H
#define SYNTH_WRITE_TRUTH_H

#include "libtensor/geometry/hand/model.h"
#include "libtensor/io/atomic_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The two files, written frame by frame in the split's order. Points come in OpenCV camera axes, metres. */
typedef struct {
    lt_atomic_file xyz, verts;
    bool open;
    int64_t count;
} synth_truth;

/* synth_truth_open - begin both files under root; nothing is there before synth_truth_commit */
lt_status synth_truth_open(synth_truth *t, const char *root);

/* synth_truth_add - the next frame; joints in MANO order */
void synth_truth_add(synth_truth *t, const double joints[LT_HAND_KEYPOINTS][3],
                     const double vertices[LT_HAND_VERTICES][3]);

lt_status synth_truth_commit(synth_truth *t);
void synth_truth_abort(synth_truth *t);         /* leaves nothing; fine after a failed open */

#ifdef __cplusplus
}
#endif
#endif
