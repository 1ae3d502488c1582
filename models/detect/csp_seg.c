/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/csp_seg.h"

#include "libtensor/nn/init.h"

#include <math.h>
#include <string.h>

typedef struct {
    csp_seg_config config;
    backbone backbone;
    neck neck;
    detect_head head;
} csp_seg;

static const char *const variants[] = { "n", NULL };
static const char *const blocks[] = { "backbone", "neck", "head", NULL };
static const char *const fresh[] = { "head.class.", NULL };

const char *const csp_seg_output[DETECT_OUTPUTS] = {
    "box8", "box16", "box32", "class8", "class16", "class32", "mask8", "mask16", "mask32", "prototypes",
};

#define KEY(field) #field, .offset = offsetof(csp_seg_config, field)
#define WEIGHT(field, value, what) \
    { KEY(field), .type = LT_CONFIG_NUMBER, .fallback = value, .lo = 0, .hi = 1e30, \
      .doc = "weight of the loss of " what }

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"n\"", .choices = variants,
      .doc = "depth 0.33, width 0.25" },
    { KEY(image_size), .type = LT_CONFIG_INT, .fallback = "640", .lo = 32, .hi = 2048,
      .doc = "side of the square that an image is fitted into, in pixels: a multiple of 32" },
    { KEY(classes), .type = LT_CONFIG_INT, .fallback = "23", .lo = 1, .hi = 1000, .doc = "classes" },
    WEIGHT(w_box, "7.5", "boxes, 1 - CIoU"),
    WEIGHT(w_class, "0.5", "classes"),
    WEIGHT(w_sides, "1.5", "the distribution of each side"),
    WEIGHT(w_mask, "7.5", "masks"),
    { .name = NULL },
};

static lt_status check(const char *where, const void *config)
{
    const csp_seg_config *c = config;

    if (c->image_size % 32)
        return lt_error(LT_EINVAL, "%s.image_size: %d is not a multiple of 32", where, c->image_size);
    return LT_OK;
}

static void build(model *self, const lt_hand_layer *hand)
{
    csp_seg *m = self->self;

    (void)hand;
    self->variant = variants[m->config.variant], self->image_size = m->config.image_size;
    backbone_new(&m->backbone, self->params, "backbone");
    neck_new(&m->neck, self->params, "neck");
    detect_head_new(&m->head, self->params, "head", m->config.classes);
}

static void init(const model *self, uint64_t seed)
{
    const csp_seg *m = self->self;

    lt_init_default(self->params, seed);
    detect_head_init(&m->head);
}

const csp_seg_config *csp_seg_config_of(const model *m)
{
    return m->cls == &csp_seg_class ? &((const csp_seg *)m->self)->config : NULL;
}

static lt_tensor *add_loss(model_record *r, const char *name, lt_tensor *loss, double weight, lt_tensor *sum)
{
    model_port_add(&r->losses, name, lt_output(loss, name));
    loss = lt_scale(loss, weight);
    return sum ? lt_add(sum, loss) : loss;
}

static lt_tensor *masks_input(model_record *r, const lt_tensor *proto)
{
    const int64_t words = lt_ceil_div(lt_dim(proto, 2) * lt_dim(proto, 3), 32);
    lt_tensor *t = lt_input(r->g, "masks", LT_I32, 3, (int64_t[]){ r->batch, DETECT_MAX_OBJECTS, words });

    model_port_add(&r->inputs, "masks", t);
    return t;
}

static void record_losses(const csp_seg_config *c, const detect_maps *maps, double scale, model_record *r)
{
    lt_tensor *objects = model_input(r, "objects", LT_SHAPE(r->batch, DETECT_MAX_OBJECTS, OBJECT_NUMBERS));
    lt_tensor *masks = masks_input(r, maps->proto), *assigned = detect_assign(maps, objects);
    lt_tensor *box = detect_box_loss(maps, objects, assigned), *sum;

    sum = add_loss(r, "box", box, c->w_box, NULL);
    sum = add_loss(r, "class", detect_class_loss(maps, objects, assigned), c->w_class, sum);
    sum = add_loss(r, "sides", lt_result(box, 1), c->w_sides, sum);
    sum = add_loss(r, "mask", detect_mask_loss(maps, objects, masks, assigned), c->w_mask, sum);
    r->loss = lt_output(lt_scale(sum, scale), "loss");
}

void csp_seg_record(const model *self, bool losses, double scale, model_record *r)
{
    const csp_seg *m = self->self;
    const int S = m->config.image_size;
    const backbone_out c = backbone_forward(&m->backbone, model_input(r, "image", LT_SHAPE(r->batch, 3, S, S)));
    const neck_out p = neck_forward(&m->neck, &c);
    const detect_maps maps = detect_head_forward(&m->head, &p);
    lt_tensor *const *of[] = { maps.box, maps.cls, maps.mask };

    for (int i = 0; i < 3 * DETECT_LEVELS; i++)
        model_port_add(&r->outputs, csp_seg_output[i], lt_output(of[i / DETECT_LEVELS][i % DETECT_LEVELS],
                                                                 csp_seg_output[i]));
    model_port_add(&r->outputs, "prototypes", lt_output(maps.proto, "prototypes"));
    if (losses)
        record_losses(&m->config, &maps, scale, r);
}

static void record(const model *self, bool losses, model_record *r)
{
    csp_seg_record(self, losses, 1, r);
}

const model_class csp_seg_class = {
    .name = "csp_seg", .size = sizeof(csp_seg), .paper = "YOLOv8-seg layout", .task = "detect",
    .variants = variants, .keys = keys, .blocks = blocks, .fresh = fresh, .check = check, .build = build, .init = init,
    .record = record,
};
