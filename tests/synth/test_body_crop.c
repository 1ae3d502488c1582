/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of persons: what is written of them against the body in them; clothes; the body in a file. */
#include "assets/body/body.h"
#include "assets/hand/hand.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "synth/body/crop.h"
#include "tests/suite.h"

#include <math.h>

enum { PICTURES = 6, BYTES = BODY_PICTURE_WIDTH * BODY_PICTURE_HEIGHT * 3 };

static lt_arena *arena;
static lt_hand_model *hand;
static synth_body body;
static synth_prop_pair prop[YCB_COUNT];         /* all of them the same can: others take seconds to make */
static double vertex[BODY_VERTICES][3], joint[BODY_JOINTS][3], R[BODY_JOINTS][9];

/* What is taken in one place */
typedef struct {
    synth_crop_place place;
    body_row truth[PICTURES];
    uint8_t rgb[PICTURES][BYTES];
} album;

static album first;

static void take(void *ctx, int64_t i)
{
    album *a = ctx;
    lt_arena *own = lt_arena_new();
    synth_frame *small = synth_frame_new(SYNTH_BODY_LOOK_WIDTH, SYNTH_BODY_LOOK_HEIGHT);
    synth_frame *frame = synth_frame_new(BODY_PICTURE_WIDTH, BODY_PICTURE_HEIGHT);

    check_ok(synth_crop_take(own, &a->place, i, small, frame, &a->truth[i]));
    memcpy(a->rgb[i], frame->rgb, BYTES);
    synth_frame_free(small);
    synth_frame_free(frame);
    lt_arena_free(own);
}

static void fill(album *a)
{
    a->place = (synth_crop_place){ .body = &body, .hand = hand, .prop = prop, .seed = 4, .number = 1 };
    check_ok(synth_crop_place_new(arena, &a->place));
    lt_parallel_for(PICTURES, take, a);
}

/* One place for all tests. */
static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    lt_set_threads(1);
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(synth_body_new(arena, hand, &body));
    check_ok(synth_prop_new_bare(arena, 4, &prop[0].right));
    check_ok(synth_prop_mirror(arena, &prop[0].right, &prop[0].left));
    for (int i = 1; i < YCB_COUNT; i++)
        prop[i] = prop[0];
    fill(&first);
}

static void teardown(void)
{
    remove_scratch_folder();
    lt_arena_free(arena);
}

START_TEST(threads_do_not_matter)
{
    static album again;

    lt_set_threads(3);
    fill(&again);
    ck_assert_mem_eq(again.truth, first.truth, sizeof(first.truth));
    ck_assert_mem_eq(again.rgb, first.rgb, sizeof(first.rgb));
}
END_TEST

static void pose(const body_row *t)
{
    const lt_rig rig = synth_body_rig(body.model);
    double all[BODY_DIRECTIONS], trans[3];

    for (int j = 0; j < BODY_JOINTS; j++)
        lt_rot_from_axis_angle((double[]){ t->pose[j][0], t->pose[j][1], t->pose[j][2] }, R[j]);
    for (int k = 0; k < 10; k++) {
        all[k] = t->shape[k];
        all[10 + k] = t->expression[k];
    }
    for (int k = 0; k < 3; k++)
        trans[k] = t->trans[k];
    lt_rig_pose(&rig, R[0], all, trans, vertex[0], joint[0]);
}

static void check_node(const body_row *t, int k, const double node[3])
{
    const float *x = t->nodes_3d[k], *uv = t->nodes_2d[k];

    ck_assert_double_lt(hypot(hypot(node[0] - x[0], node[1] - x[1]), node[2] - x[2]), 1e-5);
    ck_assert_double_eq_tol(t->K[0][0] * x[0] / x[2] + t->K[0][2], uv[0], 0.01 + 1e-5 * fabsf(uv[0]));
    ck_assert_double_eq_tol(t->K[1][1] * x[1] / x[2] + t->K[1][2], uv[1], 0.01 + 1e-5 * fabsf(uv[1]));
    ck_assert(t->seen[k] <= 3 && t->seen[k] != 2);
    ck_assert(!t->seen[k] || (uv[0] >= -0.6f && uv[0] < 192 && uv[1] >= -0.6f && uv[1] < 256));
    if (k >= 25) {                              /* a hand's vertices are around its joints */
        const float *box = t->boxes[k < 45 ? 0 : 1];
        ck_assert(uv[0] >= box[0] && uv[0] <= box[2] && uv[1] >= box[1] && uv[1] <= box[3]);
    }
}

/* Whoever poses the body by the numbers gets the nodes, their places in the picture, and the boxes. */
START_TEST(truth_is_the_posed_body)
{
    int visible = 0;

    for (int i = 0; i < PICTURES; i++) {
        double node[BODY_NODES][3];

        pose(&first.truth[i]);
        body_nodes(vertex[0], joint[0], node);
        for (int k = 0; k < BODY_NODES; k++) {
            check_node(&first.truth[i], k, node[k]);
            visible += first.truth[i].seen[k] == 3;
        }
    }
    ck_assert_int_gt(visible, PICTURES * BODY_NODES / 3);
}
END_TEST

START_TEST(within_limits)
{
    for (int i = 0; i < PICTURES; i++) {
        pose(&first.truth[i]);
        for (int j = 1; j < BODY_FINGERS; j++)
            ck_assert_msg(synth_body_within(j, R[j]), "picture %d, joint %d", i, j);
        ck_assert_int_eq(first.truth[i].subject / SYNTH_BODY_PEOPLE, 1);        /* of this place alone */
    }
}
END_TEST

/* Clothes lie near the skin, and end at their hems. */
START_TEST(clothes)
{
    synth_appearance a;
    synth_instance worn[SYNTH_WORN];
    const body_row rest = { .subject = 0 };
    int n;

    check_ok(synth_appearance_draw(arena, hand, 1, 1, &a));
    a.hair_depth = 0.02;
    pose(&rest);
    check_ok(synth_appearance_wear(arena, &body, &a, (const double (*)[3])vertex, worn, &n));
    ck_assert_int_eq(n, 8);
    for (int i = 0; i < n; i++) {
        const lt_mesh *m = worn[i].mesh;

        ck_assert_int_gt(m->n_faces, 20);
        for (int f = 0; f < m->n_faces; f++)
            for (int k = 0; k < 3; k++)
                ck_assert(m->face[f][k] >= 0 && m->face[f][k] < m->n_vertices);
        for (int v = 0; v < m->n_vertices; v++)
            ck_assert(isfinite(m->vertex[v][0] + m->vertex[v][1] + m->vertex[v][2]));
    }
    for (int v = 0; v < worn[0].mesh->n_vertices; v++) {        /* the shirt */
        const float *p = worn[0].mesh->vertex[v];
        ck_assert(fabsf(p[0]) < a.sleeve + 0.02 && p[1] + 0.955 > a.hem - 0.02 && p[1] + 0.955 < 1.51);
    }
}
END_TEST

START_TEST(the_body_in_a_file)
{
    const body_model *m = body.model;
    body_model *back;

    check_ok(body_file_write(in_folder("body.npz"), m));
    check_ok(body_file_read(arena, in_folder("body.npz"), &back));
    ck_assert(back->synthetic && back->shapes == BODY_SHAPES && back->expressions == BODY_EXPRESSIONS);
    ck_assert_mem_eq(back->v_template, m->v_template, BODY_VERTICES * sizeof(*m->v_template));
    ck_assert_mem_eq(back->posedirs, m->posedirs, (size_t)BODY_VERTICES * 3 * BODY_FEATURES * sizeof(float));
    ck_assert_mem_eq(back->weights, m->weights, (size_t)BODY_VERTICES * BODY_JOINTS * sizeof(float));
    ck_assert_mem_eq(back->faces, m->faces, BODY_FACES * sizeof(*m->faces));
    ck_assert_mem_eq(back->parent, m->parent, sizeof(m->parent));
    ck_assert_mem_eq(back->hand_mean[0], m->hand_mean[0], BODY_HAND_PCA * sizeof(float));
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 0);
    tcase_add_unchecked_fixture(t, setup, teardown);
    tcase_add_test(t, threads_do_not_matter);
    tcase_add_test(t, truth_is_the_posed_body);
    tcase_add_test(t, within_limits);
    tcase_add_test(t, clothes);
    tcase_add_test(t, the_body_in_a_file);
}

int main(void)
{
    return run_suite("body crop", add_tests);
}
