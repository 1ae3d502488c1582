/* SPDX-License-Identifier: Apache-2.0 */
/* The splat rasteriser dressed as a model without weights: a graph that draws the scene, and for training the mean of
 * what is drawn, whose gradient reaches all that a Gaussian is made of. */
#include "eval/bench/splat.h"

#include "eval/bench/splat_scene.h"
#include "libtensor/ops/ops.h"

#include <string.h>

enum { CAMERA = 4 };

typedef struct {
    int gaussians, size;
    bool sets;
    splat_scene scene;
} splat_bench;

static const char *const variants[] = { "one", "sets", NULL }, *const blocks[] = { NULL };

#define KEY(field) #field, .offset = offsetof(splat_bench, field)

static const lt_config_key keys[] = {
    { KEY(gaussians), .type = LT_CONFIG_INT, .fallback = "10000", .lo = 2, .hi = 10000000, .doc = "how many" },
    { KEY(size), .type = LT_CONFIG_INT, .fallback = "224", .lo = 1, .hi = 16384, .doc = "side of the image in pixels" },
    { KEY(sets), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "the images and opacities of both halves as well, not only one of all" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    splat_bench *m = self->self;

    (void)hand;
    self->variant = variants[m->sets], self->image_size = m->size;
    if (splat_scene_new(lt_params_arena(self->params), m->gaussians, &m->scene))
        m->scene.n = 0;                 /* the arena remembers */
}

static void init(const model *self, uint64_t seed)
{
    (void)self, (void)seed;
}

static lt_tensor *input(model_record *r, const char *name, lt_shape shape, bool learns)
{
    lt_tensor *t = model_input(r, name, shape);

    if (learns)
        lt_want_grad(t);
    return t;
}

static void record(const model *self, bool losses, model_record *r)
{
    const splat_bench *m = self->self;
    const int64_t n = m->gaussians;
    const int32_t half = (int32_t)(n / 2);
    const lt_splat_in in = {
        .centre = input(r, "centre", LT_SHAPE(n, 3), losses), .axes = input(r, "axes", LT_SHAPE(n, 3, 3), losses),
        .opacity = input(r, "opacity", LT_SHAPE(n), losses), .colour = input(r, "colour", LT_SHAPE(n, 3), losses),
        .camera = input(r, "camera", LT_SHAPE(CAMERA), false),
        .first = m->sets ? lt_constant(r->g, LT_I32, (lt_shape){ 0 }, &half) : NULL,
    };
    lt_tensor *image = lt_splat_raster(&in, &(lt_splat_opts){ .width = m->size, .height = m->size, .near_z = 0.2,
                                                              .sets = m->sets });

    model_port_add(&r->outputs, "image", lt_output(image, "image"));
    model_port_add(&r->outputs, "instances", lt_output(lt_result(image, 2), "instances"));
    if (!losses)
        return;
    r->loss = lt_output(lt_scale(lt_sum(image), 1.0 / (double)lt_numel(image)), "loss");
    model_port_add(&r->losses, "loss", r->loss);
}

static void copy(lt_real *x, const float *from, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        x[i] = (lt_real)from[i];
}

static void fill(const model *self, const char *name, lt_real *x)
{
    const splat_bench *m = self->self;
    const splat_scene *s = &m->scene;
    const lt_real focal = (lt_real)splat_scene_focal(m->size), middle = (lt_real)(m->size / 2.0 - 0.5);
    const lt_real camera[CAMERA] = { focal, focal, middle, middle };

    if (strcmp(name, "centre") == 0)
        copy(x, s->centre, 3 * s->n);
    else if (strcmp(name, "opacity") == 0)
        copy(x, s->opacity, s->n);
    else if (strcmp(name, "colour") == 0)
        copy(x, s->colour, 3 * s->n);
    else if (strcmp(name, "axes") == 0)
        splat_scene_axes(s, x);
    else
        memcpy(x, camera, sizeof(camera));
}

const model_class bench_splat_class = {
    .name = "splat", .size = sizeof(splat_bench), .paper = "Kerbl et al. 2023, ACM Transactions on Graphics 42(4)",
    .variants = variants, .keys = keys, .blocks = blocks, .build = build, .init = init, .record = record, .fill = fill,
};
