/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Poses in the words of anatomy: flexion, spread and twist of each joint, and how far they go.
 *
 * Source: ranges of motion as in clinical tables; a last finger joint follows the one before it because
 * one tendon bends both.
 */
#include "assets/hand/hand.h"
#include "libtensor/geometry/rotation.h"

#define RAD(deg) ((deg) * (M_PI / 180))

/* MANO's order: index, middle, little, ring, thumb; flex, spread, twist of each joint. */
#define MCP { { RAD(-20), RAD(-20), RAD(-5) }, { RAD(90), RAD(20), RAD(5) } }
#define PIP { { RAD(0), 0, 0 }, { RAD(110), 0, 0 } }
#define DIP { { RAD(-5), 0, 0 }, { RAD(80), 0, 0 } }
#define FINGER MCP, PIP, DIP

const synth_hand_limit synth_hand_limits[15] = {
    FINGER, FINGER, FINGER, FINGER,
    { { RAD(-20), RAD(-15), RAD(-30) }, { RAD(45), RAD(45), RAD(30) } },
    { { RAD(-5), RAD(-10), 0 }, { RAD(60), RAD(10), 0 } },
    { { RAD(-15), 0, 0 }, { RAD(85), 0, 0 } },
};

static const double thumb_dorsal[3] = { 0.35, 0.35, 0.8 };     /* of a right hand at rest */

void synth_hand_parts(const lt_hand_model *model, uint8_t part[LT_HAND_VERTICES])
{
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        part[v] = 0;
        for (int j = 1; j < LT_HAND_JOINTS; j++)
            if (model->weights[v][j] > model->weights[v][part[v]])
                part[v] = (uint8_t)j;
    }
}

static void rest_joint(const lt_hand_model *model, int j, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int c = 0; c < 3; c++)
            out[c] += (double)model->J_regressor[j][v] * model->v_template[v][c];
}

/* The end of the bone that starts at joint j: the next joint, or the tip of the digit. */
static void bone_end(const lt_hand_model *model, int j, double out[3])
{
    static const int tip_of_digit[5] = { 1, 2, 4, 3, 0 }; /* joints' order to thumb-first order */

    if (j % 3)
        rest_joint(model, j + 1, out);
    else
        for (int c = 0; c < 3; c++)
            out[c] = model->v_template[lt_hand_tips_ho3d[tip_of_digit[(j - 1) / 3]]][c];
}

void synth_hand_frames_init(synth_hand_frames *frames, const lt_hand_model *model)
{
    frames->left = model->left;
    for (int i = 0; i < 15; i++) {
        double *bone = frames->bone[i], *up = frames->dorsal[i], here[3], end[3];

        rest_joint(model, i + 1, here);
        bone_end(model, i + 1, end);
        lt_vec3_sub(end, here, bone);
        lt_vec3_unit(bone);
        for (int c = 0; c < 3; c++)
            up[c] = i >= 12 ? thumb_dorsal[c] : c == 1;
        if (model->left)
            up[0] = -up[0];
        const double lift = lt_vec3_dot(up, bone);
        for (int c = 0; c < 3; c++)
            up[c] -= lift * bone[c];
        lt_vec3_unit(up);
        lt_vec3_cross(up, bone, frames->flex[i]);
    }
}

/* Columns dorsal, bone, flex: rotations about them are turns about x, y and z. */
static void frame_matrix(const synth_hand_frames *frames, int i, double F[9])
{
    for (int c = 0; c < 3; c++) {
        F[3 * c] = frames->dorsal[i][c];
        F[3 * c + 1] = frames->bone[i][c];
        F[3 * c + 2] = frames->flex[i][c];
    }
}

/* A mirrored hand bends alike about its flexion axis, and turns the other way about the other two. */
static double side(const synth_hand_frames *frames) { return frames->left ? -1 : 1; }

void synth_hand_angles_to_pose(const synth_hand_frames *frames, double angles[15][3],
                               double pose[45])
{
    for (int i = 0; i < 15; i++) {
        const double s = side(frames), *a = angles[i];
        const double cf = cos(a[0]), sf = sin(a[0]), cs = cos(a[1]), ss = sin(s * a[1]);
        const double ct = cos(a[2]), st = sin(s * a[2]);
        const double M[9] = { cf * ct - sf * ss * st, -sf * cs, cf * st + sf * ss * ct,
                              sf * ct + cf * ss * st, cf * cs, sf * st - cf * ss * ct,
                              -cs * st, ss, cs * ct };      /* Rz(flex) Rx(spread) Ry(twist) */
        double F[9], Ft[9], T[9], R[9];

        frame_matrix(frames, i, F);
        lt_mat3_transpose(F, Ft);
        lt_mat3_mul(F, M, T);
        lt_mat3_mul(T, Ft, R);
        lt_rot_to_axis_angle(R, pose + 3 * i);
    }
}

void synth_hand_pose_to_angles(const synth_hand_frames *frames, const double pose[45],
                               double angles[15][3])
{
    for (int i = 0; i < 15; i++) {
        double F[9], Ft[9], T[9], R[9], M[9];

        lt_rot_from_axis_angle(pose + 3 * i, R);
        frame_matrix(frames, i, F);
        lt_mat3_transpose(F, Ft);
        lt_mat3_mul(Ft, R, T);
        lt_mat3_mul(T, F, M);
        angles[i][SYNTH_HAND_FLEX] = atan2(-M[1], M[4]);
        angles[i][SYNTH_HAND_SPREAD] = side(frames) * asin(fmax(-1, fmin(1, M[7])));
        angles[i][SYNTH_HAND_TWIST] = side(frames) * atan2(-M[6], M[8]);
    }
}

static double into(double x, double lo, double hi) { return fmin(fmax(x, lo), hi); }

static void clamp_finger(double angles[3][3])
{
    const double bent = into(angles[0][SYNTH_HAND_FLEX] / RAD(90), 0, 1),
                 follow = angles[1][SYNTH_HAND_FLEX] * 0.67;
    const double room = RAD(20) * (1 - bent);

    angles[0][SYNTH_HAND_SPREAD] = into(angles[0][SYNTH_HAND_SPREAD], -room, room);
    angles[2][SYNTH_HAND_FLEX] = into(angles[2][SYNTH_HAND_FLEX], fmax(follow - RAD(10), RAD(-5)),
                                      fmin(follow + RAD(10), RAD(80)));
}

void synth_hand_clamp_angles(double angles[15][3])
{
    for (int i = 0; i < 15; i++)
        for (int k = 0; k < 3; k++)
            angles[i][k] =
                into(angles[i][k], synth_hand_limits[i].lo[k], synth_hand_limits[i].hi[k]);
    for (int digit = 0; digit < 4; digit++)
        clamp_finger(&angles[3 * digit]);
}
