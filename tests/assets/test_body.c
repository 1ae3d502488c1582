/* SPDX-License-Identifier: Apache-2.0 */
/* The synthetic body: mesh, ids, joints, weights, hands, and what posing makes of them. */
#include "assets/body/body.h"
#include "assets/body/internal.h"
#include "assets/hand/hand.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <stdlib.h>

static lt_arena *arena;
static lt_hand_model *hand;
static synth_body body;
static body_skeleton design;
static lt_rig rig;
static double vertex[V][3], joint[J][3], rotation[J][9], shape[BODY_DIRECTIONS];

static void stand(void)
{
    memset(rotation, 0, sizeof(rotation));
    memset(shape, 0, sizeof(shape));
    for (int j = 0; j < J; j++)
        rotation[j][0] = rotation[j][4] = rotation[j][8] = 1;
}

static void bend(int j, double x, double y, double z)
{
    synth_body_rotation((double[]){ x, y, z }, rotation[j]);
}

static void pose(void)
{
    lt_rig_pose(&rig, rotation[0], shape, NULL, vertex[0], joint[0]);
}

/* ---- the mesh ------------------------------------------------------------------------------------------ */

typedef struct { int32_t a, b, forward; } edge;

static int by_ends(const void *x, const void *y)
{
    const edge *e = x, *g = y;

    return e->a != g->a ? e->a - g->a : e->b != g->b ? e->b - g->b : e->forward - g->forward;
}

START_TEST(topology)
{
    edge *e = malloc(3 * F * sizeof(*e));
    int n = 0, edges = 0, open = 0;

    for (int f = 0; f < F; f++)
        for (int k = 0; k < 3; k++) {
            const int32_t a = body.model->faces[f][k], b = body.model->faces[f][(k + 1) % 3];
            e[n++] = a < b ? (edge){ a, b, 1 } : (edge){ b, a, 0 };
        }
    qsort(e, (size_t)n, sizeof(*e), by_ends);
    for (int i = 0; i < n; i++) {
        const bool again = i && e[i - 1].a == e[i].a && e[i - 1].b == e[i].b;

        if (again) {
            ck_assert_int_ne(e[i - 1].forward, e[i].forward);           /* manifold, all faces the same way out */
            open--;
        } else {
            edges++;
            open++;
        }
    }
    ck_assert_int_eq(open, 2 * EYE_EDGES);
    ck_assert_int_eq(V - edges + F, 2 * 3 - 2);                         /* body and two eyes, two sockets */
    free(e);
}
END_TEST

START_TEST(outwards)
{
    double volume = 0;

    stand();
    pose();
    for (int f = 0; f < F; f++) {
        const int32_t *c = body.model->faces[f];
        double n[3];

        lt_vec3_cross(vertex[c[1]], vertex[c[2]], n);
        volume += lt_vec3_dot(vertex[c[0]], n) / 6;
    }
    ck_assert_double_gt(volume, 0.055);                                 /* 1.70 m of a person: 55 to 80 litres */
    ck_assert_double_lt(volume, 0.080);
}
END_TEST

START_TEST(landmarks)
{
    const surface_skin skin = body_shape_skin(&design);

    for (int i = 0; i < LANDMARKS; i++)
        for (int left = 0; left < (i ? 2 : 1); left++) {
            vec3 want = skin.snap(skin.ctx, design.landmark[i], i == 0 ? RIM_MIDDLE : 0);
            const float *p = body.model->v_template[body_landmark_id[i][left]];

            ck_assert_double_lt(dist(want, design.landmark[i]), 12);
            want = sub(left ? body_mirror(want) : want, design.joint[0]);
            ck_assert_double_lt(dist(want, scale(vec(p[0], p[1], p[2]), 1000)), 0.01);
        }
}
END_TEST

START_TEST(nodes_where_they_belong)
{
    double node[BODY_NODES][3];

    stand();
    pose();
    body_nodes(vertex[0], joint[0], node);
    for (int k = 0; k < 3; k++) {
        ck_assert_double_lt(fabs(node[22][k] - joint[BODY_EYE][k]), 0.017);             /* left eye, right eye */
        ck_assert_double_lt(fabs(node[23][k] - joint[BODY_EYE + 1][k]), 0.017);
    }
    ck_assert(node[22][0] > 0 && node[23][0] < 0 && node[24][2] > node[22][2] && node[24][1] < node[22][1]);
    ck_assert(node[20][0] > 0.07 && node[21][0] < -0.07);                               /* ears */
    for (int finger = 0; finger < 5; finger++) {                /* tips are beyond the last joints, by a finger's end */
        const double *last = node[25 + 4 * finger + 2], *tip = node[25 + 4 * finger + 3];

        ck_assert_double_gt(tip[0] - last[0], 0.012);
        ck_assert_double_lt(lt_vec3_distance(tip, last), 0.036);
    }
}
END_TEST

START_TEST(mirrored)
{
    double node[BODY_NODES][3];

    stand();
    for (int left = 1; left >= 0; left--) {
        const double s = left ? 1 : -1;

        bend(BODY_SHOULDER + 1 - left, 0.2, -0.5 * s, -0.8 * s);
        bend(BODY_ELBOW + 1 - left, -0.4, -1.2 * s, 0);
        bend(BODY_HIP + 1 - left, -0.9, 0.2 * s, 0.2 * s);
        bend(BODY_KNEE + 1 - left, 1.1, 0, 0);
    }
    pose();
    body_nodes(vertex[0], joint[0], node);
    for (int k = 0; k < 40; k++)
        ck_assert_double_eq_tol(node[25 + k % 20][k / 20], (k / 20 ? 1 : -1) * node[45 + k % 20][k / 20], 1e-5);
    for (int v = 0; v < HAND; v++)
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(vertex[body.hand[0][v]][k], (k ? 1 : -1) * vertex[body.hand[1][v]][k], 1e-5);
}
END_TEST

/* ---- joints and weights -------------------------------------------------------------------------------- */

START_TEST(regressor)
{
    stand();
    pose();
    for (int j = 0; j < J; j++) {
        const float *row = body.model->J_regressor + (size_t)j * V;
        double sum = 0;
        int n = 0;

        for (int v = 0; v < V; v++) {
            ck_assert(row[v] >= 0);
            sum += row[v];
            n += row[v] > 0;
        }
        ck_assert_double_eq_tol(sum, 1, 1e-5);
        ck_assert(n >= 12 && n <= 60);
        if (j < BODY_FINGERS) {
            const vec3 p = vec(joint[j][0], joint[j][1], joint[j][2]);
            ck_assert_double_lt(dist(scale(p, 1000), sub(design.joint[j], design.joint[0])), 0.05);
        }
    }
}
END_TEST

/* Along each direction the regressed joints move as was designed: lengths of bones follow. */
START_TEST(shapes)
{
    double arm, leg, breadth;

    stand();
    pose();
    arm = lt_vec3_distance(joint[BODY_SHOULDER], joint[BODY_WRIST]);
    leg = lt_vec3_distance(joint[BODY_HIP], joint[BODY_ANKLE]);
    breadth = lt_vec3_distance(joint[BODY_SHOULDER], joint[BODY_SHOULDER + 1]);
    shape[5] = 1;                                                       /* arms longer by 3.5 % */
    pose();
    ck_assert_double_eq_tol(lt_vec3_distance(joint[BODY_SHOULDER], joint[BODY_WRIST]) / arm, 1.035, 0.002);
    ck_assert_double_eq_tol(lt_vec3_distance(joint[BODY_HIP], joint[BODY_ANKLE]) / leg, 1, 0.001);
    stand();
    shape[3] = 1;
    pose();
    ck_assert_double_gt(lt_vec3_distance(joint[BODY_SHOULDER], joint[BODY_SHOULDER + 1]) / breadth, 1.03);
    stand();
    shape[0] = 1;
    pose();
    ck_assert_double_eq_tol(lt_vec3_distance(joint[BODY_HIP], joint[BODY_ANKLE]) / leg, 1.053, 0.003);
}
END_TEST

START_TEST(weights)
{
    for (int v = 0; v < V; v++) {
        const float *w = body.model->weights + (size_t)v * J;
        double sum = 0;
        int n = 0;

        for (int j = 0; j < J; j++) {
            ck_assert(w[j] >= 0);
            sum += w[j];
            n += w[j] > 0;
        }
        ck_assert_double_eq_tol(sum, 1, 1e-6);
        ck_assert_int_le(n, 4);
    }
    for (int i = 0; i < WRIST_EDGES; i++)
        for (int side = 0; side < 2; side++) {
            const size_t v = (size_t)body.hand[side][synth_hand_wrist_loop[i]];
            ck_assert(body.model->weights[v * J + BODY_WRIST + (size_t)side] == 1);
        }
    ck_assert(body.model->weights[(size_t)4933 * J + 27] > 0.98f);      /* tip of the left index finger */
}
END_TEST

/* ---- posing -------------------------------------------------------------------------------------------- */

START_TEST(rest_is_the_template)
{
    stand();
    pose();
    for (int v = 0; v < V; v++)
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(vertex[v][k], body.model->v_template[v][k], 2e-7);
}
END_TEST

START_TEST(root_is_rigid)
{
    double root[3], want[3], off[3];

    stand();
    pose();
    memcpy(root, joint[0], sizeof(root));
    bend(0, 0.4, -1.2, 0.3);
    pose();
    for (int v = 0; v < V; v += 7) {
        for (int k = 0; k < 3; k++)
            off[k] = body.model->v_template[v][k] - root[k];
        lt_mat3_mulvec(rotation[0], off, want);
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(vertex[v][k], want[k] + root[k], 1e-6);
    }
}
END_TEST

/* The hand layer's vertices under the wrist's frame. */
START_TEST(hands_are_the_hand)
{
    static lt_hand_model left;
    static double skin[HAND][3], keys[LT_HAND_JOINTS][3], beta[LT_HAND_BETAS], R[LT_HAND_JOINTS][9];
    lt_rng rng = lt_rng_make(5, 7);

    synth_hand_mirror(hand, &left);
    stand();
    bend(BODY_SHOULDER, 0.3, -0.6, -0.7);
    bend(BODY_ELBOW + 1, -0.4, 1.1, 0);
    bend(BODY_WRIST, 0.1, 0.2, -0.5);
    for (int j = BODY_FINGERS; j < J; j++) {
        const double angle[3] = { lt_rng_range(&rng, -0.8, 0.8), lt_rng_range(&rng, -0.2, 0.2),
                                  lt_rng_range(&rng, -0.8, 0.8) };
        lt_rot_from_axis_angle(angle, rotation[j]);
    }
    pose();
    for (int side = 0; side < 2; side++) {
        double world[9], up[9], way[3];

        memcpy(world, rotation[BODY_WRIST + side], sizeof(world));
        for (int j = body_parent[BODY_WRIST + side]; j >= 0; j = body_parent[j]) {
            lt_mat3_mul(rotation[j], world, up);
            memcpy(world, up, sizeof(world));
        }
        memcpy(R[0], world, sizeof(world));
        memcpy(R[1], rotation[BODY_FINGERS + side * BODY_HAND_JOINTS], sizeof(R) - sizeof(R[0]));
        lt_hand_pose(side ? hand : &left, R[0], beta, (double[]){ 0, 0, 0 }, skin[0], keys[0]);
        lt_vec3_sub(joint[BODY_WRIST + side], keys[0], way);
        for (int v = 0; v < HAND; v++)
            for (int k = 0; k < 3; k++)
                ck_assert_double_eq_tol(vertex[body.hand[side][v]][k], skin[v][k] + way[k], 1e-5);
    }
}
END_TEST

START_TEST(limbs_keep_their_girth)
{
    static const struct { int joint; double y; int end; } bends[] = { { BODY_ELBOW, -1.6, BODY_WRIST },
                                                                      { BODY_KNEE, 0, BODY_ANKLE } };

    for (size_t i = 0; i < LT_COUNT(bends); i++) {
        double before = 0, after = 0;
        int n = 0;

        for (int bent = 0; bent < 2; bent++) {
            stand();
            bend(bends[i].joint, bent && i ? 1.6 : 0, bent ? bends[i].y : 0, 0);
            pose();
            for (int v = 0; v < V; v++)
                if (body.model->weights[(size_t)v * J + (size_t)bends[i].joint] > 0.35f &&
                    body.model->weights[(size_t)v * J + (size_t)bends[i].joint] < 0.65f) {
                    *(bent ? &after : &before) += lt_vec3_distance(vertex[v], joint[bends[i].joint]);
                    n++;
                }
        }
        ck_assert_int_gt(n, 20);
        ck_assert_double_gt(after / before, 0.85);
        ck_assert_double_lt(after / before, 1.15);
    }
}
END_TEST

START_TEST(angles)
{
    lt_rng rng = lt_rng_make(2, 3);

    for (int i = 0; i < 100; i++) {
        double a[3], R[9], back[3];

        for (int k = 0; k < 3; k++)
            a[k] = lt_rng_range(&rng, k ? -3.1 : -1.5, k ? 3.1 : 1.5);
        synth_body_rotation(a, R);
        synth_body_angles(R, back);
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(a[k], back[k], 1e-9);
    }
    for (int j = 0; j < BODY_FINGERS; j++)
        for (int k = 0; k < 3; k++)
            ck_assert(synth_body_limits[j].lo[k] <= 0 && synth_body_limits[j].hi[k] >= 0);
    for (int i = 0; i < 2; i++) {               /* a knee bends by 120 degrees, and not by 160 */
        double R[9];

        synth_body_rotation((double[]){ i ? 2.8 : 2.1, 0.1, 0 }, R);
        ck_assert(synth_body_within(BODY_KNEE, R) == !i);
    }
}
END_TEST

/* Expressions move the face alone. */
START_TEST(expressions)
{
    for (int k = BODY_SHAPES; k < BODY_DIRECTIONS; k++) {
        double most = 0;

        for (int v = 0; v < V; v++) {
            const float *d = body.model->shapedirs + (size_t)v * 3 * BODY_DIRECTIONS + k;
            const double way = hypot(hypot(d[0], d[BODY_DIRECTIONS]), d[2 * BODY_DIRECTIONS]);

            most = fmax(most, way);
            ck_assert(way == 0 || body.model->v_template[v][1] > 0.45f);
        }
        ck_assert(most > 0.001 && most < 0.01);
    }
}
END_TEST

/* The rig of the nodes alone poses them as the whole body does. */
START_TEST(nodes_alone)
{
    double whole[BODY_NODES][3], alone[BODY_NODES][3], place[512][3], at[J][3];
    int points[BODY_NODES];
    lt_rig nodes;

    stand();
    bend(BODY_SHOULDER, 0.3, -0.5, 0.7);
    bend(BODY_KNEE + 1, 0.9, 0, 0);
    bend(BODY_HEAD, 0.2, 0.4, -0.1);
    bend(BODY_FINGERS + 3, 0.2, 0.1, 0.8);
    for (int s = 0; s < BODY_DIRECTIONS; s++)
        shape[s] = s % 3 - 0.7;
    pose();
    body_nodes(vertex[0], joint[0], whole);
    check_ok(synth_body_nodes_rig(arena, body.model, &nodes, points));
    ck_assert_int_lt(nodes.V, 100);
    lt_rig_pose(&nodes, rotation[0], shape, NULL, place[0], at[0]);
    for (int i = 0; i < BODY_NODES; i++)
        memcpy(alone[i], points[i] < J ? at[points[i]] : place[points[i] - J], sizeof(alone[i]));
    for (int i = 0; i < BODY_NODES; i++)
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(alone[i][k], whole[i][k], 1e-6);
}
END_TEST

START_TEST(same_bits)
{
    lt_arena *other = lt_arena_new();
    synth_body again;

    lt_set_threads(3);
    check_ok(synth_body_new(other, hand, &again));
    ck_assert_mem_eq(again.model->v_template, body.model->v_template, V * 3 * sizeof(float));
    ck_assert_mem_eq(again.model->faces, body.model->faces, F * 3 * sizeof(int32_t));
    ck_assert_mem_eq(again.model->J_regressor, body.model->J_regressor, (size_t)J * V * sizeof(float));
    lt_arena_free(other);
}
END_TEST

/* The first allocations are cheap to come to; of the last ones, each behind another stage, a few. */
START_TEST(no_memory)
{
    for (long n = 1; n < 28; n += n < 12 ? 1 : 7) {
        lt_arena *other = lt_arena_new();
        synth_body out = { .model = NULL };

        lt_alloc_fail_at(n);
        ck_assert_int_eq(synth_body_new(other, hand, &out), LT_ENOMEM);
        lt_alloc_fail_at(0);
        ck_assert_ptr_null(out.model);
        lt_arena_free(other);
    }
}
END_TEST

static void build_models(void)
{
    arena = lt_arena_new();
    lt_set_threads(1);
    if (synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand) || synth_body_new(arena, hand, &body)) {
        fprintf(stderr, "%s\n", lt_last_error());
        exit(1);
    }
    body_skeleton_init(&design);
    rig = synth_body_rig(body.model);
}

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 0);
    tcase_add_test(t, topology);
    tcase_add_test(t, outwards);
    tcase_add_test(t, landmarks);
    tcase_add_test(t, nodes_where_they_belong);
    tcase_add_test(t, mirrored);
    tcase_add_test(t, regressor);
    tcase_add_test(t, shapes);
    tcase_add_test(t, weights);
    tcase_add_test(t, rest_is_the_template);
    tcase_add_test(t, root_is_rigid);
    tcase_add_test(t, hands_are_the_hand);
    tcase_add_test(t, limbs_keep_their_girth);
    tcase_add_test(t, angles);
    tcase_add_test(t, expressions);
    tcase_add_test(t, nodes_alone);
    tcase_add_test(t, same_bits);
    tcase_add_test(t, no_memory);
}

int main(void)
{
    int failed;

    build_models();
    failed = run_suite("body", add_tests);
    lt_arena_free(arena);
    return failed;
}
