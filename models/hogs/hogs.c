/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/hogs.h"

#include "libtensor/geometry/mesh/surface.h"
#include "libtensor/nn/init.h"

#include <string.h>

#define SEES .F = true, .pixel = true, .G = true
#define VPM .colour = true, .geometry = true
#define GPM .gpm = true, .contact = true

static const hogs_variant rows[] = {
    { "full", SEES, VPM, GPM },
    { "cpu", .small = true, SEES, VPM, GPM },
    { "no-contact", SEES, VPM, .gpm = true },
    { "gpm-random", SEES, VPM, GPM, .random_points = true },
    { "no-gpm", SEES, VPM },
    { "no-color", SEES, .geometry = true, GPM },
    { "no-vpm", SEES, GPM },
    { "vpm-fg", .F = true, .G = true, VPM, GPM },
    { "vpm-fp", .F = true, .pixel = true, VPM, GPM },
    { "vpm-pg", .pixel = true, .G = true, VPM, GPM },
    { "avatar", .avatar = true },
};
static const char *const variants[] = {
    "full", "cpu", "no-contact", "gpm-random", "no-gpm", "no-color", "no-vpm", "vpm-fg", "vpm-fp", "vpm-pg", "avatar",
    NULL,
};
static const char *const sizes[] = { "full", "cpu", NULL };
static const char *const encodings[] = { "hashgrid", "oneblob", NULL };
static const char *const norms[] = { "clip", "raw", NULL };
static const char *const penalties[] = { "0", "dexycb", "ho3d", NULL };
static const char *const backgrounds[] = { "black", "white", NULL };
static const char *const blocks[] = {
    "gaussians", "vit", "hand", "object", "avatar", "skin", "gpm", "lpips", "sets", NULL,
};

#define KEY(field) .offset = offsetof(hogs_config, field)

static const lt_config_key keys[] = {
    { "variant", KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"full\"", .choices = variants,
      .doc = "all of it, or a row of the paper's Tables 7 and 8; avatar: the baseline 3DGS-Avatar; cpu: all of it, in "
             "sizes for a CPU" },
    { "size", KEY(small), .type = LT_CONFIG_CHOICE, .fallback = "\"full\"", .choices = sizes,
      .doc = "the paper's, or for a CPU" },
    { "hands", KEY(hands), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 1000,
      .doc = "subjects; 0: as many as the training data have" },
    { "objects", KEY(objects), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 1000,
      .doc = "objects; 0: as many as the training data have" },
    { "gaussians", KEY(gaussians), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 1000000,
      .doc = "of a hand or an object at first, which may become four times as many; 0: 5000, or 1000 for a CPU" },
    { "frames", KEY(frames), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 10000000,
      .doc = "avatar: frames to train on, of which each has a code; 0: as many as the training data have" },
    { "width", KEY(width), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 4096,
      .doc = "of the frames in pixels; 0: as the training data have" },
    { "height", KEY(height), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 4096, .doc = "likewise" },
    { "enc", KEY(one_blob), .type = LT_CONFIG_CHOICE, .fallback = "\"hashgrid\"", .choices = encodings,
      .doc = "how a place is encoded" },
    { "vit_norm", KEY(raw_vit), .type = LT_CONFIG_CHOICE, .fallback = "\"clip\"", .choices = norms,
      .doc = "how the crop is normalised before the ViT" },
    { "alpha3", KEY(alpha3), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "V-PM mixes each channel by a share of its own" },
    { "lambda_nr", KEY(lambda_nr), .type = LT_CONFIG_CHOICE, .fallback = "\"0\"", .choices = penalties,
      .doc = "weights of the penalty on V-PM's changes of Gaussians" },
    { "bg", KEY(white), .type = LT_CONFIG_CHOICE, .fallback = "\"black\"", .choices = backgrounds,
      .doc = "what is behind the Gaussians" },
    { "gpm_draw", KEY(subset), .type = LT_CONFIG_CHOICE, .fallback = "\"replace\"",
      .choices = (const char *const[]){ "replace", "subset", NULL },
      .doc = "how G-PM draws points of an object in training" },
    { "gpm_metric_radius", KEY(metric_radius), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "G-PM groups points in metres, not in the unit sphere" },
    { "clip", KEY(clip_groups), .type = LT_CONFIG_CHOICE, .fallback = "\"global\"",
      .choices = (const char *const[]){ "global", "group", NULL },
      .doc = "how gradients of networks are held to 0.1: one norm over all, or each group's own" },
    { "point_backbone", KEY(point_backbone), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "weights that G-PM's point backbone begins with: ULIP's, or a run of points-cpu; \"\": random ones" },
    { .name = NULL },
};

/* ---- building -------------------------------------------------------------------------------------------- */

enum { BENCH_HANDS = 2, BENCH_OBJECTS = 4, FULL_HANDS = 10, FULL_OBJECTS = 20, BENCH_FRAMES = 2000, LEAST_FRAME = 31 };

static lt_status check(const char *where, const void *config)
{
    const hogs_config *c = config;

    if ((c->width && c->width < LEAST_FRAME) || (c->height && c->height < LEAST_FRAME))
        return lt_error(LT_EINVAL, "%s.width, .height: %d x %d, want %d pixels at least", where, c->width, c->height,
                        LEAST_FRAME);
    return LT_OK;
}

/* What the data would say */
static void fill_config(hogs *m)
{
    hogs_config *c = &m->config;
    const bool small = m->is->small || c->small;

    c->small = small;
    c->hands = c->hands ? c->hands : small ? BENCH_HANDS : FULL_HANDS;
    c->objects = c->objects ? c->objects : small ? BENCH_OBJECTS : FULL_OBJECTS;
    c->frames = c->frames ? c->frames : BENCH_FRAMES;
    c->gaussians = c->gaussians ? c->gaussians : small ? 1000 : 5000;
    c->width = c->width ? c->width : small ? 320 : 640;
    c->height = c->height ? c->height : small ? 240 : 480;
}

static void fill_sizes(hogs *m)
{
    hogs_sizes *s = &m->sizes;

    *s = m->config.small ? hogs_cpu : hogs_full;
    s->vpm.global = m->is->F, s->vpm.pixel = m->is->pixel, s->vpm.gaussian = m->is->G;
    s->vpm.one_blob = m->config.one_blob, s->vpm.alpha3 = m->config.alpha3;
    s->gpm.encoding = vpm_encoding(&s->vpm);
    s->avatar.frames = m->config.frames;
    s->gpm.metric_radius = m->config.metric_radius;
}

static lt_param *fixed(lt_params *set, const char *name, lt_shape shape)
{
    lt_param *p = lt_params_add(set, "sets", name, LT_WEIGHT, shape);

    p->frozen = true;
    return p;
}

/* What changes and colours Gaussians */
static void build_appearance(hogs *m, lt_params *set)
{
    if (m->is->avatar) {
        avatar_new(&m->avatar, set, "avatar", m->config.hands, m->config.objects, &m->sizes.avatar);
        return;
    }
    vit_new(&m->vit, set, "vit", &vit_sizes[m->config.small ? VIT_TINY : VIT_B32]);
    vpm_new(&m->hand, set, "hand", m->config.hands, &m->sizes.vpm);
    vpm_new(&m->object, set, "object", m->config.objects, &m->sizes.vpm);
}

static void build(model *self, const lt_hand_layer *hand)
{
    hogs *m = self->self;
    lt_params *set = self->params;

    (void)hand;
    m->is = &rows[m->config.variant];
    fill_config(m);
    fill_sizes(m);
    self->variant = m->is->small ? variants[0] : m->is->name, self->image_size = m->sizes.crop;
    gaussians_new(&m->gaussians, set, "gaussians", hogs_n_sets(m), m->config.gaussians,
                  m->is->avatar ? m->sizes.avatar.feature : 0);
    build_appearance(m, set);
    skin_field_new(&m->skin, set, "skin", m->config.hands, m->sizes.skin_width);
    if (m->is->gpm)
        gpm_new(&m->gpm, set, "gpm", &m->sizes.gpm);
    lpips_new(&m->lpips, set, "lpips");
    m->box[0] = fixed(set, "hand_box", LT_SHAPE(m->config.hands, 6));
    m->box[1] = fixed(set, "object_box", LT_SHAPE(m->config.objects, 6));
    m->id[0] = fixed(set, "hand_id", LT_SHAPE(m->config.hands));
    m->id[1] = fixed(set, "object_id", LT_SHAPE(m->config.objects));
    m->beta = fixed(set, "beta", LT_SHAPE(m->config.hands, LT_HAND_BETAS));
}

/* ---- sets ------------------------------------------------------------------------------------------------ */

lt_status hogs_give_sets(model *self, const hogs_sets *sets)
{
    hogs *m = self->self;

    if (sets->hands != m->config.hands || sets->objects != m->config.objects)
        return lt_error(LT_EINVAL, "model.hands and model.objects are %d and %d, but the data have %d subjects and %d "
                        "objects; leave them out of the configuration to have as many as the data",
                        m->config.hands, m->config.objects, sets->hands, sets->objects);
    m->sets = sets;
    return LT_OK;
}

int hogs_find_set(const hogs *m, bool object, int id)
{
    const lt_param *p = m->id[object];

    for (int i = 0; i < p->shape.dim[0]; i++)
        if ((int)p->data[i] == id)
            return i;
    return -1;
}

void hogs_beta(const hogs *m, int hand, float out[LT_HAND_BETAS])
{
    for (int k = 0; k < LT_HAND_BETAS; k++)
        out[k] = (float)m->beta->data[hand * LT_HAND_BETAS + k];
}

static void remember(const hogs *m, bool object, int i, const hogs_set *s)
{
    lt_real *box = m->box[object]->data + 6 * i;

    for (int k = 0; k < 3; k++) {
        box[k] = (lt_real)((s->lo[k] + s->hi[k]) / 2);
        box[3 + k] = (lt_real)(2 / (s->hi[k] - s->lo[k]));
    }
    m->id[object]->data[i] = (lt_real)s->id;
    for (int k = 0; k < LT_HAND_BETAS && !object; k++)
        m->beta->data[LT_HAND_BETAS * i + k] = (lt_real)s->beta[k];
}

/* Places at first: over a hand's surface, in an object's box */
static lt_status draw_places(const hogs_set *s, lt_rng *rng, int n, float (*place)[3])
{
    if (s->mesh)
        return lt_mesh_sample(s->mesh, rng, n, place, NULL);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            place[i][k] = (float)lt_rng_range(rng, s->lo[k], s->hi[k]);
    return LT_OK;
}

/* What model_class.init cannot report, the first Gaussians that are missing, a run finds at its first step. */
static void place_set(const hogs *m, int i, const hogs_set *s, uint64_t seed)
{
    const int n = m->config.gaussians;
    float (*place)[3] = lt_alloc((size_t)n * sizeof(*place));
    lt_rng rng = lt_rng_make(seed, lt_rng_mix(0x474155, (uint64_t)i));

    if (place && !draw_places(s, &rng, n, place))
        gaussians_place(&m->gaussians, i, (const float (*)[3])place, n);
    lt_release(place);
}

/* Half a decimetre to all sides: as large as what a hand holds */
static hogs_set some_box(int i)
{
    return (hogs_set){ .id = i, .lo = { -0.05, -0.05, -0.05 }, .hi = { 0.05, 0.05, 0.05 } };
}

static void init_sets(const hogs *m, uint64_t seed)
{
    for (int i = 0; i < hogs_n_sets(m); i++) {
        const bool object = i >= m->config.hands;
        const hogs_set some = some_box(i), *s = m->sets ? &m->sets->set[i] : &some;

        remember(m, object, object ? i - m->config.hands : i, s);
        place_set(m, i, s, seed);
    }
}

static void init(const model *self, uint64_t seed)
{
    const hogs *m = self->self;

    lt_init_default(self->params, seed);
    if (m->is->avatar) {
        avatar_init(&m->avatar, seed);
    } else {
        vit_init(&m->vit, seed);
        vpm_init(&m->hand, seed);
        vpm_init(&m->object, seed);
    }
    skin_field_init(&m->skin, seed);
    if (m->is->gpm)
        gpm_init(&m->gpm, seed);
    lpips_init((lpips *)&m->lpips);
    for (lt_param *p = lt_params_first(self->params); p; p = p->next)
        if (strncmp(p->name, "gaussians.", 10) == 0 || strncmp(p->name, "sets.", 5) == 0)
            lt_init_constant(p, 0);
    init_sets(m, seed);
}

static void record(const model *self, bool losses, model_record *r)
{
    const hogs *m = self->self;

    hogs_record(self, !losses ? HOGS_RENDER : m->is->gpm ? HOGS_JOINT : HOGS_GAUSSIANS, r);
}

const model_class hogs_class = {
    .name = "hogs", .size = sizeof(hogs), .paper = "HOGS", .task = "hogs", .variants = variants, .keys = keys,
    .blocks = blocks, .check = check, .build = build, .init = init, .record = record, .fill = hogs_fill,
};
