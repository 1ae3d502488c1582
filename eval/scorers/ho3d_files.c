/* SPDX-License-Identifier: Apache-2.0 */
/* Joints come first in a prediction file: they are kept. Vertices are scored as they come, block by block. */
#include "eval/scorers/ho3d_files.h"

#include "data/ho3d/points.h"
#include "libtensor/geometry/hand/model.h"

#include <stdlib.h>

enum { J = 3 * LT_HAND_KEYPOINTS, V = 3 * LT_HAND_VERTICES, BLOCK = 64 };

typedef struct {
    const char *pred_path, *xyz_path, *verts_path;
    ho3d_points *pred, *xyz, *verts;
    float (*p_xyz)[J], (*g_xyz)[J];             /* all frames */
    float (*p_verts)[V], (*g_verts)[V];         /* a block */
    int64_t n, room;
    ho3d_scorer *scorer;
} scoring;

static lt_status open_all(scoring *s)
{
    static const int both[2] = { LT_HAND_KEYPOINTS, LT_HAND_VERTICES };
    lt_status st = ho3d_points_open(s->pred_path, both, 2, &s->pred);

    if (!st)
        st = ho3d_points_open(s->xyz_path, both, 1, &s->xyz);
    if (!st)
        st = ho3d_points_open(s->verts_path, both + 1, 1, &s->verts);
    s->p_verts = calloc(BLOCK, sizeof(*s->p_verts));
    s->g_verts = calloc(BLOCK, sizeof(*s->g_verts));
    s->scorer = ho3d_scorer_new();
    if (!st && (!s->p_verts || !s->g_verts || !s->scorer))
        st = lt_error(LT_ENOMEM, "%s: no memory", s->pred_path);
    return st;
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

static lt_status score_block(scoring *s, int64_t done, int count)
{
    return ho3d_scorer_add(s->scorer, count, s->p_xyz[done], s->p_verts[0], s->g_xyz[done], s->g_verts[0], NULL);
}

static lt_status score_vertices(scoring *s, bool (*progress)(void *ctx, int64_t done, int64_t total), void *ctx)
{
    int64_t done = 0;
    bool more = true;

    while (more) {
        lt_status st = LT_OK;
        int count = 0;
        while (!st && more && count < BLOCK) {
            st = next_pair(s->pred, s->p_verts[count], s->verts, s->g_verts[count], s->pred_path, s->verts_path,
                           done + count, &more);
            count += !st && more;
            if (!st && done + count > s->n)
                st = lt_error(LT_EFORMAT, "%s: has vertices of more than the %lld frames that it has joints of",
                              s->pred_path, (long long)s->n);
        }
        if (!st && count)
            st = score_block(s, done, count);
        if (st)
            return st;
        done += count;
        if (progress && !progress(ctx, done, s->n))
            return lt_error(LT_ESTOPPED, "stopped after %lld of %lld samples", (long long)done, (long long)s->n);
    }
    return done == s->n ? LT_OK : lt_error(LT_EFORMAT, "%s: has joints of %lld frames, vertices of %lld", s->pred_path,
                                           (long long)s->n, (long long)done);
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
}

lt_status ho3d_score_files(const char *pred, const char *xyz, const char *verts, double scores[HO3D_SCORES], int64_t *n,
                           bool (*progress)(void *ctx, int64_t done, int64_t total), void *ctx)
{
    scoring s = { .pred_path = pred, .xyz_path = xyz, .verts_path = verts };
    lt_status st = open_all(&s);

    if (!st)
        st = read_joints(&s);
    if (!st)
        st = score_vertices(&s, progress, ctx);
    if (!st) {
        ho3d_scorer_scores(s.scorer, scores);
        *n = s.n;
    }
    close_all(&s);
    return st;
}
