/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/export/meta.h"

#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/onnx/onnx.h"

#include <config.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { GRID = 64 };                 /* the finest grid of a drawn map */

/* ---- what the file says of itself --------------------------------------------------------------------------- */

enum { MAX_META = 24 };

typedef struct {
    lt_arena *arena;
    lt_onnx_text list[MAX_META];
    int n;
    bool failed;                    /* no memory */
} meta;

static void add(meta *m, const char *key, const char *value)
{
    m->failed |= value == NULL;
    m->list[m->n++] = (lt_onnx_text){ key, value };
}

static const char *three(lt_arena *arena, const double *x, double fallback)
{
    return lt_arena_printf(arena, "%g, %g, %g", x ? x[0] : fallback, x ? x[1] : fallback, x ? x[2] : fallback);
}

/* A square's side; else height and width */
static const char *image_size(lt_arena *arena, const model_record *r, int side)
{
    const lt_tensor *image = model_port_find(&r->inputs, "image");

    if (!image || lt_dim(image, 2) == lt_dim(image, 3))
        return lt_arena_printf(arena, "%d", side);
    return lt_arena_printf(arena, "%d, %d", (int)lt_dim(image, 2), (int)lt_dim(image, 3));
}

static void describe_image(meta *m, const model *mo, const model_record *r)
{
    add(m, "image.layout", "NCHW");
    add(m, "image.color", "RGB");
    add(m, "image.size", image_size(m->arena, r, mo->image_size));
    add(m, "image.range", "0, 1");
    add(m, "image.mean", three(m->arena, mo->cls->mean, 0));
    add(m, "image.std", three(m->arena, mo->cls->deviation, 1));
    if (!mo->depth)
        return;
    add(m, "depth.layout", "NCHW, one channel, the image's pixels");
    add(m, "depth.value", "(metres - the median over the object, or over the crop's middle third where its mask is not "
        "known) / 0.3, cut to -1 .. 1");
    add(m, "depth.unknown", "1");
}

static void describe_hand(meta *m, const char *hand_name)
{
    add(m, "boxes", "x0, y0, x1, y1 in pixels of the image");
    add(m, "axes", "camera: x right, y down, z forward");
    add(m, "joints", "wrist, thumb_cmc, thumb_mcp, thumb_ip, thumb_tip, index_mcp, index_pip, index_dip, index_tip, "
        "middle_mcp, middle_pip, middle_dip, middle_tip, ring_mcp, ring_pip, ring_dip, ring_tip, little_mcp, "
        "little_pip, little_dip, little_tip");
    add(m, "joints.unit", "metres from the wrist");
    add(m, "joints2d.unit", "sides of hand_box from its corner x0, y0");
    add(m, "peak.unit", "the highest cell of each joint's heat map, whose cells sum to 1");
    add(m, "points", "21 control points of the object's bounding box; a cell's confidence and place");
    add(m, "points.unit", "sides of object_box from its corner x0, y0");
    add(m, "hand", export_text(m->arena, hand_name));
}

static lt_status describe(const export_options *o, lt_arena *arena, const model_record *r, lt_onnx_model *out)
{
    meta *m = lt_arena_alloc(arena, sizeof(*m));

    if (!m)
        return lt_error(LT_ENOMEM, "no memory to export");
    m->arena = arena;
    add(m, "model", o->m->cls->name);
    add(m, "variant", o->m->variant);
    add(m, "paper", o->m->cls->paper);
    add(m, "config", export_config(arena, o->m));
    describe_image(m, o->m, r);
    if (o->m->hand)
        describe_hand(m, o->hand_name ? o->hand_name : "");
    out->name = o->m->cls->name;
    out->producer = "palmar";
    out->version = PACKAGE_VERSION;
    out->meta = m->list;
    out->n_meta = m->n;
    return m->failed ? lt_error(LT_ENOMEM, "no memory to export") : LT_OK;
}

/* ---- writing ---------------------------------------------------------------------------------------------------- */

static lt_status record(const model *m, int batch, model_record *r)
{
    *r = (model_record){ .g = lt_graph_new(), .batch = batch, .whole_maps = true };
    if (!r->g)
        return LT_ENOMEM;
    m->cls->record(m, false, r);
    return lt_graph_status(r->g);
}

/* For any batch: recorded for one and for two images; what differs is the batch. */
static lt_status make_model(const export_options *o, lt_arena *arena, model_record *r, lt_onnx_model *out)
{
    model_record twin = { .g = NULL };
    lt_status st = record(o->m, o->batch ? o->batch : 1, r);

    if (st == LT_OK && !o->batch)
        st = record(o->m, 2, &twin);
    if (st == LT_OK)
        st = lt_onnx_describe(arena, r->g, twin.g, out);
    if (st == LT_OK)
        st = describe(o, arena, r, out);
    lt_graph_free(twin.g);
    return st;
}

static lt_status write_beside(const export_options *o, lt_arena *arena, lt_atomic_file *f, export_report *report)
{
    model_record r = { .g = NULL };
    lt_onnx_model m;
    lt_status st = make_model(o, arena, &r, &m);

    if (st == LT_OK)
        st = lt_onnx_write(f->stream, f->path, &m);
    if (st == LT_OK && fflush(f->stream))
        st = lt_error(lt_errno_status(errno), "%s: cannot write: %s", f->path, strerror(errno));
    if (st == LT_OK) {
        report->operators = m.n_nodes;
        report->opset = (int)m.opset;
        report->any_batch = !o->batch;
        report->bytes = (size_t)ftell(f->stream);
    }
    lt_graph_free(r.g);
    return st;
}

/* ---- reading back ------------------------------------------------------------------------------------------------ */

/* The model, and the file as a graph, side by side */
typedef struct {
    model_record ours;
    lt_graph *theirs;
    lt_plan *our_plan, *other_plan, *their_plan;        /* the other one neither folds nor fuses: it rounds elsewhere */
    lt_onnx_ports ports;
    lt_onnx_model file;
    double largest[MODEL_PORTS];    /* magnitude of each output */
    double rounding[MODEL_PORTS];   /* its largest difference between our two plans */
    lt_arena *arena;
    lt_named_array sample[2 * MODEL_PORTS];     /* inputs and our outputs of all runs, when someone wants them */
    size_t n_samples;
} pair;

static lt_status compile(lt_graph *g, bool no_fusion, lt_plan **out)
{
    *out = lt_compile(g, &(lt_compile_opts){ .no_fusion = no_fusion });
    return *out ? LT_OK : lt_last_status();
}

static lt_status open_pair(const export_options *o, lt_arena *arena, const char *path, int batch, pair *p)
{
    lt_status st = lt_onnx_read(arena, path, &p->file);

    p->theirs = lt_graph_new();
    if (st == LT_OK && !p->theirs)
        st = lt_last_status();
    if (st == LT_OK)
        st = lt_onnx_import(arena, p->theirs, &p->file, batch, &p->ports);
    if (st == LT_OK)
        st = record(o->m, batch, &p->ours);
    if (st == LT_OK)
        st = compile(p->theirs, false, &p->their_plan);
    if (st == LT_OK)
        st = compile(p->ours.g, true, &p->other_plan);
    return st ? st : compile(p->ours.g, false, &p->our_plan);
}

static void close_pair(pair *p)
{
    lt_plan_free(p->our_plan);
    lt_plan_free(p->other_plan);
    lt_plan_free(p->their_plan);
    lt_graph_free(p->ours.g);
    lt_graph_free(p->theirs);
}

/* Add a grid of n x n drawn numbers, blown up to a plane of h x w between its cells' centres, times weight. */
static void add_grid(lt_rng *rng, int n, double weight, int64_t h, int64_t w, lt_real *plane)
{
    double grid[GRID][GRID];

    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            grid[i][k] = lt_rng_uniform(rng);
    for (int64_t r = 0; r < h; r++)
        for (int64_t c = 0; c < w; c++) {
            const double y = fmin(fmax(((double)r + .5) / (double)h * n - .5, 0), n - 1);
            const double x = fmin(fmax(((double)c + .5) / (double)w * n - .5, 0), n - 1);
            const int i = (int)fmin(y, n - 2), k = (int)fmin(x, n - 2);
            const double v = y - i, u = x - k;

            plane[r * w + c] += (lt_real)(weight * ((1 - v) * ((1 - u) * grid[i][k] + u * grid[i][k + 1])
                                                    + v * ((1 - u) * grid[i + 1][k] + u * grid[i + 1][k + 1])));
        }
}

/* As pictures are, between 0 and 1: each finer grid counts half of the one before. */
static void fill_map(const lt_tensor *t, lt_rng *rng, lt_real *x)
{
    const int64_t h = lt_dim(t, -2), w = lt_dim(t, -1);
    double whole = 0;

    memset(x, 0, lt_nbytes(t));
    for (int n = 2; n <= GRID; n *= 2)
        whole += 1. / n;
    for (int64_t plane = 0; plane < lt_numel(t) / (h * w); plane++)
        for (int n = 2; n <= GRID; n *= 2)
            add_grid(rng, n, 1. / n / whole, h, w, x + plane * h * w);
}

/* Maps as pictures are, boxes inside the image, everything else between 0 and 1 */
static void fill_input(const model *m, const model_port *port, lt_rng *rng, lt_real *x)
{
    const double S = m->image_size;

    if (port->tensor->shape.rank == 4) {
        fill_map(port->tensor, rng, x);
        return;
    }
    for (int64_t i = 0; i < lt_numel(port->tensor); i++)
        x[i] = (lt_real)lt_rng_uniform(rng);
    if (!strstr(port->name, "_box"))
        return;
    for (int64_t i = 0; i + 4 <= lt_numel(port->tensor); i += 4)
        for (int k = 0; k < 2; k++) {
            x[i + k] = (lt_real)lt_rng_range(rng, 0, 0.5 * S);
            x[i + 2 + k] = (lt_real)(x[i + k] + lt_rng_range(rng, 0.1, 0.5) * S);
        }
}

static lt_status fill_pair(const export_options *o, pair *p, lt_rng *rng)
{
    for (int i = 0; i < p->file.n_inputs; i++) {
        lt_tensor *ours = model_port_find(&p->ours.inputs, p->file.input[i].name);
        lt_real *x = ours ? lt_plan_data(p->our_plan, ours) : NULL, *y = lt_plan_data(p->their_plan, p->ports.input[i]);

        if (!x || !y || !lt_same_shape(&ours->shape, &p->ports.input[i]->shape))
            return lt_error(LT_EFORMAT, "the file's input \"%s\" is not the model's", p->file.input[i].name);
        fill_input(o->m, &(model_port){ p->file.input[i].name, ours }, rng, x);
        memcpy(y, x, lt_nbytes(ours));
        memcpy(lt_plan_data(p->other_plan, ours), x, lt_nbytes(ours));
    }
    return LT_OK;
}

static const lt_tensor *their_output(const pair *p, const char *name)
{
    for (int i = 0; i < p->file.n_outputs; i++)
        if (strcmp(p->file.output[i].name, name) == 0)
            return p->ports.output[i];
    return NULL;
}

static lt_status compare(pair *p, export_report *report)
{
    for (int i = 0; i < report->n_outputs; i++) {
        export_difference *d = &report->output[i];
        const lt_tensor *ours = p->ours.outputs.port[i].tensor, *theirs = their_output(p, d->name);
        const lt_real *x, *y, *z;

        if (!theirs || !lt_same_shape(&ours->shape, &theirs->shape))
            return lt_error(LT_EFORMAT, "the file's output \"%s\" is not the model's", d->name);
        x = lt_plan_data(p->our_plan, ours);
        y = lt_plan_data(p->their_plan, theirs);
        z = lt_plan_data(p->other_plan, ours);
        for (int64_t k = 0; k < lt_numel(ours); k++) {
            const double difference = fabs((double)x[k] - (double)y[k]);

            d->absolute = difference <= d->absolute ? d->absolute : difference;         /* NaN stays */
            p->largest[i] = fmax(p->largest[i], fabs((double)x[k]));
            p->rounding[i] = fmax(p->rounding[i], fabs((double)x[k] - (double)z[k]));
        }
    }
    return LT_OK;
}

static lt_status judge(const pair *p, const char *path, export_report *report)
{
    lt_status st = LT_OK;

    for (int i = 0; i < report->n_outputs; i++) {
        export_difference *d = &report->output[i];
        const double largest = p->largest[i] > 0 ? p->largest[i] : 1;
        double most;

        d->relative = d->absolute / largest;
        d->rounding = p->rounding[i] / largest;
        most = fmin(fmax(EXPORT_TOLERANCE, EXPORT_ROUNDINGS * d->rounding), EXPORT_MOST);
        if (!(d->relative <= most) && st == LT_OK)
            st = lt_error(LT_ENUMERIC, "%s: output \"%s\" differs from the model's by %.1e of its largest value, want "
                          "at most %.1e (the model's own rounding makes %.1e); nothing was written", path, d->name,
                          d->relative, most, d->rounding);
    }
    return st;
}

/* ---- what others can compare with ------------------------------------------------------------------------------ */

static lt_status keep_ports(pair *p, const model_ports *ports, int runs, int run)
{
    for (int i = 0; i < ports->n; i++) {
        const lt_tensor *t = ports->port[i].tensor;
        lt_named_array *s = &p->sample[p->n_samples++];
        const lt_shape shape = t->shape;

        if (run == 0) {
            void *data = lt_arena_array(p->arena, (size_t)runs, lt_nbytes(t));

            if (!data)
                return lt_error(LT_ENOMEM, "no memory to keep \"%s\"", ports->port[i].name);
            s->name = ports->port[i].name;
            s->array = lt_array_make(LT_ELEM_F4, shape.rank, shape.dim, data);
            s->array.shape[0] *= runs;
        }
        memcpy((char *)s->array.data + (size_t)run * lt_nbytes(t), lt_plan_data(p->our_plan, t), lt_nbytes(t));
    }
    return LT_OK;
}

/* The first dimension of inputs and outputs is the sample: runs follow each other. */
static lt_status keep_samples(pair *p, int runs, int run)
{
    lt_status st;

    p->n_samples = 0;
    st = keep_ports(p, &p->ours.inputs, runs, run);
    return st ? st : keep_ports(p, &p->ours.outputs, runs, run);
}

static lt_status run_pair(const export_options *o, int batch, pair *p, export_report *report)
{
    const int runs = (EXPORT_INPUTS + batch - 1) / batch;
    lt_rng rng = lt_rng_make(16, 0);
    lt_status st = LT_OK;

    report->n_outputs = p->ours.outputs.n;
    for (int i = 0; i < report->n_outputs; i++)
        report->output[i].name = p->ours.outputs.port[i].name;
    for (int run = 0; st == LT_OK && run < runs; run++) {
        st = fill_pair(o, p, &rng);
        if (st)
            break;
        lt_run(p->our_plan);
        lt_run(p->other_plan);
        lt_run(p->their_plan);
        st = compare(p, report);
        if (st == LT_OK && o->samples)
            st = keep_samples(p, runs, run);
    }
    return st;
}

static lt_status check(const export_options *o, lt_arena *arena, const lt_atomic_file *f, export_report *report)
{
    const int batch = o->batch ? o->batch : 4;
    pair p = { .arena = arena };
    lt_status st = open_pair(o, arena, f->temp, batch, &p);

    if (st == LT_OK)
        st = run_pair(o, batch, &p, report);
    if (st == LT_OK)
        st = judge(&p, f->path, report);
    if (st == LT_OK && o->samples)
        st = lt_npz_write(o->samples, p.sample, p.n_samples, false);
    close_pair(&p);
    return st;
}

lt_status export_onnx(const export_options *o, const char *path, export_report *report)
{
    lt_arena *arena = lt_arena_new();
    lt_atomic_file f;
    lt_status st;

    *report = (export_report){ .n_outputs = 0 };
    if (!arena)
        return lt_error(LT_ENOMEM, "no memory to export");
    st = lt_atomic_open(&f, path);
    if (st == LT_OK) {
        st = write_beside(o, arena, &f, report);
        if (st == LT_OK)
            st = check(o, arena, &f, report);
        if (st)
            lt_atomic_abort(&f);
        else
            st = lt_atomic_commit(&f);
    }
    lt_arena_free(arena);
    return st;
}
