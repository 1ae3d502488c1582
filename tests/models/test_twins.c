/* SPDX-License-Identifier: Apache-2.0 */
/* The models against their PyTorch twins of scripts/peers: names, sizes, inference, loss, gradients. */
#include "libtensor/graph/plan.h"
#include "libtensor/io/array/npz.h"
#include "tests/geometry/hashed_hand.h"
#include "tests/models/model_of.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* forward is relative to the largest value of an output; gradient to the length of each parameter's own,
 * where that is above two millionths of the longest: a shift that a batch norm behind it takes off has none.
 * HOCAT's batch norms see eight values where its maps are 2 x 2, and make rounding errors larger; PyTorch's own
 * gradients in float32 are 7e-4 from those in float64 for the unified estimator, whose pools and relus are many. */
static const struct {
    const char *model, *config;
    const char *vectors;            /* the file's name; NULL: the model's */
    int batch;
    double forward, gradient;
} twins[] = {
    { "resnet50", "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 2, 1, 1], \"classes\": 10}", NULL, 4, 5e-6,
      5e-5 },
    { "efficientnet_b0", "{\"image_size\": 64, \"classes\": 10, \"dropout\": 0, \"stochastic_depth\": 0}", NULL,
      4, 5e-6, 1e-4 },
    { "hocat", "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 1, "
      "\"heads\": 2, \"mlp_ratio\": 1}", NULL, 2, 2e-5, 1e-3 },
    { "unified", "{\"image_size\": 96, \"width\": 8, \"layers\": 1, \"heads\": 2, \"points\": 2, "
      "\"dropout\": 0, \"stochastic_depth\": 0}", NULL, 4, 2e-5, 5e-3 },
    { "pointnet2", "{\"points\": 600, \"features\": 5}", "pointnet2_sa1", 1, 1e-5, 1e-4 },
    { "pointnet2", "{\"variant\": \"ulip\", \"points\": 520, \"dropout\": 0}", "pointnet2_ulip", 3, 1e-5, 1e-3 },
    { "vit", "{\"variant\": \"tiny\"}", NULL, 2, 1e-5, 1e-4 },
    { "csp_seg", "{\"image_size\": 64, \"classes\": 5}", NULL, 2, 2e-5, 1e-3 },
    { "reid", "{\"identities\": 7, \"dropout\": 0}", NULL, 4, 2e-5, 1e-3 },
    { "reid", "{\"identities\": 7, \"dropout\": 0, \"reid_compat\": \"tf\"}", "reid_tf", 4, 2e-5, 1e-3 },
    { "osx", "{}", NULL, 2, 2e-5, 1e-3 },
    { "action", "{\"frames\": 14, \"dropout\": 0}", NULL, 3, 2e-5, 1e-3 },
};

static lt_arena *arena;
static lt_params *params;
static lt_npz npz;
static model m;
static model_record r;
static lt_plan *plan;

/* ---- the numbers of scripts/vectors/models.py ---------------------------------------------------------- */

static uint32_t seed_of(const char *name)
{
    uint32_t h = 2166136261u;

    for (; *name; name++)
        h = (h ^ (unsigned char)*name) * 16777619u;
    return h;
}

static bool ends_with(const char *name, const char *end)
{
    const size_t n = strlen(name), k = strlen(end);

    return n >= k && strcmp(name + n - k, end) == 0;
}

static void fill_parameter(lt_param *p)
{
    const bool near_one = ends_with(p->name, ".weight") || ends_with(p->name, "running_var")
        || ends_with(p->name, "temperature");
    const int64_t n = lt_param_numel(p);
    const double scale = p->shape.rank > 1 ? sqrt(3 / (double)(n / p->shape.dim[0])) : near_one ? 0.5 : 0.125;
    const double offset = p->shape.rank == 1 && near_one ? 1 : 0;

    for (int64_t i = 0; i < n; i++)
        p->data[i] = (lt_real)(offset + scale * hashed(seed_of(p->name), (uint32_t)i));
}

enum { OBJECT = 6, OBJECTS = 64, WORDS = 8 };

/* The objects of scripts/vectors/ops.py, in two images */
static void fill_objects(lt_real *x)
{
    static const lt_real first[2 * OBJECT] = { 2, 5, 9, 40.5, 33, 1, 0, 30, 2.5, 61, 50, 0 };
    static const lt_real second[OBJECT] = { 1, 11, 20, 43, 60, 1 };

    for (int i = 0; i < 2 * OBJECTS * OBJECT; i++)
        x[i] = -1;
    memcpy(x, first, sizeof(first));
    memcpy(x + (OBJECTS + 1) * OBJECT, second, sizeof(second));
}

/* Bit p is set where p % 3 is 0 or the object's number is 1. */
static void fill_masks(int32_t *x)
{
    for (int i = 0; i < 2 * OBJECTS * WORDS; i++) {
        uint32_t word = 0;

        for (int bit = 0; bit < 32; bit++)
            word |= (uint32_t)(i / WORDS % OBJECTS == 1 || (i % WORDS * 32 + bit) % 3 == 0) << bit;
        x[i] = (int32_t)word;
    }
}

static void fill_inputs(void)
{
    static const lt_real hand[] = { 10, 8, 41, 36, 30, 29, 60, 61 }, object[] = { 4, 4, 33, 30, 22, 31, 52, 62 };

    for (int k = 0; k < r.inputs.n; k++) {
        const model_port *port = &r.inputs.port[k];
        const char *name = strcmp(port->name, "object_weight") ? port->name : "weight";      /* the twins have one */
        lt_real *x = lt_plan_data(plan, port->tensor);

        for (int64_t i = 0; i < lt_numel(port->tensor); i++)
            x[i] = (lt_real)(hashed(seed_of(name), (uint32_t)i) / 2 + 0.5);
        if (strcmp(port->name, "hand_box") == 0)
            memcpy(x, hand, sizeof(hand));
        if (strcmp(port->name, "object_box") == 0)
            memcpy(x, object, sizeof(object));
        if (strcmp(port->name, "objects") == 0)
            fill_objects(x);
        if (strcmp(port->name, "masks") == 0)
            fill_masks((int32_t *)x);
    }
}

/* ---- one model ----------------------------------------------------------------------------------------- */

static void read_vectors(const char *name)
{
    const char *srcdir = getenv("srcdir");
    const char *path = lt_arena_printf(arena, "%s/tests/vectors/models/%s.npz", srcdir ? srcdir : "..", name);

    check_ok(lt_npz_read(arena, path, &npz));
}

static void open_twin(int i)
{
    lt_hand_model *hand;
    lt_hand_layer *layer;

    arena = lt_arena_new();
    hand = lt_arena_alloc(arena, sizeof(*hand));
    read_vectors(twins[i].vectors ? twins[i].vectors : twins[i].model);
    hashed_hand(hand);
    ck_assert_int_eq(lt_hand_layer_new(arena, hand, lt_hand_tips_ho3d, &layer), LT_OK);
    params = model_of(twins[i].model, twins[i].config, layer, &m);
    for (lt_param *p = lt_params_first(params); p; p = p->next)
        fill_parameter(p);
}

static void run(int i, bool train)
{
    r = (model_record){ .g = lt_graph_new(), .batch = twins[i].batch };
    m.cls->record(&m, train, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ .train = train, .loss = r.loss });
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    fill_inputs();
    lt_params_zero_grad(params);
    lt_run(plan);
}

static void close_twin(void)
{
    lt_plan_free(plan);
    lt_graph_free(r.g);
    lt_params_free(params);
    lt_arena_free(arena);
    plan = NULL;
    r.g = NULL;
}

static const lt_array *vector(const char *name)
{
    const lt_array *a;

    check_ok(lt_npz_get(&npz, name, &a));
    return a;
}

START_TEST(names_and_sizes)
{
    const lt_array *names, *sizes;
    int64_t total = 0;

    open_twin(_i);
    names = vector("names");
    sizes = vector("sizes");
    for (size_t k = 0; k < lt_array_count(names); k++) {
        const lt_param *p = lt_params_find(params, lt_array_text(names, k));

        ck_assert_msg(p != NULL, "%s: no such parameter", lt_array_text(names, k));
        ck_assert_int_eq(lt_param_numel(p), lt_array_int(sizes, k));
        total += lt_param_numel(p);
    }
    ck_assert_int_eq(lt_params_count(params, LT_WEIGHT, ""), total);
    close_twin();
}
END_TEST

/* The largest difference over the largest value. */
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

START_TEST(inference)
{
    int compared = 0;

    open_twin(_i);
    run(_i, false);
    for (int k = 0; k < r.outputs.n; k++) {
        const lt_array *want = lt_npz_find(&npz, r.outputs.port[k].name);

        if (!want)
            continue;
        ck_assert_double_lt(difference(r.outputs.port[k].tensor, want), twins[_i].forward);
        compared++;
    }
    ck_assert_int_gt(compared, 0);
    close_twin();
}
END_TEST

static double largest(const lt_array *a)
{
    double most = 0;

    for (size_t i = 0; i < lt_array_count(a); i++)
        most = fmax(most, lt_array_get(a, i));
    return most;
}

static double length(const lt_real *x, int64_t n)
{
    double sum = 0;

    for (int64_t i = 0; i < n; i++)
        sum += (double)x[i] * x[i];
    return sqrt(sum);
}

START_TEST(training_step)
{
    const lt_array *names, *want;

    open_twin(_i);
    run(_i, true);
    ck_assert_double_lt(difference(r.loss, vector("loss")), twins[_i].gradient);
    names = vector("names");
    want = vector("gradients");
    for (size_t k = 0; k < lt_array_count(names); k++) {
        const lt_param *p = lt_params_find(params, lt_array_text(names, k));
        const double w = lt_array_get(want, k), got = p->grad ? length(p->grad, lt_param_numel(p)) : 0;

        ck_assert_msg(fabs(got - w) < twins[_i].gradient * w + 2e-6 * largest(want), "%s: %.9g, want %.9g", p->name,
                      got, w);
    }
    close_twin();
}
END_TEST

/* ---- the sizes that are published ------------------------------------------------------------------------ */

static const struct {
    const char *model, *config;
    int64_t parameters, macs;
} published[] = {
    { "resnet50", "{}", 25557032, 5340348416 }, { "efficientnet_b0", "{}", 5288548, 385814752 },
    { "vit", "{}", 87456000, 4408418304 }, { "csp_seg", "{\"classes\": 80}", 3409968, 6000844800 },
    { "csp_seg", "{\"classes\": 23}", 3268101, 5682048000 }, { "reid", "{}", 2802080, 294387712 },
    { "action", "{}", 1328510, 373694720 }, { "action", "{\"variant\": \"full\"}", 3979498, 2210353024 },
};

START_TEST(full_size)
{
    lt_plan *p;

    params = model_of(published[_i].model, published[_i].config, NULL, &m);
    ck_assert_int_eq(lt_params_count(params, LT_WEIGHT, ""), published[_i].parameters);
    r = (model_record){ .g = lt_graph_new(), .batch = 1 };
    m.cls->record(&m, false, &r);
    p = lt_compile(r.g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    ck_assert_int_eq(lt_plan_macs(p), published[_i].macs);
    lt_plan_free(p);
    lt_graph_free(r.g);
    lt_params_free(params);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_loop_test(tc, names_and_sizes, 0, (int)LT_COUNT(twins));
    tcase_add_loop_test(tc, inference, 0, (int)LT_COUNT(twins));
    tcase_add_loop_test(tc, training_step, 0, (int)LT_COUNT(twins));
    tcase_add_loop_test(tc, full_size, 0, (int)LT_COUNT(published));
}

int main(void)
{
    return run_suite("twins", add_tests);
}
