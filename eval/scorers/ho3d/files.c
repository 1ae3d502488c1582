/* SPDX-License-Identifier: Apache-2.0 */
/* Joints come first in a prediction file: they are kept. Vertices are scored as they come, block by block. */
#include "eval/scorers/ho3d/files.h"

#include "data/ho3d/points.h"
#include "data/slip.h"
#include "libtensor/geometry/hand/model.h"

#include <stdlib.h>
#include <string.h>

enum { J = 3 * LT_HAND_KEYPOINTS, V = 3 * LT_HAND_VERTICES, BLOCK = 64, LOOK = 256 };    /* LOOK: frames for slips */

typedef struct {
    const char *pred_path, *xyz_path, *verts_path;
    ho3d_points *pred, *xyz, *verts;
    float (*p_xyz)[J], (*g_xyz)[J];             /* all frames */
    float *p_verts, (*g_verts)[V];              /* a block; p_verts of so many points a frame as it has */
    float *frame;                               /* the first with vertices, which says how many */
    int64_t n, room;
    int points;
    ho3d_scorer *scorer;
    eval_notes *notes;
} scoring;

static lt_status open_all(scoring *s)
{
    static const int both[2] = { LT_HAND_KEYPOINTS, LT_HAND_VERTICES };
    lt_status st = ho3d_points_open(s->pred_path, both, 2, &s->pred);

    if (!st)
        st = ho3d_points_open(s->xyz_path, both, 1, &s->xyz);
    if (!st)
        st = ho3d_points_open(s->verts_path, both + 1, 1, &s->verts);
    s->frame = calloc(HO3D_MOST_POINTS, 3 * sizeof(*s->frame));
    s->g_verts = calloc(BLOCK, sizeof(*s->g_verts));
    s->scorer = ho3d_scorer_new();
    if (!st && (!s->frame || !s->g_verts || !s->scorer))
        st = lt_error(LT_ENOMEM, "%s: no memory", s->pred_path);
    if (st)
        return st;
    ho3d_points_any(s->pred);
    if (ho3d_points_note(s->pred))
        eval_note(s->notes, "archive", "%s: %s", s->pred_path, ho3d_points_note(s->pred));
    return LT_OK;
}

static lt_status grow(scoring *s)
{
    const int64_t room = 2 * s->room + 1024;
    float (*p)[J] = realloc(s->p_xyz, (size_t)room * sizeof(*p)), (*g)[J];

    if (p)
        s->p_xyz = p;
    g = realloc(s->g_xyz, (size_t)room * sizeof(*g));
    if (g)
        s->g_xyz = g;
    if (!p || !g)
        return lt_error(LT_ENOMEM, "%s: no memory for %lld frames", s->pred_path, (long long)room);
    s->room = room;
    return LT_OK;
}

/* One frame of each of two files, which have to end together. */
static lt_status next_pair(ho3d_points *a, float *x, ho3d_points *b, float *y, const char *path_a, const char *path_b,
                           int64_t frame, bool *more)
{
    bool second;
    lt_status st = ho3d_points_next(a, x, more);

    if (!st)
        st = ho3d_points_next(b, y, &second);
    if (!st && *more != second)
        st = lt_error(LT_EFORMAT, "%s has %lld frames, %s has more", *more ? path_b : path_a, (long long)frame,
                      *more ? path_a : path_b);
    return st;
}

static lt_status read_joints(scoring *s)
{
    bool more = true;

    for (;; s->n++) {
        lt_status st = s->n == s->room ? grow(s) : LT_OK;
        if (!st)
            st = next_pair(s->pred, s->p_xyz[s->n], s->xyz, s->g_xyz[s->n], s->pred_path, s->xyz_path, s->n, &more);
        if (st || !more)
            return st;
    }
}

/* ---- slips ---- */

/* From the file's axes and order to those in which slips are looked for. */
static void turn(const float *in, int points, const int *from, float *out)
{
    for (int i = 0; i < points; i++) {
        const float *x = in + 3 * (from ? from[i] : i);
        out[3 * i] = x[0];
        out[3 * i + 1] = -x[1];
        out[3 * i + 2] = -x[2];
    }
}

/* n frames of two files, every step-th; what they look like is said. */
static void look_for_slip(scoring *s, const char *what, int64_t n, int64_t step, int points, const int *from,
                          const float *p, const float *g)
{
    const size_t size = 3 * (size_t)points;
    float *found = calloc((size_t)n, 2 * size * sizeof(*found)), *wanted = found ? found + (size_t)n * size : NULL;
    slip_points look = { .what = what, .file.opengl = true, .n = n, .points = points, .skip = -1, .places = true };
    slip out = { 0 };

    if (!found)
        return;
    for (int64_t i = 0; i < n; i++) {
        turn(p + size * (size_t)(i * step), points, from, found + size * (size_t)i);
        turn(g + size * (size_t)(i * step), points, from, wanted + size * (size_t)i);
    }
    look.found = found;
    look.wanted = wanted;
    slip_in_points(&look, &out);
    if (out.code)
        eval_note(s->notes, out.code, "%s: it looks as if %s", s->pred_path, out.text);
    free(found);
}

static void look_at_joints(scoring *s)
{
    const int64_t step = (s->n + LOOK - 1) / LOOK;

    if (s->notes && s->n)
        look_for_slip(s, "the joints", s->n / step, step, LT_HAND_KEYPOINTS, lt_mano_to_simple, s->p_xyz[0],
                      s->g_xyz[0]);
}

/* ---- vertices ---- */

static lt_status no_vertices(scoring *s)
{
    const float *none = s->frame;

    eval_note(s->notes, "joints-only", "%s: has joints alone, so that the mesh scores are -1; HO3D's server wants a "
              "list of vertices too", s->pred_path);
    s->points = 0;
    for (int64_t i = 0; i < s->n; i++) {
        bool more;
        lt_status st = ho3d_points_next(s->verts, s->g_verts[0], &more);
        if (!st && !more)
            st = lt_error(LT_EFORMAT, "%s has %lld frames, %s has more", s->verts_path, (long long)i, s->pred_path);
        if (!st)
            st = ho3d_scorer_add_mesh(s->scorer, 1, s->p_xyz[i], none, 0, s->g_xyz[i], s->g_verts[0]);
        if (st)
            return st;
    }
    return LT_OK;
}

static void say_points(scoring *s)
{
    if (s->points && s->points != LT_HAND_VERTICES)
        eval_note(s->notes, "other-mesh", "%s: has meshes of %d vertices, not MANO's %d: mesh scores are -1, as the "
                  "server's, which aligns such vertices by the joints", s->pred_path, s->points, LT_HAND_VERTICES);
    if (!s->points)
        eval_note(s->notes, "joints-only", "%s: has meshes without vertices, so that the mesh scores are -1; HO3D's "
                  "server wants some", s->pred_path);
}

/* The first frame with vertices; *more false: there is none, and the file has joints alone. */
static lt_status first_vertices(scoring *s, bool *more)
{
    lt_status st = ho3d_points_next(s->pred, s->frame, more);

    if (st || !*more)
        return st;
    s->points = ho3d_points_of(s->pred, 1);
    s->p_verts = calloc(BLOCK, (3 * (size_t)s->points + 1) * sizeof(*s->p_verts));
    if (!s->p_verts)
        return lt_error(LT_ENOMEM, "%s: no memory", s->pred_path);
    memcpy(s->p_verts, s->frame, 3 * (size_t)s->points * sizeof(*s->frame));
    say_points(s);
    return LT_OK;
}

/* The next frame's vertices into place `count` of the block; the very first were read already. */
static lt_status next_vertices(scoring *s, int64_t frame, int count, bool *more)
{
    float *p = s->p_verts + 3 * (size_t)s->points * (size_t)count;

    if (frame)
        return next_pair(s->pred, p, s->verts, s->g_verts[count], s->pred_path, s->verts_path, frame, more);
    const lt_status st = ho3d_points_next(s->verts, s->g_verts[0], more);
    return !st && !*more ? lt_error(LT_EFORMAT, "%s has 0 frames, %s has more", s->verts_path, s->pred_path) : st;
}

static lt_status fill_block(scoring *s, int64_t done, int *count, bool *more)
{
    lt_status st = LT_OK;

    for (*count = 0; !st && *more && *count < BLOCK; *count += !st && *more) {
        st = next_vertices(s, done + *count, *count, more);
        if (!st && *more && done + *count >= s->n)
            st = lt_error(LT_EFORMAT, "%s: has vertices of more than the %lld frames that it has joints of",
                          s->pred_path, (long long)s->n);
    }
    return st;
}

static lt_status score_block(scoring *s, int64_t done, int count)
{
    if (!done && s->notes && s->points == LT_HAND_VERTICES)
        look_for_slip(s, "the vertices", count, 1, s->points, NULL, s->p_verts, s->g_verts[0]);
    return ho3d_scorer_add_mesh(s->scorer, count, s->p_xyz[done], s->p_verts, s->points, s->g_xyz[done], s->g_verts[0]);
}

static lt_status score_vertices(scoring *s, bool (*progress)(void *ctx, int64_t done, int64_t total), void *ctx)
{
    int64_t done = 0;
    bool more;
    lt_status st = first_vertices(s, &more);

    if (!st && !more)
        return s->n ? no_vertices(s) : LT_OK;
    while (!st && more) {
        int count;
        st = fill_block(s, done, &count, &more);
        if (!st && count)
            st = score_block(s, done, count);
        if (st)
            return st;
        done += count;
        if (progress && !progress(ctx, done, s->n))
            return lt_error(LT_ESTOPPED, "stopped after %lld of %lld samples", (long long)done, (long long)s->n);
    }
    if (!st && done != s->n)
        st = lt_error(LT_EFORMAT, "%s: has joints of %lld frames, vertices of %lld", s->pred_path, (long long)s->n,
                      (long long)done);
    return st;
}

static void close_all(scoring *s)
{
    ho3d_points_close(s->pred);
    ho3d_points_close(s->xyz);
    ho3d_points_close(s->verts);
    ho3d_scorer_free(s->scorer);
    free(s->p_xyz);
    free(s->g_xyz);
    free(s->p_verts);
    free(s->g_verts);
    free(s->frame);
}

lt_status ho3d_score_files(const char *pred, const char *xyz, const char *verts, double scores[HO3D_SCORES], int64_t *n,
                           eval_notes *notes, bool (*progress)(void *ctx, int64_t done, int64_t total), void *ctx)
{
    scoring s = { .pred_path = pred, .xyz_path = xyz, .verts_path = verts, .notes = notes };
    lt_status st = open_all(&s);

    if (!st)
        st = read_joints(&s);
    if (!st) {
        look_at_joints(&s);
        st = score_vertices(&s, progress, ctx);
    }
    if (!st) {
        ho3d_scorer_scores(s.scorer, scores);
        *n = s.n;
    }
    close_all(&s);
    return st;
}
