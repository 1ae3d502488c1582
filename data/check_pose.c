/* SPDX-License-Identifier: Apache-2.0 */
/* The annotated hands against the hand model; and when they do not agree, the slips that people make. */
#include "data/check.h"

#include "data/hand_pose.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, MIDDLE_TIP = 12 };

static const double LIMIT_MM = 1, IN_VIEW = 0.5, BESIDE = 0.25;

/* ---- slips: each turns what was read into what would have been meant ---- */

typedef struct { float (*joints)[3]; double (*aa)[3]; lt_hand_model *hand; } reading;

static void permute(float (*joints)[3], const int *from)
{
    float old[J][3];

    memcpy(old, joints, sizeof(old));
    for (int i = 0; i < J; i++)
        memcpy(joints[i], old[from[i]], sizeof(old[0]));
}

static void mano_order(const reading *r) { permute(r->joints, lt_mano_to_simple); }
static void simple_order(const reading *r) { permute(r->joints, lt_simple_to_mano); }

static void interhand_order(const reading *r)
{
    static const int from[J] = { 20, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, 19, 18, 17, 16 };

    permute(r->joints, from);
}

static void opengl_axes(const reading *r)
{
    for (int i = 0; i < J; i++)
        for (int k = 1; k < 3; k++)
            r->joints[i][k] = -r->joints[i][k];
}

static void millimetres(const reading *r)
{
    for (int i = 0; i < J; i++)
        for (int k = 0; k < 3; k++)
            r->joints[i][k] /= 1000;
}

static void add_mean(const reading *r, double sign)
{
    for (int i = 0; i < LT_HAND_PCA; i++)
        r->aa[1 + i / 3][i % 3] += sign * r->hand->hands_mean[i];
}

static void mean_left_out(const reading *r) { add_mean(r, 1); }
static void mean_added(const reading *r) { add_mean(r, -1); }

/* The numbers were coefficients, and were taken for angles. */
static void pca_as_angles(const reading *r)
{
    double c[LT_HAND_PCA];

    for (int k = 0; k < LT_HAND_PCA; k++)
        c[k] = r->aa[1 + k / 3][k % 3];
    for (int i = 0; i < LT_HAND_PCA; i++) {
        double x = r->hand->hands_mean[i];
        for (int k = 0; k < LT_HAND_PCA; k++)
            x += c[k] * r->hand->hands_components[k][i];
        r->aa[1 + i / 3][i % 3] = x;
    }
}

/* The numbers were angles, and were taken for coefficients: those are the projections on the components. */
static void angles_as_pca(const reading *r)
{
    double x[LT_HAND_PCA];

    for (int i = 0; i < LT_HAND_PCA; i++)
        x[i] = r->aa[1 + i / 3][i % 3] - r->hand->hands_mean[i];
    for (int k = 0; k < LT_HAND_PCA; k++) {
        double c = 0;
        for (int i = 0; i < LT_HAND_PCA; i++)
            c += x[i] * r->hand->hands_components[k][i];
        r->aa[1 + k / 3][k % 3] = c;
    }
}

static void shape_sign(const reading *r)
{
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int b = 0; b < LT_HAND_BETAS; b++)
            r->hand->shapedirs[v][0][b] = -r->hand->shapedirs[v][0][b];
}

typedef struct {
    const char *name;
    void (*turn)(const reading *r);
    bool left_only;
} slip;

static const slip slips[] = {
    { "the joints are in MANO's order (index, middle, little, ring, thumb; tips last)", mano_order, false },
    { "the joints are ordered from thumb to little finger, not as MANO has them", simple_order, false },
    { "the joints are ordered from the tips down, as InterHand has them", interhand_order, false },
    { "the joints have OpenGL's axes (y up, z backward)", opengl_axes, false },
    { "the joints are in millimetres", millimetres, false },
    { "the pose is made of PCA coefficients, not of angles", pca_as_angles, false },
    { "the pose is made of angles, not of PCA coefficients", angles_as_pca, false },
    { "the pose lacks the mean pose (flat_hand_mean)", mean_left_out, false },
    { "the pose has the mean pose in it already (flat_hand_mean)", mean_added, false },
    { "the x row of the left hand's shapedirs has the other sign", shape_sign, true },
};

/* ---- measuring ---- */

typedef struct {
    const dataset *d;
    const lt_hand_model *hand;
    bool left;
    lt_hand_model *turned;          /* scratch: a copy that a slip may change */
    double (*vertices)[3];
} measure;

/* Sum of squared distances over the joints that are compared. */
static double squared_error(const measure *m, const lt_hand_model *hand, const double (*aa)[3], const double *beta,
                            const float (*joints)[3], int *compared)
{
    double R[LT_HAND_JOINTS * 9], posed[LT_HAND_JOINTS][3], key[J][3], sum = 0;

    for (int j = 0; j < LT_HAND_JOINTS; j++)
        lt_rot_from_axis_angle(aa[j], R + 9 * j);
    lt_hand_pose(hand, R, beta, NULL, m->vertices[0], posed[0]);
    lt_hand_keypoints(m->vertices[0], posed[0], m->d->tips, LT_HAND_SIMPLE_ORDER, key[0]);
    *compared = 0;
    for (int i = 1; i < J; i++) {
        if (m->left && i == MIDDLE_TIP)
            continue;
        for (int k = 0; k < 3; k++) {
            const double e = (key[i][k] - key[0][k]) - ((double)joints[i][k] - joints[0][k]);
            sum += e * e;
        }
        (*compared)++;
    }
    return sum;
}

static double error_with(const measure *m, const dataset_sample *s, const slip *what, int *compared)
{
    float joints[J][3];
    double R[LT_HAND_JOINTS][9], beta[LT_HAND_BETAS], aa[LT_HAND_JOINTS][3];
    const reading r = { joints, aa, m->turned };

    memcpy(joints, s->joints, sizeof(joints));
    hand_pose_widen(s->rotation[0], s->beta, R[0], beta);
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        lt_rot_to_axis_angle(R[j], aa[j]);
    if (what) {
        *m->turned = *m->hand;
        what->turn(&r);
    }
    return squared_error(m, what ? m->turned : m->hand, (const double (*)[3])aa, beta, (const float (*)[3])joints,
                         compared);
}

static int count_in_view(const dataset_sample *s)
{
    const double u0 = BESIDE * s->width, v0 = BESIDE * s->height;
    int n = 0;

    for (int i = 0; i < J; i++) {
        const double p[3] = { s->joints[i][0], s->joints[i][1], s->joints[i][2] };
        double uv[2];
        n += lt_camera_project(&s->camera, p, uv) && uv[0] >= -u0 && uv[0] < s->width + u0 && uv[1] >= -v0 &&
             uv[1] < s->height + v0;
    }
    return n;
}

static bool usable(const measure *m, const dataset_sample *s)
{
    const unsigned need = SAMPLE_HAND_POSE | SAMPLE_JOINTS;

    return (s->flags & need) == need && !!(s->flags & SAMPLE_MIRRORED) == m->left;
}

/* Root mean square over up to n hands, in mm. */
static double rms_with(const measure *m, int64_t n, const slip *what, int64_t *hands, double *in_view)
{
    int64_t compared = 0, seen = 0, used = 0;
    double sum = 0;

    for (int64_t i = 0; i < n; i++) {
        lt_arena *arena = lt_arena_new();
        dataset_sample s;
        int c = 0;
        if (arena && !dataset_annotation(m->d, i * m->d->count / n, arena, &s) && usable(m, &s)) {
            sum += error_with(m, &s, what, &c);
            compared += c;
            seen += count_in_view(&s);
            used++;
        }
        lt_arena_free(arena);
    }
    *hands = used;
    *in_view = used ? (double)seen / (double)(J * used) : 0;
    return compared ? 1000 * sqrt(sum / (double)compared) : 0;
}

bool check_hands_good(const check_hands *c)
{
    return !c->hands || (c->rms_mm <= LIMIT_MM && c->in_view >= IN_VIEW);
}

/* The slip that brings model and annotation together; else, of axes, what the place of the hands tells. */
static const char *explain(const measure *m, int64_t n, const check_hands *c)
{
    for (size_t i = 0; c->rms_mm > LIMIT_MM && i < LT_COUNT(slips); i++) {
        int64_t hands;
        double in_view;
        if ((!slips[i].left_only || m->left) && rms_with(m, n, &slips[i], &hands, &in_view) <= LIMIT_MM)
            return slips[i].name;
    }
    return c->rms_mm <= LIMIT_MM ? "the hands are not where the camera looks: OpenGL axes, or another unit" : NULL;
}

lt_status check_pose(const dataset *d, const lt_hand_model *hand, int64_t n, bool left, check_hands *out)
{
    measure m = { .d = d, .hand = hand, .left = left, .turned = malloc(sizeof(*m.turned)),
                  .vertices = malloc(LT_HAND_VERTICES * sizeof(*m.vertices)) };
    check_hands c = { 0 };

    n = lt_min_i64(n, d->count);
    if (m.turned && m.vertices) {
        c.rms_mm = rms_with(&m, n, NULL, &c.hands, &c.in_view);
        if (!check_hands_good(&c))
            c.slip = explain(&m, n, &c);
        *out = c;
    }
    free(m.vertices);
    free(m.turned);
    return m.turned && m.vertices ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", d->root);
}
