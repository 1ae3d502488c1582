/* SPDX-License-Identifier: Apache-2.0 */
/* Sets of frames, with what was found drawn over them. */
#include "eval/report/session/internal.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/io/image/write.h"
#include "vision/drawing/body.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { SHOWN = 12, WIDTH = 480, QUALITY = 85 };

static const double STAMP = 1e-3, AXIS = 0.06;  /* seconds that stamps are rounded by at most; metres */
static const draw_color DARK = { 30, 30, 30 };

/* A camera's view of a set, smaller than its frame */
typedef struct {
    draw_canvas c;
    const recording_camera *camera;
    int number;                     /* of the camera */
    bool alone;                     /* there is no other */
    float scale;
} view;

/* ---- what is seen ---- */

/* Where the view has a point of the world; NaN behind the camera */
static void project(const view *v, const double p[3], float out[2])
{
    double Rt[9], x[3] = { p[0], p[1], p[2] }, uv[2];

    if (v->camera->placed) {
        lt_mat3_transpose(v->camera->R, Rt);
        lt_vec3_sub(p, v->camera->t, x);
        lt_mat3_mulvec(Rt, x, x);
    }
    out[0] = out[1] = NAN;
    if (!lt_camera_project(&v->camera->K, x, uv))
        return;
    out[0] = v->scale * (float)uv[0];
    out[1] = v->scale * (float)uv[1];
}

/* What one camera sees stands in its own axes where nobody knows how the cameras stand; so it is another camera's not
 * to show. seen_by: -1: not told */
static bool shows(const view *v, int seen_by)
{
    return v->camera->placed || v->alone || v->number == seen_by;
}

static draw_color color_of(const char *cls)
{
    static const draw_color person = { 120, 175, 255 }, hand = { 255, 150, 80 }, object = { 255, 220, 120 };

    return strcmp(cls, "person") == 0 ? person : strstr(cls, "hand") ? hand : object;
}

static void draw_track(view *v, const session_track *t)
{
    const float x0 = v->scale * t->box[0], y0 = v->scale * t->box[1], x1 = v->scale * t->box[2];
    const float y1 = v->scale * t->box[3], p[4][2] = { { x0, y0 }, { x1, y0 }, { x1, y1 }, { x0, y1 } };
    char text[64];
    int left, top, n;

    for (int i = 0; i < 4; i++)
        draw_line(&v->c, p[i], p[(i + 1) % 4], 1, color_of(t->cls), 0.9f);
    if (!isfinite(x0) || !isfinite(y0))
        return;
    left = (int)fmaxf(0, fminf(x0, WIDTH));
    top = (int)fmaxf(0, fminf(y0, WIDTH));
    n = snprintf(text, sizeof(text), "#%" PRId64 " %.40s", t->id, t->cls);
    draw_rect(&v->c, left, top, left + DRAW_GLYPH_WIDTH * n + 3, top + DRAW_GLYPH_HEIGHT + 2, DARK, 0.6f);
    draw_text(&v->c, left + 2, top + 1, 1, color_of(t->cls), text);
}

static void draw_axes(view *v, const session_object *o)
{
    static const draw_color color[3] = { { 255, 80, 80 }, { 90, 220, 90 }, { 90, 140, 255 } };
    float from[2];

    project(v, o->t, from);
    for (int a = 0; a < 3; a++) {
        const double end[3] = { o->t[0] + AXIS * o->R[a], o->t[1] + AXIS * o->R[3 + a], o->t[2] + AXIS * o->R[6 + a] };
        float to[2];

        project(v, end, to);
        draw_line(&v->c, from, to, 2, color[a], o->coasts ? 0.5f : 1);
    }
}

static void draw_person(view *v, const session_person *p)
{
    float node[ACTION_BODY][2];

    for (int k = 0; k < ACTION_BODY; k++)
        project(v, p->joint[k], node[k]);
    body_draw(&v->c, (const float (*)[2])node, 1);
}

static void draw_hand(view *v, const session_hand *hand)
{
    float joint[LT_HAND_KEYPOINTS][2];

    for (int k = 0; k < LT_HAND_KEYPOINTS; k++)
        project(v, hand->joint[k], joint[k]);
    draw_skeleton(&v->c, (const float (*)[2])joint, 2);
}

static void draw_found(view *v, const session_line *l)
{
    for (int i = 0; i < l->n_tracks; i++)
        if (l->track[i].camera == v->number)
            draw_track(v, &l->track[i]);
    for (int i = 0; i < l->n_people; i++)
        if (shows(v, l->person[i].camera))
            draw_person(v, &l->person[i]);
    for (int i = 0; i < l->n_hands; i++)
        if (shows(v, l->hand[i].camera))
            draw_hand(v, &l->hand[i]);
    for (int i = 0; i < l->n_objects && shows(v, -1); i++)
        draw_axes(v, &l->object[i]);
}

/* ---- a set ---- */

/* The frame of a camera with this stamp; -1: there is none */
static int64_t find_frame(const recording *r, int camera, double t)
{
    int64_t best = -1;
    double least = STAMP;

    for (int64_t i = 0; i < r->n_frames; i++)
        if (r->frame[i].camera == camera && fabs(r->frame[i].t - t) < least) {
            least = fabs(r->frame[i].t - t);
            best = i;
        }
    return best;
}

/* Dark where the frame is not there, or cannot be read */
static lt_status draw_view(const history *h, lt_arena *arena, int camera, const session_line *l, draw_canvas *out)
{
    const recording_camera *c = &h->r.rig.camera[camera];
    const int64_t k = isfinite(l->t[camera]) ? find_frame(&h->r, camera, l->t[camera]) : -1;
    view v = { .camera = c, .number = camera, .alone = h->r.rig.n == 1, .scale = (float)WIDTH / (float)c->width };
    lt_image frame;
    lt_status st = k < 0 ? LT_EFORMAT : recording_colour(&h->r, k, arena, &frame);

    v.c = draw_canvas_new(arena, WIDTH, (int)lt_max_i64(1, (int64_t)WIDTH * c->height / c->width), DARK);
    if (st == LT_ENOMEM || !v.c.rgb)
        return lt_error(LT_ENOMEM, "no memory for pictures of the page");
    if (!st) {
        const draw_canvas picture = { (uint8_t (*)[3])frame.data, frame.width, frame.height };

        draw_picture(&v.c, 0, 0, v.c.width, v.c.height, &picture);
    }
    if (isfinite(l->t[camera]))
        draw_found(&v, l);
    *out = v.c;
    return LT_OK;
}

/* All cameras' views in one picture */
static lt_status put_views(FILE *f, const history *h, lt_arena *arena, const session_line *l)
{
    const int n = h->r.rig.n;
    const char *title[RECORDING_CAMERAS];
    draw_canvas picture[RECORDING_CAMERAS], sheet;
    uint8_t *jpeg;
    int height = 1;
    size_t bytes;
    lt_status st = LT_OK;

    for (int c = 0; c < n && !st; c++) {
        st = draw_view(h, arena, c, l, &picture[c]);
        title[c] = isfinite(l->t[c]) ? lt_arena_printf(arena, "%.40s  %.3f s", h->r.rig.camera[c].name, l->t[c])
                                     : lt_arena_printf(arena, "%.40s  no frame", h->r.rig.camera[c].name);
        height = st ? 1 : (int)lt_max_i64(height, picture[c].height);
    }
    if (st)
        return st;
    sheet = draw_sheet(arena, picture, title, n, n > 1 ? 2 : 1, WIDTH, height);
    if (!sheet.rgb)
        return lt_error(LT_ENOMEM, "no memory for pictures of the page");
    st = lt_jpeg_encode(arena, &(lt_image){ sheet.width, sheet.height, 3, 8, sheet.rgb[0] }, QUALITY, &jpeg, &bytes);
    if (!st)
        html_jpeg(f, jpeg, bytes, "the cameras' frames of a set, with what was found in them");
    return st;
}

static void put_doing(FILE *f, const session_doing *d)
{
    fprintf(f, "; person %" PRId64 ": ", d->person);
    html_text(f, d->what);
    if (isfinite(d->p))
        fprintf(f, " (%.2f)", d->p);
}

static lt_status put_set(FILE *f, const history *h, lt_arena *arena, int64_t k)
{
    session_line l;
    lt_status st = history_line(h, arena, k, &l);

    if (st)
        return st;
    fputs("<figure>", f);
    st = put_views(f, h, arena, &l);
    fprintf(f, "<figcaption>Set %" PRId64 ", %.2f s", k, h->time[k]);
    for (int i = 0; i < l.n_actions; i++)
        put_doing(f, &l.action[i]);
    for (int i = 0; i < l.n_interactions; i++)
        put_doing(f, &l.interaction[i]);
    fputs("</figcaption></figure>\n", f);
    return st;
}

/* ---- all of them ---- */

static const char script[] =
    "const sets=document.getElementById('sets'),all=sets.querySelectorAll('figure'),at=sets.querySelector('input');\n"
    "function show(){all.forEach((one,i)=>one.hidden=i!=at.value)}\n"
    "at.hidden=false;at.oninput=show;show();\n";

lt_status pictures_put(FILE *f, const history *h, const char *nonce)
{
    const int64_t n = lt_min_i64(SHOWN, h->n);
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "no memory for pictures of the page");

    if (n)
        fprintf(f, "<h2>What the cameras saw</h2>\n<p>%" PRId64 " of %" PRId64 " sets, spread over the session: boxes "
                "with their numbers, bodies, hands, and the axes of objects that are followed.</p>\n<div id=sets>"
                "<input type=range min=0 max=%" PRId64 " value=0 aria-label=\"set\" hidden>\n", n, h->n, n - 1);
    for (int64_t i = 0; i < n && !st; i++) {
        lt_arena_reset(arena);
        st = put_set(f, h, arena, n > 1 ? i * (h->n - 1) / (n - 1) : 0);
    }
    if (n)
        fprintf(f, "</div>\n<script nonce=%s>\n%s</script>\n", nonce, script);
    lt_arena_free(arena);
    return st;
}
