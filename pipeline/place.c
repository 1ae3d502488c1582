/* SPDX-License-Identifier: Apache-2.0 */
/* Where the hand is: its shape put where the heat maps see its joints, and as far away as a sensor measures them; and
 * whether the two agree; and whether what it holds is where it is. */
#include "pipeline/internal.h"

#include "libtensor/base/order.h"
#include "libtensor/geometry/translation.h"

#include <math.h>

static const double AGREEMENT = 0.1;                        /* of the hand box's side */
static const double GUESSED_DEPTH = 0.6;                    /* metres */
static const double UNDER_SKIN = 0.010, FAR_OFF = 0.25;     /* a joint, of what is seen; another thing's depth */
static const double GRASP = 0.1;                            /* a joint, of the box of what the hand holds */
enum { REACH = 2, FEW_JOINTS = 5 };                         /* pixels around a joint; joints that must be measured */

typedef struct {
    double X[3 * LT_HAND_KEYPOINTS], uv[2 * LT_HAND_KEYPOINTS], weight[LT_HAND_KEYPOINTS];
} sight;

static void see(const predict_result *r, sight *s)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        for (int d = 0; d < 3; d++)
            s->X[3 * i + d] = r->e.joints[i][d];
        for (int d = 0; d < 2; d++)
            s->uv[2 * i + d] = r->heatmap2d[i][d];
        s->weight[i] = r->e.peak[i];
    }
}

/* The median of what is known of the depth around a pixel; NaN where nothing is. */
static double depth_around(const predict_view *v, const double uv[2])
{
    double known[(2 * REACH + 1) * (2 * REACH + 1)];
    int n = 0;

    if (!(fabs(uv[0]) < v->width && fabs(uv[1]) < v->height))
        return NAN;
    for (int y = (int)lround(uv[1]) - REACH; y <= (int)lround(uv[1]) + REACH; y++)
        for (int x = (int)lround(uv[0]) - REACH; x <= (int)lround(uv[0]) + REACH; x++)
            if (x >= 0 && x < v->width && y >= 0 && y < v->height && v->depth[y * (int64_t)v->width + x] > 0)
                known[n++] = (double)v->depth[y * (int64_t)v->width + x];
    return lt_median(n, known);
}

/* The wrist's depth, were every joint as far away as it is measured; NaN where too few joints are. Without a mask of
 * the hand what stands before it is measured too. */
static double measured_depth(const predict_view *v, const sight *s)
{
    double wrist[LT_HAND_KEYPOINTS];
    int n = 0;

    for (int i = 0; v->depth && i < LT_HAND_KEYPOINTS; i++) {
        const double d = depth_around(v, s->uv + 2 * i);

        if (!isnan(d))
            wrist[n++] = d + UNDER_SKIN - s->X[3 * i + 2];
    }
    return n < FEW_JOINTS ? NAN : lt_median(n, wrist);
}

/* At an arm's length, in the middle of its box. */
static void guess_place(const predict_view *v, double t[3])
{
    const double middle[2] = { (v->hand_box.x0 + v->hand_box.x1) / 2, (v->hand_box.y0 + v->hand_box.y1) / 2 };

    lt_camera_backproject(&v->camera, middle, GUESSED_DEPTH, t);
}

/* What is measured counts where it is near what the joints' size says: else it is of something else. */
static bool find_place(const predict_view *v, const sight *s, predict_result *r, double t[3])
{
    if (lt_hand_translation(&v->camera, LT_HAND_KEYPOINTS, s->X, s->uv, s->weight, t))
        return false;
    r->solved_m = t[2];
    r->measured_m = measured_depth(v, s);
    if (fabs(r->measured_m - t[2]) < FAR_OFF)
        lt_hand_translation_at(&v->camera, LT_HAND_KEYPOINTS, s->X, s->uv, s->weight, r->measured_m, t);
    return t[2] > PREDICT_NEAREST && t[2] < PREDICT_FARTHEST;
}

static void move(float (*point)[3], int n, const double t[3])
{
    for (int i = 0; i < n; i++)
        for (int d = 0; d < 3; d++)
            point[i][d] += (float)t[d];
}

void predict_place_hand(const predict_view *v, predict_result *r)
{
    double t[3];
    sight s;

    see(r, &s);
    r->measured_m = r->solved_m = NAN;
    r->placed = find_place(v, &s, r, t);
    if (!r->placed)
        guess_place(v, t);
    move(r->e.joints, LT_HAND_KEYPOINTS, t);
    move(r->e.vertices, LT_HAND_VERTICES, t);
}

void predict_reproject(const predict_view *v, predict_result *r)
{
    double sum = 0;

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const double p[3] = { r->e.joints[i][0], r->e.joints[i][1], r->e.joints[i][2] };
        double uv[2];

        lt_camera_project(&v->camera, p, uv);
        r->joints2d[i][0] = (float)uv[0];
        r->joints2d[i][1] = (float)uv[1];
        sum += hypot(uv[0] - r->heatmap2d[i][0], uv[1] - r->heatmap2d[i][1]);
    }
    r->agreement_px = sum / LT_HAND_KEYPOINTS;
}

bool predict_trusted(const predict_view *v, const predict_result *r)
{
    const crop_box b = v->hand_box;

    return r->placed && r->agreement_px <= AGREEMENT * (double)fmaxf(b.x1 - b.x0, b.y1 - b.y0);
}

/* From a point in the camera's axes to the object's box, which stands along the model's axes, metres */
static double distance_to_box(const predict_object *o, const lt_pose *pose, const float p[3])
{
    double sum = 0;

    for (int a = 0; a < 3; a++) {
        double x = 0, lo = INFINITY, hi = -INFINITY, out;

        for (int d = 0; d < 3; d++)
            x += pose->R[3 * d + a] * ((double)p[d] - pose->t[d]);
        for (int i = 0; i < LT_BOX_POINTS; i++) {
            lo = fmin(lo, (double)o->control[i][a]);
            hi = fmax(hi, (double)o->control[i][a]);
        }
        out = fmax(0, fmax(lo - x, x - hi));
        sum += out * out;
    }
    return sqrt(sum);
}

double predict_object_apart(const predict_view *v, const predict_result *r)
{
    double nearest = INFINITY;

    for (int i = 0; v->object && r->object_found && i < LT_HAND_KEYPOINTS; i++)
        nearest = fmin(nearest, distance_to_box(v->object, &r->e.object, r->e.joints[i]));
    return nearest;
}

bool predict_object_trusted(const predict_view *v, const predict_result *r)
{
    return predict_trusted(v, r) && predict_object_apart(v, r) <= GRASP;
}
