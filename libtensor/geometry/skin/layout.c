/* SPDX-License-Identifier: Apache-2.0 */
/* How a rig is laid out for speed. */
#include "libtensor/geometry/skin/internal.h"

#include "libtensor/kernels/gemm/gemm.h"
#include "libtensor/kernels/gemm/tiles.h"

#include <string.h>

/* ---- what is copied ------------------------------------------------------------------------------------ */

/* n directions (V, 3, n), each of them a row of blends: a group after the other, as they are read column by column */
static void lay_directions(const float *from, int64_t V, int64_t n, int64_t columns, lt_real *blend)
{
    for (int64_t g = 0; g < columns / COLUMNS; g++)
        for (int64_t k = 0; k < n; k++)
            for (int64_t lane = 0; lane < lt_min_i64(GROUP, V - g * GROUP); lane++)
                for (int a = 0; a < 3; a++)
                    blend[k * columns + (3 * g + a) * GROUP + lane] = from[((g * GROUP + lane) * 3 + a) * n + k];
}

static void lay_weights(const lt_rig *rig, int64_t padded, lt_real *weight)
{
    for (int64_t i = 0; i < rig->V; i++)
        for (int j = 0; j < rig->J; j++)
            weight[j * padded + i] = rig->weights[i * rig->J + j];
}

static void lay_joint(const lt_rig *rig, int j, double (*rest)[3], double (*rest_shape)[3])
{
    for (int64_t i = 0; i < rig->V; i++) {
        const double w = rig->J_regressor[j * (int64_t)rig->V + i];

        for (int a = 0; w != 0 && a < 3; a++) {
            rest[j][a] += w * rig->v_template[3 * i + a];
            for (int k = 0; k < rig->S; k++)
                rest_shape[k * rig->J + j][a] += w * rig->shapedirs[(3 * i + a) * rig->S + k];
        }
    }
}

/* ---- groups of vertices -------------------------------------------------------------------------------- */

static bool moves_group(const lt_real *weight)
{
    for (int i = 0; i < GROUP; i++)
        if (weight[i] != 0)
            return true;
    return false;
}

/* The joints that move each group, and their weights */
static lt_skin_group *lay_groups(lt_arena *arena, const lt_skin_tables *t)
{
    lt_skin_group *groups = lt_arena_array(arena, (size_t)t->groups, sizeof(*groups));
    size_t all = 0;
    int *joint;
    lt_real (*weight)[LT_SKIN_GROUP];

    for (int64_t g = 0; groups && g < t->groups; g++)
        for (int j = 0; j < t->J; j++)
            groups[g].n += moves_group(t->weight + j * t->padded + g * GROUP);
    for (int64_t g = 0; groups && g < t->groups; g++)
        all += (size_t)groups[g].n;
    joint = lt_arena_array(arena, all, sizeof(*joint));
    weight = lt_arena_array(arena, all, sizeof(*weight));
    if (!groups || !joint || !weight)
        return NULL;
    for (int64_t g = 0; g < t->groups; g++) {
        groups[g].joint = joint;
        groups[g].weight = (const lt_real (*)[LT_SKIN_GROUP])weight;
        for (int j = 0; j < t->J; j++) {
            const lt_real *from = t->weight + j * t->padded + g * GROUP;

            if (!moves_group(from))
                continue;
            *joint++ = j;
            memcpy(*weight++, from, sizeof(*weight));
        }
    }
    return groups;
}

/* ---- the blends, packed -------------------------------------------------------------------------------- */

static int64_t packed_count(const lt_skin_layer *layer, int64_t columns)
{
    return lt_k->gemm_tiles ? lt_gemm_tiles_packed(columns, layer->blends)
                            : lt_gemm_packed_count(columns, layer->blends);
}

static bool pack_piece(lt_skin_layer *layer, lt_arena *arena, int64_t i)
{
    const skin_piece p = skin_piece_at(layer, i);
    const int64_t columns = p.groups * COLUMNS;

    layer->packed[i] = lt_arena_array(arena, (size_t)packed_count(layer, columns), sizeof(lt_real));
    if (layer->packed[i])
        (lt_k->gemm_tiles ? lt_gemm_tiles_pack : lt_gemm_pack)(
            LT_NO_TRANS, columns, layer->blends, layer->t.blend + p.first * COLUMNS, layer->columns, layer->packed[i]);
    return layer->packed[i];
}

/* ---- scratch ------------------------------------------------------------------------------------------- */

/* Room for n numbers of that size, aligned; where it begins */
static size_t take(size_t *at, int64_t n, size_t size)
{
    const size_t here = *at;

    *at += (size_t)lt_ceil_div(n * (int64_t)size, LT_ALIGN) * LT_ALIGN;
    return here;
}

static void lay_sample(lt_skin_layer *layer)
{
    const lt_skin_tables *t = &layer->t;
    skin_places *at = &layer->at;

    at->posed = take(&at->end, layer->columns, sizeof(lt_real));
    at->skin = take(&at->end, 12 * t->padded, sizeof(lt_real));
    at->coef = take(&at->end, layer->blends, sizeof(lt_real));
    at->frame = take(&at->end, t->J, sizeof(lt_real[LT_SKIN_FRAME]));
    at->rest = take(&at->end, t->J, sizeof(double[3]));
    at->world_R = take(&at->end, t->J, sizeof(double[9]));
    at->world_t = take(&at->end, t->J, sizeof(double[3]));
}

size_t lt_skin_scratch_bytes(const lt_skin_layer *layer, int64_t n)
{
    return (size_t)n * layer->at.end;
}

/* ---- all of it ----------------------------------------------------------------------------------------- */

static lt_status check_rig(const lt_rig *rig, const int *points, int n_points)
{
    if (rig->V < 1 || rig->J < 1 || rig->J > LT_RIG_JOINTS || rig->S < 0)
        return lt_error(LT_EINVAL, "skin layer: %d vertices, %d joints and %d shape directions, want at least 1, "
                        "1 to %d, and at least 0", rig->V, rig->J, rig->S, LT_RIG_JOINTS);
    for (int j = 0; j < rig->J; j++)
        if (rig->parents[j] >= j || rig->parents[j] < (j ? 0 : -1))
            return lt_error(LT_EINVAL, "skin layer: joint %d has parent %d, want %s", j, rig->parents[j],
                            j ? "a joint before it" : "-1");
    for (int i = 0; i < n_points; i++)
        if (points[i] < 0 || points[i] >= rig->J + rig->V)
            return lt_error(LT_EINVAL, "skin layer: point %d is %d, want a joint, 0 to %d, or a vertex, %d to %d", i,
                            points[i], rig->J - 1, rig->J, rig->J + rig->V - 1);
    return LT_OK;
}

static const void *copy(lt_arena *arena, const void *from, size_t count, size_t size)
{
    void *to = lt_arena_array(arena, count, size);

    if (to && count)
        memcpy(to, from, count * size);
    return to;
}

/* The arrays of a rig, or false without memory */
static bool lay_tables(lt_arena *arena, const lt_rig *rig, lt_skin_layer *layer)
{
    lt_skin_tables *t = &layer->t;
    lt_real *blend = lt_arena_array(arena, (size_t)(layer->blends * layer->columns), sizeof(*blend));
    lt_real *weight = lt_arena_array(arena, (size_t)(t->J * t->padded), sizeof(*weight));
    double (*rest)[3] = lt_arena_array(arena, (size_t)t->J, sizeof(*rest));
    double (*rest_shape)[3] = lt_arena_array(arena, (size_t)t->S * (size_t)t->J, sizeof(*rest_shape));

    t->parents = copy(arena, rig->parents, (size_t)t->J, sizeof(*t->parents));
    if (!blend || !weight || !rest || !rest_shape || !t->parents)
        return false;
    lay_directions(rig->v_template, t->V, 1, layer->columns, blend);
    lay_directions(rig->shapedirs, t->V, t->S, layer->columns, blend + layer->columns);
    lay_directions(rig->posedirs, t->V, t->P, layer->columns, blend + (1 + t->S) * layer->columns);
    lay_weights(rig, t->padded, weight);
    for (int j = 0; j < t->J; j++)
        lay_joint(rig, j, rest, rest_shape);
    t->blend = blend;
    t->weight = weight;
    t->rest = (const double (*)[3])rest;
    t->rest_shape = (const double (*)[3])rest_shape;
    layer->group = lay_groups(arena, t);
    layer->packed = lt_arena_array(arena, (size_t)layer->pieces, sizeof(*layer->packed));
    for (int64_t i = 0; layer->packed && i < layer->pieces; i++)
        if (!pack_piece(layer, arena, i))
            return false;
    return layer->group && layer->packed;
}

static bool lay_points(lt_arena *arena, const int *points, int n, lt_skin_layer *layer)
{
    layer->t.points = copy(arena, points, (size_t)n, sizeof(*points));
    layer->t.n_points = n;
    layer->vertex_points = lt_arena_array(arena, (size_t)n, sizeof(*layer->vertex_points));
    if (!layer->t.points || !layer->vertex_points)
        return false;
    for (int i = 0; i < n; i++)
        if (points[i] >= layer->t.J)
            layer->vertex_points[layer->n_vertex_points++] = (skin_vertex_point){ i, points[i] - layer->t.J };
    return true;
}

lt_status lt_skin_layer_new(lt_arena *arena, const lt_rig *rig, const int *points, int n_points,
                            lt_skin_layer **out)
{
    const int64_t groups = lt_ceil_div(rig->V, GROUP);
    lt_skin_layer *layer;
    lt_status st = check_rig(rig, points, n_points);

    if (!st)
        st = lt_kernels_init();             /* its tables are packed for the kernels that will read them */
    if (st)
        return st;
    layer = lt_arena_alloc(arena, sizeof(*layer));
    if (!layer)
        return lt_error(LT_ENOMEM, "skin layer: no memory for its tables");
    layer->t = (lt_skin_tables){
        .V = rig->V, .J = rig->J, .S = rig->S, .P = rig->posedirs ? 9 * (rig->J - 1) : 0,
        .groups = groups, .padded = groups * GROUP,
    };
    layer->blends = 1 + layer->t.S + layer->t.P;
    layer->columns = groups * COLUMNS;
    layer->pieces = lt_ceil_div(groups, PIECE);
    layer->isa = lt_k->isa;
    lay_sample(layer);
    if (!lay_tables(arena, rig, layer) || !lay_points(arena, points, n_points, layer))
        return lt_error(LT_ENOMEM, "skin layer: no memory for its tables");
    *out = layer;
    return LT_OK;
}

lt_skin_tables lt_skin_layer_tables(const lt_skin_layer *layer)
{
    return layer->t;
}
