/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a model is to the trainer, the scorer and the command: parameters, and graphs whose inputs,
 * outputs and losses have names. Nothing outside a model's own folder knows more of it.
 */
#ifndef MODELS_MODEL_H
#define MODELS_MODEL_H

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/graph/graph.h"
#include "libtensor/graph/int8.h"
#include "libtensor/io/text/config.h"

enum { MODEL_PORTS = 64 };

typedef struct {
    const char *name;
    lt_tensor *tensor;
} model_port;

typedef struct {
    model_port port[MODEL_PORTS];
    int n;
} model_ports;

/*
 * One recorded graph of a model. Inputs that every hand-object model has, by name:
 *   "image" (B, 3, S, S) in [0, 1]
 * that some have:
 *   "hand_box", "object_box" (B, 4) crop pixels      "depth" (B, 1, S, S) in [-1, 1], see depth_crop
 * and for losses:
 *   "joints2d" (B, 21, 2)   "rotation" (B, 16, 3, 3)   "beta" (B, 10)   "points2d" (B, 21, 2)
 *   "mask" (B, cells, cells)   "weight", "object_weight" (B)
 * Outputs of a hand-object model:
 *   "joints2d" (B, 21, 2)   "peak" (B, 21)    of the heat maps: their mean place, their highest cell
 *   "rotation" (B, 16, 3, 3)   "beta" (B, 10)
 *   "vertices" (B, 778, 3)  "joints" (B, 21, 3)    wrist-relative, metres, simple order
 *   "conf", "point_x", "point_y" (B, 21, cells, cells)    of the object's control points, in units
 *                                                     of the object box
 * A classifier has the input "image", the output "logits" (B, classes), and for its loss the input
 * "target" (B, classes).
 */
typedef struct {
    lt_graph *g;
    int batch;
    bool whole_maps;                /* also where no box reads them: for formats that cannot say it, the same to 1e-5 */
    model_ports inputs, outputs, losses;
    lt_tensor *loss;                /* the weighted sum of the losses; NULL without them */
} model_record;

typedef struct model model;

typedef struct model_class {
    const char *name;               /* "hocat" */
    size_t size;                    /* of the model's own struct, which begins with its config, as read by keys */
    const char *paper;
    const char *task;               /* what it is trained for: "hand-object"; NULL: nothing here, it is known for its
                                     * speed elsewhere */
    const char *const *variants;    /* NULL-terminated; the first is the default */
    const lt_config_key *keys;      /* of the "model" group of a config */
    const char *const *blocks;      /* name prefixes of the parts, for listings; NULL-terminated */
    const char *const *twins;       /* (2) blocks of one network: published weights for the first begin the second too,
                                     * whose first layer may look at one channel instead of three; NULL: none */
    const char *const *fresh;       /* name prefixes of what begins fresh where a file of weights has it in another
                                     * shape: it depends on what is looked for; NULL-terminated, or NULL */
    const double *mean, *deviation; /* (3) of red, green, blue in [0, 1]: what an image is normalised by before it
                                     * is the input; NULL: by nothing */

    /* What the keys' ranges do not tell of a config: an error line that begins with where. NULL: nothing. */
    lt_status (*check)(const char *where, const void *config);

    /* Make m->self, whose config stands, and its parameters; say what image m looks at. What it allocates lives in the
     * parameters' arena. */
    void (*build)(model *m, const lt_hand_layer *hand);

    /* Give every parameter its initial value. */
    void (*init)(const model *m, uint64_t seed);

    /* Record the forward pass for a batch, and with losses the losses too. */
    void (*record)(const model *m, bool losses, model_record *out);

    /* The values that an input is timed with, where numbers between 0 and 1 would be none. NULL: they will do. */
    void (*fill)(const model *m, const char *input, lt_real *x);
} model_class;

struct model {
    const model_class *cls;
    lt_params *params;
    void *self;                     /* the model's own struct */
    const char *variant;
    int image_size, cells;          /* side of the crop; side of the pooled features and masks */
    bool depth;                     /* it has the input "depth" */
    bool depth_fit;                 /* the object's pose is laid on the depth that was measured */
    bool hand_alone;                /* no loss has taught it where objects are: nobody asks it for them */
    const lt_hand_layer *hand;      /* that its graphs pose; NULL for a classifier */
    const lt_int8_table *int8;      /* layers that read 8-bit integers in inference; NULL: none */
};

/* model_takes_depth - whether it looks at depth images, or what it finds is held against them */
static inline bool model_takes_depth(const model *m)
{
    return m->depth || m->depth_fit;
}

/* zoo.c: model_classes - all models, NULL-terminated; model_find - by name, with an error that lists them */
extern const model_class *const model_classes[];
lt_status model_find(const char *name, const model_class **out);

/**
 * model_create - a model from its group of a config
 *
 *   where    what errors begin with: "tiny.json: model"
 *   config   an object, or NULL for the model's defaults
 *   hand     NULL for a classifier
 *   set      empty; the model's parameters, not yet initialised, and its memory
 *
 * Errors: LT_EINVAL for a key or value that cannot be; LT_ENOMEM.
 */
lt_status model_create(const model_class *cls, const char *where, const struct cJSON *config,
                       const lt_hand_layer *hand, lt_params *set, model *out);

/* model_port_find - by name, NULL when the graph has none; model_port_add - for the models */
lt_tensor *model_port_find(const model_ports *ports, const char *name);
void model_port_add(model_ports *ports, const char *name, lt_tensor *t);

/* model_input - lt_input with a port of the same name */
lt_tensor *model_input(model_record *r, const char *name, lt_shape shape);

#endif
