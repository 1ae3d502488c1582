/* SPDX-License-Identifier: Apache-2.0 */
/* The annotated hands against the hand model; and when they do not agree, the slips that people make. */
#include "data/check.h"

#include "data/hand_pose.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, MIDDLE_TIP = 12 };

static const double LIMIT_MM = 1, IN_VIEW = 0.5, BESIDE = 0.25;

/* ---- slips of the pose: each turns what was read into what would have been meant ---- */

typedef struct { double (*aa)[3]; lt_hand_model *hand; } reading;

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
    const char *words;
    void (*turn)(const reading *r);
    bool left_only;
} pose_slip;

static const pose_slip pose_slips[] = {
    { "the pose is made of PCA coefficients, not of angles", pca_as_angles, false },
    { "the pose is made of angles, not of PCA coefficients", angles_as_pca, false },
    { "the pose lacks the mean pose (flat_hand_mean)", mean_left_out, false },
    { "the pose has the mean pose in it already (flat_hand_mean)", mean_added, false },
    { "the x row of the left hand's shapedirs has the other sign", shape_sign, true },
};

/* ---- hands ---- */

/* What is kept of an annotated hand. */
typedef struct {
    float rotation[LT_HAND_JOINTS][9], beta[LT_HAND_BETAS];
    lt_camera camera;
    int width, height;
} annotated;

typedef struct {
    const dataset *d;
    const lt_hand_model *hand;
    bool left;
    int64_t n;
    annotated *label;               /* (n) */
    float (*joints)[J][3];          /* (n) as annotated */
    float (*posed)[J][3];           /* (n) as the model has them, the wrist where it is at rest */
    lt_hand_model *turned;          /* scratch: a copy that a slip may change */
    double (*vertices)[3];          /* scratch */
} measure;

static bool usable(const measure *m, const dataset_sample *s)
{
    const unsigned need = SAMPLE_HAND_POSE | SAMPLE_JOINTS;

    return (s->flags & need) == need && !!(s->flags & SAMPLE_MIRRORED) == m->left;
}

static void collect(measure *m, int64_t most)
{
    for (int64_t i = 0; i < most; i++) {
        lt_arena *arena = lt_arena_new();
        dataset_sample s;
        if (arena && !dataset_annotation(m->d, i * m->d->count / most, arena, &s) && usable(m, &s)) {
            annotated *a = &m->label[m->n];
            *a = (annotated){ .camera = s.camera, .width = s.width, .height = s.height };
            memcpy(a->rotation, s.rotation, sizeof(a->rotation));
            memcpy(a->beta, s.beta, sizeof(a->beta));
            memcpy(m->joints[m->n++], s.joints, sizeof(s.joints));
        }
        lt_arena_free(arena);
    }
}

/* The model in the annotated pose, as it was read or, with a slip, as it would have been meant. */
static void pose_one(measure *m, int64_t i, const pose_slip *what)
{
    double R[LT_HAND_JOINTS][9], beta[LT_HAND_BETAS], aa[LT_HAND_JOINTS][3], joints[LT_HAND_JOINTS][3], key[J][3];
    const reading r = { aa, m->turned };

    hand_pose_widen(m->label[i].rotation[0], m->label[i].beta, R[0], beta);
    if (what) {
        *m->turned = *m->hand;
        for (int j = 0; j < LT_HAND_JOINTS; j++)
            lt_rot_to_axis_angle(R[j], aa[j]);
        what->turn(&r);
        for (int j = 0; j < LT_HAND_JOINTS; j++)
            lt_rot_from_axis_angle(aa[j], R[j]);
    }
    lt_hand_pose(what ? m->turned : m->hand, R[0], beta, NULL, m->vertices[0], joints[0]);
    lt_hand_keypoints(m->vertices[0], joints[0], m->d->tips, LT_HAND_SIMPLE_ORDER, key[0]);
    for (int k = 0; k < 3 * J; k++)
        m->posed[i][k / 3][k % 3] = (float)key[k / 3][k % 3];
}

static void pose_all(measure *m, const pose_slip *what)
{
    for (int64_t i = 0; i < m->n; i++)
        pose_one(m, i, what);
}

/* Root mean square in mm, wrist on wrist. */
static double rms_mm(const measure *m)
{
    double sum = 0;

    for (int64_t i = 0; i < m->n; i++)
        for (int j = 1; j < J; j++)
            for (int k = 0; k < 3 && !(m->left && j == MIDDLE_TIP); k++) {
                const double ours = (double)m->posed[i][j][k] - m->posed[i][0][k];
                const double e = ours - ((double)m->joints[i][j][k] - m->joints[i][0][k]);
                sum += e * e;
            }
    return m->n ? 1000 * sqrt(sum / (double)(m->n * (J - 1 - m->left))) : 0;
}

/* The share of the joints that a camera has in view, or a little beside it; sign: of their y and z. */
static double share_in_view(const measure *m, int sign)
{
    int64_t seen = 0;

    for (int64_t i = 0; i < m->n; i++) {
        const annotated *a = &m->label[i];
        const double u0 = BESIDE * a->width, v0 = BESIDE * a->height;
        for (int j = 0; j < J; j++) {
            const float *x = m->joints[i][j];
            const double p[3] = { x[0], sign * x[1], sign * x[2] };
            double uv[2];
            seen += lt_camera_project(&a->camera, p, uv) && uv[0] >= -u0 && uv[0] < a->width + u0 && uv[1] >= -v0 &&
                    uv[1] < a->height + v0;
        }
    }
    return m->n ? (double)seen / (double)(J * m->n) : 0;
}

bool check_hands_good(const check_hands *c)
{
    return !c->hands || (c->rms_mm <= LIMIT_MM && c->in_view >= IN_VIEW);
}

/* ---- what would make them fit ---- */

static slip_file file_of(const dataset *d)
{
    return (slip_file){ .opengl = d->opengl };
}

static void explain_joints(const measure *m, slip *out)
{
    const slip_points p = { .what = "the joints", .file = file_of(m->d), .n = m->n, .points = J,
                            .found = m->joints[0][0], .wanted = m->posed[0][0], .skip = m->left ? MIDDLE_TIP : -1 };

    slip_in_points(&p, out);
}

/* A slip of the pose, alone or with one of the joints, that leaves nothing unexplained; else what the joints tell. */
static void explain_pose(measure *m, slip *out)
{
    slip joints, with;

    explain_joints(m, &joints);
    *out = joints;
    for (size_t i = 0; !(1000 * out->after <= LIMIT_MM) && i < LT_COUNT(pose_slips); i++) {
        const pose_slip *s = &pose_slips[i];
        if (s->left_only && !m->left)
            continue;
        pose_all(m, s);
        explain_joints(m, &with);
        if (!(1000 * with.after <= LIMIT_MM))
            continue;
        *out = (slip){ .code = "pose", .before = joints.before, .after = with.after };
        snprintf(out->text, sizeof(out->text), "%.80s%s%.200s", s->words, with.code ? ", and " : "",
                 with.text);
    }
}

/* Hands that agree with themselves, but not with the camera. */
static void explain_view(const measure *m, slip *out)
{
    static const char where[] = "the hands are not where the camera looks";
    slip camera;

    *out = (slip){ .code = "axes" };
    slip_in_camera(&m->label[0].camera, m->label[0].width, m->label[0].height, &camera);
    if (camera.code) {
        out->code = camera.code;
        snprintf(out->text, sizeof(out->text), "%s: %.200s", where, camera.text);
    } else if (share_in_view(m, -1) >= IN_VIEW) {
        snprintf(out->text, sizeof(out->text), "%s: poses and joints have %s", where, m->d->opengl ?
                 "OpenCV's axes (y down, z forward), not OpenGL's" : "OpenGL's axes (y up, z backward), not OpenCV's");
    } else {
        out->code = "place";
        snprintf(out->text, sizeof(out->text), "%s: counted from another place, or another camera's", where);
    }
}

static void compare(measure *m, check_hands *out)
{
    pose_all(m, NULL);
    *out = (check_hands){ .hands = m->n, .rms_mm = rms_mm(m), .in_view = share_in_view(m, 1) };
    if (check_hands_good(out))
        return;
    if (out->rms_mm > LIMIT_MM)
        explain_pose(m, &out->slip);
    else
        explain_view(m, &out->slip);
}

lt_status check_pose(const dataset *d, const lt_hand_model *hand, int64_t n, bool left, check_hands *out)
{
    lt_arena *arena = lt_arena_new();
    measure m = { .d = d, .hand = hand, .left = left };

    n = lt_min_i64(n, d->count);
    if (arena) {
        m.label = lt_arena_array(arena, (size_t)n, sizeof(*m.label));
        m.joints = lt_arena_array(arena, (size_t)n, sizeof(*m.joints));
        m.posed = lt_arena_array(arena, (size_t)n, sizeof(*m.posed));
        m.turned = lt_arena_alloc(arena, sizeof(*m.turned));
        m.vertices = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*m.vertices));
    }
    if (!arena || !m.label || !m.joints || !m.posed || !m.turned || !m.vertices) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "%s: no memory", d->root);
    }
    collect(&m, n);
    compare(&m, out);
    lt_arena_free(arena);
    return LT_OK;
}
