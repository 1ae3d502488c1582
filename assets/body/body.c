/* SPDX-License-Identifier: Apache-2.0 */
/* The synthetic body, built: skeleton, skin, and the arrays of a body model. */
#include "assets/body/internal.h"

#include "assets/hand/hand.h"

#include <string.h>

static lt_status get_arrays(lt_arena *arena, body_model **out)
{
    body_model *m = lt_arena_alloc(arena, sizeof(*m));
    bool ok = m != NULL;

    if (ok) {
        m->shapes = BODY_SHAPES;
        m->expressions = BODY_EXPRESSIONS;
        m->synthetic = true;
        m->v_template = lt_arena_array(arena, V, sizeof(*m->v_template));
        m->shapedirs = lt_arena_array(arena, 3 * V * BODY_DIRECTIONS, sizeof(float));
        m->posedirs = lt_arena_array(arena, (size_t)3 * V * BODY_FEATURES, sizeof(float));
        m->J_regressor = lt_arena_array(arena, J * V, sizeof(float));
        m->weights = lt_arena_array(arena, J * V, sizeof(float));
        m->faces = lt_arena_array(arena, F, sizeof(*m->faces));
        ok = m->v_template && m->shapedirs && m->posedirs && m->J_regressor && m->weights && m->faces;
    }
    for (int side = 0; ok && side < 2; side++) {
        m->hand_components[side] = lt_arena_array(arena, BODY_HAND_PCA, sizeof(*m->hand_components[side]));
        m->hand_mean[side] = lt_arena_array(arena, BODY_HAND_PCA, sizeof(float));
        ok = m->hand_components[side] && m->hand_mean[side];
    }
    *out = m;
    return ok ? LT_OK : lt_error(LT_ENOMEM, "synthetic body: no memory for the model");
}

/* Weights as floats whose sum is 1 to rounding: the largest takes the difference. */
static void store_weights(const double w[J], float *out)
{
    int most = 0;
    float rest = 1;

    for (int j = 0; j < J; j++) {
        out[j] = (float)w[j];
        most = out[j] > out[most] ? j : most;
    }
    for (int j = 0; j < J; j++)
        rest -= j == most ? 0 : out[j];
    out[most] = rest;
}

static void store_skin(const body_skeleton *s, const body_skin *skin, const body_motion *motion, body_model *m)
{
    for (int v = 0; v < V; v++) {
        const vec3 p = sub(skin->vertex[v], s->joint[BODY_PELVIS]);

        m->v_template[v][0] = (float)(p.x / 1000);
        m->v_template[v][1] = (float)(p.y / 1000);
        m->v_template[v][2] = (float)(p.z / 1000);
        store_weights(skin->weight[v], m->weights + (size_t)v * J);
        for (int k = 0; k < BODY_DIRECTIONS; k++) {
            const vec3 d = motion[k].vertex[v];
            float *at = m->shapedirs + (size_t)v * 3 * BODY_DIRECTIONS + k;

            at[0] = (float)(d.x / 1000);
            at[BODY_DIRECTIONS] = (float)(d.y / 1000);
            at[2 * BODY_DIRECTIONS] = (float)(d.z / 1000);
        }
    }
    memcpy(m->faces, skin->face, sizeof(skin->face));
    memcpy(m->parent, body_parent, sizeof(body_parent));
}

static void store_hands(const lt_hand_model *hand, body_model *m)
{
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < LT_HAND_PCA; k++) {     /* axis-angle vectors keep x and turn y, z round in a mirror */
            const float sign = side == 0 && k % 3 ? -1 : 1;

            m->hand_mean[side][k] = sign * hand->hands_mean[k];
            for (int i = 0; i < LT_HAND_PCA; i++)
                m->hand_components[side][i][k] = sign * hand->hands_components[i][k];
        }
}

/* Where the hand says that its joints are. */
static void take_finger_joints(body_skeleton *s, const lt_hand_model *hand)
{
    for (int k = 1; k < LT_HAND_JOINTS; k++) {
        vec3 p = vec(0, 0, 0);

        for (int v = 0; v < HAND; v++)
            for (int c = 0; c < 3; c++)
                p = madd(p, vec(c == 0, c == 1, c == 2), 1000.0 * hand->J_regressor[k][v] * hand->v_template[v][c]);
        p = add(p, s->hand);
        s->joint[BODY_FINGERS + BODY_HAND_JOINTS + k - 1] = p;
        s->joint[BODY_FINGERS + k - 1] = body_mirror(p);
    }
}

static lt_status build(lt_arena *arena, const lt_hand_model *hand, body_skeleton *s, synth_body *out)
{
    body_skin *skin = lt_arena_alloc(arena, sizeof(*skin));
    body_motion *motion = lt_arena_array(arena, BODY_DIRECTIONS, sizeof(*motion));
    int wrist[WRIST_EDGES];
    surface_mesh half;
    lt_status st;

    if (!skin || !motion)
        return lt_error(LT_ENOMEM, "synthetic body: no memory for its skin");
    st = body_half(arena, s, hand, &half, wrist);
    if (!st)
        st = body_skin_join(arena, s, &half, wrist, hand, skin);
    if (st)
        return st;
    take_finger_joints(s, hand);
    body_weights(s, hand, skin);
    body_shapes(s, skin, motion);
    body_expressions(skin, motion + BODY_SHAPES);
    store_skin(s, skin, motion, out->model);
    body_regressor(s, skin, hand, motion, out->model->J_regressor);
    body_correctives(s, skin, hand, out->model->posedirs);
    store_hands(hand, out->model);
    memcpy(out->hand, skin->hand, sizeof(out->hand));
    return LT_OK;
}

lt_status synth_body_new(lt_arena *arena, const lt_hand_model *hand, synth_body *out)
{
    lt_arena *scratch = lt_arena_new();
    body_skeleton s;
    synth_body made;
    lt_status st = scratch ? get_arrays(arena, &made.model) : lt_error(LT_ENOMEM, "synthetic body: no memory");

    body_skeleton_init(&s);
    if (!st)
        st = build(scratch, hand, &s, &made);
    lt_arena_free(scratch);
    if (!st)
        *out = made;
    return st;
}

lt_rig synth_body_rig(const body_model *m)
{
    return (lt_rig){ .V = V, .J = J, .S = m->shapes + m->expressions, .parents = m->parent,
                     .v_template = m->v_template[0], .shapedirs = m->shapedirs, .posedirs = m->posedirs,
                     .J_regressor = m->J_regressor, .weights = m->weights };
}
