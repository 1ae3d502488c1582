/* SPDX-License-Identifier: Apache-2.0 */
#include "train/feed.h"

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
        { "points2d", { b->points2d, 42 } },
        { "mask", { b->mask, cells } },
        { "weight", { b->weight, 1 } },
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
    o->crop = m->crop == MODEL_CROP_UNION ? HAND_OBJECT_UNION : HAND_OBJECT_BOXES;
    o->depth = m->depth;
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

static bool counts(const hand_object_batch *b, int slot)
{
    return slot < b->count && b->weight[slot] > 0;
}

/* The sample that stands in place i of n from first: itself, or the next one round that counts. */
static int sample_for(const hand_object_batch *b, int first, int n, int i)
{
    for (int k = 0; k < n; k++)
        if (counts(b, first + (i + k) % n))
            return first + (i + k) % n;
    return first;
}

static void copy_port(const lt_plan *p, const model_port *port, const hand_object_batch *b, int first, int n)
{
    lt_real *to = lt_plan_data(p, port->tensor);
    const bool weight = strcmp(port->name, "weight") == 0;
    field f;

    if (!to || !find_field(b, port->name, &f))
        return;
    for (int i = 0; i < n; i++) {
        const float *from = f.data + f.size * sample_for(b, first, n, i);

        for (int64_t k = 0; k < f.size; k++)
            to[f.size * i + k] = weight && !counts(b, first + i) ? 0 : from[k];
    }
}

double feed_batch(const lt_plan *p, const model_record *r, const hand_object_batch *b, int first)
{
    double total = 0;

    for (int i = 0; i < r->batch; i++)
        total += counts(b, first + i) ? (double)b->weight[first + i] : 0;
    for (int i = 0; total > 0 && i < r->inputs.n; i++)
        copy_port(p, &r->inputs.port[i], b, first, r->batch);
    return total;
}
