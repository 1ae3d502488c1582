/* SPDX-License-Identifier: Apache-2.0 */
/* A rig of the nodes alone, for who wants no more of a body: less than a hundredth of its vertices. */
#include "assets/body/body.h"

#include <string.h>

enum { FEATURES = 9 * (BODY_JOINTS - 1) };

typedef struct {
    float *v_template, *shapedirs, *posedirs, *J_regressor, *weights;
} arrays;

static bool new_arrays(lt_arena *arena, size_t V, size_t S, arrays *a)
{
    *a = (arrays){
        .v_template = lt_arena_array(arena, V, 3 * sizeof(float)),
            .shapedirs = lt_arena_array(arena, V, 3 * S * sizeof(float)),
        .posedirs = lt_arena_array(arena, V, 3 * FEATURES * sizeof(float)),
        .J_regressor = lt_arena_array(arena, V, BODY_JOINTS * sizeof(float)),
        .weights = lt_arena_array(arena, V, BODY_JOINTS * sizeof(float)),
    };
    return a->v_template && a->shapedirs && a->posedirs && a->J_regressor && a->weights;
}

static void copy_vertex(const lt_rig *from, int v, const arrays *to, int i)
{
    const size_t shape = 3 * (size_t)from->S, joints = (size_t)from->J;

    memcpy(to->v_template + 3 * i, from->v_template + 3 * v, 3 * sizeof(float));
    memcpy(to->shapedirs + shape * (size_t)i, from->shapedirs + shape * (size_t)v, shape * sizeof(float));
    memcpy(to->posedirs + (size_t)(3 * FEATURES) * (size_t)i, from->posedirs + (size_t)(3 * FEATURES) * (size_t)v,
           3 * FEATURES * sizeof(float));
    memcpy(to->weights + joints * (size_t)i, from->weights + joints * (size_t)v, joints * sizeof(float));
}

/* A joint at rest, as all vertices say where it is, stands for a vertex that moves with it. */
static void put_joint(const lt_rig *from, int j, const arrays *to, int i, int V)
{
    const float *share = from->J_regressor + (size_t)j * (size_t)from->V;
    const int numbers = 3 * from->S;
    double place[3] = { 0 }, dirs[3 * BODY_DIRECTIONS] = { 0 };

    for (int v = 0; v < from->V; v++) {
        for (int k = 0; k < 3 && share[v] != 0; k++)
            place[k] += (double)share[v] * (double)from->v_template[3 * v + k];
        for (int k = 0; k < numbers && share[v] != 0; k++)
            dirs[k] += (double)share[v] * (double)from->shapedirs[(size_t)numbers * (size_t)v + (size_t)k];
    }
    for (int k = 0; k < 3; k++)
        to->v_template[3 * i + k] = (float)place[k];
    for (int k = 0; k < numbers; k++)
        to->shapedirs[numbers * i + k] = (float)dirs[k];
    to->weights[BODY_JOINTS * i + j] = 1;
    to->J_regressor[V * j + i] = 1;
}

lt_status synth_body_nodes_rig(lt_arena *arena, const body_model *m, lt_rig *out, int points[BODY_NODES])
{
    const lt_rig whole = synth_body_rig(m);
    int n = 0, V = BODY_JOINTS;
    arrays a;

    for (int i = 0; i < BODY_NODES; i++)
        V += body_node[i] >= BODY_JOINTS;
    if (!new_arrays(arena, (size_t)V, (size_t)whole.S, &a))
        return lt_error(LT_ENOMEM, "no memory for a body's nodes");
    for (int i = 0; i < BODY_NODES; i++) {
        points[i] = body_node[i];
        if (body_node[i] < BODY_JOINTS)
            continue;
        copy_vertex(&whole, body_node[i] - BODY_JOINTS, &a, n);
        points[i] = BODY_JOINTS + n++;
    }
    for (int j = 0; j < BODY_JOINTS; j++)
        put_joint(&whole, j, &a, n + j, V);
    *out = (lt_rig){ .V = V, .J = whole.J, .S = whole.S, .parents = whole.parents, .v_template = a.v_template,
                     .shapedirs = a.shapedirs, .posedirs = a.posedirs, .J_regressor = a.J_regressor,
                         .weights = a.weights };
    return LT_OK;
}
