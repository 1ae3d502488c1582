/* SPDX-License-Identifier: Apache-2.0 */
/* A network of one's own from the first step to another program: docs/your-first-network.md walks through it. */
#include <libtensor/base/rng.h>
#include <libtensor/graph/plan.h>
#include <libtensor/io/array/safetensors.h>
#include <libtensor/io/atomic_file.h>
#include <libtensor/io/onnx/onnx.h>
#include <libtensor/nn/init.h>
#include <libtensor/nn/layers.h>
#include <libtensor/optim/optim.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BATCH = 32, SIDE = 12, STEPS = 60 };

/* ---- the network ------------------------------------------------------------------------------------------------- */

typedef struct {
    lt_params *params;
    lt_conv_layer conv;
    lt_batch_norm_layer norm;
    lt_linear_layer out;
} network;

static network network_new(void)
{
    network n = { .params = lt_params_new() };

    n.conv = lt_conv_layer_new(n.params, "conv", 1, 8, 3, false, &(lt_conv_opts){ .pad = 1 });
    n.norm = lt_batch_norm_layer_new(n.params, "norm", 8);
    n.out = lt_linear_layer_new(n.params, "out", 8, 2, true);
    return n;
}

/* images (B, 1, SIDE, SIDE) to the scores of two classes, (B, 2) */
static lt_tensor *network_forward(const network *n, lt_tensor *image)
{
    lt_tensor *x = lt_relu(lt_batch_norm_layer_forward(&n->norm, lt_conv_layer_forward(&n->conv, image)));

    return lt_linear_layer_forward(&n->out, lt_global_avg_pool(x));
}

static lt_tensor *image_input(lt_graph *g, int64_t batch)
{
    return lt_input(g, "image", LT_F32, 4, (int64_t[]){ batch, 1, SIDE, SIDE });
}

/* ---- data: stripes that lie (0) or stand (1), in noise ----------------------------------------------------------- */

/* wanted (BATCH, 2): a 1 in the place of the class */
static void draw(lt_rng *rng, float *image, float *wanted)
{
    for (int i = 0; i < BATCH; i++) {
        const int stands = (int)lt_rng_below(rng, 2);

        wanted[2 * i] = (float)!stands;
        wanted[2 * i + 1] = (float)stands;
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++)
                *image++ = (float)((stands ? x : y) % 4 < 2) + 0.3f * (float)lt_rng_normal(rng);
    }
}

/* ---- training ---------------------------------------------------------------------------------------------------- */

typedef struct {
    lt_graph *g;
    lt_tensor *image, *wanted, *loss;
    lt_plan *plan;
    lt_optim *adam;
} training;

static training training_new(const network *n)
{
    training t = { .g = lt_graph_new() };

    t.image = image_input(t.g, BATCH);
    t.wanted = lt_input(t.g, "wanted", LT_F32, 2, (int64_t[]){ BATCH, 2 });
    t.loss = lt_cross_entropy(network_forward(n, t.image), t.wanted, NULL);
    t.plan = lt_compile(t.g, &(lt_compile_opts){ .loss = t.loss, .train = true });
    if (!t.plan) {
        fprintf(stderr, "%s\n", lt_last_error());
        exit(1);
    }
    t.adam = lt_optim_new(n->params, &(lt_optim_opts){ .kind = LT_ADAM });
    return t;
}

/* Steps from where the optimiser is up to `until`. Each draws its batch by its own number, so that it does not matter
 * where training began. lt_optim_step moves the running statistics of the norm, too. */
static float train(const network *n, training *t, int until)
{
    while (lt_optim_steps(t->adam) < until) {
        lt_rng rng = lt_rng_make(1, (uint64_t)lt_optim_steps(t->adam));

        draw(&rng, lt_plan_data(t->plan, t->image), lt_plan_data(t->plan, t->wanted));
        lt_params_zero_grad(n->params);
        lt_run(t->plan);
        lt_optim_step(t->adam, 0.02, lt_optim_grad_norm(t->adam));
    }
    return *(float *)lt_plan_data(t->plan, t->loss);
}

static void training_free(training *t)
{
    lt_optim_free(t->adam);
    lt_plan_free(t->plan);
    lt_graph_free(t->g);
}

/* ---- saving and resuming ----------------------------------------------------------------------------------------- */

enum { MOST = 64 };

/* Parameters with running statistics, and what the optimiser remembers: all that the next step depends on */
static int collect(const network *n, const training *t, lt_named_array *list)
{
    int count = 0;

    for (lt_param *p = lt_params_first(n->params); p; p = p->next)
        list[count++] = (lt_named_array){ p->name, lt_array_make(LT_ELEM_F4, p->shape.rank, p->shape.dim, p->data) };
    for (int i = 0; i < lt_optim_state_count(t->adam); i++) {
        const lt_optim_state s = lt_optim_state_at(t->adam, i);

        list[count++] = (lt_named_array){ s.name, lt_array_make(LT_ELEM_F4, s.shape.rank, s.shape.dim, s.data) };
    }
    return count;
}

static lt_status save(const network *n, const training *t, const char *path)
{
    lt_named_array list[MOST];
    const int count = collect(n, t, list);
    char steps[32];

    snprintf(steps, sizeof(steps), "%lld", (long long)lt_optim_steps(t->adam));
    return lt_safetensors_write(path, list, (size_t)count, &(lt_text_pair){ "steps", steps }, 1);
}

/* Into a network and a training that were just made */
static lt_status resume(const network *n, training *t, const char *path)
{
    lt_arena *arena = lt_arena_new();
    lt_named_array list[MOST];
    const int count = collect(n, t, list);
    lt_safetensors file;
    lt_status st = lt_safetensors_read(arena, path, &file);

    for (int i = 0; st == LT_OK && i < count; i++) {
        const lt_array *a = lt_safetensors_find(&file, list[i].name);

        if (!a || a->type != LT_ELEM_F4 || !lt_array_has_shape(a, list[i].array.rank, list[i].array.shape))
            st = lt_error(LT_EFORMAT, "%s: has no such \"%s\"", path, list[i].name);
        else
            memcpy(list[i].array.data, a->data, lt_array_count(a) * sizeof(float));
    }
    if (st == LT_OK) {
        lt_optim_set_steps(t->adam, strtoll(lt_safetensors_meta(&file, "steps"), NULL, 10));
        lt_params_changed(n->params);           /* they were written by hand: plans fold them again */
    }
    lt_arena_free(arena);
    return st;
}

/* ---- at work ----------------------------------------------------------------------------------------------------- */

/* The share of right answers: the norm takes its running statistics, folded into the convolution. */
static double accuracy(const network *n)
{
    lt_graph *g = lt_graph_new();
    lt_tensor *image = image_input(g, BATCH), *scores = lt_output(network_forward(n, image), "scores");
    lt_plan *p = lt_compile(g, NULL);
    lt_rng rng = lt_rng_make(2, 0);
    float wanted[2 * BATCH];
    const float *s;
    int right = 0;

    draw(&rng, lt_plan_data(p, image), wanted);
    lt_run(p);
    s = lt_plan_data(p, scores);
    for (int i = 0; i < BATCH; i++)
        right += (s[2 * i + 1] > s[2 * i]) == (wanted[2 * i + 1] > 0);
    lt_plan_free(p);
    lt_graph_free(g);
    return right / (double)BATCH;
}

/* For any number of images: recorded for one and for two, what differs is the batch. */
static lt_status export(const network *n, const char *path)
{
    lt_arena *arena = lt_arena_new();
    lt_graph *one = lt_graph_new(), *two = lt_graph_new();
    lt_onnx_model m;
    lt_atomic_file f;
    lt_status st;

    lt_output(network_forward(n, image_input(one, 1)), "scores");
    lt_output(network_forward(n, image_input(two, 2)), "scores");
    st = lt_onnx_describe(arena, one, two, &m);
    if (st == LT_OK)
        st = lt_atomic_open(&f, path);
    if (st == LT_OK) {
        st = lt_onnx_write(f.stream, path, &m);
        if (st)
            lt_atomic_abort(&f);
        else
            st = lt_atomic_commit(&f);
    }
    lt_graph_free(one);
    lt_graph_free(two);
    lt_arena_free(arena);
    return st;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static void check(lt_status st)
{
    if (st) {
        fprintf(stderr, "%s\n", lt_last_error());
        exit(1);
    }
}

int main(void)
{
    network a = network_new(), b = network_new();
    training ta = training_new(&a), tb = training_new(&b);
    float through, resumed;

    lt_init_default(a.params, 1);
    printf("untrained %.2f\n", accuracy(&a));
    train(&a, &ta, STEPS / 2);
    check(save(&a, &ta, "half.safetensors"));
    through = train(&a, &ta, STEPS);
    check(resume(&b, &tb, "half.safetensors"));
    resumed = train(&b, &tb, STEPS);
    printf("loss %g, resumed %g: %s\n", (double)through, (double)resumed, through == resumed ? "equal" : "not equal");
    printf("trained %.2f\n", accuracy(&b));
    check(export(&b, "first.onnx"));
    training_free(&ta);
    training_free(&tb);
    lt_params_free(a.params);
    lt_params_free(b.params);
    return through != resumed;
}
