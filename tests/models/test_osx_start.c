/* SPDX-License-Identifier: Apache-2.0 */
/* Where the training of an osx begins: how somebody stands, what the first layer makes of grey and of edges; and which
 * losses it has. */
#include "models/body/osx.h"
#include "models/body/osx_encoder.h"
#include "tests/models/model_of.h"

#include <math.h>

enum { PATCH = 16, FILTER = 3 * PATCH * PATCH, WIDTH = 192, FILTERS = WIDTH - 64 };

static model m;
static lt_params *set;

static void start(void)
{
    set = model_of("osx", "{\"w_volumes\": 2, \"w_nodes\": 3}", NULL, &m);
    check_ok(lt_params_status(set));
    m.cls->init(&m, 1);
}

static void stop(void)
{
    lt_params_free(set);
}

static const lt_real *values(const char *name)
{
    const lt_param *p = lt_params_find(set, name);

    ck_assert_ptr_nonnull(p);
    return p->data;
}

/* The columns' numbers in turns: x is the camera's, y, up, against it */
START_TEST(upright)
{
    static const lt_real want[6] = { 1, 0, 0, -1, 0, 0 }, at_rest[6] = { 1, 0, 0, 1, 0, 0 };
    const lt_real *root = values("body_regressor.root_pose_out.0.bias");
    const lt_real *pose = values("body_regressor.body_pose_out.0.bias");

    for (int k = 0; k < 6; k++) {
        ck_assert_float_eq(root[k], want[k]);
        ck_assert_float_eq(pose[6 + k], at_rest[k]);
    }
}
END_TEST

START_TEST(grey_is_zero)
{
    const lt_real *w = values("encoder.patch_embed.proj.weight"), *b = values("encoder.patch_embed.proj.bias");

    for (int f = 0; f < FILTERS; f++) {
        double sum = b[f];

        for (int i = 0; i < FILTER; i++)
            sum += 0.5 * (double)w[f * FILTER + i];
        ck_assert_double_eq_tol(sum, 0, 1e-5);
    }
    for (int i = FILTERS * FILTER; i < WIDTH * FILTER; i++)
        ck_assert(w[i] == 0);                           /* places have these channels */
}
END_TEST

/* No two filters see the same. */
START_TEST(filters_differ)
{
    const lt_real *w = values("encoder.patch_embed.proj.weight");

    for (int f = 0; f < FILTERS; f++)
        for (int g = 0; g < f; g++) {
            double both = 0, of_f = 0, of_g = 0;

            for (int i = 0; i < FILTER; i++) {
                const double x = (double)w[f * FILTER + i], y = (double)w[g * FILTER + i];

                both += x * y;
                of_f += x * x;
                of_g += y * y;
            }
            ck_assert(fabs(both) < 1e-5 * sqrt(of_f * of_g));
        }
}
END_TEST

/* Neighbours are more alike than cells far apart. */
START_TEST(places)
{
    const lt_real *p = values("encoder.pos_embed");
    double near = 0, far = 0;

    for (int k = 0; k < WIDTH; k++) {
        const double here = (double)p[(1 + 5 * OSX_COLUMNS + 3) * WIDTH + k];

        near += here * (double)p[(1 + 5 * OSX_COLUMNS + 4) * WIDTH + k];
        far += here * (double)p[(1 + 14 * OSX_COLUMNS + 10) * WIDTH + k];
        ck_assert_float_eq(p[k], 0);                    /* the row that is added to all */
    }
    ck_assert(near > 1.2 * far);
}
END_TEST

/* What attention of a block's head makes of two cells' places alone, behind the norm in front of it */
static double attention(int block, int head, int from, int to)
{
    const lt_real *p = values("encoder.pos_embed");
    const char *name[2] = { lt_name(set, "encoder.blocks.%d.attn.q.weight", block),
                            lt_name(set, "encoder.blocks.%d.attn.k.weight", block) };
    const int cell[2] = { from, to };
    double sum = 0, out[2][64];

    for (int side = 0; side < 2; side++) {
        const lt_real *w = values(name[side]) + (int64_t)64 * head * WIDTH, *x = p + (int64_t)(1 + cell[side]) * WIDTH;
        double mean = 0, square = 0;

        for (int k = 0; k < WIDTH; k++) {
            mean += (double)x[k] / WIDTH;
            square += (double)x[k] * (double)x[k] / WIDTH;
        }
        for (int i = 0; i < 64; i++) {
            out[side][i] = 0;
            for (int k = 0; k < WIDTH; k++)
                out[side][i] += (double)w[i * WIDTH + k] * ((double)x[k] - mean) / sqrt(square - mean * mean);
        }
    }
    for (int i = 0; i < 64; i++)
        sum += out[0][i] * out[1][i] / 8;
    return sum;
}

/* Two heads of each block look at the cells beside, or at those above and below. */
START_TEST(looks_beside)
{
    static const int further[2][2] = { { -1, 1 }, { -OSX_COLUMNS, OSX_COLUMNS } };
    const int here = 7 * OSX_COLUMNS + 5;

    for (int block = 0; block < 4; block++)
        for (int head = 0; head < 2; head++) {
            const int there = here + further[block % 2][head];
            const double best = attention(block, head, here, there);

            for (int i = 0; i < OSX_CELLS; i++)
                ck_assert_msg(i == there || attention(block, head, here, i) < best - 2, "block %d, head %d: cell %d",
                              block, head, i);
        }
}
END_TEST

START_TEST(losses)
{
    lt_graph *g = lt_graph_new();
    model_record r = { .g = g, .batch = 2 };
    lt_params *plain_set;
    model plain;

    ck_assert_double_eq(osx_weights_of(&m).nodes, 3);
    ck_assert_double_eq(osx_weights_of(&m).rotation, 1);
    m.cls->record(&m, true, &r);
    check_ok(lt_graph_status(g));
    ck_assert_ptr_nonnull(model_port_find(&r.losses, "volumes"));
    lt_graph_free(g);

    plain_set = model_of("osx", "{}", NULL, &plain);
    g = lt_graph_new();
    r = (model_record){ .g = g, .batch = 2 };
    plain.cls->record(&plain, true, &r);
    ck_assert_ptr_null(model_port_find(&r.losses, "volumes"));
    lt_graph_free(g);
    lt_params_free(plain_set);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_test(tc, upright);
    tcase_add_test(tc, grey_is_zero);
    tcase_add_test(tc, filters_differ);
    tcase_add_test(tc, places);
    tcase_add_test(tc, looks_beside);
    tcase_add_test(tc, losses);
}

int main(void)
{
    return run_suite("osx's start", add_tests);
}
