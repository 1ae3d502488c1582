/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The synthetic hand, built: skeleton, skin, mesh, ids, and the arrays of a hand model.
 */
#include "assets/hand/internal.h"

#include <string.h>

static lt_status build_surface(lt_arena *scratch, const hand_skeleton *s, surface_mesh *m)
{
    const surface_skin skin = hand_shape_skin(s);
    const surface_grid grid = { .origin = { -98, -40, -73 }, .cell = 2, .n = { 104, 44, 92 }, .cut = { 0, s->cut_x },
                                .loop = { 0, 1 } };
    const int rim[SURFACE_LOOPS] = { WRIST_LOOP };
    lt_status st = surface_nets(scratch, &skin, &grid, m);

    if (!st)
        st = surface_decimate(scratch, &skin, LT_HAND_VERTICES, rim, m);
    if (!st)
        st = surface_relax(scratch, &skin, 40, 0, m);
    if (!st)
        hand_number(s, m);
    return st;
}

static void measure(const hand_skeleton *s, const surface_mesh *m, hand_rig *rig)
{
    double total = 0;

    for (int f = 0; f < m->n_faces; f++) {
        const vec3 a = m->vertex[m->face[f][0]], b = m->vertex[m->face[f][1]],
                   c = m->vertex[m->face[f][2]];
        const double area = norm(cross(sub(b, a), sub(c, a))) / 2;

        total += area;
        for (int k = 0; k < 3; k++)
            rig->area[m->face[f][k]] += area / 3;
    }
    for (int v = 0; v < m->n_vertices; v++) {
        rig->vertex[v] = m->vertex[v];
        rig->area[v] /= total;
        hand_weights_at(s, m->vertex[v], rig->weight[v]);
    }
}

static void to_metres(vec3 v, float out[3])
{
    out[0] = (float)(v.x / 1000);
    out[1] = (float)(v.y / 1000);
    out[2] = (float)(v.z / 1000);
}

/* Weights as floats whose sum is 1 to rounding: the largest takes the difference. */
static void store_weights(const double w[LT_HAND_JOINTS], float out[LT_HAND_JOINTS])
{
    int most = 0;
    float rest = 1;

    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        out[j] = (float)w[j];
        most = out[j] > out[most] ? j : most;
    }
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        rest -= j == most ? 0 : out[j];
    out[most] = rest;
}

static void store(const surface_mesh *m, const hand_rig *rig, const hand_motion *motion,
                  lt_hand_model *out)
{
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        to_metres(rig->vertex[v], out->v_template[v]);
        store_weights(rig->weight[v], out->weights[v]);
        for (int k = 0; k < LT_HAND_BETAS; k++) {
            float d[3];

            to_metres(motion[k].vertex[v], d);
            for (int c = 0; c < 3; c++)
                out->shapedirs[v][c][k] = d[c];
        }
    }
    memcpy(out->faces, m->face, sizeof(out->faces));
    out->synthetic = true;
}

static lt_status build(lt_arena *scratch, const hand_skeleton *s, lt_hand_model *out)
{
    hand_rig *rig = lt_arena_alloc(scratch, sizeof(*rig));
    hand_motion *motion = lt_arena_array(scratch, LT_HAND_BETAS, sizeof(*motion));
    surface_mesh m;
    lt_status st;

    if (!rig || !motion)
        return lt_error(LT_ENOMEM, "synthetic hand: no memory for its rig");
    st = build_surface(scratch, s, &m);
    if (st)
        return st;
    measure(s, &m, rig);
    hand_betas(s, rig, motion);
    store(&m, rig, motion, out);
    hand_regressor(s, rig, motion, out->J_regressor);
    hand_correctives(s, rig, out->posedirs);
    return hand_pose_space(scratch, out);
}

lt_status synth_hand_new(lt_arena *arena, synth_hand_profile profile, lt_hand_model **out)
{
    lt_hand_model *model = lt_arena_alloc(arena, sizeof(*model));
    lt_arena *scratch = lt_arena_new();
    lt_status st = LT_ENOMEM;
    hand_skeleton s;

    hand_skeleton_init(&s, profile);
    if (model && scratch)
        st = build(scratch, &s, model);
    else
        lt_error(LT_ENOMEM, "synthetic hand: no memory for the model");
    lt_arena_free(scratch);
    if (!st)
        *out = model;
    return st;
}

static void mirror_vectors(lt_hand_model *m)
{
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        m->v_template[v][0] = -m->v_template[v][0];
        for (int k = 0; k < LT_HAND_BETAS; k++)
            m->shapedirs[v][0][k] = -m->shapedirs[v][0][k];
        for (int f = 0; f < LT_HAND_POSE_FEATURES; f++) {
            const bool row_x = f % 9 / 3 == 0,
                       col_x = f % 3 == 0; /* of R - I: mirrored on one side */

            for (int c = 0; c < 3; c++)
                if ((c == 0) != (row_x != col_x))
                    m->posedirs[v][c][f] = -m->posedirs[v][c][f];
        }
    }
}

void synth_hand_mirror(const lt_hand_model *right, lt_hand_model *left)
{
    *left = *right;
    left->left = !right->left;
    mirror_vectors(left);
    for (int f = 0; f < LT_HAND_FACES; f++) {
        left->faces[f][1] = right->faces[f][2];
        left->faces[f][2] = right->faces[f][1];
    }
    for (int i = 0; i < LT_HAND_PCA; i++) {
        if (i % 3)                              /* axis-angle vectors keep x and turn y, z round */
            left->hands_mean[i] = -right->hands_mean[i];
        for (int k = 0; k < LT_HAND_PCA; k++)
            if (i % 3)
                left->hands_components[k][i] = -right->hands_components[k][i];
    }
}
