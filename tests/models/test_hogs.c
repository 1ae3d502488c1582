/* SPDX-License-Identifier: Apache-2.0 */
/* HOGS's parts against PyTorch (scripts/vectors/hogs.py): results, and the length of each parameter's gradient; what a
 * shell of Gaussians holds inside; zones of a hand. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/array/npz.h"
#include "models/hogs/contact.h"
#include "models/hogs/occupancy.h"
#include "models/hogs/sizes.h"
#include "tests/models/hogs_parts.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the largest value; of the longest gradient, as batch norms make rounding errors larger. */
static const double FORWARD = 1e-5, GRADIENT = 2e-4;

static lt_arena *arena;
static lt_params *params;
static lt_npz npz;
static model_record r;
static lt_plan *plan;

static void start(int i, bool train)
{
    const char *srcdir = getenv("srcdir");

    arena = lt_arena_new();
    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/models/hogs_%s.npz", srcdir ? srcdir : "..",
                                                hogs_parts[i].name), &npz));
    params = lt_params_new();
    r = (model_record){ .g = lt_graph_new() };
    hogs_parts[i].record(params, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ .train = train, .loss = r.loss });
    ck_assert_msg(plan != NULL, "%s: %s", hogs_parts[i].name, lt_last_error());
    hogs_part_fill(params, &r, plan);
    lt_run(plan);
}

static void stop(void)
{
    lt_plan_free(plan);
    lt_graph_free(r.g);
    lt_params_free(params);
    lt_arena_free(arena);
}

static double difference(const lt_tensor *t, const lt_array *want)
{
    const lt_real *got = lt_plan_data(plan, t);
    double most = 0, largest = 0;

    ck_assert_int_eq(lt_numel(t), lt_array_count(want));
    for (int64_t i = 0; i < lt_numel(t); i++) {
        const double w = lt_array_get(want, (size_t)i);

        most = fmax(most, isfinite(got[i]) ? fabs(got[i] - w) : INFINITY);
        largest = fmax(largest, fabs(w));
    }
    return most / largest;
}

START_TEST(values)
{
    start(_i, true);
    for (int k = 0; k < r.outputs.n; k++) {
        const model_port *port = &r.outputs.port[k];
        const lt_array *want = lt_npz_find(&npz, port->name);

        ck_assert_msg(want != NULL, "no vectors of %s", port->name);
        ck_assert_msg(difference(port->tensor, want) < FORWARD, "%s: %s differs by %g", hogs_parts[_i].name, port->name,
                      difference(port->tensor, want));
    }
    stop();
}
END_TEST

/* Of the row of the set in use, where the parameter has rows */
static double length(const lt_param *p)
{
    const int64_t width = p->rows ? lt_param_width(p) : lt_param_numel(p);
    const lt_real *g = p->grad ? p->grad + (p->rows ? width : 0) : NULL;
    double sum = 0;

    for (int64_t i = 0; g && i < width; i++)
        sum += (double)g[i] * (double)g[i];
    return sqrt(sum);
}

START_TEST(gradients)
{
    const lt_array *names, *want;
    double longest = 0;

    start(_i, true);
    names = lt_npz_find(&npz, "names"), want = lt_npz_find(&npz, "gradients");
    for (size_t k = 0; k < lt_array_count(want); k++)
        longest = fmax(longest, lt_array_get(want, k));
    for (size_t k = 0; k < lt_array_count(names); k++) {
        const lt_param *p = lt_params_find(params, lt_array_text(names, k));
        const double w = lt_array_get(want, k);

        ck_assert_msg(p != NULL, "%s: no parameter %s", hogs_parts[_i].name, lt_array_text(names, k));
        ck_assert_msg(fabs(length(p) - w) < GRADIENT * w + 1e-6 * longest, "%s: %s: %.9g, want %.9g",
                      hogs_parts[_i].name, p->name, length(p), w);
    }
    stop();
}
END_TEST

/* The same bits for any number of threads are test_ops' to see of single ops; here of the chains. */
START_TEST(any_number_of_threads)
{
    lt_real one[64], more;

    for (int threads = 1; threads <= 4; threads++) {
        lt_set_threads(threads);
        start(_i, true);
        for (int k = 0; k < r.outputs.n; k++) {
            more = *(const lt_real *)lt_plan_data(plan, r.outputs.port[k].tensor);
            if (threads == 1)
                one[k] = more;
            ck_assert(memcmp(&one[k], &more, sizeof(more)) == 0);
        }
        stop();
    }
}
END_TEST

/* ---- the published sizes ----------------------------------------------------------------------------------- */

START_TEST(full_sizes)
{
    lt_params *set = lt_params_new();
    gpm g;
    vpm v;

    ck_assert_int_eq(gpm_token(&hogs_full.gpm), 435);
    ck_assert_int_eq(gpm_token(&hogs_cpu.gpm), 3 + 64 + 128 + 48);
    ck_assert_int_eq(lt_hash_grid_entries(&hogs_full.vpm.grid), 898024);
    vpm_new(&v, set, "hand", 1, &hogs_full.vpm);
    gpm_new(&g, set, "gpm", &hogs_full.gpm);
    check_ok(lt_params_status(set));
    ck_assert_int_eq(v.trunk.weight[0]->shape.dim[2], 343);
    ck_assert_int_eq(v.trunk.weight[3]->shape.dim[1], 266);
    ck_assert_int_eq(g.level.conv[0].weight->shape.dim[1], 90);
    lt_params_free(set);
}
END_TEST

/* ---- the avatar ---------------------------------------------------------------------------------------------- */

/* Its pose encoder has 9,158 numbers; a frame that it was not trained on has the mean of the codes. */
START_TEST(avatar_parts)
{
    enum { FRAMES = 3 };
    const avatar_opts o = { .grid = hogs_cpu.avatar.grid, .deform = 8, .look = 8, .feature = 4, .frames = FRAMES };
    lt_params *set = lt_params_new();
    lt_graph *g = lt_graph_new();
    const lt_real *mean;
    int64_t numbers = 0;
    lt_tensor *code;
    lt_plan *p;
    avatar m;

    avatar_new(&m, set, "avatar", 1, 1, &o);
    check_ok(lt_params_status(set));
    for (lt_param *x = lt_params_first(set); x; x = x->next)
        numbers += strncmp(x->name, "avatar.pose.", 12) == 0 ? lt_param_numel(x) : 0;
    ck_assert_int_eq(numbers, 9158);
    avatar_init(&m, 3);
    code = lt_output(avatar_code(&m, g, NULL), "code");
    p = lt_compile(g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    lt_run(p);
    mean = lt_plan_data(p, code);
    for (int k = 0; k < AVATAR_CODE; k++) {
        const lt_real *c = m.code->data + k;

        ck_assert_double_eq_tol((double)mean[k], (double)(c[0] + c[AVATAR_CODE] + c[2 * AVATAR_CODE]) / 3, 1e-6);
    }
    lt_plan_free(p);
    lt_graph_free(g);
    lt_params_free(set);
}
END_TEST

/* ---- occupancy ----------------------------------------------------------------------------------------------- */

enum { SHELL = 3000 };
static const double RADIUS = 0.05;
static lt_real centre[SHELL + 1][3], axes[SHELL + 1][9], opacity[SHELL + 1];

/* A ball's surface of Gaussians of 2 mm (points of a spiral), and one that is flat */
static occupancy_gaussians shell(void)
{
    for (int i = 0; i <= SHELL; i++) {
        const double z = 1 - (2 * i + 1.0) / (SHELL + 1), a = 2.399963229728653 * i, s = sqrt(1 - z * z);
        const double p[3] = { s * cos(a), s * sin(a), z };

        for (int k = 0; k < 3; k++) {
            centre[i][k] = (lt_real)(RADIUS * p[k]);
            axes[i][4 * k] = i < SHELL ? (lt_real)0.002 : 0;
        }
        opacity[i] = (lt_real)0.9;
    }
    return (occupancy_gaussians){ .n = SHELL + 1, .centre = (const lt_real (*)[3])centre,
                                  .axes = (const lt_real (*)[9])axes, .opacity = opacity };
}

static bool inside_at(const occupancy *o, double x, double y, double z)
{
    return occupancy_inside(o, (lt_real[]){ (lt_real)x, (lt_real)y, (lt_real)z });
}

START_TEST(a_shell_is_solid)
{
    const occupancy_gaussians g = shell();
    occupancy *o = lt_alloc(sizeof(*o)), *again = lt_alloc(sizeof(*o));
    int32_t *index = lt_alloc(sizeof(*index) * (SHELL + 1));
    int64_t n;

    check_ok(occupancy_build(&g, (double[]){ -0.06, -0.06, -0.06 }, (double[]){ 0.06, 0.06, 0.06 }, o));
    ck_assert(inside_at(o, 0, 0, 0) && inside_at(o, 0.04, 0, 0) && inside_at(o, 0, 0, -0.049));
    ck_assert(!inside_at(o, 0.058, 0, 0) && !inside_at(o, 0.045, 0.045, 0.045) && !inside_at(o, 1, 0, 0));
    ck_assert(!inside_at(o, NAN, 0, 0));
    n = occupancy_surface(o, &g, index);
    ck_assert_int_gt(n, 0);
    for (int64_t i = 1; i < n; i++)
        ck_assert_int_lt(index[i - 1], index[i]);
    lt_set_threads(1);
    check_ok(occupancy_build(&g, (double[]){ -0.06, -0.06, -0.06 }, (double[]){ 0.06, 0.06, 0.06 }, again));
    ck_assert(memcmp(o, again, sizeof(*o)) == 0);
    lt_release(o), lt_release(again), lt_release(index);
}
END_TEST

/* Through a hole in the shell everything is reached. */
START_TEST(an_open_shell_is_not)
{
    occupancy_gaussians g = shell();
    occupancy *o = lt_alloc(sizeof(*o));

    for (int i = 0; i < SHELL; i++)
        opacity[i] = (lt_real)(centre[i][2] > (lt_real)0.03 ? 0 : 0.9);
    check_ok(occupancy_build(&g, (double[]){ -0.06, -0.06, -0.06 }, (double[]){ 0.06, 0.06, 0.06 }, o));
    ck_assert(!inside_at(o, 0, 0, 0) && inside_at(o, 0, 0, -0.05));
    check_error(occupancy_build(&g, (double[]){ 0, 0, 0 }, (double[]){ 1, 0, 1 }, o), LT_EINVAL,
                "occupancy grid: the box goes from 0 to 0 along axis 1, want an extent");
    lt_release(o);
}
END_TEST

START_TEST(zones)
{
    static const float vertex[6][3] = { { 0.1f }, { 0.11f }, { 0.13f }, { 0 }, { 0, 0, 0.01f }, { 0.03f } };
    static const float normal[6][3] = { { 1 }, { 1 }, { 1 }, { 0, -1, 0 }, { 0, 1, 0 }, { 0, -1, 0 } };
    static float weight[6][SKIN_FIELD_BONES];
    const contact_template t = { .n = 6, .vertex = vertex, .normal = normal, .weight = (const float (*)[16])weight,
                                 .tip = { 0, 0, 2, 2, 2 }, .palm = { 0, -1, 0 } };
    int32_t zone[6];

    for (int i = 0; i < 6; i++)
        weight[i][i == 5 ? 3 : 0] = 1;
    contact_zones(&t, zone);
    ck_assert_int_eq(zone[0], 0);
    ck_assert_int_eq(zone[1], 0);
    ck_assert_int_eq(zone[2], 2);
    ck_assert_int_eq(zone[3], CONTACT_PALM);
    ck_assert_int_eq(zone[4], CONTACT_NOWHERE);
    ck_assert_int_eq(zone[5], CONTACT_NOWHERE);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_loop_test(tc, values, 0, n_hogs_parts);
    tcase_add_loop_test(tc, gradients, 0, n_hogs_parts);
    tcase_add_loop_test(tc, any_number_of_threads, 0, n_hogs_parts);
    tcase_add_test(tc, full_sizes);
    tcase_add_test(tc, avatar_parts);
    tcase_add_test(tc, a_shell_is_solid);
    tcase_add_test(tc, an_open_shell_is_not);
    tcase_add_test(tc, zones);
}

int main(void)
{
    return run_suite("hogs", add_tests);
}
