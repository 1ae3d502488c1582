/* SPDX-License-Identifier: Apache-2.0 */
/* Slips in objects' poses, in intrinsics, and in the size of a thing. */
#include "data/slip.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- poses ---- */

/* What may have been done to a pose, each in one of some ways. */
typedef struct {
    int power;                      /* the translation's unit */
    bool flipped;                   /* OpenGL's axes for OpenCV's */
    bool transposed;                /* R by columns */
    bool inverse;                   /* from the camera to the object */
    bool bop;                       /* the model's origin in the middle of its box */
} pose_slip;

static int count_slips(const pose_slip *h)
{
    return !!h->power + h->flipped + h->transposed + h->inverse + h->bop;
}

/* What was meant, if the slip was made. */
static lt_pose undo(const pose_slip *h, const slip_pose *p)
{
    lt_pose e = p->found;
    double moved[3];

    for (int k = 0; k < 3; k++)
        e.t[k] *= pow(10, h->power);
    if (h->transposed || h->inverse)
        lt_mat3_transpose(p->found.R, e.R);
    if (h->inverse) {
        lt_mat3_mulvec(e.R, e.t, moved);
        for (int k = 0; k < 3; k++)
            e.t[k] = -moved[k];
    }
    if (h->flipped)
        for (int i = 0; i < 9; i++)
            e.R[i] = i < 3 ? e.R[i] : -e.R[i];
    for (int k = 1; h->flipped && k < 3; k++)
        e.t[k] = -e.t[k];
    if (h->bop) {
        lt_mat3_mulvec(e.R, p->centre, moved);
        for (int k = 0; k < 3; k++)
            e.t[k] -= moved[k];
    }
    return e;
}

static double corner_distance(const lt_pose *e, const slip_pose *p)
{
    double sum = 0;

    for (int i = 0; i < 8; i++) {
        double a[3], b[3];
        lt_rigid_apply(e->R, e->t, p->corner[i], a);
        lt_rigid_apply(p->wanted.R, p->wanted.t, p->corner[i], b);
        sum += lt_vec3_distance(a, b) / 8;
    }
    return sum;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return x < y ? -1 : x > y;
}

/* The median over poses; room: n numbers. */
static double pose_distance(const pose_slip *h, const slip_pose *pose, int64_t n, double *room)
{
    for (int64_t i = 0; i < n; i++) {
        const lt_pose e = undo(h, &pose[i]);
        room[i] = corner_distance(&e, &pose[i]);
    }
    qsort(room, (size_t)n, sizeof(*room), by_value);
    return room[n / 2];
}

/* Each slip has to halve the distance. */
static pose_slip best_pose_slip(const slip_pose *pose, int64_t n, double *room, double *after)
{
    static const int powers[] = { 0, -3, 3, -2, 2, -1, 1 };
    pose_slip best = { 0 };
    double least = INFINITY;

    for (size_t u = 0; u < LT_COUNT(powers); u++)
        for (int bits = 0; bits < 16; bits++) {
            const pose_slip h = { powers[u], bits & 1, bits & 2, bits & 4, bits & 8 };
            double d;
            if (h.transposed && h.inverse)
                continue;
            d = pose_distance(&h, pose, n, room);
            if (d * pow(2, count_slips(&h)) < least) {
                least = d * pow(2, count_slips(&h));
                best = h;
                *after = d;
            }
        }
    return best;
}

static void add_words(slip *out, const char *code, const char *words)
{
    const size_t n = strlen(out->text);

    snprintf(out->text + n, SLIP_TEXT - n, "%s%s", n ? ", and " : "", words);
    if (!out->code)
        out->code = code;
}

void slip_in_poses(const slip_pose *pose, int64_t n, slip_file file, slip *out)
{
    const pose_slip none = { 0 };
    double *room = malloc((size_t)(n ? n : 1) * sizeof(*room));
    char unit[SLIP_UNIT], words[SLIP_UNIT + 32];
    pose_slip s;

    *out = (slip){ 0 };
    if (!room || !n) {
        free(room);
        return;
    }
    out->before = pose_distance(&none, pose, n, room);
    s = best_pose_slip(pose, n, room, &out->after);
    free(room);
    if (s.power) {
        snprintf(words, sizeof(words), "the translations are %s", slip_unit_words(s.power, file.millimetres, unit));
        add_words(out, "unit", words);
    }
    if (s.flipped)
        add_words(out, "axes", file.opengl ? "the poses have OpenCV's axes (y down, z forward), not OpenGL's"
                                           : "the poses have OpenGL's axes (y up, z backward), not OpenCV's");
    if (s.transposed)
        add_words(out, "axes", "the rotations are written by columns, not by rows");
    if (s.inverse)
        add_words(out, "place", "the poses are the camera's in the object's frame, not the object's in the camera's");
    if (s.bop)
        add_words(out, "place", "the poses are of BOP's models, whose origin is the middle of their box");
}

/* ---- intrinsics ---- */

static bool about(double x, double y, double share)
{
    return fabs(x - y) < share * fabs(y);
}

/* The point lies where the image's middle would be if it stood upright. */
static bool is_exchanged(const lt_camera *c, int w, int h)
{
    return !about(w, h, 0.1) && about(c->cx, h / 2.0, 0.05) && about(c->cy, w / 2.0, 0.05);
}

static void explain_camera(const lt_camera *c, int w, int h, bool middle, slip *out)
{
    if (middle && c->fx < 0.1 * w)
        snprintf(out->text, SLIP_TEXT, "the focal length, %.4g, is in millimetres, not in pixels", c->fx);
    else if (middle)
        snprintf(out->text, SLIP_TEXT, "the focal length is %.4g, %.4g pixels", c->fx, c->fy);
    else if (is_exchanged(c, w, h))
        snprintf(out->text, SLIP_TEXT, "cx and cy are exchanged");
    else if (about(c->cx, 0.5, 0.2) && about(c->cy, 0.5, 0.2))
        snprintf(out->text, SLIP_TEXT, "the intrinsics are in units of the image's sides, not in pixels");
    else if (about(c->cx * h, c->cy * w, 0.2))
        snprintf(out->text, SLIP_TEXT, "the intrinsics are those of an image of %.0f x %.0f, not of %d x %d", 2 * c->cx,
                 2 * c->cy, w, h);
    else
        snprintf(out->text, SLIP_TEXT, "the intrinsics are those of another image: their principal point (%.4g, %.4g) "
                 "is far from the middle of %d x %d", c->cx, c->cy, w, h);
}

void slip_in_camera(const lt_camera *c, int width, int height, slip *out)
{
    const double side = width > height ? width : height, x = fabs(c->cx / width - 0.5), y = fabs(c->cy / height - 0.5);
    const double f = fmin(c->fx, c->fy) / side, g = fmax(c->fx, c->fy) / side;
    const bool middle = x < 0.2 && y < 0.2 && !is_exchanged(c, width, height);

    *out = (slip){ 0 };
    if (middle && f > 1.0 / 3 && g < 10)
        return;
    out->code = "camera";
    explain_camera(c, width, height, middle, out);
}
