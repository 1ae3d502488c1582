/* SPDX-License-Identifier: Apache-2.0 */
/* What a ViT that does not learn sees of frames: the same bits whatever is kept of it and whatever else has moved, and
 * a graph that takes it learns as one that has the ViT in it. */
#include "models/hogs/hogs.h"
#include "tasks/hogs/vit_cache.h"
#include "tests/geometry/hashed.h"
#include "tests/models/model_of.h"
#include "tests/suite.h"

#include <math.h>

enum { FRAMES = 3, ROOM = 2, LOOKS = 7, S = 112, C = 192, CELLS = 49 };

static const char config[] = "{ \"size\": \"cpu\", \"gaussians\": 60, \"width\": 128, \"height\": 112, \"hands\": 1, "
    "\"objects\": 1 }";

static float image[FRAMES][3 * S * S];
static lt_params *set;
static model m;

static void setup(void)
{
    set = model_of("hogs", config, NULL, &m);
    m.cls->init(&m, 1);
    for (uint32_t f = 0; f < FRAMES; f++)
        for (uint32_t i = 0; i < 3 * S * S; i++)
            image[f][i] = (float)(hashed(f + 1, i) / 2 + 0.5);
}

static void teardown(void)
{
    lt_params_free(set);
}

typedef struct { lt_real feature[C], patches[CELLS * C]; } seen;

static seen look(vit_cache *c, int64_t frame)
{
    seen s;

    vit_cache_look(c, frame, image[frame], s.feature, s.patches);
    return s;
}

START_TEST(same_whatever_is_kept)
{
    static const int64_t order[LOOKS] = { 0, 1, 0, 2, 2, 1, 0 };
    vit_cache none, some;
    seen first[FRAMES];

    ck_assert_uint_eq(vit_cache_bytes(hogs_of(&m)), sizeof(seen));
    check_ok(vit_cache_new(hogs_of(&m), FRAMES, 0, &none));
    check_ok(vit_cache_new(hogs_of(&m), FRAMES, ROOM * sizeof(seen) + 1, &some));
    check_ok(vit_cache_begin(&none));
    check_ok(vit_cache_begin(&some));
    for (int64_t f = 0; f < FRAMES; f++)
        first[f] = look(&none, f);
    for (int i = 0; i < LOOKS; i++) {
        const seen a = look(&none, order[i]), b = look(&some, order[i]);

        ck_assert_int_eq(memcmp(&a, &first[order[i]], sizeof(a)), 0);
        ck_assert_int_eq(memcmp(&b, &a, sizeof(a)), 0);
        lt_params_changed(set);                         /* as a step does */
    }
    ck_assert(memcmp(&first[0], &first[1], sizeof(seen)) != 0);
    ck_assert_int_eq(some.room, 0);
    ck_assert(some.kept[0] && some.kept[1] && !some.kept[2]);
    ck_assert(!none.kept[0]);
    vit_cache_free(&some);
    vit_cache_free(&none);
}
END_TEST

/* A graph that learns, run once; its loss, and the gradient of the hand's trunk */
typedef struct {
    double loss;
    lt_real trunk[64];
} learnt;

static learnt learn(const seen *given)
{
    const lt_param *trunk = lt_params_find(set, "hand.reduce.weight");
    model_record r = { .g = lt_graph_new(), .batch = 1 };
    learnt out;
    lt_plan *p;

    hogs_record(&m, HOGS_GAUSSIANS, &r);
    p = lt_compile(r.g, &(lt_compile_opts){ .loss = r.loss, .train = true });
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    ck_assert((model_port_find(&r.inputs, "image") == NULL) == (given != NULL));
    for (int i = 0; i < r.inputs.n; i++)
        hogs_fill(&m, r.inputs.port[i].name, lt_plan_data(p, r.inputs.port[i].tensor));
    if (given) {
        memcpy(lt_plan_data(p, model_port_find(&r.inputs, "feature")), given->feature, sizeof(given->feature));
        memcpy(lt_plan_data(p, model_port_find(&r.inputs, "patches")), given->patches, sizeof(given->patches));
    } else {
        lt_real *x = lt_plan_data(p, model_port_find(&r.inputs, "image"));

        for (int i = 0; i < 3 * S * S; i++)
            x[i] = (lt_real)image[0][i];
    }
    lt_params_zero_grad(set);
    for (lt_param *q = lt_params_first(set); q; q = q->next)
        if (q->rows)
            check_ok(lt_param_touch(q, 0, q->shape.dim[0]));
    check_ok(lt_run(p));
    out.loss = (double)*(const lt_real *)lt_plan_data(p, r.loss);
    memcpy(out.trunk, trunk->grad, sizeof(out.trunk));
    lt_plan_free(p);
    lt_graph_free(r.g);
    return out;
}

START_TEST(learns_the_same)
{
    const learnt inside = learn(NULL);
    learnt outside;
    double most = 0, off = 0;
    vit_cache c;
    seen s;

    check_ok(vit_cache_new(hogs_of(&m), FRAMES, 0, &c));
    check_ok(vit_cache_begin(&c));
    s = look(&c, 0);
    hogs_take_seen(&m);
    outside = learn(&s);
    ck_assert_double_eq_tol(outside.loss, inside.loss, 1e-6 * inside.loss);
    for (int i = 0; i < 64; i++) {
        most = fmax(most, fabs((double)inside.trunk[i]));
        off = fmax(off, fabs((double)inside.trunk[i] - (double)outside.trunk[i]));
    }
    ck_assert(most > 0);
    ck_assert_msg(off < 1e-4 * most, "off by %g of %g", off, most);
    vit_cache_free(&c);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_set_timeout(t, 120);
    tcase_add_test(t, same_whatever_is_kept);
    tcase_add_test(t, learns_the_same);
}

int main(void)
{
    return run_suite("vit cache", add_tests);
}
