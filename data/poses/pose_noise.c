/* SPDX-License-Identifier: Apache-2.0 */
#include "data/poses/pose_noise.h"

#include "libtensor/base/rng.h"
#include "libtensor/geometry/rotation.h"

static const double OF_FRAME = 0.1;             /* of a frame's own draw where noise is correlated */
#define DEGREE 0.017453292519943295

static pose_noise draw(uint64_t seed, uint64_t stream, bool coarse)
{
    const double hand = coarse ? 8 * DEGREE : 4 * DEGREE, object = coarse ? 15 * DEGREE : 9 * DEGREE;
    const double shift = coarse ? 0.0144 : 0.0086;
    lt_rng rng = lt_rng_make(seed, stream);
    pose_noise n;

    for (int i = 0; i < 48; i++)
        n.hand[i] = hand * lt_rng_normal(&rng);
    for (int k = 0; k < 3; k++)
        n.object[k] = object * lt_rng_normal(&rng);
    for (int k = 0; k < 3; k++)
        n.shift[k] = shift * lt_rng_normal(&rng);
    return n;
}

/* Half of the draws are coarse, half fine. */
static bool is_coarse(uint64_t seed, uint64_t stream)
{
    lt_rng rng = lt_rng_make(seed, lt_rng_mix(stream, 'c'));

    return lt_rng_uniform(&rng) < 0.5;
}

pose_noise pose_noise_draw(pose_noise_kind kind, uint64_t seed, uint64_t sequence, uint64_t frame)
{
    const bool coarse = is_coarse(seed, kind == POSE_NOISE_CORRELATED ? sequence : frame);
    pose_noise n = { .hand = { 0 } }, own;

    if (kind == POSE_NOISE_NONE)
        return n;
    own = draw(seed, frame, coarse);
    if (kind == POSE_NOISE_INDEPENDENT)
        return own;
    n = draw(seed, sequence, coarse);
    for (int i = 0; i < 48; i++)
        n.hand[i] += OF_FRAME * own.hand[i];
    for (int i = 0; i < 3; i++) {
        n.object[i] += OF_FRAME * own.object[i];
        n.shift[i] += OF_FRAME * own.shift[i];
    }
    return n;
}

/* A rotation turned by a few degrees, in place. */
static void turn(const double by[3], double R[9])
{
    double T[9];

    lt_rot_from_axis_angle(by, T);
    lt_mat3_mul(T, R, R);
}

void pose_noise_apply(const pose_noise *n, double pose[48], double R[9], double t[3])
{
    double root[9];

    lt_rot_from_axis_angle(pose, root);
    turn(n->hand, root);
    lt_rot_to_axis_angle(root, pose);
    for (int i = 3; i < 48; i++)
        pose[i] += n->hand[i];
    turn(n->object, R);
    for (int k = 0; k < 3; k++)
        t[k] += n->shift[k];
}
