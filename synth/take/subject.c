/* SPDX-License-Identifier: Apache-2.0 */
/* Draws people. */
#include "synth/take/subject.h"

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

enum { STREAM = 0x5355424a };

static void mean_color(const float (*color)[3], const int *vertex, int n, float out[3])
{
    for (int k = 0; k < 3; k++) {
        out[k] = 0;
        for (int i = 0; i < n; i++)
            out[k] += color[vertex[i]][k] / (float)n;
    }
}

void synth_subject_draw(const lt_hand_model *hand, uint64_t seed, int number, synth_subject *out)
{
    lt_rng rng = lt_rng_make(seed, lt_rng_mix(STREAM, (uint64_t)number));
    /* Neighbours in number differ in tone, so that a small set already varies. */
    const int tone = (2 * number + number / 3) % SYNTH_HAND_TONES;

    for (int i = 0; i < LT_HAND_BETAS; i++)
        out->beta[i] = fmax(-2.5, fmin(2.5, lt_rng_normal(&rng)));
    lt_hand_rest_wrist(hand, out->beta, out->rest_wrist);
    synth_hand_colors(hand, tone, out->color);
    mean_color((const float (*)[3])out->color, synth_hand_wrist_loop, SYNTH_HAND_WRIST_LOOP, out->skin);
    out->bare = lt_rng_uniform(&rng) < 0.3 ? 1 : lt_rng_range(&rng, 0.02, 0.2);
}

void synth_subject_pose(const synth_subject *s, const lt_hand_model *hand, const double R_root[9],
                        const double wrist[3], const double fingers[45], synth_posed_hand *out)
{
    double R[LT_HAND_JOINTS][9], trans[3], joints[LT_HAND_JOINTS][3];

    memcpy(R[0], R_root, sizeof(R[0]));
    for (int i = 1; i < LT_HAND_JOINTS; i++)
        lt_rot_from_axis_angle(fingers + 3 * (i - 1), R[i]);
    lt_vec3_sub(wrist, s->rest_wrist, trans);
    lt_hand_pose(hand, &R[0][0], s->beta, trans, &out->vertices[0][0], &joints[0][0]);
    lt_hand_keypoints(&out->vertices[0][0], &joints[0][0], lt_hand_tips_ho3d, LT_HAND_MANO_ORDER,
                      &out->keypoints[0][0]);
}
