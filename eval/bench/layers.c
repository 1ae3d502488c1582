/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/bench/layers.h"

#include "libtensor/io/text/nearest.h"
#include "libtensor/nn/init.h"
#include "libtensor/nn/layers.h"

#include <cjson/cJSON.h>
#include <string.h>

enum { MIN_COPIES = 8, MAX_COPIES = 1024, MAX_INPUTS = 3, MAP_SCALE = 4 };
static const int64_t COLD_BYTES = 100000000;

/* What a layer's text can say; each kind has keys for some of it. */
typedef struct {
    int c, o, k, stride, groups, hw, rows, tokens, heads, points, out;
} layer_config;

typedef union {
    lt_conv_layer conv;
    lt_linear_layer linear;
    lt_layer_norm_layer layer_norm;
    lt_batch_norm_layer batch_norm;
} layer_weights;

/* What one copy is made of. */
typedef struct {
    const layer_config *config;
    const layer_weights *weights;
    const lt_hand_layer *hand;
    lt_tensor *const *in;
} layer_use;

typedef struct {
    const char *name;
    const lt_config_key *keys;
    int n_in;
    lt_shape (*shape)(const layer_config *c, int64_t batch, int input);
    layer_weights (*make)(const layer_config *c, lt_params *set, const char *name);     /* NULL: none */
    lt_tensor *(*apply)(const layer_use *u);
} layer_kind;

typedef struct {
    layer_config config;
    const layer_kind *kind;
    const lt_hand_layer *hand;
    layer_weights *copy;
    int copies;
} layer;

#define KEY(field, value, most, text) \
    { .name = #field, .type = LT_CONFIG_INT, .offset = offsetof(layer_config, field), .fallback = value, \
      .lo = 1, .hi = most, .doc = text }

/* ---- maps ---------------------------------------------------------------------------------------------- */

static lt_shape map_shape(const layer_config *c, int64_t batch, int input)
{
    (void)input;
    return LT_SHAPE(batch, c->c, c->hw, c->hw);
}

static const lt_config_key conv2d_keys[] = {
    KEY(c, "64", 65536, "channels in"), KEY(o, "64", 65536, "channels out"), KEY(k, "3", 31, "window"),
    KEY(stride, "1", 16, "stride"), KEY(groups, "1", 65536, "groups; as many as channels: depthwise"),
    KEY(hw, "56", 4096, "side of the map"), { .name = NULL },
};

static layer_weights conv2d_make(const layer_config *c, lt_params *set, const char *name)
{
    const lt_conv_opts opts = { .stride = c->stride, .pad = (c->k - 1) / 2, .groups = c->groups };

    return (layer_weights){ .conv = lt_conv_layer_new(set, name, c->c, c->o, c->k, true, &opts) };
}

static lt_tensor *conv2d_apply(const layer_use *u)
{
    return lt_conv_layer_forward(&u->weights->conv, u->in[0]);
}

static const lt_config_key map_keys[] = {
    KEY(c, "256", 65536, "channels"), KEY(hw, "64", 4096, "side of the map"), { .name = NULL },
};

static layer_weights batch_norm_make(const layer_config *c, lt_params *set, const char *name)
{
    return (layer_weights){ .batch_norm = lt_batch_norm_layer_new(set, name, c->c) };
}

static lt_tensor *batch_norm_apply(const layer_use *u)
{
    return lt_batch_norm_layer_forward(&u->weights->batch_norm, u->in[0]);
}

static const lt_config_key roi_align_keys[] = {
    KEY(c, "256", 65536, "channels"), KEY(hw, "64", 4096, "side of the map"),
    KEY(out, "32", 256, "side of the result, of half the map"), { .name = NULL },
};

/* One box an image, half the map wide and high, between the cells. */
static lt_tensor *roi_align_apply(const layer_use *u)
{
    static const double corner[4] = { 0.2, 0.25, 0.7, 0.75 };
    const int64_t n = lt_dim(u->in[0], 0);
    lt_tensor *boxes;
    lt_real *box = lt_constant_reals(u->in[0]->graph, LT_SHAPE(n, 5), &boxes);

    for (int64_t b = 0; box && b < n; b++, box += 5) {
        box[0] = (lt_real)b;
        for (int i = 0; i < 4; i++)
            box[1 + i] = (lt_real)(corner[i] * MAP_SCALE * u->config->hw);
    }
    return lt_roi_align(u->in[0], boxes, u->config->out, u->config->out, 1.0 / MAP_SCALE);
}

/* ---- rows ---------------------------------------------------------------------------------------------- */

static lt_shape rows_shape(const layer_config *c, int64_t batch, int input)
{
    (void)input;
    return LT_SHAPE(batch * c->rows, c->c);
}

static const lt_config_key linear_keys[] = {
    KEY(c, "256", 65536, "inputs"), KEY(o, "1024", 65536, "outputs"), KEY(rows, "1024", 1048576, "rows an image"),
    { .name = NULL },
};

static layer_weights linear_make(const layer_config *c, lt_params *set, const char *name)
{
    return (layer_weights){ .linear = lt_linear_layer_new(set, name, c->c, c->o, true) };
}

static lt_tensor *linear_apply(const layer_use *u)
{
    return lt_linear_layer_forward(&u->weights->linear, u->in[0]);
}

static const lt_config_key layer_norm_keys[] = {
    KEY(c, "256", 65536, "channels"), KEY(rows, "1024", 1048576, "rows an image"), { .name = NULL },
};

static layer_weights layer_norm_make(const layer_config *c, lt_params *set, const char *name)
{
    return (layer_weights){ .layer_norm = lt_layer_norm_layer_new(set, name, c->c) };
}

static lt_tensor *layer_norm_apply(const layer_use *u)
{
    return lt_layer_norm_layer_forward(&u->weights->layer_norm, u->in[0]);
}

static const lt_config_key attention_keys[] = {
    KEY(tokens, "1024", 65536, "queries, and keys"), KEY(c, "256", 65536, "channels of all heads"),
    KEY(heads, "4", 256, "heads"), { .name = NULL },
};

static lt_shape attention_shape(const layer_config *c, int64_t batch, int input)
{
    (void)input;
    return LT_SHAPE(batch, c->tokens, c->c);
}

static lt_tensor *attention_apply(const layer_use *u)
{
    return lt_attention(u->in[0], u->in[1], u->in[2], u->config->heads);
}

static const lt_config_key deformable_keys[] = {
    KEY(hw, "28", 1024, "side of the map; every cell asks"), KEY(c, "128", 65536, "channels of all heads"),
    KEY(heads, "8", 256, "heads"), KEY(points, "4", 16, "places a head looks at"), { .name = NULL },
};

static lt_shape deformable_shape(const layer_config *c, int64_t batch, int input)
{
    const int64_t places = (int64_t)c->heads * c->points;

    return LT_SHAPE(batch, (int64_t)c->hw * c->hw, input == 0 ? c->c : input == 1 ? 2 * places : places);
}

static lt_tensor *deformable_apply(const layer_use *u)
{
    lt_tensor *own = lt_cell_places(u->in[0]->graph, u->config->hw, u->config->hw);

    return lt_deformable_attention(u->in[0], u->in[1], u->in[2], own, u->config->heads, u->config->hw,
                                   u->config->hw);
}

/* ---- the hand ------------------------------------------------------------------------------------------ */

static const lt_config_key no_keys[] = { { .name = NULL } };

static lt_shape hand_shape(const layer_config *c, int64_t batch, int input)
{
    (void)c;
    return input ? LT_SHAPE(batch, LT_HAND_BETAS) : LT_SHAPE(batch, LT_HAND_JOINTS, 3, 3);
}

static lt_tensor *hand_apply(const layer_use *u)
{
    return lt_skin(u->hand, u->in[0], u->in[1]);
}

static const layer_kind kinds[] = {
    { "conv2d", conv2d_keys, 1, map_shape, conv2d_make, conv2d_apply },
    { "linear", linear_keys, 1, rows_shape, linear_make, linear_apply },
    { "attention", attention_keys, 3, attention_shape, NULL, attention_apply },
    { "deformable_attention", deformable_keys, 3, deformable_shape, NULL, deformable_apply },
    { "layer_norm", layer_norm_keys, 1, rows_shape, layer_norm_make, layer_norm_apply },
    { "batch_norm", map_keys, 1, map_shape, batch_norm_make, batch_norm_apply },
    { "roi_align", roi_align_keys, 1, map_shape, NULL, roi_align_apply },
    { "hand", no_keys, 2, hand_shape, NULL, hand_apply },
};

void layer_list(FILE *f)
{
    for (size_t i = 0; i < LT_COUNT(kinds); i++) {
        const char *mark = ":";

        fprintf(f, "  %s", kinds[i].name);
        for (const lt_config_key *k = kinds[i].keys; k->name; k++, mark = ",")
            fprintf(f, "%s%s=%s", mark, k->name, k->fallback);
        fputc('\n', f);
    }
}

/* ---- recording ----------------------------------------------------------------------------------------- */

/* consume: reads x without looking at it, in blocks where a convolution makes it so, for that is how layers run inside
 * a network; the copies are wanted one after another.
 *   chain ()   x (any shape)   ->   chain;   dx += 1e-3 dchain
 */
static lt_status consume_infer(lt_call *c)
{
    c->out->shape = (lt_shape){ 0 };
    return lt_want_shape(c, 0, "chain", (lt_shape){ 0 });
}

static void consume_forward(const lt_call *c)
{
    *(lt_real *)c->out->data = *(const lt_real *)c->in[0]->data;
}

static void consume_backward(const lt_call *c)
{
    const lt_real g = (lt_real)1e-3 * *c->dout;

    if (c->din[0])
        *c->din[0] += *c->dout;
    for (int64_t i = 0; c->din[1] && i < lt_numel(c->in[1]); i++)
        c->din[1][i] += g;
}

static unsigned consume_takes_blocks(const lt_node *node)
{
    return node->in[1]->shape.rank == 4 ? LT_BLOCKS_IN(1) : 0;
}

static const lt_op consume_op = {
    .name = "consume", .keeps = LT_KEEP_NOTHING, .infer = consume_infer, .forward = consume_forward,
    .backward = consume_backward, .takes_blocks = consume_takes_blocks,
};

static void record(const model *self, bool train, model_record *r)
{
    static const char *const names[MAX_INPUTS] = { "x", "y", "z" };
    const layer *m = self->self;
    lt_tensor *in[MAX_INPUTS], *chain = model_input(r, "chain", (lt_shape){ 0 });

    for (int i = 0; i < m->kind->n_in; i++) {
        in[i] = model_input(r, names[i], m->kind->shape(&m->config, r->batch, i));
        if (train)
            lt_want_grad(in[i]);
    }
    for (int i = 0; i < m->copies; i++) {
        const layer_use u = { &m->config, &m->copy[i], m->hand, in };

        chain = lt_apply(&consume_op, NULL, 0, (lt_tensor *[]){ chain, m->kind->apply(&u) }, 2);
    }
    r->loss = lt_output(chain, "chain");
}

/* ---- from the text ------------------------------------------------------------------------------------- */

static lt_status find_kind(const char *text, size_t n, const layer_kind **out)
{
    const char *names[LT_COUNT(kinds)];
    char name[32];

    snprintf(name, sizeof(name), "%.*s", (int)n, text);
    for (size_t i = 0; i < LT_COUNT(kinds); i++) {
        names[i] = kinds[i].name;
        if (strcmp(name, names[i]) == 0) {
            *out = &kinds[i];
            return LT_OK;
        }
    }
    return lt_unknown_name(name, names, LT_COUNT(kinds), NULL, "no such layer \"%s\"", name);
}

/* "c=256,k=3" as an object; empty for "" */
static lt_status read_pairs(lt_arena *arena, const char *kind, const char *text, cJSON *root)
{
    char *pairs = lt_arena_strdup(arena, text), *rest = pairs;
    lt_status st = pairs ? LT_OK : lt_error(LT_ENOMEM, "no memory for the layer");

    for (char *pair; st == LT_OK && (pair = strsep(&rest, ",")) != NULL;)
        if (*pair)
            st = *pair != '=' && strchr(pair, '=')
                ? lt_config_set(root, kind, pair)
                : lt_error(LT_EUSAGE, "found \"%s\", want key=value", pair);
    return st;
}

static lt_status read_config(lt_arena *arena, const layer_kind *kind, const char *pairs, layer_config *out)
{
    cJSON *root = cJSON_CreateObject();
    lt_status st = root ? read_pairs(arena, kind->name, pairs, root) : lt_error(LT_ENOMEM, "no memory for the layer");

    if (st == LT_OK)
        st = lt_config_read(arena, kind->name, root, kind->keys, out);
    cJSON_Delete(root);
    return st;
}

/* "conv2d:c=256,k=3": what is wrong in it is the option's fault. */
static lt_status read_text(lt_arena *arena, const char *text, layer *m)
{
    const size_t n = strcspn(text, ":");
    lt_status st = find_kind(text, n, &m->kind);

    if (st == LT_OK)
        st = read_config(arena, m->kind, text + n + (text[n] == ':'), &m->config);
    return st && st != LT_ENOMEM ? lt_error_prefix(LT_EUSAGE, "--layer") : st;
}

/* The first copy says how large one is, and so how many are cold. */
static lt_status make_copies(layer *m, lt_params *set)
{
    m->copies = MIN_COPIES;
    m->copy = lt_arena_array(lt_params_arena(set), MAX_COPIES, sizeof(*m->copy));
    if (!m->copy)
        return lt_error(LT_ENOMEM, "no memory for the layer");
    for (int i = 0; m->kind->make && i < m->copies; i++) {
        m->copy[i] = m->kind->make(&m->config, set, lt_name(set, "%d", i));
        if (i == 0) {
            const int64_t bytes = (int64_t)sizeof(lt_real) * lt_params_count(set, LT_WEIGHT, "");

            m->copies = (int)lt_max_i64(MIN_COPIES, lt_min_i64(MAX_COPIES, lt_ceil_div(COLD_BYTES, bytes)));
        }
    }
    lt_init_default(set, 0);
    return lt_params_status(set);
}

/* "c=256 k=3 ..." with every key */
static const char *describe(const layer *m, lt_arena *arena)
{
    const char *text = "", *gap = "";

    for (const lt_config_key *k = m->kind->keys; k->name; k++, gap = " ")
        text = lt_arena_printf(arena, "%s%s%s=%d", text, gap, k->name,
                               *(const int *)(const void *)((const char *)&m->config + k->offset));
    return text;
}

lt_status layer_new(const char *text, const lt_hand_layer *hand, lt_params *set, model *out, int *copies)
{
    lt_arena *arena = lt_params_arena(set);
    layer *m = lt_arena_alloc(arena, sizeof(*m));
    model_class *cls = lt_arena_alloc(arena, sizeof(*cls));
    lt_status st;

    if (!m || !cls)
        return lt_error(LT_ENOMEM, "no memory for the layer");
    *m = (layer){ .hand = hand };
    st = read_text(arena, text, m);
    if (st == LT_OK)
        st = make_copies(m, set);
    if (st)
        return st;
    *cls = (model_class){ .name = m->kind->name, .record = record };
    *out = (model){ .cls = cls, .params = set, .self = m, .variant = describe(m, arena) };
    *copies = m->copies;
    return LT_OK;
}
