/* SPDX-License-Identifier: Apache-2.0 */
/* estimate: the crop around each hand through the network, a left hand's in the mirror; where a hand may stand any way
 * up, or be of either side, as it looks best. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include "estimate/feed.h"

#include <math.h>
#include <string.h>

/* Of 2D and 3D joints, in parts of the box's longer side: a look that is not to be bettered; and how much smaller than
 * of the picture as it stands it must be of a turned one */
static const double GOOD = 0.04, TURNED = 0.7;

typedef struct {
    hand_object_options options;
    hand_object_batch *crop;            /* of one hand */
    estimator *estimator;
} looker;

static void close_looker(void *state)
{
    looker *l = state;

    hand_object_batch_free(l->crop);
    estimator_free(l->estimator);
    lt_release(l);
}

static lt_status open_looker(const predict_options *o, void **state)
{
    looker *l = lt_alloc(sizeof(*l));
    lt_status st;

    if (!l)
        return lt_error(LT_ENOMEM, "no memory to predict with");
    l->options = hand_object_defaults(false, 0);
    feed_options(o->m, &l->options);
    l->options.bilinear = o->bilinear;
    l->crop = hand_object_batch_new(1, l->options.size, l->options.cells);
    st = !l->crop ? lt_error(LT_ENOMEM, "no memory for a batch")
         : o->alone ? estimator_new_alone(o->m, 1, &l->estimator) : estimator_new(o->m, 1, &l->estimator);
    if (st)
        close_looker(l);
    else
        *state = l;
    return st;
}

/* ---- one look -------------------------------------------------------------------------------------------------- */

/* A view as a sample of a dataset: boxes, and nothing that would have to be known. The object's box is
 * the extent of its control points, so two of its corners stand in for all. */
static void sample_of(const predict_view *v, dataset_sample *s)
{
    const float corner[2][2] = { { v->object_box.x0, v->object_box.y0 }, { v->object_box.x1, v->object_box.y1 } };

    *s = (dataset_sample){
        .name = v->path, .flags = SAMPLE_HAND_BOX | SAMPLE_OBJECT, .width = v->width, .height = v->height,
        .rgb = v->rgb, .depth = v->depth, .camera = v->camera, .object = -1,
        .hand_box = { v->hand_box.x0, v->hand_box.y0, v->hand_box.x1, v->hand_box.y1 },
    };
    for (int i = 0; i < LT_BOX_POINTS; i++)
        memcpy(s->control2d[i], corner[i & 1], sizeof(s->control2d[i]));
}

static object_shape shape_of(const predict_object *o, bool left)
{
    if (!o)
        return (object_shape){ 0 };
    return left ? (object_shape){ o->mirrored, o->mirrored_surface } : (object_shape){ o->control, o->surface };
}

static bool finite_hand(const estimate *e)
{
    float sum = 0;

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        sum += e->joints[i][0] + e->joints[i][1] + e->joints[i][2] + e->joints2d[i][0] + e->joints2d[i][1];
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        sum += e->vertices[i][0] + e->vertices[i][1] + e->vertices[i][2];
    return isfinite(sum);
}

/* Points from the crop back to the image. */
static void points_in_image(const float affine[6], const float (*crop)[2], int n, float (*out)[2])
{
    double A[6];

    for (int k = 0; k < 6; k++)
        A[k] = affine[k];
    if (lt_affine_inverse(A, A))
        memcpy(out, crop, (size_t)n * sizeof(*out));
    else
        crop_points(A, crop, n, out);
}

/* One hand at a time: the numbers of one do not depend on which others are in the picture. */
static lt_status look(const looker *l, const predict_view *seen, predict_result *r)
{
    const object_shape shape = shape_of(seen->object, seen->left);
    dataset_sample sample;
    lt_status st;

    sample_of(seen, &sample);
    st = hand_object_prepare(&sample, &l->options, 0, 0, l->crop, 0);
    if (st)
        return st;
    l->crop->count = 1;
    memset(r, 0, sizeof(*r));
    estimator_run(l->estimator, l->crop, &shape, &r->e);
    if (!finite_hand(&r->e))
        return lt_error(LT_ENUMERIC, "%s: the model's answer is not finite: its weights are damaged", seen->path);
    points_in_image(l->crop->affine, (const float (*)[2])r->e.joints2d, LT_HAND_KEYPOINTS, r->heatmap2d);
    points_in_image(l->crop->affine, (const float (*)[2])r->e.control2d, LT_BOX_POINTS, r->control2d);
    return LT_OK;
}

/* ---- the best of several --------------------------------------------------------------------------------------- */

/* How far 2D and 3D joints differ, in parts of the box's longer side; infinite where the hand cannot be placed */
static double misfit(const predict_view *seen, const predict_result *r)
{
    const crop_box b = seen->hand_box;
    predict_result placed = *r;

    predict_place_hand(seen, &placed);
    predict_reproject(seen, &placed);
    return placed.placed ? placed.agreement_px / (double)fmaxf(b.x1 - b.x0, b.y1 - b.y0) : INFINITY;
}

/* A look at a hand, mirrored or not, turned or not */
typedef struct {
    predict_view seen;
    predict_turn turn;
    predict_result result;
    double misfit;                  /* a turned one's counts for more */
} one_look;

/* side, turned by so many quarters */
static lt_status look_turned(const looker *l, lt_arena *arena, const predict_view *side, int quarters, one_look *out)
{
    lt_status st;

    out->seen = *side;
    out->turn = (predict_turn){ 0 };
    st = quarters ? predict_view_turn(arena, side, quarters, &out->seen, &out->turn) : LT_OK;
    st = st ? st : look(l, &out->seen, &out->result);
    if (!st)
        out->misfit = misfit(&out->seen, &out->result) / (quarters ? TURNED : 1);
    return st;
}

static void take(const one_look *best, predict_frame *f, int i)
{
    f->seen[i] = best->seen;
    f->turn[i] = best->turn;
    f->result[i] = best->result;
    f->view[i].left = best->seen.left;
}

static lt_status side_of(lt_arena *arena, const predict_view *v, bool left, predict_view *out)
{
    const lt_status st = left ? predict_view_mirror(arena, v, out) : LT_OK;

    if (!left)
        *out = *v;
    out->left = left;
    return st;
}

/* followed: its side is that of the film's frames before */
static lt_status look_at(const looker *l, predict_frame *f, int i, bool followed)
{
    const predict_view v = f->view[i];
    const int sides = v.any_side && !followed ? 2 : 1, turns = f->o->any_way_up ? 4 : 1;
    predict_view side[2];
    double best = NAN;
    lt_status st = LT_OK;

    for (int k = 0; k < sides && !st; k++)
        st = side_of(f->arena, &v, k ? !v.left : v.left, &side[k]);
    for (int k = 0; k < sides * turns && !st && !(best < GOOD); k++) {
        one_look at;

        st = look_turned(l, f->arena, &side[k % sides], k / sides, &at);
        if (st || at.misfit >= best)
            continue;
        best = at.misfit;
        take(&at, f, i);
    }
    return st;
}

static lt_status run(void *state, predict_frame *f)
{
    bool *followed = lt_arena_array(f->arena, (size_t)f->n, sizeof(*followed));
    lt_status st = LT_OK;

    f->seen = lt_arena_array(f->arena, (size_t)f->n, sizeof(*f->seen));
    f->turn = lt_arena_array(f->arena, (size_t)f->n, sizeof(*f->turn));
    f->result = lt_arena_array(f->arena, (size_t)f->n, sizeof(*f->result));
    if (!followed || !f->seen || !f->turn || !f->result)
        return lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    if (f->film)
        st = predict_follow_sides(f->film, f->arena, f->view, f->n, followed);
    for (int i = 0; i < f->n && !st; i++)
        st = look_at(state, f, i, followed[i]);
    return st;
}

const stage estimate_stage = {
    .name = "estimate", .needs = FRAME_VIEWS, .gives = FRAME_ESTIMATES,
    .open = open_looker, .run = run, .close = close_looker,
};
