/* SPDX-License-Identifier: Apache-2.0 */
/* The camera of an image: given, read or assumed; whether it is this image's; and the lens taken out of the picture. */
#include "pipeline/internal.h"

#include "vision/undistort.h"

#include <math.h>
#include <stdio.h>

static const double FOCAL_PER_SIDE = 1.2, OFF_CENTRE = 0.1, SAME_SHAPE = 0.02, ALIKE = 0.15;    /* shares */
static const double WIDEST = 0.25, LONGEST = 20;    /* focal lengths, in longer sides, that a camera for hands has */
static const double FAR_MOVED = 2;                  /* a factor */

/* ---- K of another size ----------------------------------------------------------------------------------- */

/* Pixels' centres are at whole numbers, so that a picture's edge is at -1/2. */
static lt_camera scaled_camera(lt_camera c, double x, double y)
{
    return (lt_camera){ c.fx * x, c.fy * y, (c.cx + 0.5) * x - 0.5, (c.cy + 0.5) * y - 0.5 };
}

/* A file that says for which size its K is tells it of another, as long as the shape is the same: else false. */
static bool scale_given(const predict_options *o, predict_view *v, predict_notes *notes)
{
    const double x = (double)v->width / o->camera_width, y = (double)v->height / o->camera_height;

    if (o->camera_width == v->width && o->camera_height == v->height)
        return true;
    if (fabs(x / y - 1) > SAME_SHAPE) {
        predict_note_add(notes, NULL, NOTE_CAMERA_DOUBTFUL, "K is of pictures of %d x %d, and this one, of %d x %d, "
                         "has another shape: was it turned or cut?", o->camera_width, o->camera_height, v->width,
                         v->height);
        return false;
    }
    v->camera = scaled_camera(v->camera, x, y);
    predict_note_add(notes, NULL, NOTE_CAMERA_SCALED, "K is of pictures of %d x %d: scaled to %d x %d", o->camera_width,
                     o->camera_height, v->width, v->height);
    return true;
}

/* ---- K that does not fit --------------------------------------------------------------------------------- */

static bool near_middle(const predict_view *v, double cx, double cy, double share)
{
    return fabs(cx - (v->width - 1) / 2.0) <= share * v->width && fabs(cy - (v->height - 1) / 2.0) <= share * v->height;
}

/* As far from the middle along both axes as K of another size would have it; *scale: from that to this */
static bool is_scaled(const predict_view *v, double *scale)
{
    const double x = v->width / (2 * v->camera.cx + 1), y = v->height / (2 * v->camera.cy + 1);

    *scale = x > 0 && y > 0 ? sqrt(x * y) : 1;
    return x > 0 && y > 0 && fabs(x / y - 1) < ALIKE && !near_middle(v, v->camera.cx, v->camera.cy, OFF_CENTRE);
}

/* The principal point lies where it would in the picture on its side. */
static bool is_turned(const predict_view *v)
{
    return !near_middle(v, v->camera.cx, v->camera.cy, OFF_CENTRE) &&
           near_middle(v, v->camera.cy, v->camera.cx, OFF_CENTRE / 2);
}

/* fx, cx, fy, cy */
static bool is_disordered(const predict_view *v)
{
    const lt_camera c = v->camera;

    return !near_middle(v, c.cx, c.cy, OFF_CENTRE) && near_middle(v, c.fy, c.cy, OFF_CENTRE) &&
           fabs(c.cx / c.fx - 1) < ALIKE;
}

static void note_middle(const predict_view *v, predict_notes *notes, const char *likely)
{
    predict_note_add(notes, NULL, NOTE_CAMERA_DOUBTFUL, "the principal point %.0f,%.0f is far from the middle of "
                     "%d x %d: %s", v->camera.cx, v->camera.cy, v->width, v->height, likely);
}

/* The principal point of most cameras is within a few hundredths of the middle. What would put it there is named. */
static void doubt_middle(const predict_view *v, predict_notes *notes)
{
    const lt_camera c = v->camera;
    char likely[256];
    lt_camera fit;
    double scale;

    if (is_turned(v)) {
        note_middle(v, notes, "K of the picture before it was turned?");
    } else if (is_disordered(v)) {
        snprintf(likely, sizeof(likely), "the order is fx,fy,cx,cy; was %.0f,%.0f,%.0f,%.0f meant?", c.fx, c.cx, c.fy,
                 c.cy);
        note_middle(v, notes, likely);
    } else if (is_scaled(v, &scale)) {
        fit = scaled_camera(c, scale, scale);
        snprintf(likely, sizeof(likely), "K of pictures of about %.0f x %.0f? For this size it would be "
                 "%.0f,%.0f,%.0f,%.0f", 2 * c.cx, 2 * c.cy, fit.fx, fit.fy, fit.cx, fit.cy);
        note_middle(v, notes, likely);
    } else if (!near_middle(v, c.cx, c.cy, 2 * OFF_CENTRE)) {
        note_middle(v, notes, "K of another camera or size, or was the picture cut?");
    }
}

static void doubt_given(const predict_options *o, const predict_view *v, predict_notes *notes)
{
    const lt_camera c = v->camera;
    const double side = fmax(v->width, v->height);

    if (fabs(o->camera_skew) > 1e-3 * c.fx)
        predict_note_add(notes, NULL, NOTE_CAMERA_DOUBTFUL, "K has a skew of %.3g px, which is left out",
                         o->camera_skew);
    doubt_middle(v, notes);
    if (fmin(c.fx, c.fy) < WIDEST * side || fmax(c.fx, c.fy) > LONGEST * side)
        predict_note_add(notes, NULL, NOTE_CAMERA_DOUBTFUL, "focal lengths of %.3g and %.3g px for a picture of "
                         "%d x %d: are they pixels of this size, not millimetres?", c.fx, c.fy, v->width, v->height);
    else if (fmax(c.fx / c.fy, c.fy / c.fx) > 1 + ALIKE && !is_disordered(v))
        predict_note_add(notes, NULL, NOTE_CAMERA_DOUBTFUL, "focal lengths of %.0f and %.0f px: most cameras have one, "
                         "and the order is fx,fy,cx,cy", c.fx, c.fy);
}

lt_camera predict_assumed_camera(double focal, int width, int height)
{
    const double f = focal > 0 ? focal : FOCAL_PER_SIDE * fmax(width, height);

    return (lt_camera){ f, f, (width - 1) / 2.0, (height - 1) / 2.0 };
}

void predict_choose_camera(const predict_options *o, const lt_exif *exif, predict_view *v, predict_notes *notes)
{
    const double measured = lt_exif_focal_px(exif, v->width, v->height);

    if (!o->camera) {
        v->camera = predict_assumed_camera(measured, v->width, v->height);
        v->camera_from = measured > 0 ? PREDICT_EXIF : PREDICT_DEFAULT;
        return;
    }
    v->camera = *o->camera;
    v->camera_from = PREDICT_GIVEN;
    if (o->camera_width <= 0 || scale_given(o, v, notes))
        doubt_given(o, v, notes);
}

/* ---- the lens -------------------------------------------------------------------------------------------- */

static undistortion lens_of(const predict_options *o, const predict_view *v)
{
    return (undistortion){ v->camera, *o->lens, v->width, v->height };
}

/* A lens that folds its picture back before the nearest edge is none, nor is one that moves that edge far away. */
static lt_status check_lens(const undistortion *u)
{
    const lt_camera *c = &u->camera;
    const double x = fmin(c->cx, u->width - 1 - c->cx) / c->fx, y = fmin(c->cy, u->height - 1 - c->cy) / c->fy;
    const double edge[2] = { fmin(x, y), 0 };
    double seen[2];

    lt_lens_distort(&u->lens, edge, seen);
    if (undistort_fold(u) >= edge[0] && fabs(seen[0]) < FAR_MOVED * edge[0] && fabs(seen[1]) < edge[0])
        return LT_OK;
    return lt_error(LT_EINVAL, "no lens does this: a point %.0f px from the picture's middle comes to lie at %.0f; the "
                    "order is k1,k2,p1,p2,k3,k4,k5,k6, and K is of this picture's size", edge[0] * c->fx,
                    seen[0] * c->fx);
}

lt_status predict_undistort(lt_arena *arena, const predict_options *o, predict_view *v, predict_notes *notes)
{
    const size_t n = (size_t)v->width * (size_t)v->height;
    const undistortion u = o->lens ? lens_of(o, v) : (undistortion){ .width = 0 };
    uint8_t *rgb;
    float *depth = NULL;
    lt_status st;

    if (!o->lens || lt_lens_is_none(o->lens))
        return LT_OK;
    st = check_lens(&u);
    st = st ? st : lt_arena_try(arena, 3 * n, (void **)&rgb);
    if (!st && v->depth)
        st = lt_arena_try(arena, n * sizeof(*depth), (void **)&depth);
    if (st)
        return lt_error_prefix(st, "%s", v->path);
    undistort_rgb(&u, v->rgb, rgb);
    if (depth)
        undistort_depth(&u, v->depth, depth);
    v->rgb = rgb;
    v->depth = depth;
    v->lens = o->lens;
    predict_note_add(notes, NULL, NOTE_UNDISTORTED, "the lens's distortion was taken out: pixels of the results, and "
                     "of the overlay, are those of the picture without it");
    return LT_OK;
}

crop_box predict_undistort_box(const predict_view *v, crop_box b)
{
    const undistortion u = { v->camera, v->lens ? *v->lens : (lt_lens){ { 0 }, { 0 } }, v->width, v->height };

    return v->lens ? undistort_box(&u, b) : b;
}
