/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A MANO-shaped hand as 21 joint angles: axes and limits of the human hand, skin, pads and the spheres that
 * keep bones out of things.
 */
#include "synth/grasp/internal.h"

#include "assets/hand/hand.h"
#include "libtensor/geometry/rotation.h"

#include <string.h>

#define DEG (M_PI / 180)

/* Towards the back of each digit at rest; made square to its first bone before use. */
static const double dorsal_hint[FINGERS][3] = {
    { 0, 1, 0 }, { 0, 1, 0 }, { 0, 1, 0 }, { 0, 1, 0 }, { -0.05, 0.72, 0.55 },
};

static int digit_joint(int finger, int phalanx) { return 1 + 3 * finger + phalanx; }

/* ---- shape ---------------------------------------------------------------------------------------- */

static void shape_skin(grasp_hand *h)
{
    const lt_hand_model *m = h->model;

    memset(h->J, 0, sizeof(h->J));
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int k = 0; k < 3; k++) {
            double x = m->v_template[v][k];
            for (int b = 0; b < LT_HAND_BETAS; b++)
                x += h->beta[b] * m->shapedirs[v][k][b];
            h->rest[v][k] = x;
            for (int j = 0; j < LT_HAND_JOINTS; j++)
                h->J[j][k] += m->J_regressor[j][v] * x;
        }
}

/* The heaviest MAX_WEIGHTS, rescaled to sum to 1. */
static void take_weights(grasp_hand *h, int v)
{
    double sum = 0;
    int n = 0;

    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        const double w = h->model->weights[v][j];
        int i = n;
        if (w < 1e-4)
            continue;
        for (; i > 0 && h->weight[v][i - 1] < w; i--)
            if (i < MAX_WEIGHTS) {
                h->weight[v][i] = h->weight[v][i - 1];
                h->weight_joint[v][i] = h->weight_joint[v][i - 1];
            }
        if (i == MAX_WEIGHTS)
            continue;
        h->weight[v][i] = w;
        h->weight_joint[v][i] = (uint8_t)j;
        n += n < MAX_WEIGHTS;
    }
    for (int i = 0; i < n; i++)
        sum += h->weight[v][i];
    for (int i = 0; i < n; i++)
        h->weight[v][i] /= sum;
    h->n_weights[v] = (uint8_t)n;
}

static void rest_normals(grasp_hand *h, double (*normal)[3])
{
    memset(normal, 0, sizeof(*normal) * LT_HAND_VERTICES);
    for (int f = 0; f < LT_HAND_FACES; f++) {
        const int32_t *i = h->model->faces[f];
        double a[3], b[3], n[3];
        lt_vec3_sub(h->rest[i[1]], h->rest[i[0]], a);
        lt_vec3_sub(h->rest[i[2]], h->rest[i[0]], b);
        lt_vec3_cross(a, b, n);
        for (int c = 0; c < 3; c++) {
            h->area[i[c]] += lt_vec3_norm(n) / 6;
            for (int k = 0; k < 3; k++)
                normal[i[c]][k] += n[k];
        }
    }
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        lt_vec3_unit(normal[v]);
}

static void bone_frame(const grasp_hand *h, int finger, double along[3], double dorsal[3], double flex[3])
{
    const double *a = h->J[digit_joint(finger, 0)], *b = h->J[digit_joint(finger, 1)];
    double d;

    lt_vec3_sub(b, a, along);
    lt_vec3_unit(along);
    d = lt_vec3_dot(along, dorsal_hint[finger]);
    for (int k = 0; k < 3; k++)
        dorsal[k] = dorsal_hint[finger][k] - d * along[k];
    lt_vec3_unit(dorsal);
    lt_vec3_cross(dorsal, along, flex);
}

/* Palmar skin: what is to touch. */
static void mark_pads(grasp_hand *h, double (*normal)[3])
{
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        const int j = h->weight_joint[v][0];
        double along[3], dorsal[3], flex[3];
        h->finger[v] = (int8_t)(j ? (j - 1) / 3 : -1);
        h->pad[v] = -1;
        if (!j) {
            if (normal[v][1] < -0.6)
                h->pad[v] = 15;
            continue;
        }
        bone_frame(h, h->finger[v], along, dorsal, flex);
        if (lt_vec3_dot(normal[v], dorsal) < -0.45 && h->weight[v][0] > 0.6)
            h->pad[v] = (int8_t)(j - 1);
    }
}

/* ---- angles --------------------------------------------------------------------------------------- */

static void set_angle(hand_angle *a, int joint, const double axis[3], double sign, double lo, double hi)
{
    *a = (hand_angle){ .joint = joint, .lo = lo * DEG, .hi = hi * DEG };
    for (int k = 0; k < 3; k++)
        a->axis[k] = sign * axis[k];
}

/* Ranges of motion in degrees; positive flexion bends, positive spread leads towards the thumb, for the
 * thumb away from the palm. */
static void set_angles(grasp_hand *h)
{
    for (int f = 0; f < FINGERS; f++) {
        hand_angle *a = &h->angle[finger_angle(f)];
        const int j = digit_joint(f, 0);
        double along[3], dorsal[3], flex[3];
        bone_frame(h, f, along, dorsal, flex);
        if (f == THUMB) {
            set_angle(a++, j, along, 1, -30, 30);
            set_angle(a++, j, dorsal, 1, -15, 45);
            set_angle(a++, j, flex, 1, -20, 45);
            set_angle(a++, j + 1, flex, 1, -5, 60);
            set_angle(a++, j + 2, flex, 1, -15, 85);
        } else {
            set_angle(a++, j, dorsal, 1, -15, 15);
            set_angle(a++, j, flex, 1, -20, 90);
            set_angle(a++, j + 1, flex, 1, 0, 105);
            set_angle(a++, j + 2, flex, 1, -5, 75);
        }
    }
}

/* ---- spheres -------------------------------------------------------------------------------------- */

/* Mean distance of a joint's own skin from the line a-b. */
static double flesh(const grasp_hand *h, int joint, const double a[3], const double b[3])
{
    double sum = 0, along[3], n = 0;

    lt_vec3_sub(b, a, along);
    lt_vec3_unit(along);
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        double p[3], c[3];
        if (h->weight_joint[v][0] != joint || h->weight[v][0] < 0.8)
            continue;
        lt_vec3_sub(h->rest[v], a, p);
        lt_vec3_cross(along, p, c);
        sum += lt_vec3_norm(c);
        n++;
    }
    return n > 0 ? sum / n : 8e-3;
}

static void finger_tip(const grasp_hand *h, int finger, double out[3])
{
    static const int order[FINGERS] = { 1, 2, 4, 3, 0 };    /* into lt_hand_tips_* */
    const int joint = digit_joint(finger, 2);
    const double *tip = h->rest[lt_hand_tips_ho3d[order[finger]]];
    double along[3], reach = 0;

    lt_vec3_sub(tip, h->J[joint], along);
    lt_vec3_unit(along);
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        double p[3];
        if (h->weight_joint[v][0] != joint)
            continue;
        lt_vec3_sub(h->rest[v], h->J[joint], p);
        reach = fmax(reach, lt_vec3_dot(p, along));
    }
    for (int k = 0; k < 3; k++)
        out[k] = h->J[joint][k] + reach * along[k];
}

/* Three on each phalanx, three along each metacarpal of the four fingers. */
static void set_spheres(grasp_hand *h)
{
    int n = 0;

    for (int f = 0; f < FINGERS; f++)
        for (int p = 0; p < 3; p++) {
            const int j = digit_joint(f, p);
            double end[3], r;
            if (p == 2)
                finger_tip(h, f, end);
            else
                memcpy(end, h->J[j + 1], sizeof(end));
            r = flesh(h, j, h->J[j], end);
            for (int i = 0; i < 3; i++, n++) {
                const double s = p == 2 ? 0.08 + 0.28 * i : (i + 0.5) / 3;
                h->sphere[n] = (hand_sphere){ .joint = j, .radius = r };
                for (int k = 0; k < 3; k++)
                    h->sphere[n].at[k] = h->J[j][k] + s * (end[k] - h->J[j][k]);
            }
        }
    for (int f = 0; f < THUMB; f++)
        for (int i = 0; i < 3; i++, n++) {
            h->sphere[n] = (hand_sphere){ .joint = 0, .radius = 9.5e-3 };
            for (int k = 0; k < 3; k++)
                h->sphere[n].at[k] = h->J[0][k] + (0.42 + 0.26 * i) * (h->J[digit_joint(f, 0)][k] - h->J[0][k]);
        }
}

void grasp_hand_init(grasp_hand *h, const lt_hand_model *model, const double *beta)
{
    double normal[LT_HAND_VERTICES][3];

    memset(h, 0, sizeof(*h));
    h->model = model;
    if (beta)
        memcpy(h->beta, beta, sizeof(h->beta));
    synth_hand_parts(model, h->part);
    shape_skin(h);
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        take_weights(h, v);
    rest_normals(h, normal);
    mark_pads(h, normal);
    set_angles(h);
    set_spheres(h);
}

/* ---- posing --------------------------------------------------------------------------------------- */

void grasp_axis_turn(const double a[3], double angle, double R[9])
{
    const double c = cos(angle), s = sin(angle), d = 1 - c;

    R[0] = c + d * a[0] * a[0];
    R[1] = d * a[0] * a[1] - s * a[2];
    R[2] = d * a[0] * a[2] + s * a[1];
    R[3] = d * a[1] * a[0] + s * a[2];
    R[4] = c + d * a[1] * a[1];
    R[5] = d * a[1] * a[2] - s * a[0];
    R[6] = d * a[2] * a[0] - s * a[1];
    R[7] = d * a[2] * a[1] + s * a[0];
    R[8] = c + d * a[2] * a[2];
}

/* Local rotation of a joint as the product of its angles' turns; axes as they stand before the parent. */
static int turn_joint(const grasp_hand *h, const hand_state *s, int joint, int a, double R[9],
                      double (*axis)[3])
{
    double T[9];

    lt_mat3_identity(R);
    for (; a < ANGLES && h->angle[a].joint == joint; a++) {
        lt_mat3_mulvec(R, h->angle[a].axis, axis[a]);
        grasp_axis_turn(h->angle[a].axis, s->q[a], T);
        lt_mat3_mul(R, T, R);
    }
    return a;
}

void grasp_hand_frames(const grasp_hand *h, const hand_state *s, hand_frames *f)
{
    int a = 0;

    memcpy(f->R[0], s->R, sizeof(s->R));
    memcpy(f->t[0], s->t, sizeof(s->t));
    for (int j = 1; j < LT_HAND_JOINTS; j++) {
        const int parent = lt_hand_parent[j], first = a;
        double R[9], d[3];
        a = turn_joint(h, s, j, a, R, f->axis);
        for (int i = first; i < a; i++)
            lt_mat3_mulvec(f->R[parent], f->axis[i], f->axis[i]);
        lt_mat3_mul(f->R[parent], R, f->R[j]);
        lt_vec3_sub(h->J[j], h->J[parent], d);
        lt_rigid_apply(f->R[parent], f->t[parent], d, f->t[j]);
    }
}

void grasp_hand_correct(const grasp_hand *h, const hand_state *s, double (*rest)[3])
{
    double feature[LT_HAND_POSE_FEATURES], axis[ANGLES][3], R[9];
    int a = 0;

    for (int j = 1; j < LT_HAND_JOINTS; j++) {
        a = turn_joint(h, s, j, a, R, axis);
        for (int i = 0; i < 9; i++)
            feature[9 * (j - 1) + i] = R[i] - (i % 4 == 0);
    }
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int k = 0; k < 3; k++) {
            const float *p = h->model->posedirs[v][k];
            double x = h->rest[v][k];
            for (int i = 0; i < LT_HAND_POSE_FEATURES; i++)
                x += p[i] * feature[i];
            rest[v][k] = x;
        }
}

void grasp_hand_skin(const grasp_hand *h, const hand_frames *f, const double (*rest)[3], int v, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; i < h->n_weights[v]; i++) {
        const int j = h->weight_joint[v][i];
        double d[3], p[3];
        lt_vec3_sub(rest[v], h->J[j], d);
        lt_rigid_apply(f->R[j], f->t[j], d, p);
        for (int k = 0; k < 3; k++)
            out[k] += h->weight[v][i] * p[k];
    }
}

void grasp_hand_sphere(const grasp_hand *h, const hand_frames *f, int i, double out[3])
{
    const hand_sphere *s = &h->sphere[i];
    double d[3];

    lt_vec3_sub(s->at, h->J[s->joint], d);
    lt_rigid_apply(f->R[s->joint], f->t[s->joint], d, out);
}

/* ---- axis-angle ----------------------------------------------------------------------------------- */

void grasp_hand_pose(const grasp_hand *h, const hand_state *s, double pose[48], double trans[3])
{
    double axis[ANGLES][3], R[9];
    int a = 0;

    lt_rot_to_axis_angle(s->R, pose);
    for (int j = 1; j < LT_HAND_JOINTS; j++) {
        a = turn_joint(h, s, j, a, R, axis);
        lt_rot_to_axis_angle(R, &pose[3 * j]);
    }
    for (int k = 0; k < 3; k++)
        trans[k] = s->t[k] - h->J[0][k];
}
