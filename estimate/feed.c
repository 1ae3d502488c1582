/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/feed.h"

#include "estimate/protocol.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/io/file.h"

#include <string.h>

/* A field of the batch: its first float, and floats a sample. */
typedef struct {
    const float *data;
    int64_t size;
} field;

static bool find_field(const hand_object_batch *b, const char *name, field *out)
{
    const int64_t pixels = (int64_t)b->size * b->size, cells = (int64_t)b->cells * b->cells;
    const struct { const char *name; field f; } known[] = {
        { "image", { b->image, 3 * pixels } },
        { "depth", { b->depth, pixels } },
        { "hand_box", { b->hand_box, 4 } },
        { "object_box", { b->object_box, 4 } },
        { "joints2d", { b->joints2d, 2 * LT_HAND_KEYPOINTS } },
        { "rotation", { b->rotation, 9 * LT_HAND_JOINTS } },
        { "beta", { b->beta, LT_HAND_BETAS } },
        { "points2d", { b->points2d, 2 * LT_BOX_POINTS } },
        { "mask", { b->mask, cells } },
        { "weight", { b->weight, 1 } },
        { "object_weight", { b->object_weight, 1 } },
    };

    for (size_t i = 0; i < LT_COUNT(known); i++)
        if (strcmp(known[i].name, name) == 0) {
            *out = known[i].f;
            return true;
        }
    return false;
}

void feed_options(const model *m, hand_object_options *o)
{
    o->size = m->image_size;
    o->cells = m->cells;
    o->crop = protocol_of(m)->crop;
    o->depth = m->depth || (m->depth_fit && !o->augment);
}

lt_status feed_check(const model_record *r)
{
    const lt_tensor *image = model_port_find(&r->inputs, "image");
    const lt_tensor *mask = model_port_find(&r->inputs, "mask");
    const hand_object_batch like = {
        .size = image ? (int)lt_dim(image, -1) : 0, .cells = mask ? (int)lt_dim(mask, -1) : 0,
    };

    for (int i = 0; i < r->inputs.n; i++) {
        const model_port *p = &r->inputs.port[i];
        field f;

        if (!find_field(&like, p->name, &f))
            return lt_error(LT_EINVAL, "the model wants an input \"%s\", which hand-object data do not have",
                            p->name);
        if (f.size * r->batch != lt_numel(p->tensor))
            return lt_error(LT_EINVAL, "the model's input \"%s\" has %lld numbers for %d samples, the data "
                            "have %lld", p->name, (long long)lt_numel(p->tensor), r->batch,
                            (long long)f.size * r->batch);
    }
    return LT_OK;
}

int feed_parts(const model *m, int batch)
{
    enum { FEW_WEIGHTS = 1 << 24 };
    const bool pays = lt_params_count(m->params, LT_WEIGHT, "") < FEW_WEIGHTS;

    return pays && batch % COMPILED_MAX_PARTS == 0 ? COMPILED_MAX_PARTS : 1;
}

static bool counts(const hand_object_batch *b, int slot)
{
    return slot < b->count && b->weight[slot] > 0;
}

/* Slots [first, first + n) */
typedef struct { int first, n; } slots;

static double weight_of(const hand_object_batch *b, slots r)
{
    double total = 0;

    for (int i = r.first; i < r.first + r.n; i++)
        total += counts(b, i) ? (double)b->weight[i] : 0;
    return total;
}

/* The sample that stands in a slot: its own, or the next one round among all that counts. */
static int sample_for(const hand_object_batch *b, slots all, int slot)
{
    for (int k = 0; k < all.n; k++) {
        const int s = all.first + (slot - all.first + k) % all.n;

        if (counts(b, s))
            return s;
    }
    return slot;
}

static void copy_port(const lt_plan *p, const model_port *port, const hand_object_batch *b, slots all, slots part)
{
    lt_real *to = lt_plan_data(p, port->tensor);
    const bool weight = lt_ends_with(port->name, "weight");
    field f;

    if (!to || !find_field(b, port->name, &f))
        return;
    for (int i = 0; i < part.n; i++) {
        const float *from = f.data + f.size * sample_for(b, all, part.first + i);

        for (int64_t k = 0; k < f.size; k++)
            to[f.size * i + k] = weight && !counts(b, part.first + i) ? 0 : from[k];
    }
}

/* Part number `part` of the n that feed_batch would fill at once; a neighbour may come from another part. */
static double feed_part(const lt_plan *p, const model_record *r, const hand_object_batch *b, int first, int part, int n)
{
    const slots all = { first, n * r->batch }, mine = { first + part * r->batch, r->batch };
    const bool some = weight_of(b, all) > 0;

    for (int i = 0; some && i < r->inputs.n; i++)
        copy_port(p, &r->inputs.port[i], b, all, mine);
    return weight_of(b, mine);
}

double feed_batch(const lt_plan *p, const model_record *r, const hand_object_batch *b, int first)
{
    return feed_part(p, r, b, first, 0, 1);
}

static lt_status recipe_record(const void *ctx, model_record *r)
{
    const model *m = ctx;

    m->cls->record(m, true, r);
    return lt_graph_status(r->g) == LT_OK ? feed_check(r) : LT_OK;
}

static int recipe_parts(const void *ctx, int batch)
{
    return feed_parts(ctx, batch);
}

static double recipe_feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first,
                          int part, int n)
{
    (void)ctx;
    return feed_part(p, r, batch, first, part, n);
}

recipe feed_recipe(const model *m)
{
    return (recipe){ .ctx = m, .record = recipe_record, .parts = recipe_parts, .feed = recipe_feed };
}
