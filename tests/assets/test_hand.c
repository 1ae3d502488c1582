/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The embedded hand against what it promises: topology, ids, bones, rig, poses, mirror image.
 */
#include "assets/hand/hand.h"
#include "assets/hand/internal.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { V = LT_HAND_VERTICES, F = LT_HAND_FACES, J = LT_HAND_JOINTS };

#define RAD(deg) ((deg) * (M_PI / 180))

static lt_arena *arena;             /* the models are built once, before tests fork */
static lt_hand_model *profiles[2], *model;

static vec3 vertex(const lt_hand_model *m, int v)
{
    return vec(m->v_template[v][0], m->v_template[v][1], m->v_template[v][2]);
}

static vec3 joint(const lt_hand_model *m, int j)
{
    vec3 p = vec(0, 0, 0);

    for (int v = 0; v < V; v++)
        p = madd(p, vertex(m, v), m->J_regressor[j][v]);
    return p;
}

typedef struct { double vertices[V][3], joints[J][3], keypoints[LT_HAND_KEYPOINTS][3]; } posed;

static void pose_hand(const lt_hand_model *m, const double root[3], const double pose[45],
                      posed *out)
{
    static const double beta[LT_HAND_BETAS];
    double R[J][9];

    lt_rot_from_axis_angle(root, R[0]);
    for (int j = 1; j < J; j++)
        lt_rot_from_axis_angle(pose + 3 * (j - 1), R[j]);
    lt_hand_pose(m, R[0], beta, NULL, out->vertices[0], out->joints[0]);
    lt_hand_keypoints(out->vertices[0], out->joints[0], lt_hand_tips_ho3d, LT_HAND_MANO_ORDER,
                      out->keypoints[0]);
}

static const double no_turn[3];

/* ---- topology ------------------------------------------------------------------------------------ */

static uint8_t (*count_edges(const lt_hand_model *m))[V]
{
    static uint8_t edges[V][V];

    memset(edges, 0, sizeof(edges));
    for (int f = 0; f < F; f++)
        for (int k = 0; k < 3; k++)
            edges[m->faces[f][k]][m->faces[f][(k + 1) % 3]]++;
    return edges;
}

START_TEST(one_disc)
{
    const uint8_t (*edges)[V] = (const uint8_t (*)[V])count_edges(profiles[_i]);
    int n_edges = 0, border = 0;
    bool used[V] = { false };

    for (int a = 0; a < V; a++)
        for (int b = 0; b < V; b++) {
            ck_assert_int_le(edges[a][b], 1); /* manifold, and faces agree on their side */
            border += edges[a][b] && !edges[b][a];
            n_edges += edges[a][b] && (a < b || !edges[b][a]);
            used[a] |= edges[a][b];
        }
    for (int v = 0; v < V; v++)
        ck_assert(used[v]);
    ck_assert_int_eq(border, 16);
    ck_assert_int_eq(V - n_edges + F, 1);
}
END_TEST

START_TEST(wrist_loop)
{
    const uint8_t (*edges)[V] = (const uint8_t (*)[V])count_edges(model);

    for (int i = 0; i < 16; i++) {
        const int a = synth_hand_wrist_loop[i], b = synth_hand_wrist_loop[(i + 1) % 16];

        ck_assert_msg(edges[b][a] == 1 && edges[a][b] == 0, "%d - %d is not on the border", a, b);
        ck_assert_double_eq_tol(model->v_template[a][0], model->v_template[b][0], 1e-7);
    }
}
END_TEST

static double volume(const lt_hand_model *m, const double (*v)[3])
{
    double sum = 0, n[3];

    for (int f = 0; f < F + SYNTH_HAND_CAP_FACES; f++) {
        const int32_t *c = f < F ? m->faces[f] : synth_hand_cap[f - F];

        lt_vec3_cross(v[c[1]], v[c[2]], n);
        sum += lt_vec3_dot(v[c[0]], n) / 6;
    }
    return sum;
}

START_TEST(closed_by_the_cap)
{
    uint8_t (*edges)[V] = count_edges(model);
    static const double zero[45];
    posed p;

    for (int f = 0; f < SYNTH_HAND_CAP_FACES; f++)
        for (int k = 0; k < 3; k++)
            edges[synth_hand_cap[f][k]][synth_hand_cap[f][(k + 1) % 3]]++;
    for (int a = 0; a < V; a++)
        for (int b = 0; b < V; b++)
            ck_assert_int_eq(edges[a][b], edges[b][a]);
    pose_hand(model, no_turn, zero, &p);
    ck_assert_double_gt(volume(model, p.vertices), 250e-6); /* outwards, and as large as a hand */
    ck_assert_double_lt(volume(model, p.vertices), 400e-6);
}
END_TEST

START_TEST(good_triangles)
{
    for (int f = 0; f < F; f++)
        for (int k = 0; k < 3; k++) {
            const int32_t *c = profiles[_i]->faces[f];
            const vec3 a = vertex(profiles[_i], c[k]);
            const vec3 ab = sub(vertex(profiles[_i], c[(k + 1) % 3]), a);
            const vec3 ac = sub(vertex(profiles[_i], c[(k + 2) % 3]), a);

            ck_assert_double_gt(norm(ab), 0.0015);
            ck_assert_double_lt(norm(ab), 0.0140);
            ck_assert_double_gt(acos(dot(ab, ac) / (norm(ab) * norm(ac))), RAD(20));
        }
}
END_TEST

/* ---- ids ----------------------------------------------------------------------------------------- */

START_TEST(tips)
{
    static const struct { int joint, ids[6]; } digit[5] = {
        { 15, { 728, 744, 745 } }, { 3, { 317, 320, 333, 353 } }, { 6, { 442, 443, 444, 445 } },
        { 12, { 554, 555, 556, 576 } }, { 9, { 657, 671, 672, 673, 694 } },
    };
    const lt_hand_model *m = profiles[_i];
    uint8_t part[V];

    synth_hand_parts(m, part);
    for (int d = 0; d < 5; d++) {
        double reach = 0;

        for (int v = 0; v < V; v++)
            if (part[v] == digit[d].joint)
                reach = fmax(reach, dist(vertex(m, v), joint(m, digit[d].joint)));
        for (int i = 0; digit[d].ids[i]; i++) {
            const int id = digit[d].ids[i];

            ck_assert_int_eq(part[id], digit[d].joint);
            ck_assert_double_ge(m->weights[id][part[id]], 0.98);
            ck_assert_double_gt(dist(vertex(m, id), joint(m, part[id])), reach - 0.010);
        }
    }
}
END_TEST

START_TEST(palm_ids)
{
    const vec3 front = vertex(model, 95), back = vertex(model, 22);
    uint8_t part[V];

    synth_hand_parts(model, part);
    ck_assert_int_eq(part[95], 0);
    ck_assert_int_eq(part[22], 0);
    ck_assert_double_gt(back.y - front.y, 0.015);
    ck_assert_double_lt(hypot(back.x - front.x, back.z - front.z), 0.010);
}
END_TEST

/* ---- bones --------------------------------------------------------------------------------------- */

START_TEST(wrist_place)
{
    const vec3 w = joint(profiles[_i], 0);

    ck_assert_double_eq_tol(w.x, 0.096, 5e-5);
    ck_assert_double_eq_tol(w.y, 0.006, 5e-5);
    ck_assert_double_eq_tol(w.z, 0.006, 5e-5);
}
END_TEST

START_TEST(bone_lengths)
{
    static const double mm[2][5][3] = {
        /* wrist to base, and on; index middle little ring thumb */
        { { 91, 33, 22 }, { 95, 32, 23 }, { 82, 21, 19 }, { 86, 29, 25 }, { 39, 31, 27 } },
        { { 93, 39.8, 22.4 },
          { 91.6, 44.6, 26.3 },
          { 78, 32.7, 18.1 },
          { 84, 41.4, 25.7 },
          { 32, 46.2, 31.6 } },
    };

    for (int d = 0; d < 5; d++)
        for (int k = 0; k < 3; k++) {
            const int j = 1 + 3 * d + k;
            const double len = dist(joint(profiles[_i], j), joint(profiles[_i], lt_hand_parent[j]));

            ck_assert_double_eq_tol(len, mm[_i][d][k] / 1000, 1e-4);
        }
    for (int i = 0; i < 5; i++) {               /* last joint to tip, at zero shape */
        static const int last[5] = { 15, 3, 6, 12, 9 };
        const double len = dist(vertex(model, lt_hand_tips_ho3d[i]), joint(model, last[i]));

        ck_assert_double_gt(len, 0.018);
        ck_assert_double_lt(len, 0.027);
    }
}
END_TEST

START_TEST(regressor)
{
    for (int j = 0; j < J; j++) {
        double sum = 0;
        int used = 0;

        for (int v = 0; v < V; v++) {
            ck_assert_float_ge(model->J_regressor[j][v], 0);
            sum += model->J_regressor[j][v];
            used += model->J_regressor[j][v] > 0;
        }
        ck_assert_double_eq_tol(sum, 1, 1e-6);
        ck_assert_int_ge(used, 12);
        ck_assert_int_le(used, 60);
    }
}
END_TEST

/* What the builder had in mind: the skeleton, and its motion under each beta. */
static void design(hand_skeleton *s, hand_rig *rig, hand_motion *motion)
{
    hand_skeleton_init(s, SYNTH_HAND_MANO_LIKE);
    memset(rig, 0, sizeof(*rig));
    for (int v = 0; v < V; v++) {
        rig->vertex[v] = scale(vertex(model, v), 1000);
        hand_weights_at(s, rig->vertex[v], rig->weight[v]);
    }
    for (int f = 0; f < F; f++) {
        const int32_t *c = model->faces[f];
        const vec3 a = rig->vertex[c[0]];

        for (int k = 0; k < 3; k++)
            rig->area[c[k]] +=
                norm(cross(sub(rig->vertex[c[1]], a), sub(rig->vertex[c[2]], a))) / 6;
    }
    double total = 0;
    for (int v = 0; v < V; v++)
        total += rig->area[v];
    for (int v = 0; v < V; v++)
        rig->area[v] /= total;
    hand_betas(s, rig, motion);
}

START_TEST(joints_follow_the_shape)
{
    static hand_motion motion[LT_HAND_BETAS];
    static hand_rig rig;
    hand_skeleton s;

    design(&s, &rig, motion);
    for (int j = 0; j < J; j++) {
        const vec3 want = scale(j ? s.joint[(j - 1) / 3][(j - 1) % 3] : s.wrist, 1e-3);

        ck_assert_double_lt(dist(joint(model, j), want), 5e-5);
        for (int k = 0; k < LT_HAND_BETAS; k++) {
            vec3 moved = vec(0, 0, 0);

            for (int v = 0; v < V; v++)
                moved = madd(moved, vec(model->shapedirs[v][0][k], model->shapedirs[v][1][k],
                                        model->shapedirs[v][2][k]), model->J_regressor[j][v]);
            ck_assert_double_lt(dist(scale(moved, 1000), motion[k].joint[j]), 0.5);
        }
    }
}
END_TEST

START_TEST(shape_sizes)
{
    static const double rms_mm[LT_HAND_BETAS] = { 3.0,  1.6,  1.2,  0.9,  0.75,
                                                  0.65, 0.55, 0.45, 0.38, 0.3 };
    static hand_motion motion[LT_HAND_BETAS];
    static hand_rig rig;
    hand_skeleton s;

    design(&s, &rig, motion);
    for (int a = 0; a < LT_HAND_BETAS; a++)
        for (int b = 0; b <= a; b++) {
            double inner = 0;

            for (int v = 0; v < V; v++)
                for (int c = 0; c < 3; c++)
                    inner +=
                        rig.area[v] * 1e6 * model->shapedirs[v][c][a] * model->shapedirs[v][c][b];
            ck_assert_double_eq_tol(inner, a == b ? rms_mm[a] * rms_mm[a] : 0, 2e-4);
        }
}
END_TEST

/* ---- rig ----------------------------------------------------------------------------------------- */

START_TEST(weights)
{
    for (int v = 0; v < V; v++) {
        double sum = 0;
        int used = 0;

        for (int j = 0; j < J; j++) {
            ck_assert_float_ge(model->weights[v][j], 0);
            sum += model->weights[v][j];
            used += model->weights[v][j] > 0;
        }
        ck_assert_double_eq_tol(sum, 1, 1e-6);
        ck_assert_int_le(used, 4);
    }
    for (int i = 0; i < 16; i++)
        ck_assert_float_eq(model->weights[synth_hand_wrist_loop[i]][0], 1);
}
END_TEST

START_TEST(rest_is_the_template)
{
    static const double zero[45];
    posed p;

    pose_hand(model, no_turn, zero, &p);
    for (int v = 0; v < V; v++)
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq_tol(p.vertices[v][c], model->v_template[v][c], 1e-7);
}
END_TEST

START_TEST(root_is_rigid)
{
    static const double zero[45], root[3] = { 0.4, -0.7, 1.1 };
    const vec3 J0 = joint(model, 0);
    double R[9];
    posed p;

    pose_hand(model, root, zero, &p);
    lt_rot_from_axis_angle(root, R);
    for (int v = 0; v < V; v++) {
        const vec3 r = sub(vertex(model, v), J0);
        double turned[3];

        lt_mat3_mulvec(R, (double[]){ r.x, r.y, r.z }, turned);
        ck_assert_double_eq_tol(p.vertices[v][0], turned[0] + J0.x, 1e-7);
        ck_assert_double_eq_tol(p.vertices[v][1], turned[1] + J0.y, 1e-7);
        ck_assert_double_eq_tol(p.vertices[v][2], turned[2] + J0.z, 1e-7);
    }
}
END_TEST

/* Joint k of all fingers at 90 degrees: the hand keeps 96 % of its volume. */
START_TEST(bent_keeps_volume)
{
    static const double zero[45];
    double angles[15][3] = { { 0 } }, pose[45];
    synth_hand_frames frames;
    posed flat, bent;

    synth_hand_frames_init(&frames, model);
    for (int d = 0; d < 4; d++)
        angles[3 * d + _i][SYNTH_HAND_FLEX] = RAD(90);
    synth_hand_angles_to_pose(&frames, angles, pose);
    pose_hand(model, no_turn, zero, &flat);
    pose_hand(model, no_turn, pose, &bent);
    ck_assert_double_gt(volume(model, bent.vertices), 0.96 * volume(model, flat.vertices));
    ck_assert_double_lt(volume(model, bent.vertices), 1.02 * volume(model, flat.vertices));
}
END_TEST

START_TEST(correctives)
{
    synth_hand_frames frames;

    synth_hand_frames_init(&frames, model);
    for (int i = 0; i < 16; i++)
        for (int c = 0; c < 3; c++)
            for (int f = 0; f < LT_HAND_POSE_FEATURES; f++)
                ck_assert_float_eq(model->posedirs[synth_hand_wrist_loop[i]][c][f], 0);
    for (int n = 0; n < 50; n++) {
        lt_rng rng = lt_rng_make(11, (uint64_t)n);
        double angles[15][3], pose[45], R[9], sum = 0;
        static double moved[V][3];

        memset(moved, 0, sizeof(moved));
        synth_hand_draw_angles(&rng, angles);
        synth_hand_angles_to_pose(&frames, angles, pose);
        for (int j = 0; j < 15; j++) {
            lt_rot_from_axis_angle(pose + 3 * j, R);
            for (int e = 0; e < 9; e++)
                for (int v = 0; v < V; v++)
                    for (int c = 0; c < 3; c++)
                        moved[v][c] += model->posedirs[v][c][9 * j + e] * (R[e] - (e % 4 == 0));
        }
        for (int v = 0; v < V; v++)
            sum += lt_vec3_dot(moved[v], moved[v]) / V;
        ck_assert_double_lt(sqrt(sum), 0.0015);
    }
}
END_TEST

/* ---- poses --------------------------------------------------------------------------------------- */

START_TEST(components)
{
    for (int a = 0; a < 45; a++)
        for (int b = 0; b <= a; b++) {
            double inner = 0;

            for (int i = 0; i < 45; i++)
                inner += (double)model->hands_components[a][i] * model->hands_components[b][i];
            ck_assert_double_eq_tol(inner, a == b, 1e-5);
        }
    for (int d = 0; d < 4; d++)                 /* the first bends all fingers together, about +z */
        ck_assert_float_gt(model->hands_components[0][9 * d + 5] * model->hands_components[0][5],
                           0.05F);
}
END_TEST

static void assert_within(double angles[15][3])
{
    for (int i = 0; i < 15; i++)
        for (int k = 0; k < 3; k++) {
            ck_assert_double_ge(angles[i][k], synth_hand_limits[i].lo[k] - 1e-6);
            ck_assert_double_le(angles[i][k], synth_hand_limits[i].hi[k] + 1e-6);
        }
}

START_TEST(clamped_poses)
{
    lt_rng rng = lt_rng_make(3, 1);
    synth_hand_frames frames;

    synth_hand_frames_init(&frames, model);
    for (int n = 0; n < 100; n++) {
        double pose[45], again[15][3], angles[15][3];

        for (int i = 0; i < 45; i++)
            pose[i] = 0.8 * lt_rng_normal(&rng);
        synth_hand_pose_to_angles(&frames, pose, angles);
        synth_hand_clamp_angles(angles);
        assert_within(angles);
        memcpy(again, angles, sizeof(again));
        synth_hand_clamp_angles(again);
        ck_assert_mem_eq(again, angles, sizeof(again));
    }
}
END_TEST

START_TEST(mean_is_a_pose)
{
    static const double want[3] = { 20, 35, 20 };
    double pose[45], angles[15][3];
    synth_hand_frames frames;

    synth_hand_frames_init(&frames, model);
    for (int i = 0; i < 45; i++)
        pose[i] = model->hands_mean[i];
    synth_hand_pose_to_angles(&frames, pose, angles);
    assert_within(angles);
    for (int i = 0; i < 12; i++)
        ck_assert_double_eq_tol(angles[i][SYNTH_HAND_FLEX], RAD(want[i % 3]), 1e-5);
    ck_assert_double_eq_tol(angles[12][SYNTH_HAND_SPREAD], RAD(15), 1e-5);
}
END_TEST

/* Capsules fit the skin of the digits they stand for. */
START_TEST(capsules)
{
    static const double zero[45];
    synth_hand_capsule capsule[SYNTH_HAND_CAPSULES];
    uint8_t part[V];
    posed p;

    pose_hand(model, no_turn, zero, &p);
    synth_hand_parts(model, part);
    synth_hand_capsules(p.keypoints, capsule);
    for (int v = 0; v < V; v++) {
        double d = 1;

        for (int c = 0; c < SYNTH_HAND_CAPSULES; c++)
            d = fmin(d, synth_hand_capsule_distance(&capsule[c], p.vertices[v]));
        if (part[v] && (part[v] - 1) % 3 && part[v] != 14) /* not where a web or the palm joins */
            ck_assert_double_eq_tol(d, 0, 0.004);
    }
}
END_TEST

/* ---- mirror, colours, sameness ------------------------------------------------------------------- */

START_TEST(mirrored)
{
    static lt_hand_model left;
    static posed a, b;
    synth_hand_frames fr, fl;
    double pose[45], mirror_pose[45], angles[15][3], same[15][3];
    lt_rng rng = lt_rng_make(9, 9);

    synth_hand_mirror(model, &left);
    ck_assert(left.left && left.synthetic);
    synth_hand_frames_init(&fr, model);
    synth_hand_frames_init(&fl, &left);
    synth_hand_draw_angles(&rng, angles);
    synth_hand_angles_to_pose(&fr, angles, pose);
    synth_hand_angles_to_pose(&fl, angles, mirror_pose);
    synth_hand_pose_to_angles(&fl, mirror_pose, same);
    pose_hand(model, no_turn, pose, &a);
    pose_hand(&left, no_turn, mirror_pose, &b);
    for (int i = 0; i < 45; i++)
        ck_assert_double_eq_tol(mirror_pose[i], i % 3 ? -pose[i] : pose[i], 1e-6);
    for (int i = 0; i < 45; i++)
        ck_assert_double_eq_tol(same[i / 3][i % 3], angles[i / 3][i % 3], 1e-9);
    for (int v = 0; v < V; v++)
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq_tol(b.vertices[v][c], c ? a.vertices[v][c] : -a.vertices[v][c],
                                    1e-6);
}
END_TEST

START_TEST(colours)
{
    static float dark[V][3], light[V][3];

    synth_hand_colors(model, 0, light);
    synth_hand_colors(model, SYNTH_HAND_TONES - 1, dark);
    for (int v = 0; v < V; v++)
        for (int c = 0; c < 3; c++) {
            ck_assert_float_ge(dark[v][c], 0);
            ck_assert_float_lt(dark[v][c], light[v][c]);
            ck_assert_float_le(light[v][c], 1);
        }
    ck_assert_float_gt(dark[95][0], 1.5F * dark[22][0]);        /* palm and back */
}
END_TEST

START_TEST(same_bits)
{
    lt_arena *other = lt_arena_new();
    lt_hand_model *again;

    lt_set_threads(3);
    ck_assert_int_eq(synth_hand_new(other, SYNTH_HAND_MANO_LIKE, &again), LT_OK);
    ck_assert_mem_eq(again, model, sizeof(*model));
    lt_arena_free(other);
}
END_TEST

START_TEST(no_memory)
{
    lt_status st = LT_ENOMEM;

    for (long n = 1; st; n++) {
        lt_arena *other = lt_arena_new();
        lt_hand_model *out = NULL;

        ck_assert_int_lt(n, 100);
        lt_alloc_fail_at(n);
        st = synth_hand_new(other, SYNTH_HAND_MANO_LIKE, &out);
        lt_alloc_fail_at(0);
        ck_assert_int_eq(st, out ? LT_OK : LT_ENOMEM);
        lt_arena_free(other);
    }
}
END_TEST

static void build_models(void)
{
    arena = lt_arena_new();
    lt_set_threads(1);
    for (int p = 0; p < 2; p++)
        if (synth_hand_new(arena, (synth_hand_profile)p, &profiles[p])) {
            fprintf(stderr, "%s\n", lt_last_error());
            exit(1);
        }
    model = profiles[0];
}

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 0);
    tcase_add_loop_test(t, one_disc, 0, 2);
    tcase_add_test(t, wrist_loop);
    tcase_add_test(t, closed_by_the_cap);
    tcase_add_loop_test(t, good_triangles, 0, 2);
    tcase_add_loop_test(t, tips, 0, 2);
    tcase_add_test(t, palm_ids);
    tcase_add_loop_test(t, wrist_place, 0, 2);
    tcase_add_loop_test(t, bone_lengths, 0, 2);
    tcase_add_test(t, regressor);
    tcase_add_test(t, joints_follow_the_shape);
    tcase_add_test(t, shape_sizes);
    tcase_add_test(t, weights);
    tcase_add_test(t, rest_is_the_template);
    tcase_add_test(t, root_is_rigid);
    tcase_add_loop_test(t, bent_keeps_volume, 0, 2);
    tcase_add_test(t, correctives);
    tcase_add_test(t, components);
    tcase_add_test(t, clamped_poses);
    tcase_add_test(t, mean_is_a_pose);
    tcase_add_test(t, capsules);
    tcase_add_test(t, mirrored);
    tcase_add_test(t, colours);
    tcase_add_test(t, same_bits);
    tcase_add_test(t, no_memory);
}

int main(void)
{
    int failed;

    build_models();
    failed = run_suite("hand", add_tests);
    lt_arena_free(arena);
    return failed;
}
