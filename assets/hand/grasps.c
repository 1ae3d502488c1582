/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Plausible grasps, and the mean pose and principal directions that come of them.
 *
 * Source: Santello, Flanders, Soechting 1998, "Postural hand synergies for tool use", for the idea that
 * a few common movements account for most of a grasp.
 */
#include "assets/hand/internal.h"
#include "libtensor/geometry/eigen.h"

#include <string.h>

#define RAD(deg) ((deg) * (M_PI / 180))

enum { GRASPS = 2048, POSE = LT_HAND_PCA };

static const uint64_t GRASP_STREAM = 0x68616e64;

static void draw_finger(lt_rng *rng, double close, double spread, double angles[3][3])
{
    const double own = close + 0.12 * lt_rng_normal(rng);
    const double knuckle = own + 0.18 * lt_rng_normal(rng);

    angles[0][SYNTH_HAND_FLEX] = RAD(-5) + RAD(80) * knuckle;
    angles[0][SYNTH_HAND_SPREAD] = spread + RAD(3) * lt_rng_normal(rng);
    angles[0][SYNTH_HAND_TWIST] = RAD(1.5) * lt_rng_normal(rng);
    angles[1][SYNTH_HAND_FLEX] = RAD(5) + RAD(90) * (own + 0.08 * lt_rng_normal(rng));
    angles[1][SYNTH_HAND_SPREAD] = angles[1][SYNTH_HAND_TWIST] = 0;
    angles[2][SYNTH_HAND_FLEX] = 0.67 * angles[1][SYNTH_HAND_FLEX] + RAD(4) * lt_rng_normal(rng);
    angles[2][SYNTH_HAND_SPREAD] = angles[2][SYNTH_HAND_TWIST] = 0;
}

static void draw_thumb(lt_rng *rng, double close, double oppose, double angles[3][3])
{
    memset(angles, 0, sizeof(double[3][3]));
    angles[0][SYNTH_HAND_FLEX] = RAD(-12) + RAD(45) * oppose + RAD(6) * lt_rng_normal(rng);
    angles[0][SYNTH_HAND_SPREAD] = RAD(5) + RAD(30) * oppose + RAD(8) * lt_rng_normal(rng);
    angles[0][SYNTH_HAND_TWIST] = RAD(5) - RAD(25) * oppose + RAD(5) * lt_rng_normal(rng);
    angles[1][SYNTH_HAND_FLEX] = RAD(5) + RAD(35) * close + RAD(8) * lt_rng_normal(rng);
    angles[1][SYNTH_HAND_SPREAD] = RAD(3) * lt_rng_normal(rng);
    angles[2][SYNTH_HAND_FLEX] = RAD(50) * close + RAD(12) * lt_rng_normal(rng);
}

void synth_hand_draw_angles(lt_rng *rng, double angles[15][3])
{
    static const double fan[4] = { 1, 0.1, -1.4, -0.7 }, order[4] = { -0.5, 0, 1, 0.5 };
    const double close = lt_rng_range(rng, 0, 1), tilt = 0.15 * lt_rng_normal(rng);
    const double spread = RAD(5) + RAD(6) * lt_rng_normal(rng), oppose = lt_rng_range(rng, 0, 1);

    for (int d = 0; d < 4; d++)
        draw_finger(rng, close + tilt * order[d], spread * fan[d], &angles[3 * d]);
    draw_thumb(rng, 0.6 * close + 0.4 * lt_rng_uniform(rng), oppose, &angles[12]);
    synth_hand_clamp_angles(angles);
}

/* A relaxed hand. */
static void mean_angles(double angles[15][3])
{
    static const double relaxed[3] = { RAD(20), RAD(35), RAD(20) };

    memset(angles, 0, sizeof(double[15][3]));
    for (int i = 0; i < 12; i++)
        angles[i][SYNTH_HAND_FLEX] = relaxed[i % 3];
    angles[12][SYNTH_HAND_SPREAD] = RAD(15);
}

static void covariance(double (*poses)[POSE], double cov[POSE][POSE])
{
    double mean[POSE] = { 0 };

    for (int g = 0; g < GRASPS; g++)
        for (int i = 0; i < POSE; i++)
            mean[i] += poses[g][i] / GRASPS;
    memset(cov, 0, sizeof(double[POSE][POSE]));
    for (int g = 0; g < GRASPS; g++)
        for (int i = 0; i < POSE; i++)
            for (int j = 0; j <= i; j++)
                cov[i][j] += (poses[g][i] - mean[i]) * (poses[g][j] - mean[j]) / GRASPS;
    for (int i = 0; i < POSE; i++)
        for (int j = 0; j < i; j++)
            cov[j][i] = cov[i][j];
}

/* Rows by falling variance, each with its largest number positive. */
static void store_components(double a[POSE][POSE], double v[POSE][POSE], float out[POSE][POSE])
{
    bool used[POSE] = { false };

    for (int r = 0; r < POSE; r++) {
        int best = -1, big = 0;

        for (int i = 0; i < POSE; i++)
            if (!used[i] && (best < 0 || a[i][i] > a[best][best]))
                best = i;
        used[best] = true;
        for (int i = 0; i < POSE; i++)
            big = fabs(v[best][i]) > fabs(v[best][big]) ? i : big;
        for (int i = 0; i < POSE; i++)
            out[r][i] = (float)copysign(1, v[best][big]) * (float)v[best][i];
    }
}

lt_status hand_pose_space(lt_arena *arena, lt_hand_model *model)
{
    double (*poses)[POSE] = lt_arena_array(arena, GRASPS, sizeof(*poses));
    double (*cov)[POSE] = lt_arena_array(arena, 2 * POSE, sizeof(*cov)), (*v)[POSE] = cov + POSE;
    double angles[15][3], mean[POSE];
    synth_hand_frames frames;

    if (!poses || !cov)
        return lt_error(LT_ENOMEM, "synthetic hand: no memory for its grasps");
    synth_hand_frames_init(&frames, model);
    mean_angles(angles);
    synth_hand_angles_to_pose(&frames, angles, mean);
    for (int i = 0; i < POSE; i++)
        model->hands_mean[i] = (float)mean[i];
    for (int g = 0; g < GRASPS; g++) {
        lt_rng rng = lt_rng_make(GRASP_STREAM, (uint64_t)g);

        synth_hand_draw_angles(&rng, angles);
        synth_hand_angles_to_pose(&frames, angles, poses[g]);
    }
    covariance(poses, cov);
    lt_eigen_symmetric(POSE, cov[0], v[0]);
    store_components(cov, v, model->hands_components);
    return LT_OK;
}
