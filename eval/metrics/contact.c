/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/metrics/contact.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/surface.h"

#include <math.h>
#include <string.h>

static const double VOXEL = 5e-3, TOUCHES = 4e-3, LARGEST = 2;      /* metres */

/* Voxel (i, j, k) has its centre at lo + VOXEL (i + 1/2, j + 1/2, k + 1/2). */
struct eval_contact_object {
    const lt_mesh_index *surface;
    double lo[3], hi[3];
    int n[3];
    bool *inside;                   /* (n[2], n[1], n[0]) */
};

static bool is_inside(const lt_mesh_index *surface, const double p[3])
{
    return fabs(lt_mesh_winding(surface, p)) > 0.5;
}

static void bounds(const lt_mesh *mesh, double lo[3], double hi[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] = INFINITY;
        hi[k] = -INFINITY;
        for (int i = 0; i < mesh->n_vertices; i++) {
            lo[k] = fmin(lo[k], mesh->vertex[i][k]);
            hi[k] = fmax(hi[k], mesh->vertex[i][k]);
        }
    }
}

static void centre_of(const eval_contact_object *o, int i, int j, int k, double out[3])
{
    out[0] = o->lo[0] + VOXEL * (i + 0.5);
    out[1] = o->lo[1] + VOXEL * (j + 0.5);
    out[2] = o->lo[2] + VOXEL * (k + 0.5);
}

/* ---- the object ---- */

static void fill_layer(void *ctx, int64_t k)
{
    const eval_contact_object *o = ctx;
    bool *at = o->inside + (size_t)k * (size_t)o->n[1] * (size_t)o->n[0];

    for (int j = 0; j < o->n[1]; j++)
        for (int i = 0; i < o->n[0]; i++) {
            double p[3];
            centre_of(o, i, j, (int)k, p);
            *at++ = is_inside(o->surface, p);
        }
}

lt_status eval_contact_object_new(lt_arena *arena, const lt_mesh *mesh, eval_contact_object **out)
{
    eval_contact_object *o = lt_arena_alloc(arena, sizeof(*o));
    lt_mesh_index *surface = NULL;
    lt_status st = o ? lt_mesh_index_new(arena, mesh, &surface) : lt_error(LT_ENOMEM, "contact: no memory");

    if (st)
        return st;
    o->surface = surface;
    bounds(mesh, o->lo, o->hi);
    for (int k = 0; k < 3; k++) {
        if (o->hi[k] - o->lo[k] > LARGEST)
            return lt_error(LT_EINVAL, "contact: the object is %.3g m large, want at most %g", o->hi[k] - o->lo[k],
                            LARGEST);
        o->n[k] = (int)fmax(1, ceil((o->hi[k] - o->lo[k]) / VOXEL - 1e-6));
    }
    o->inside = lt_arena_array(arena, (size_t)o->n[0] * (size_t)o->n[1], (size_t)o->n[2]);
    if (!o->inside)
        return lt_error(LT_ENOMEM, "contact: no memory for %d x %d x %d voxels", o->n[0], o->n[1], o->n[2]);
    lt_parallel_for(o->n[2], fill_layer, o);
    *out = o;
    return LT_OK;
}

/* ---- a frame ---- */

/* The hand in the object's frame: x_object = R^T (x_cam - t). */
static lt_status bring_hand(lt_arena *arena, const double R[9], const double t[3], const lt_mesh *hand, lt_mesh *out)
{
    *out = *hand;
    out->vertex = lt_arena_array(arena, (size_t)hand->n_vertices, sizeof(*out->vertex));
    if (!out->vertex)
        return lt_error(LT_ENOMEM, "contact: no memory for a hand");
    for (int i = 0; i < hand->n_vertices; i++) {
        const double d[3] = { hand->vertex[i][0] - t[0], hand->vertex[i][1] - t[1], hand->vertex[i][2] - t[2] };
        for (int k = 0; k < 3; k++)
            out->vertex[i][k] = (float)(R[k] * d[0] + R[3 + k] * d[1] + R[6 + k] * d[2]);
    }
    return LT_OK;
}

static bool in_box(const eval_contact_object *o, const double p[3], double margin)
{
    for (int k = 0; k < 3; k++)
        if (p[k] < o->lo[k] - margin || p[k] > o->hi[k] + margin)
            return false;
    return true;
}

static void score_vertices(const eval_contact_object *o, const lt_mesh *hand, eval_contact_score *out)
{
    for (int i = 0; i < hand->n_vertices; i++) {
        const double p[3] = { hand->vertex[i][0], hand->vertex[i][1], hand->vertex[i][2] };
        double distance;
        if (!in_box(o, p, TOUCHES))
            continue;
        distance = lt_mesh_closest(o->surface, p).distance;
        if (is_inside(o->surface, p)) {
            out->penetration_mm = fmax(out->penetration_mm, 1000 * distance);
            out->contact = true;
        }
        out->contact |= distance <= TOUCHES;
    }
}

/* Voxels along axis k that a box may have the centres of. */
static void voxel_range(const eval_contact_object *o, int k, double lo, double hi, int range[2])
{
    range[0] = (int)fmax(0, floor((lo - o->lo[k]) / VOXEL - 0.5));
    range[1] = (int)fmin(o->n[k], ceil((hi - o->lo[k]) / VOXEL + 0.5));
}

static double shared_cm3(const eval_contact_object *o, const lt_mesh *hand, const lt_mesh_index *surface)
{
    double lo[3], hi[3], p[3];
    int range[3][2];
    int64_t shared = 0;

    bounds(hand, lo, hi);
    for (int k = 0; k < 3; k++)
        voxel_range(o, k, lo[k], hi[k], range[k]);
    for (int k = range[2][0]; k < range[2][1]; k++)
        for (int j = range[1][0]; j < range[1][1]; j++)
            for (int i = range[0][0]; i < range[0][1]; i++) {
                if (!o->inside[((size_t)k * (size_t)o->n[1] + (size_t)j) * (size_t)o->n[0] + (size_t)i])
                    continue;
                centre_of(o, i, j, k, p);
                shared += is_inside(surface, p);
            }
    return (double)shared * VOXEL * VOXEL * VOXEL * 1e6;
}

lt_status eval_contact(const eval_contact_object *object, const double R[9], const double t[3], const lt_mesh *hand,
                       eval_contact_score *out)
{
    lt_arena *arena = lt_arena_new();
    lt_mesh_index *surface = NULL;
    lt_mesh mine;
    lt_status st = arena ? bring_hand(arena, R, t, hand, &mine) : lt_error(LT_ENOMEM, "contact: no memory");

    if (!st)
        st = lt_mesh_index_new(arena, &mine, &surface);
    if (!st) {
        *out = (eval_contact_score){ 0 };
        score_vertices(object, &mine, out);
        out->intersection_cm3 = shared_cm3(object, &mine, surface);
    }
    lt_arena_free(arena);
    return st;
}

void eval_close_hand(const lt_hand_model *hand, int32_t face[EVAL_CLOSED_HAND_FACES][3])
{
    memcpy(face, hand->faces, sizeof(hand->faces));
    for (int f = 0; f < SYNTH_HAND_CAP_FACES; f++)
        for (int k = 0; k < 3; k++)
            face[LT_HAND_FACES + f][hand->left ? 2 - k : k] = synth_hand_cap[f][k];
}
