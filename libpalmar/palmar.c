/* SPDX-License-Identifier: Apache-2.0 */
/* The stages of palmar predict over a caller's picture: what is given is checked, and stands for the read stage. */
#include <config.h>
#include "libpalmar/palmar.h"

#include "estimate/trained.h"
#include "libtensor/base/parallel.h"
#include "pipeline/internal.h"
#include "pipeline/objects/objects.h"
#include "pipeline/stage.h"

#include <math.h>
#include <string.h>

_Static_assert((int)PALMAR_JOINTS == (int)LT_HAND_KEYPOINTS && (int)PALMAR_VERTICES == (int)LT_HAND_VERTICES &&
               (int)PALMAR_FACES == (int)LT_HAND_FACES && (int)PALMAR_ROTATIONS == (int)LT_HAND_JOINTS &&
               (int)PALMAR_SHAPE == (int)LT_HAND_BETAS, "the hand that palmar.h tells of is MANO's");

static const double FARTHEST_PX = 1e6;          /* of a box, and of a camera's numbers */

struct palmar {
    trained t;
    predict_options o;
    pipeline *stages;
    lt_arena *scratch;                          /* of a picture */
    const predict_object **object;              /* n_objects, in the trained model's arena */
    size_t n_objects, room;
    predict_followed film;                      /* dt 0: none */
};

/* A status of the library's as palmar.h has them. */
static palmar_status status_of(lt_status st)
{
    switch (st) {
    case LT_OK: return PALMAR_OK;
    case LT_EIO: case LT_ENOSPC: return PALMAR_EIO;
    case LT_EFORMAT: return PALMAR_EFORMAT;
    case LT_ENOMEM: return PALMAR_ENOMEM;
    case LT_ENUMERIC: return PALMAR_ENUMERIC;
    default: return PALMAR_EINVAL;
    }
}

/* ---- opening --------------------------------------------------------------------------------------------- */

static lt_status open_stages(palmar *p)
{
    static const char *const names[] = { "estimate", "solve", "smooth", NULL };

    p->o = (predict_options){ .m = &p->t.m, .bilinear = p->t.bilinear, .hand = p->t.hand, .any_way_up = true,
                              .alone = true };
    p->scratch = lt_arena_new();
    p->film.arena = lt_arena_new();
    if (!p->scratch || !p->film.arena)
        return lt_error(LT_ENOMEM, "%s: no memory", p->t.path);
    return pipeline_open(&p->o, FRAME_VIEWS, names, &p->stages);
}

palmar_status palmar_open(const char *path, const char *hand, palmar **out)
{
    palmar *p = path && out ? lt_alloc(sizeof(*p)) : NULL;
    lt_status st;

    if (!p)
        return status_of(path && out ? lt_error(LT_ENOMEM, "%s: no memory", path)
                                     : lt_error(LT_EINVAL, "palmar_open: %s is NULL", path ? "out" : "path"));
    st = trained_open(path, "hand-object", hand, &p->t);
    st = st ? st : open_stages(p);
    if (st)
        palmar_close(p);
    else
        *out = p;
    return status_of(st);
}

void palmar_close(palmar *p)
{
    if (!p)
        return;
    pipeline_close(p->stages);
    lt_arena_free(p->film.arena);
    lt_arena_free(p->scratch);
    trained_close(&p->t);
    lt_release(p);
}

palmar_status palmar_load_object(palmar *p, const char *name, const char *models, int *out)
{
    const predict_options o = { .models = models };
    const predict_object **all;
    predict_object *object;
    lt_status st;

    if (!p || !name || !out)
        return status_of(lt_error(LT_EINVAL, "palmar_load_object: %s is NULL", !p ? "p" : !name ? "name" : "out"));
    all = lt_arena_grow(p->t.arena, p->object, p->n_objects, &p->room, sizeof(*all));
    object = all ? lt_arena_alloc(p->t.arena, sizeof(*object)) : NULL;
    if (!object)
        return status_of(lt_error(LT_ENOMEM, "%s: no memory", name));
    p->object = all;
    st = predict_load_object(p->t.arena, &o, name, object);
    if (!st) {
        all[p->n_objects++] = object;
        *out = (int)p->n_objects;
    }
    return status_of(st);
}

palmar_status palmar_film(palmar *p, double fps)
{
    if (!p || !(fps >= 0 && fps <= 1e6))
        return status_of(p ? lt_error(LT_EINVAL, "palmar_film: fps is %g, want 0 to 1e6", fps)
                           : lt_error(LT_EINVAL, "palmar_film: p is NULL"));
    lt_arena_reset(p->film.arena);
    p->film = (predict_followed){ .arena = p->film.arena, .dt = fps > 0 ? 1 / fps : 0 };
    return PALMAR_OK;
}

/* ---- what is asked --------------------------------------------------------------------------------------- */

static bool in_reach(double x)
{
    return fabs(x) <= FARTHEST_PX;
}

static lt_status check_camera(const palmar_image *m)
{
    const bool assumed = m->fx == 0 && m->fy == 0 && m->cx == 0 && m->cy == 0;
    const bool near = in_reach(m->fx) && in_reach(m->fy) && in_reach(m->cx) && in_reach(m->cy);

    if (assumed || (near && m->fx > 0 && m->fy > 0))
        return LT_OK;
    return lt_error(LT_EINVAL, "palmar_estimate: the camera is %g, %g, %g, %g; want fx and fy above 0, all finite and "
                    "at most 1e6, or four times 0", m->fx, m->fy, m->cx, m->cy);
}

static lt_status check_image(const palmar *p, const palmar_image *m)
{
    if (!m->rgb)
        return lt_error(LT_EINVAL, "palmar_estimate: image->rgb is NULL");
    if (m->width < 1 || m->height < 1 || m->width > LT_IMAGE_MAX_SIDE || m->height > LT_IMAGE_MAX_SIDE)
        return lt_error(LT_EINVAL, "palmar_estimate: an image of %d x %d pixels, want 1 to %d", m->width, m->height,
                        LT_IMAGE_MAX_SIDE);
    if (m->stride && m->stride < 3 * (ptrdiff_t)m->width)
        return lt_error(LT_EINVAL, "palmar_estimate: rows are %td bytes apart, want 3 * %d or more, or 0", m->stride,
                        m->width);
    if (m->depth && !model_takes_depth(&p->t.m))
        return lt_error(LT_EINVAL, "palmar_estimate: %s %s was trained without depth and takes none",
                        p->t.m.cls->name, p->t.m.variant);
    if (m->depth && m->depth_stride && (m->depth_stride < 4 * (ptrdiff_t)m->width || m->depth_stride % 4))
        return lt_error(LT_EINVAL, "palmar_estimate: rows of depth are %td bytes apart, want 4 * %d or more, in fours, "
                        "or 0", m->depth_stride, m->width);
    return check_camera(m);
}

static lt_status check_query(const palmar *p, int i, const palmar_query *q)
{
    for (int k = 0; k < 4; k++)
        if (!in_reach((double)q->hand_box[k]) || !in_reach((double)q->object_box[k]))
            return lt_error(LT_EINVAL, "palmar_estimate: query[%d]: a box has the number %g, want -1e6 to 1e6", i,
                            in_reach((double)q->hand_box[k]) ? (double)q->object_box[k] : (double)q->hand_box[k]);
    if (q->object < 0 || (size_t)q->object > p->n_objects)
        return lt_error(LT_EINVAL, "palmar_estimate: query[%d]: object %d, and %zu were loaded", i, q->object,
                        p->n_objects);
    return LT_OK;
}

static lt_status check(const palmar *p, const palmar_image *image, int n, const palmar_query *query,
                       const palmar_hand *out)
{
    lt_status st;

    if (!p || !image || !query || !out)
        return lt_error(LT_EINVAL, "palmar_estimate: %s is NULL",
                        !p ? "p" : !image ? "image" : !query ? "query" : "out");
    if (n < 1 || n > PALMAR_MOST_HANDS)
        return lt_error(LT_EINVAL, "palmar_estimate: %d hands, want 1 to %d", n, PALMAR_MOST_HANDS);
    st = check_image(p, image);
    for (int i = 0; i < n && !st; i++)
        st = check_query(p, i, &query[i]);
    return st;
}

/* Rows without gaps: the caller's own where they have none. NULL without memory */
static const void *packed(lt_arena *arena, const void *rows, size_t height, size_t row, ptrdiff_t stride)
{
    uint8_t *to;

    if (!rows || !stride || (size_t)stride == row)
        return rows;
    to = lt_arena_array(arena, height, row);
    for (size_t y = 0; y < height && to; y++)
        memcpy(to + y * row, (const uint8_t *)rows + y * (size_t)stride, row);
    return to;
}

static bool is_zero(const float box[4])
{
    return box[0] == 0 && box[1] == 0 && box[2] == 0 && box[3] == 0;
}

static crop_box box_of(const float b[4])
{
    return (crop_box){ b[0], b[1], b[2], b[3] };
}

static lt_status view_hand(const palmar *p, const palmar_query *q, predict_view *v)
{
    lt_status st;

    v->left = q->left;
    v->object = q->object ? p->object[q->object - 1] : NULL;
    v->hand_from = is_zero(q->hand_box) ? PREDICT_DEFAULT : PREDICT_GIVEN;
    v->object_from = is_zero(q->object_box) ? PREDICT_DEFAULT : PREDICT_GIVEN;
    v->hand_box = is_zero(q->hand_box) ? predict_default_hand_box(v->width, v->height) : box_of(q->hand_box);
    v->object_box = is_zero(q->object_box) ? predict_default_object_box(v->hand_box) : box_of(q->object_box);
    st = predict_check_inside(v, "hand", v->hand_box);
    return st ? st : predict_check_inside(v, "object", v->object_box);
}

/* What the stages read and look give, of a picture that needs no reading */
static lt_status view(const palmar *p, const palmar_image *m, const palmar_query *query, predict_frame *f)
{
    const size_t width = (size_t)m->width, height = (size_t)m->height;
    predict_view v = {
        .path = "the image", .width = m->width, .height = m->height, .orientation = 1, .n_hands = f->n,
        .rgb = packed(f->arena, m->rgb, height, 3 * width, m->stride),
        .depth = packed(f->arena, m->depth, height, sizeof(float) * width, m->depth_stride),
        .camera = m->fx > 0 ? (lt_camera){ m->fx, m->fy, m->cx, m->cy }
                            : predict_assumed_camera(0, m->width, m->height),
        .camera_from = m->fx > 0 ? PREDICT_GIVEN : PREDICT_DEFAULT,
    };
    lt_status st = LT_OK;

    f->scene = v;
    f->view = lt_arena_array(f->arena, (size_t)f->n, sizeof(*f->view));
    if (!f->view || !v.rgb || !v.depth != !m->depth)
        return lt_error(LT_ENOMEM, "palmar_estimate: no memory for an image of %d x %d pixels", m->width, m->height);
    for (v.hand = 0; v.hand < f->n && !st; v.hand++) {
        f->view[v.hand] = v;
        st = view_hand(p, &query[v.hand], &f->view[v.hand]);
    }
    return st;
}

/* ---- what was found -------------------------------------------------------------------------------------- */

static void give(const predict_view *v, const predict_result *r, palmar_hand *out)
{
    const estimate *e = &r->e;

    memcpy(out->joints, e->joints, sizeof(out->joints));
    memcpy(out->vertices, e->vertices, sizeof(out->vertices));
    memcpy(out->joints2d, r->joints2d, sizeof(out->joints2d));
    memcpy(out->rotations, r->theta, sizeof(out->rotations));
    memcpy(out->shape, e->beta, sizeof(out->shape));
    memcpy(out->translation, e->joints[0], sizeof(out->translation));
    out->placed = r->placed;
    out->trusted = predict_trusted(v, r);
    out->agreement_px = r->agreement_px;
    out->object_found = r->object_found;
    out->object_trusted = predict_object_trusted(v, r);
    memcpy(out->object_rotation, e->object.R, sizeof(out->object_rotation));
    memcpy(out->object_translation, e->object.t, sizeof(out->object_translation));
    out->object_inliers = e->object_inliers;
    out->object_confidence = e->object_confidence;
}

palmar_status palmar_estimate(palmar *p, const palmar_image *image, int n, const palmar_query *query, palmar_hand *out)
{
    lt_status st = check(p, image, n, query, out);
    predict_frame f;

    if (st)
        return status_of(st);
    lt_arena_reset(p->scratch);
    f = (predict_frame){
        .o = &p->o, .arena = p->scratch, .notes.arena = p->scratch, .n = n, .film = p->film.dt > 0 ? &p->film : NULL,
    };
    st = view(p, image, query, &f);
    st = st ? st : pipeline_run(p->stages, &f);
    for (int i = 0; i < n && !st; i++)
        give(&f.view[i], &f.result[i], &out[i]);
    return status_of(st);
}

const int32_t *palmar_faces(const palmar *p)
{
    return p ? p->t.hand->faces[0] : NULL;
}

void palmar_set_threads(int n)
{
    lt_set_threads(n);
}

const char *palmar_last_error(void)
{
    return lt_last_error();
}

const char *palmar_version(void)
{
    return PACKAGE_VERSION;
}
