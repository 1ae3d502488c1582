/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/world/grip.h"

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "synth/grasp/grasp.h"

#include <math.h>
#include <string.h>

#define DEGREE 0.017453292519943295

static const double CROSSED = 0.004;            /* metres that a finger may reach into another */

/* ---- poses ---- */

static void mirror(double (*x)[3], int n)
{
    for (int i = 0; i < n; i++)
        x[i][0] = -x[i][0];
}

static void set_pose(const lt_hand_model *hand, const synth_subject *who, const double pose[48], const double trans[3],
                     synth_grip *g, double keypoints[LT_HAND_KEYPOINTS][3])
{
    double R[LT_HAND_JOINTS][9], joints[LT_HAND_JOINTS][3];

    memcpy(g->pose, pose, sizeof(g->pose));
    for (int i = 0; i < LT_HAND_JOINTS; i++)
        lt_rot_from_axis_angle(pose + 3 * i, R[i]);
    lt_hand_pose(hand, &R[0][0], who->beta, trans, &g->vertices[0][0], &joints[0][0]);
    if (keypoints)
        lt_hand_keypoints(&g->vertices[0][0], &joints[0][0], lt_hand_tips_ho3d, LT_HAND_MANO_ORDER, &keypoints[0][0]);
    for (int k = 0; k < 3; k++) {
        g->wrist[k] = joints[0][k];
        g->elbow[k] = R[0][3 * k];
    }
}

static void make_left(synth_grip *g)
{
    mirror(g->vertices, LT_HAND_VERTICES);
    mirror(&g->wrist, 1);
    mirror(&g->elbow, 1);
}

lt_status synth_grip_hold(const lt_hand_model *hand, const synth_subject *who, const synth_prop_pair *what, bool left,
                          uint64_t seed, synth_grip *out)
{
    const synth_prop *p = left ? &what->left : &what->right;
    lt_arena *arena = lt_arena_new();
    synth_grasp_ctx *ctx;
    synth_grasp grasp;
    lt_status st = arena ? synth_grasp_ctx_new(arena, p->id, &p->mesh, &p->sdf, hand, who->beta, &ctx)
                         : lt_error(LT_ENOMEM, "synth: no memory for a grasp");

    if (!st && left)
        synth_grasp_ctx_mirror(ctx);
    if (!st)
        st = synth_grasp_sample(ctx, seed, NULL, &grasp);
    if (!st) {
        *out = (synth_grip){ .left = left, .prop = &what->right };
        set_pose(hand, who, grasp.pose, grasp.trans, out, NULL);
        if (left)
            make_left(out);
    }
    lt_arena_free(arena);
    return st;
}

/* Fingers stretched and fanned out, one in two with a finger or more bent to the palm. */
static void draw_open(lt_rng *rng, double angles[15][3])
{
    static const double fan[4] = { 1, 0.1, -1.4, -0.7 };
    const double spread = DEGREE * lt_rng_range(rng, 0, 12), thumb = DEGREE * lt_rng_range(rng, 0, 40);
    const uint32_t bent = lt_rng_below(rng, 2) ? lt_rng_below(rng, 16) : 0;

    memset(angles, 0, sizeof(double[15][3]));
    for (int d = 0; d < 4; d++) {
        const double close = bent >> d & 1 ? lt_rng_range(rng, 0.7, 1) : lt_rng_range(rng, -0.1, 0.2);

        angles[3 * d][SYNTH_HAND_FLEX] = 75 * DEGREE * close;
        angles[3 * d][SYNTH_HAND_SPREAD] = spread * fan[d];
        angles[3 * d + 1][SYNTH_HAND_FLEX] = 95 * DEGREE * close;
        angles[3 * d + 2][SYNTH_HAND_FLEX] = 62 * DEGREE * close;
    }
    angles[12][SYNTH_HAND_SPREAD] = thumb;
    angles[12][SYNTH_HAND_FLEX] = DEGREE * lt_rng_range(rng, 0, bent ? 40 : 15);
    angles[13][SYNTH_HAND_FLEX] = DEGREE * lt_rng_range(rng, 0, bent ? 45 : 15);
    synth_hand_clamp_angles(angles);
}

void synth_grip_bare(const lt_hand_model *hand, const synth_subject *who, bool left, lt_rng *rng, synth_grip *out)
{
    enum { DRAWS = 6 };
    static const double at[3] = { 0, 0, 0 };
    const bool open = lt_rng_below(rng, 2);
    double angles[15][3], pose[48] = { 0 }, keypoints[LT_HAND_KEYPOINTS][3];
    uint8_t part[LT_HAND_VERTICES];
    synth_hand_frames frames;

    synth_hand_frames_init(&frames, hand);
    synth_hand_parts(hand, part);
    for (int i = 0; i < DRAWS; i++) {
        (open ? draw_open : synth_hand_draw_angles)(rng, angles);
        synth_hand_angles_to_pose(&frames, angles, pose + 3);
        *out = (synth_grip){ .left = left };
        set_pose(hand, who, pose, at, out, keypoints);
        if (synth_hand_self_depth(part, (const double (*)[3])out->vertices, (const double (*)[3])keypoints) < CROSSED)
            break;
    }
    if (left)
        make_left(out);
}

/* ---- in the world ---- */

/* A rotation whose first column is x, the second towards side. */
static void basis(const double x[3], const double *side, double R[9])
{
    const double other[3] = { fabs(x[0]) < 0.7, fabs(x[0]) >= 0.7, 0 };
    double y[3], z[3];

    lt_vec3_cross(x, side ? side : other, z);
    lt_vec3_unit(z);
    lt_vec3_cross(z, x, y);
    for (int k = 0; k < 3; k++) {
        R[3 * k] = x[k];
        R[3 * k + 1] = y[k];
        R[3 * k + 2] = z[k];
    }
}

void synth_grip_turn(const synth_grip *g, const double along[3], const double *side, double roll, double R[9])
{
    const double about[9] = { 1, 0, 0, 0, cos(roll), -sin(roll), 0, sin(roll), cos(roll) };
    double from[9], back[9], to[9];

    basis(g->elbow, NULL, from);
    lt_mat3_transpose(from, back);
    basis(along, side, to);
    lt_mat3_mul(to, about, to);
    lt_mat3_mul(to, back, R);
}

/* The posed hand as a mesh to draw, in the grip's frame. */
static lt_status hand_mesh(lt_arena *arena, const synth_held *h, lt_mesh *m)
{
    *m = (lt_mesh){
        .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES,
        .vertex = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*m->vertex)),
        .normal = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*m->normal)),
        .face = lt_arena_array(arena, LT_HAND_FACES, sizeof(*m->face)), .color = (float (*)[3])h->who->color,
    };
    if (!m->vertex || !m->normal || !m->face)
        return lt_error(LT_ENOMEM, "synth: no memory for a hand");
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            m->vertex[i][k] = (float)h->grip->vertices[i][k];
    for (int i = 0; i < LT_HAND_FACES; i++)
        for (int k = 0; k < 3; k++)
            m->face[i][k] = h->hand->faces[i][h->grip->left && k ? 3 - k : k];
    lt_mesh_normals(m, m->normal);
    return LT_OK;
}

static lt_status grow_arm(lt_arena *arena, const synth_held *h, const lt_mesh *hand, synth_arm *out)
{
    float loop[SYNTH_WRIST_LOOP][3], normal[SYNTH_WRIST_LOOP][3], color[SYNTH_WRIST_LOOP][3];
    synth_arm_spec spec = {
        .loop = (const float (*)[3])loop, .loop_normal = (const float (*)[3])normal,
        .loop_color = (const float (*)[3])color, .bare = fmin(h->who->bare, h->arm), .length = h->arm,
        .cloth = h->cloth, .far = h->far, .seed = h->seed, .stream = h->stream,
    };
    double back[9];

    lt_mat3_transpose(h->R, back);
    lt_mat3_mulvec(back, h->elbow, spec.elbow);
    for (int i = 0; i < SYNTH_WRIST_LOOP; i++) {
        const int v = synth_hand_wrist_loop[i];
        memcpy(loop[i], hand->vertex[v], sizeof(loop[i]));
        memcpy(normal[i], hand->normal[v], sizeof(normal[i]));
        memcpy(color[i], hand->color[v], sizeof(color[i]));
    }
    memcpy(spec.skin, h->who->skin, sizeof(spec.skin));
    return synth_arm_new(arena, &spec, out);
}

static void place(const synth_held *h, const lt_mesh *mesh, const synth_material *material, int thing, synth_world *w)
{
    synth_instance in = { .mesh = mesh, .material = *material, .moving = true };

    memcpy(in.R_world_obj, h->R, sizeof(in.R_world_obj));
    memcpy(in.t_world_obj, h->t, sizeof(in.t_world_obj));
    synth_world_place(w, thing, &in);
}

void synth_object_place(const synth_prop *prop, const double R[9], const double t[3], int identity, synth_world *w)
{
    synth_instance in = {
        .mesh = &prop->mesh, .moving = true,
        .material = { .albedo = { 1, 1, 1 }, .specular = 0.04f, .shininess = 40, .texture = prop->texture },
    };
    const int thing = synth_world_thing(w, &(synth_thing){ .kind = SYNTH_HAND_THING + prop->id, .owner = -1,
                                                           .identity = identity });

    memcpy(in.R_world_obj, R, sizeof(in.R_world_obj));
    memcpy(in.t_world_obj, t, sizeof(in.t_world_obj));
    if (thing >= 0)
        synth_world_place(w, thing, &in);
}

lt_status synth_held_place(lt_arena *arena, const synth_held *h, synth_world *w)
{
    static const synth_material skin = { .albedo = { 1, 1, 1 }, .specular = 0.028f, .shininess = 12,
                                         .translucency = 1 };
    lt_mesh *mesh = lt_arena_alloc(arena, sizeof(*mesh));
    synth_arm *arm = lt_arena_alloc(arena, sizeof(*arm));
    lt_status st = mesh && arm ? hand_mesh(arena, h, mesh) : lt_error(LT_ENOMEM, "synth: no memory for a hand");
    int thing;

    if (!st)
        st = grow_arm(arena, h, mesh, arm);
    if (st)
        return st;
    thing = synth_world_thing(w, &(synth_thing){ .kind = SYNTH_HAND_THING, .owner = h->owner, .left = h->grip->left,
                                                 .identity = h->identity });
    if (thing < 0)
        return LT_OK;
    place(h, mesh, &skin, thing, w);
    place(h, &arm->skin, &arm->skin_material, h->owner, w);
    if (arm->sleeve.n_faces)
        place(h, &arm->sleeve, &arm->sleeve_material, h->owner, w);
    if (h->grip->prop)
        synth_object_place(h->grip->prop, h->R, h->t, h->object_identity, w);
    return LT_OK;
}
