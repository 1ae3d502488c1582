/* SPDX-License-Identifier: Apache-2.0 */
/* The scene that rasterisers are timed on: NumPy's bytes, and torch's image in double (scripts/vectors/splat.py). */
#include "eval/bench/splat.h"
#include "eval/bench/splat_scene.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"

#include <zlib.h>

enum { N = 10000, SIDE = 224, STEP = 7, GRID = SIDE / STEP };

static uLong add_crc(uLong crc, const float *x, size_t n)
{
    return crc32_z(crc, (const Bytef *)x, n * sizeof(*x));
}

START_TEST(bytes)
{
    lt_arena *arena = lt_arena_new();
    splat_scene s;
    uLong crc = 0;

    check_ok(splat_scene_new(arena, N, &s));
    crc = add_crc(crc, s.centre, 3 * N);
    crc = add_crc(crc, s.scale, 3 * N);
    crc = add_crc(crc, s.quaternion, 4 * N);
    crc = add_crc(crc, s.opacity, N);
    crc = add_crc(crc, s.colour, 3 * N);
    ck_assert_uint_eq(crc, 0xe7cf3403);
    lt_arena_free(arena);
}
END_TEST

typedef struct {
    lt_params *params;
    model m;
    model_record record;
    lt_plan *plan;
} drawing;

static drawing draw(void)
{
    drawing d = { .params = lt_params_new(), .record = { .g = lt_graph_new(), .batch = 1 } };

    check_ok(model_create(&bench_splat_class, "test", NULL, NULL, d.params, &d.m));
    d.m.cls->record(&d.m, false, &d.record);
    d.plan = lt_compile(d.record.g, NULL);
    ck_assert_msg(d.plan != NULL, "%s", lt_last_error());
    for (int i = 0; i < d.record.inputs.n; i++)
        d.m.cls->fill(&d.m, d.record.inputs.port[i].name, lt_plan_data(d.plan, d.record.inputs.port[i].tensor));
    lt_run(d.plan);
    return d;
}

START_TEST(image)
{
    drawing d = draw();
    const lt_real *y = lt_plan_data(d.plan, model_port_find(&d.record.outputs, "image"));
    const lt_array *want;
    char path[1024];
    lt_npz npz;
    double mean = 0;

    snprintf(path, sizeof(path), "%s/tests/vectors/splat_scene.npz", getenv("srcdir") ? getenv("srcdir") : "..");
    check_ok(lt_npz_read(lt_params_arena(d.params), path, &npz));
    want = lt_npz_find(&npz, "image");
    ck_assert(want && lt_array_count(want) == 3 * GRID * GRID);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < GRID * GRID; i++) {
            const double got = (double)y[(c * SIDE + i / GRID * STEP) * SIDE + i % GRID * STEP];

            ck_assert_double_eq_tol(got, lt_array_get(want, (size_t)(c * GRID * GRID + i)), 1e-4);
        }
    for (int i = 0; i < 3 * SIDE * SIDE; i++)
        mean += (double)y[i] / (3 * SIDE * SIDE);
    ck_assert_double_eq_tol(mean, .2054813, 1e-6);
    lt_plan_free(d.plan);
    lt_graph_free(d.record.g);
    lt_params_free(d.params);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_test(tc, bytes);
    tcase_add_test(tc, image);
}

int main(void)
{
    return run_suite("splat_scene", add_tests);
}
