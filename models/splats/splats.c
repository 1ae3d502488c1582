/* SPDX-License-Identifier: Apache-2.0 */
#include "models/splats/splats.h"

#include "libtensor/base/rng.h"
#include "libtensor/geometry/harmonics.h"
#include "libtensor/nn/init.h"
#include "libtensor/ops/splat/gaussians.h"

#include <string.h>

enum { SOME_GAUSSIANS = 5000, SOME_SIDE = 400, LEAST_SIDE = 16 };

static const double L1_SHARE = 0.8, SSIM_SHARE = 0.2;       /* of the loss                          [equation 7] */

static const char *const variants[] = { "static", NULL };
static const char *const backgrounds[] = { "black", "white", NULL };
static const char *const blocks[] = { "gaussians", NULL };

#define KEY(field) #field, .offset = offsetof(splats_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"static\"", .choices = variants, .doc = "a still scene" },
    { KEY(gaussians), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 10000000,
      .doc = "at first; 0: one for each of the folder's points, or 5000 anywhere between the cameras where it has "
             "none" },
    { KEY(cap), .type = LT_CONFIG_INT, .fallback = "50000", .lo = 1, .hi = 1000000000, .doc = "Gaussians at most" },
    { KEY(width), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 16384,
      .doc = "of the pictures in pixels; 0: of the folder's widest" },
    { KEY(height), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 16384, .doc = "likewise" },
    { KEY(extent), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1e6,
      .doc = "size of the scene in the unit of its cameras' places, which rates and sizes go by; 0: 1.1 times as far "
             "as a camera stands from their middle" },
    { "bg", .offset = offsetof(splats_config, white), .type = LT_CONFIG_CHOICE, .fallback = "\"black\"",
      .choices = backgrounds, .doc = "what is behind the Gaussians, and behind pictures with an alpha channel" },
    { .name = NULL },
};

static lt_status check(const char *where, const void *config)
{
    const splats_config *c = config;

    if ((c->width && c->width < LEAST_SIDE) || (c->height && c->height < LEAST_SIDE))
        return lt_error(LT_EINVAL, "%s.width, .height: %d x %d, want %d pixels at least", where, c->width, c->height,
                        LEAST_SIDE);
    if (c->gaussians > c->cap)
        return lt_error(LT_EINVAL, "%s.gaussians: %d, but model.cap allows %d", where, c->gaussians, c->cap);
    return LT_OK;
}

/* What the data would say */
static void fill_config(splats_config *c)
{
    c->gaussians = c->gaussians ? c->gaussians : (int)lt_min_i64(c->cap, SOME_GAUSSIANS);
    c->width = c->width ? c->width : SOME_SIDE;
    c->height = c->height ? c->height : SOME_SIDE;
    c->extent = c->extent > 0 ? c->extent : 1;
}

static void build(model *self, const lt_hand_layer *hand)
{
    splats *m = self->self;

    (void)hand;
    fill_config(&m->config);
    self->variant = variants[m->config.variant];
    self->image_size = m->config.width;
    gaussians_new(&m->gaussians, self->params, "gaussians", 1, m->config.gaussians, 0);
}

/* ---- initial values -------------------------------------------------------------------------------------- */

void splats_give_scene(model *self, const splats_scene *scene)
{
    ((splats *)self->self)->scene = scene;
}

static void colour(const gaussians *g, int n, const float (*colour)[3])
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            g->dc->data[3 * i + k] = (lt_real)(((colour ? (double)colour[i][k] : 0.5) - 0.5) / LT_SH_C0);
}

/* What model_class.init cannot report, Gaussians that are missing, a run finds at its first step. */
static void init(const model *self, uint64_t seed)
{
    const splats *m = self->self;
    const splats_scene *s = m->scene;
    const int n = m->config.gaussians;
    float (*place)[3] = s ? NULL : lt_alloc((size_t)n * sizeof(*place));
    lt_rng rng = lt_rng_make(seed, 0x53504c);

    for (lt_param *p = lt_params_first(self->params); p; p = p->next)
        lt_init_constant(p, 0);
    for (int i = 0; place && i < n; i++)
        for (int k = 0; k < 3; k++)
            place[i][k] = (float)lt_rng_range(&rng, -0.5, 0.5);
    if (s || place)
        gaussians_place(&m->gaussians, 0, s ? s->place : (const float (*)[3])place, n);
    colour(&m->gaussians, n, s ? s->colour : NULL);
    lt_release(place);
}

/* ---- the graph ------------------------------------------------------------------------------------------- */

static lt_tensor *integer(model_record *r, const char *name)
{
    lt_tensor *t = lt_input(r->g, name, LT_I32, 1, (int64_t[]){ 1 });

    model_port_add(&r->inputs, name, t);
    return t;
}

static void put_out(model_record *r, const char *name, lt_tensor *t)
{
    model_port_add(&r->outputs, name, lt_output(t, name));
}

/* From rows to the picture: into the camera, coloured by the direction that it looks from, and drawn. */
static lt_tensor *draw(const splats *m, model_record *r, bool training)
{
    const int64_t N = gaussians_capacity(&m->gaussians);
    lt_tensor *alive = model_input(r, "alive", LT_SHAPE(N, 1)), *view = model_input(r, "view", LT_SHAPE(1, 3, 4));
    const gaussian_rows rows = gaussians_rows(&m->gaussians, integer(r, "row"), alive);
    lt_tensor *centre = lt_transform_points(rows.centre, view);
    lt_tensor *direction = lt_transform_back(lt_detach(centre), view);
    const lt_splat_in in = {
        .centre = centre, .axes = lt_splat_axes(rows.log_scale, rows.quaternion, view),
        .opacity = lt_reshape(rows.opacity, LT_SHAPE(N)),
        .colour = lt_sh_colour(rows.sh, direction, integer(r, "degree")),
        .camera = model_input(r, "camera", LT_SHAPE(4)),
        .offset = training ? lt_want_grad(model_input(r, "offset", LT_SHAPE(N, 2))) : NULL,
    };

    if (!training) {
        put_out(r, "centre", in.centre);
        put_out(r, "colour", in.colour);
    }
    return lt_splat_raster(&in, &(lt_splat_opts){ .width = m->config.width, .height = m->config.height,
                                                  .near_z = splats_near(m), .white = m->config.white });
}

static void put_loss(model_record *r, const char *name, lt_tensor *t)
{
    model_port_add(&r->losses, name, lt_output(t, name));
}

/* 0.8 L1 + 0.2 (1 - SSIM), over the whole canvas: what does not count is black in both. */
static void add_losses(const splats *m, model_record *r, lt_tensor *picture)
{
    const int64_t H = m->config.height, W = m->config.width;
    lt_tensor *seen = lt_mul(picture, model_input(r, "weight", LT_SHAPE(1, H, W)));
    lt_tensor *target = model_input(r, "target", LT_SHAPE(3, H, W));
    lt_tensor *l1 = lt_l1_loss(seen, target, NULL), *ssim = lt_ssim_loss(seen, target);

    put_loss(r, "l1", l1);
    put_loss(r, "ssim", ssim);
    r->loss = lt_output(lt_add(lt_scale(l1, L1_SHARE), lt_scale(ssim, SSIM_SHARE)), "loss");
}

/* A graph draws one picture: of others it says so when it is compiled. */
static lt_status refuse(lt_call *c)
{
    return lt_fail(c, "draws one picture at a time, found a batch of %lld", (long long)lt_dim(c->in[0], 0));
}

static void never(const lt_call *c)
{
    (void)c;
}

static const lt_op one_picture_op = { .name = "splats_picture", .infer = refuse, .forward = never };

static void record(const model *self, bool losses, model_record *r)
{
    const splats *m = self->self;
    lt_tensor *picture;

    if (r->batch != 1) {
        lt_tensor *view = model_input(r, "view", LT_SHAPE(r->batch, 3, 4));

        put_out(r, "picture", lt_apply(&one_picture_op, NULL, 0, &view, 1));
        return;
    }
    picture = draw(m, r, losses);
    put_out(r, "picture", picture);
    put_out(r, "radius", lt_result(picture, 1));
    if (losses)
        add_losses(m, r, picture);
}

/* ---- what it is timed with ------------------------------------------------------------------------------- */

/* A camera two units in front of the ball that init makes */
static void fill(const model *self, const char *input, lt_real *x)
{
    const splats *m = self->self;
    const int64_t N = gaussians_capacity(&m->gaussians);
    const lt_real camera[4] = { (lt_real)m->config.width, (lt_real)m->config.width, (lt_real)(m->config.width / 2.0),
                                (lt_real)(m->config.height / 2.0) };

    if (strcmp(input, "view") == 0) {
        memset(x, 0, 12 * sizeof(*x));
        x[0] = x[5] = x[10] = 1, x[11] = 2;
    } else if (strcmp(input, "camera") == 0) {
        memcpy(x, camera, sizeof(camera));
    } else if (strcmp(input, "alive") == 0) {
        for (int64_t i = 0; i < N; i++)
            x[i] = i < gaussians_count(&m->gaussians, 0);
    } else if (strcmp(input, "row") == 0 || strcmp(input, "degree") == 0) {
        memset(x, 0, sizeof(int32_t));
    } else if (strcmp(input, "offset") == 0) {
        memset(x, 0, 2 * (size_t)N * sizeof(*x));
    }
}

const model_class splats_class = {
    .name = "splats", .size = sizeof(splats), .paper = "3D Gaussian splatting", .task = "splats", .variants = variants,
    .keys = keys, .blocks = blocks, .check = check, .build = build, .init = init, .record = record, .fill = fill,
};
