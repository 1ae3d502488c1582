/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/ops/onnx_way.h"

#include "libtensor/graph/plan.h"
#include "libtensor/io/onnx/onnx.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Parts of a loss, which a model at work has none of, what leaves out cells that no box reads, which a model is
 * exported without, rows of a parameter that grows, Gaussians, which ONNX cannot draw, and what only HOGS works with:
 * points and what is sampled at them. */
static const char *const without[] = {
    "mse_loss", "l1_loss", "cross_entropy", "sum", "confidence_target", "heatmap_loss", "volume_loss",
    "conv2d_within", "window_means", "rows", "transform_points", "transform_back", "splat_axes", "splat_covariance",
    "quaternion_turn",
    "sh_colour", "nearest_rotation", "isometry_loss", "splat_raster", "smooth_l1_loss", "ssim_loss", "max",
    "detect_assign", "detect_class_loss", "detect_box_loss", "detect_mask_loss",
    "farthest_point_sampling", "ball_query", "nearest", "unit_sphere", "gather", "group", "hash_grid", "one_blob",
    "sample_rows",
};

static bool may_be_without(const op_suite *s)
{
    for (size_t i = 0; i < LT_COUNT(without); i++)
        if (strcmp(without[i], s->name) == 0)
            return true;
    return false;
}

typedef struct {
    lt_graph *g;
    lt_tensor *in[OP_INPUTS], *out[LT_MAX_OUT];
    int n_out;
    bool empty;                     /* a tensor has no elements: 0 in a shape means another thing there */
} recorded;

static recorded record(const op_case *c)
{
    recorded r = { .g = lt_graph_new() };
    lt_tensor *out;
    char name[16];

    for (int i = 0; i < OP_INPUTS; i++) {
        if (c->in[i].role == OP_NONE)
            continue;
        snprintf(name, sizeof(name), "in%d", i);
        r.in[i] = lt_input(r.g, name, LT_F32, c->in[i].shape.rank, c->in[i].shape.dim);
        r.empty |= lt_numel(r.in[i]) == 0;
    }
    out = c->build(r.in);
    r.n_out = out->node->n_out;
    for (int i = 0; i < r.n_out; i++) {
        snprintf(name, sizeof(name), "out%d", i);
        r.out[i] = lt_output(lt_result(out, i), name);
        r.empty |= lt_numel(r.out[i]) == 0;
    }
    check_ok(lt_graph_status(r.g));
    return r;
}

/* The bytes of its file */
static lt_status write_file(lt_arena *arena, const lt_graph *g, uint8_t **out, size_t *n)
{
    lt_onnx_model m;
    char *bytes;
    FILE *f;
    lt_status st = lt_onnx_describe(arena, g, NULL, &m);

    if (st)
        return st;
    f = open_memstream(&bytes, n);
    st = lt_onnx_write(f, "op", &m);
    fclose(f);
    *out = lt_arena_alloc(arena, *n);
    memcpy(*out, bytes, *n);
    free(bytes);
    return st;
}

static lt_status read_file(lt_arena *arena, const uint8_t *bytes, size_t n, lt_graph *to, lt_onnx_model *m,
                           lt_onnx_ports *ports)
{
    const lt_status st = lt_onnx_parse(arena, "op", bytes, n, m);

    return st ? st : lt_onnx_import(arena, to, m, 1, ports);
}

/* There and back */
static lt_status go(lt_arena *arena, const lt_graph *from, lt_graph *to, lt_onnx_model *m, lt_onnx_ports *ports)
{
    uint8_t *bytes;
    size_t n;
    const lt_status st = write_file(arena, from, &bytes, &n);

    return st ? st : read_file(arena, bytes, n, to, m, ports);
}

/* Whatever a few wrong bytes make of the file: an error, or another graph, but never the program's end */
static void damage(const lt_graph *g)
{
    enum { TIMES = 300, BYTES = 2 };
    lt_arena *arena = lt_arena_new();
    lt_rng rng = lt_rng_make(3, 0);
    uint8_t *bytes;
    size_t n;

    for (int k = 0; k < TIMES && write_file(arena, g, &bytes, &n) == LT_OK; k++) {
        lt_arena *one = lt_arena_new();
        lt_graph *to = lt_graph_new();
        lt_onnx_model m;
        lt_onnx_ports ports;

        for (int i = 0; i < BYTES; i++)
            bytes[lt_rng_u32(&rng) % n] ^= (uint8_t)(1u << lt_rng_u32(&rng) % 8);
        if (read_file(one, bytes, n, to, &m, &ports))
            ck_assert(*lt_last_error());
        lt_graph_free(to);
        lt_arena_free(one);
    }
    lt_arena_free(arena);
}

static lt_tensor *port(const lt_onnx_port *list, int n, lt_tensor **t, const char *name)
{
    for (int i = 0; i < n; i++)
        if (strcmp(list[i].name, name) == 0)
            return t[i];
    return NULL;
}

static void fill_both(const op_case *c, const recorded *r, lt_plan *ours, lt_plan *theirs, const lt_onnx_model *m,
                      const lt_onnx_ports *ports)
{
    const op_fill_fn fill = c->fill ? c->fill : fill_clear_of_zero;

    for (int i = 0; i < OP_INPUTS; i++) {
        lt_tensor *t = r->in[i] ? port(m->input, m->n_inputs, ports->input, r->in[i]->name) : NULL;
        lt_rng rng = lt_rng_make(9, (uint64_t)i);

        if (!r->in[i])
            continue;
        fill(c, i, lt_plan_data(ours, r->in[i]), lt_numel(r->in[i]), &rng);
        if (t && lt_plan_data(theirs, t))
            memcpy(lt_plan_data(theirs, t), lt_plan_data(ours, r->in[i]), lt_nbytes(t));
    }
}

static void compare(const op_suite *s, const op_case *c, const lt_real *a, const lt_real *b, int64_t n)
{
    double largest = 0, worst = 0;

    for (int64_t i = 0; i < n; i++) {
        if (!isfinite(a[i]) || !isfinite(b[i])) {
            ck_assert_msg(a[i] == b[i] || (isnan(a[i]) && isnan(b[i])), "%s %s: %g, want %g", s->name, c->name,
                          (double)b[i], (double)a[i]);
            continue;
        }
        largest = fmax(largest, fabs((double)a[i]));
        worst = fmax(worst, fabs((double)a[i] - (double)b[i]));
    }
    ck_assert_msg(worst <= 1e-5 * fmax(largest, 1e-3), "%s %s: through ONNX differs by %g of at most %g", s->name,
                  c->name, worst, largest);
}

void check_onnx_way(const op_suite *s, const op_case *c)
{
    recorded r = record(c);
    lt_arena *arena = lt_arena_new();
    lt_graph *g = lt_graph_new();
    lt_onnx_model m;
    lt_onnx_ports ports;
    const lt_status st = r.empty ? LT_OK : go(arena, r.g, g, &m, &ports);

    ck_assert_msg(st == LT_OK || may_be_without(s), "%s %s: %s", s->name, c->name, lt_last_error());
    if (!r.empty)
        damage(r.g);
    if (st == LT_OK && !r.empty) {
        lt_plan *ours = lt_compile(r.g, NULL), *theirs = lt_compile(g, NULL);

        ck_assert_msg(ours && theirs, "%s", lt_last_error());
        fill_both(c, &r, ours, theirs, &m, &ports);
        lt_run(ours);
        lt_run(theirs);
        for (int i = 0; i < r.n_out; i++) {
            lt_tensor *t = port(m.output, m.n_outputs, ports.output, r.out[i]->name);

            ck_assert_msg(t && lt_same_shape(&t->shape, &r.out[i]->shape), "%s %s: output %d", s->name, c->name, i);
            compare(s, c, lt_plan_data(ours, r.out[i]), lt_plan_data(theirs, t), lt_numel(t));
        }
        lt_plan_free(ours);
        lt_plan_free(theirs);
    }
    lt_graph_free(g);
    lt_graph_free(r.g);
    lt_arena_free(arena);
}
