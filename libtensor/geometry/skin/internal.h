/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: a rig laid out, and one sample's numbers. The root stands at the origin:
 *
 *   posed_i = sum of c_k blend_k,i                      c = 1 for the template, the shape (S), then R_k - I (P)
 *   A_k, p_k                                            frames of the joints, p_0 = 0
 *   v_i = sum of w_ik (A_k posed_i + s_k)               s_k = p_k - A_k rest_k
 *
 * Vertices go by groups, each coordinate a whole vector; what is over joints is small, and in double.
 */
#ifndef LT_GEOMETRY_SKIN_INTERNAL_H
#define LT_GEOMETRY_SKIN_INTERNAL_H

#include "libtensor/geometry/skin/skin.h"

enum {
    GROUP = LT_SKIN_GROUP, COLUMNS = 3 * GROUP,
    PIECE = 8,                          /* groups of a task */
};

/* A vertex that is one of the layer's points */
typedef struct { int point, vertex; } skin_vertex_point;

/* Where a sample's numbers are in its scratch, in bytes */
typedef struct { size_t posed, skin, coef, frame, rest, world_R, world_t, end; } skin_places;

struct lt_skin_layer {
    lt_skin_tables t;
    int64_t blends, columns;            /* 1 + S + P directions, of so many numbers */
    int64_t pieces;
    lt_real **packed;                   /* (pieces) the blends as products read them ... */
    lt_isa isa;                         /* ... with this instruction set */
    const lt_skin_group *group;         /* (groups) weights without most of the zeros */
    skin_vertex_point *vertex_points;
    int n_vertex_points;
    skin_places at;
};

/* What forward leaves for backward of one sample */
typedef struct {
    lt_real *posed;                     /* (groups, 3, GROUP) with shape and pose offsets, before skinning */
    lt_real *skin;                      /* (12, padded) backward's: each vertex's blended A, and a gradient */
    lt_real *coef;                      /* (blends) */
    lt_real (*frame)[LT_SKIN_FRAME];    /* (J) A_k, then s_k */
    double (*rest)[3];                  /* (J) joints before posing */
    double (*world_R)[9], (*world_t)[3];        /* (J) their frames */
} skin_sample;

/* skin_sample_at - where sample i has its numbers */
static inline skin_sample skin_sample_at(const lt_skin_layer *layer, void *scratch, int64_t i)
{
    const skin_places *at = &layer->at;
    char *base = (char *)scratch + (size_t)i * at->end;

    return (skin_sample){
        .posed = (void *)(base + at->posed), .skin = (void *)(base + at->skin), .coef = (void *)(base + at->coef),
        .frame = (void *)(base + at->frame), .rest = (void *)(base + at->rest),
        .world_R = (void *)(base + at->world_R), .world_t = (void *)(base + at->world_t),
    };
}

/* skin_stride - elements from a number of one sample to the next one's */
static inline int64_t skin_stride(const lt_skin_layer *layer)
{
    return (int64_t)(layer->at.end / sizeof(lt_real));
}

/* A piece of the vertices: its first group, and how many */
typedef struct { int64_t first, groups; } skin_piece;

static inline skin_piece skin_piece_at(const lt_skin_layer *layer, int64_t i)
{
    return (skin_piece){ i * PIECE, lt_min_i64(layer->t.groups - i * PIECE, PIECE) };
}

/* skin_widen - rotations of a sample, in double */
static inline void skin_widen(const lt_skin_layer *layer, const lt_real *R, double *out)
{
    for (int i = 0; i < 9 * layer->t.J; i++)
        out[i] = R[i];
}

#endif
