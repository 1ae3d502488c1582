/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/metrics/lpips_score.h"

#include "estimate/weights/weights.h"
#include "libtensor/graph/plan.h"
#include "models/parts/parts.h"

#include <string.h>

struct eval_lpips {
    const lpips *network;
    lpips own;
    lt_params *params;              /* of own; NULL: the network is somebody else's */
    lt_graph *g;
    lt_plan *plan;
    lt_tensor *image, *truth, *box, *raw01, *sym;
    int height, width;
};

bool eval_lpips_takes(int height, int width)
{
    return height >= ALEXNET_LEAST && width >= ALEXNET_LEAST && height <= LPIPS_MOST && width <= LPIPS_MOST;
}

const char *eval_lpips_name(const eval_lpips *s)
{
    return lpips_name(s->network);
}

/* ---- opening --------------------------------------------------------------------------------------------- */

static lt_status read_files(const eval_lpips_options *o, const model *m)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "no memory for the weights of LPIPS");
    weights_report report;

    for (int i = 0; i < o->n_files && !st; i++)
        st = weights_init(arena, o->file[i], m, &report);
    lt_arena_free(arena);
    return st;
}

static lt_status make_own(const eval_lpips_options *o, eval_lpips *s)
{
    const model m = { .cls = &lpips_class, .params = s->params = lt_params_new() };
    lt_status st;

    if (!s->params)
        return lt_error(LT_ENOMEM, "no memory for the weights of LPIPS");
    lpips_new(&s->own, s->params, "");
    st = lt_params_status(s->params);
    if (st)
        return st;
    lpips_init(&s->own);
    s->network = &s->own;
    return read_files(o, &m);
}

static lt_status make_plan(eval_lpips *s)
{
    const int64_t shape[] = { 1, 3, s->height, s->width };

    s->g = lt_graph_new();
    if (!s->g)
        return lt_last_status();
    s->image = lt_input(s->g, "image", LT_F32, 4, shape);
    s->truth = lt_input(s->g, "truth", LT_F32, 4, shape);
    s->box = lt_input(s->g, "box", LT_F32, 2, (int64_t[]){ 1, 4 });
    s->raw01 = lt_output(lpips_distance(s->network, LPIPS_RAW01, s->image, s->truth, s->box), "raw01");
    s->sym = lt_output(lpips_distance(s->network, LPIPS_SYM, s->image, s->truth, s->box), "sym");
    s->plan = lt_compile(s->g, &(lt_compile_opts){ 0 });
    return s->plan ? LT_OK : lt_last_status();
}

lt_status eval_lpips_new(const eval_lpips_options *o, eval_lpips **out)
{
    eval_lpips *s = lt_alloc(sizeof(*s));
    lt_status st = LT_OK;

    *out = NULL;
    if (!s)
        return lt_error(LT_ENOMEM, "no memory for LPIPS");
    *s = (eval_lpips){ .network = o->network, .height = o->height, .width = o->width };
    if (o->n_files || !o->network)
        st = make_own(o, s);
    if (!st)
        st = make_plan(s);
    if (st)
        eval_lpips_free(s);
    else
        *out = s;
    return st;
}

void eval_lpips_free(eval_lpips *s)
{
    if (!s)
        return;
    lt_plan_free(s->plan);
    lt_graph_free(s->g);
    lt_params_free(s->params);
    lt_release(s);
}

/* ---- scoring --------------------------------------------------------------------------------------------- */

/* One picture into the upper left of the graph's */
static void put(const eval_lpips *s, const eval_pictures *p, const float *from, lt_tensor *to)
{
    lt_real *x = lt_plan_data(s->plan, to);

    memset(x, 0, lt_nbytes(to));
    for (int c = 0; c < 3; c++)
        for (int64_t i = 0; i < (int64_t)p->height * p->width; i++)
            x[((int64_t)c * s->height + i / p->width) * s->width + i % p->width] =
                (lt_real)from[c * p->plane + i / p->width * p->row + i % p->width];
}

static double thousandfold(const eval_lpips *s, const lt_tensor *distance)
{
    return 1e3 * (double)*(const lt_real *)lt_plan_data(s->plan, distance);
}

eval_lpips_scores eval_lpips_score(const eval_lpips *s, const eval_pictures *p)
{
    const lt_real box[4] = { 0, 0, (lt_real)p->width, (lt_real)p->height };

    put(s, p, p->a, s->image);
    put(s, p, p->b, s->truth);
    memcpy(lt_plan_data(s->plan, s->box), box, sizeof(box));
    lt_run(s->plan);
    return (eval_lpips_scores){ .raw01 = thousandfold(s, s->raw01), .sym = thousandfold(s, s->sym) };
}
