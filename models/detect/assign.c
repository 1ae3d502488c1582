/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/assign.h"

#include "libtensor/base/parallel.h"

#include <math.h>

enum { BOX, CLS = DETECT_LEVELS, OBJECTS = 2 * DETECT_LEVELS, INPUTS };
enum { TOP = 10 };

static lt_status infer(lt_call *c)
{
    if (cells_check(c, "boxes", DETECT_SIDES * DETECT_BINS) || lt_want_rank(c, OBJECTS, "objects", 3))
        return LT_ESHAPE;
    for (int i = 0; i < DETECT_LEVELS; i++)
        if (lt_want_shape(c, CLS + i, "classes", LT_SHAPE(lt_dim(c->in[i], 0), lt_dim(c->in[CLS], 1),
                                                          lt_dim(c->in[i], 2), lt_dim(c->in[i], 3))))
            return LT_ESHAPE;
    if (lt_want_shape(c, OBJECTS, "objects", LT_SHAPE(lt_dim(c->in[BOX], 0), lt_dim(c->in[OBJECTS], 1),
                                                      OBJECT_NUMBERS)))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(lt_dim(c->in[BOX], 0), cells_of(c), ASSIGNED_NUMBERS);
    return LT_OK;
}

/* What a cell's box is to an object */
typedef struct {
    int64_t cell;
    double metric, iou, alpha;
} match;

/* Of an object: its best cells, the best first */
typedef struct {
    match list[TOP];
    int n;
} best_cells;

/* The boxes that the cells of an image see, and the best of them for each object */
static size_t image_bytes(const lt_call *c)
{
    return (size_t)cells_of(c) * sizeof(ciou_box) + (size_t)lt_dim(c->in[OBJECTS], 1) * sizeof(best_cells);
}

static void plan(lt_call *c)
{
    c->work_bytes = (size_t)lt_dim(c->in[BOX], 0) * image_bytes(c);
}

static void insert(best_cells *to, const match *m)
{
    int at = to->n;

    while (at > 0 && m->metric > to->list[at - 1].metric)
        at--;
    if (at == TOP)
        return;
    to->n += to->n < TOP;
    for (int i = to->n - 1; i > at; i--)
        to->list[i] = to->list[i - 1];
    to->list[at] = *m;
}

static double score_of(const lt_call *c, int64_t b, const cell *at, int64_t cls)
{
    const lt_tensor *map = c->in[CLS + at->level];
    const lt_real logit = ((const lt_real *)map->data)[(b * lt_dim(map, 1) + cls) * at->plane + at->at];

    return 1 / (1 + exp(-(double)logit));
}

/* The first of the cells along an axis whose centre lies behind lo */
static int64_t first_behind(double lo)
{
    return lo < 0.5 ? 0 : (int64_t)floor(lo - 0.5) + 1;
}

/* The cells of a level, whose first is number `first` of all, with their centres inside the object's box */
static void match_level(const lt_call *c, int64_t b, const lt_real *object, int64_t first, int level,
                          const ciou_box *seen, best_cells *out)
{
    const int64_t h = lt_dim(c->in[level], 2), w = lt_dim(c->in[level], 3);
    const ciou_box truth = object_box(object, 8 << level);

    for (int64_t y = first_behind(truth.v[1]); y < h && (double)y + 0.5 < truth.v[3]; y++)
        for (int64_t x = first_behind(truth.v[0]); x < w && (double)x + 0.5 < truth.v[2]; x++) {
            const int64_t i = first + y * w + x;
            const cell at = cell_at(c, i);
            match m = { .cell = i };

            m.iou = fmax(0, ciou(&seen[i], &truth, &m.alpha));
            m.metric = sqrt(score_of(c, b, &at, (int64_t)object[OBJECT_CLASS])) * pow(m.iou, 6);
            if (m.metric > 0)
                insert(out, &m);
        }
}

static void match_object(const lt_call *c, int64_t b, const lt_real *object, const ciou_box *seen,
                         best_cells *out)
{
    int64_t first = 0;

    for (int level = 0; level < DETECT_LEVELS; level++) {
        match_level(c, b, object, first, level, seen, out);
        first += lt_dim(c->in[level], 2) * lt_dim(c->in[level], 3);
    }
}

/* A cell that is among the best of two objects goes to the one that it overlaps more, the first where they are
 * alike. */
static void resolve(const best_cells *best, int64_t n, lt_real *assigned)
{
    for (int64_t g = 0; g < n; g++)
        for (int k = 0; k < best[g].n; k++) {
            const match *m = &best[g].list[k];
            lt_real *t = assigned + m->cell * ASSIGNED_NUMBERS;

            if (t[ASSIGNED_OBJECT] >= 0 && t[ASSIGNED_SCORE] >= (lt_real)m->iou)
                continue;
            t[ASSIGNED_OBJECT] = (lt_real)g;
            t[ASSIGNED_SCORE] = (lt_real)m->iou;        /* scaled below, once all of the object's are known */
            t[ASSIGNED_ALPHA] = (lt_real)m->alpha;
        }
}

/* The scores of the cells that an object keeps */
static void score(const best_cells *from, int64_t g, lt_real *assigned)
{
    double metric = 0, iou = 0;

    for (int k = 0; k < from->n; k++)
        if (assigned[from->list[k].cell * ASSIGNED_NUMBERS] == (lt_real)g) {
            metric = fmax(metric, from->list[k].metric);
            iou = fmax(iou, from->list[k].iou);
        }
    for (int k = 0; k < from->n; k++) {
        lt_real *t = assigned + from->list[k].cell * ASSIGNED_NUMBERS;

        if (t[ASSIGNED_OBJECT] == (lt_real)g)
            t[ASSIGNED_SCORE] = (lt_real)(from->list[k].metric / metric * iou);
    }
}

static void assign_image(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const int64_t n = cells_of(c), G = lt_dim(c->in[OBJECTS], 1);
    ciou_box *seen = (ciou_box *)((char *)c->work + (size_t)b * image_bytes(c));
    best_cells *best = (best_cells *)(seen + n);
    lt_real *assigned = (lt_real *)c->out->data + b * n * ASSIGNED_NUMBERS;

    for (int64_t i = 0; i < n; i++) {
        const cell at = cell_at(c, i);

        seen[i] = cell_box(&at, cell_values(c, b, &at), NULL);
        assigned[i * ASSIGNED_NUMBERS + ASSIGNED_OBJECT] = -1;
        assigned[i * ASSIGNED_NUMBERS + ASSIGNED_SCORE] = assigned[i * ASSIGNED_NUMBERS + ASSIGNED_ALPHA] = 0;
    }
    for (int64_t g = 0; g < G; g++) {
        const lt_real *object = object_at(c->in[OBJECTS], b, g);

        best[g].n = 0;
        if (object && object[OBJECT_CLASS] < (lt_real)lt_dim(c->in[CLS], 1))
            match_object(c, b, object, seen, &best[g]);
    }
    resolve(best, G, assigned);
    for (int64_t g = 0; g < G; g++)
        score(&best[g], g, assigned);
}

static void forward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->in[BOX], 0), assign_image, (void *)c);
}

static const lt_op detect_assign_op = {
    .name = "detect_assign", .flags = LT_OP_DETACH, .infer = infer, .plan = plan, .forward = forward,
};

lt_tensor *(detect_assign)(const detect_maps *maps, lt_tensor *objects)
{
    lt_tensor *in[INPUTS];

    for (int i = 0; i < DETECT_LEVELS; i++) {
        in[BOX + i] = maps->box[i];
        in[CLS + i] = maps->cls[i];
    }
    in[OBJECTS] = objects;
    return lt_apply(&detect_assign_op, NULL, 0, in, INPUTS);
}

const lt_real *assigned_at(const lt_tensor *assigned, int64_t b, int64_t i)
{
    return (const lt_real *)assigned->data + (b * lt_dim(assigned, 1) + i) * ASSIGNED_NUMBERS;
}
