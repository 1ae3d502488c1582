/* SPDX-License-Identifier: Apache-2.0 */
/* Published weights of CLIP's image tower, of LPIPS, a detector, DeepSORT's network and OSX, under the names that their
 * files have. */
#include "estimate/weights/weights.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/array/safetensors.h"
#include "tests/models/model_of.h"
#include "tests/suite.h"

#include <math.h>

enum { LAYERS = 6, C = 192, MOST = 400 };

/* A file of arrays, each filled with numbers that tell which array and which row they are of */
static lt_named_array list[MOST];
static size_t n;
static lt_arena *arena;

static void start(void) { arena = lt_arena_new(), n = 0; }
static void stop(void) { lt_arena_free(arena); }

static void put(const char *name, int rank, int64_t d0, int64_t d1, int64_t d2, int64_t d3)
{
    const int64_t shape[] = { d0, d1, d2, d3 };
    lt_array a = lt_array_make(LT_ELEM_F4, rank, shape, NULL);
    const size_t count = lt_array_count(&a);
    float *data = lt_arena_array(arena, count, sizeof(*data));

    for (size_t i = 0; i < count; i++)
        data[i] = (float)n + (float)(i / (count / (size_t)d0)) / 1024;
    a.data = data;
    list[n++] = (lt_named_array){ name, a };
}

/* A layer in a block, with its bias */
static void put_layer(const char *block, int i, const char *name, int64_t rows, int64_t columns)
{
    const char *layer = lt_arena_printf(arena, block, i);

    put(lt_arena_printf(arena, "%s%s.weight", layer, name), columns ? 2 : 1, rows, columns, 0, 0);
    put(lt_arena_printf(arena, "%s%s.bias", layer, name), 1, rows, 0, 0, 0);
}

static void put_openai(void)
{
    put("visual.class_embedding", 1, C, 0, 0, 0);
    put("visual.positional_embedding", 2, 50, C, 0, 0);
    put("visual.proj", 2, C, 512, 0, 0);
    put("visual.conv1.weight", 4, C, 3, 16, 16);
    put_layer("visual.", 0, "ln_pre", C, 0);
    put_layer("visual.", 0, "ln_post", C, 0);
    for (int i = 0; i < LAYERS; i++) {
        const char *block = "visual.transformer.resblocks.%d.";

        put(lt_arena_printf(arena, "visual.transformer.resblocks.%d.attn.in_proj_weight", i), 2, 3 * C, C, 0, 0);
        put(lt_arena_printf(arena, "visual.transformer.resblocks.%d.attn.in_proj_bias", i), 1, 3 * C, 0, 0, 0);
        put_layer(block, i, "attn.out_proj", C, C);
        put_layer(block, i, "ln_1", C, 0);
        put_layer(block, i, "ln_2", C, 0);
        put_layer(block, i, "mlp.c_fc", 4 * C, C);
        put_layer(block, i, "mlp.c_proj", C, 4 * C);
    }
    put("transformer.resblocks.0.ln_1.weight", 1, 512, 0, 0, 0);        /* of the text's tower */
    put("positional_embedding", 2, 77, 512, 0, 0);
    put("logit_scale", 0, 1, 0, 0, 0);
}

static void put_hugging_face(void)
{
    put("vision_model.embeddings.class_embedding", 1, C, 0, 0, 0);
    put("vision_model.embeddings.position_embedding.weight", 2, 50, C, 0, 0);
    put("vision_model.embeddings.patch_embedding.weight", 4, C, 3, 16, 16);
    put_layer("vision_model.", 0, "pre_layrnorm", C, 0);
    put_layer("vision_model.", 0, "post_layernorm", C, 0);
    for (int i = 0; i < LAYERS; i++) {
        const char *block = "vision_model.encoder.layers.%d.";

        put_layer(block, i, "self_attn.q_proj", C, C);
        put_layer(block, i, "self_attn.k_proj", C, C);
        put_layer(block, i, "self_attn.v_proj", C, C);
        put_layer(block, i, "self_attn.out_proj", C, C);
        put_layer(block, i, "layer_norm1", C, 0);
        put_layer(block, i, "layer_norm2", C, 0);
        put_layer(block, i, "mlp.fc1", 4 * C, C);
        put_layer(block, i, "mlp.fc2", C, 4 * C);
    }
    put("text_model.encoder.layers.0.layer_norm1.weight", 1, 512, 0, 0, 0);
}

static void put_timm(void)
{
    put("cls_token", 3, 1, 1, C, 0);
    put("pos_embed", 3, 1, 50, C, 0);
    put("patch_embed.proj.weight", 4, C, 3, 16, 16);
    put_layer("", 0, "norm_pre", C, 0);
    put_layer("", 0, "norm", C, 0);
    for (int i = 0; i < LAYERS; i++) {
        put_layer("blocks.%d.", i, "norm1", C, 0);
        put_layer("blocks.%d.", i, "attn.qkv", 3 * C, C);
        put_layer("blocks.%d.", i, "attn.proj", C, C);
        put_layer("blocks.%d.", i, "norm2", C, 0);
        put_layer("blocks.%d.", i, "mlp.fc1", 4 * C, C);
        put_layer("blocks.%d.", i, "mlp.fc2", C, 4 * C);
    }
    put_layer("", 0, "head", 10, C);
}

static const struct {
    void (*put)(void);
    const char *family, *taken, *fc1, *q, *k, *position;        /* some names of theirs */
    bool fused;                     /* q is the first third of that array, k the second */
    int left_over;
} towers[] = {
    { put_openai, "OpenAI's CLIP", "visual.", "visual.transformer.resblocks.5.mlp.c_fc.bias",
      "visual.transformer.resblocks.5.attn.in_proj_weight", NULL, "visual.positional_embedding", true, 4 },
    { put_hugging_face, "Hugging Face's CLIP", "vision_model.", "vision_model.encoder.layers.5.mlp.fc1.bias",
      "vision_model.encoder.layers.5.self_attn.q_proj.weight", "vision_model.encoder.layers.5.self_attn.k_proj.weight",
      "vision_model.embeddings.position_embedding.weight", false, 1 },
    { put_timm, "timm's ViT", "", "blocks.5.mlp.fc1.bias", "blocks.5.attn.qkv.weight", NULL, "pos_embed", true, 2 },
};

static int index_of(const char *name)
{
    for (size_t i = 0; i < n; i++)
        if (strcmp(list[i].name, name) == 0)
            return (int)i;
    ck_abort_msg("%s: no such array", name);
}

static void expect_first(const lt_params *set, const char *ours, double want)
{
    const lt_param *p = lt_params_find(set, ours);

    ck_assert_msg(p != NULL, "%s", ours);
    ck_assert_msg(fabs((double)p->data[0] - want) < 1e-4, "%s begins with %g, want %g", ours, (double)p->data[0], want);
}

START_TEST(a_tower)
{
    weights_report r;
    lt_params *set;
    double q;
    model m;

    towers[_i].put();
    check_ok(lt_safetensors_write(in_folder("t.safetensors"), list, n, NULL, 0));
    set = model_of("vit", "{ \"variant\": \"tiny\" }", NULL, &m);
    check_ok(weights_init(arena, in_folder("t.safetensors"), &m, &r));
    ck_assert_str_eq(r.family, towers[_i].family);
    ck_assert_str_eq(r.taken, towers[_i].taken);
    ck_assert_int_eq(r.n_loaded, 7 + LAYERS * 16);
    ck_assert_int_eq(r.n_missing, 0);
    ck_assert_int_eq(r.n_left_over, towers[_i].left_over);
    q = index_of(towers[_i].q);
    expect_first(set, "blocks.5.mlp.fc1.bias", index_of(towers[_i].fc1));
    expect_first(set, "embed.position", index_of(towers[_i].position));
    expect_first(set, "blocks.5.attn.q.weight", q);
    expect_first(set, "blocks.5.attn.k.weight", towers[_i].fused ? q + C / 1024. : index_of(towers[_i].k));
    if (towers[_i].fused)
        expect_first(set, "blocks.5.attn.v.weight", q + 2 * C / 1024.);
    lt_params_free(set);
}
END_TEST

START_TEST(another_size_is_refused)
{
    weights_report r;
    lt_params *set;
    model m;

    put_hugging_face();
    check_ok(lt_safetensors_write(in_folder("t.safetensors"), list, n, NULL, 0));
    set = model_of("vit", "{ \"variant\": \"s16\" }", NULL, &m);
    ck_assert_int_eq(weights_init(arena, in_folder("t.safetensors"), &m, &r), LT_EINVAL);
    lt_params_free(set);
}
END_TEST

static const int place[] = { 0, 3, 6, 8, 10 }, channels[] = { 64, 192, 384, 256, 256 };

static void put_features(const char *format)
{
    static const int in[] = { 3, 64, 192, 384, 256 }, k[] = { 11, 5, 3, 3, 3 };

    for (int i = 0; i < 5; i++) {
        const char *layer = strstr(format, "slice") ? lt_arena_printf(arena, format, i + 1, place[i])
                                                    : lt_arena_printf(arena, format, place[i]);

        put(lt_arena_printf(arena, "%s.weight", layer), 4, channels[i], in[i], k[i], k[i]);
        put(lt_arena_printf(arena, "%s.bias", layer), 1, channels[i], 0, 0, 0);
    }
}

static void put_lins(void)
{
    for (int i = 0; i < 5; i++)
        put(lt_arena_printf(arena, "lin%d.model.1.weight", i), 4, 1, channels[i], 1, 1);
}

static void load(const model *m, weights_report *r)
{
    check_ok(lt_safetensors_write(in_folder("l.safetensors"), list, n, NULL, 0));
    check_ok(weights_init(arena, in_folder("l.safetensors"), m, r));
}

/* torchvision's AlexNet and the channels' weights are two files; a whole network is one. */
START_TEST(lpips_in_two_files_or_one)
{
    weights_report r;
    model m;
    lt_params *set = model_of("lpips", "{}", NULL, &m);

    put_features("features.%d");
    put_layer("classifier.", 0, "1", 16, 16);
    load(&m, &r);
    ck_assert_str_eq(r.family, "torchvision and palmar");
    ck_assert_int_eq(r.n_loaded, 10);
    ck_assert_int_eq(r.n_missing, 5);
    ck_assert_int_eq(r.n_left_over, 2);
    n = 0;
    put_lins();
    load(&m, &r);
    ck_assert_int_eq(r.n_loaded, 5);
    expect_first(set, "lin3.model.1.weight", 3);
    n = 0;
    put_features("net.slice%d.%d");
    put_lins();
    load(&m, &r);
    ck_assert_str_eq(r.family, "LPIPS");
    ck_assert_int_eq(r.n_loaded, 15);
    expect_first(set, "features.10.bias", 9);
    expect_first(set, "lin3.model.1.weight", 13);
    lt_params_free(set);
}
END_TEST

/* What a file of the YOLOv8 layout calls a parameter of csp_seg */
static const char *layer_name(const lt_param *p)
{
    static const struct { const char *ours, *theirs; } part[] = {
        { "backbone.", "model." }, { "neck.", "model." }, { "head.box.", "model.22.cv2." },
        { "head.class.", "model.22.cv3." }, { "head.mask.", "model.22.cv4." }, { "head.", "model.22." },
    };
    size_t i = 0;

    while (strncmp(p->name, part[i].ours, strlen(part[i].ours)) != 0)
        i++;
    return lt_arena_printf(arena, "%s%s", part[i].theirs, p->name + strlen(part[i].ours));
}

static void put_detector(const char *config)
{
    model m;
    lt_params *set = model_of("csp_seg", config, NULL, &m);

    for (const lt_param *p = lt_params_first(set); p; p = p->next)
        put(layer_name(p), p->shape.rank, p->shape.dim[0], p->shape.dim[1], p->shape.dim[2], p->shape.dim[3]);
    lt_params_free(set);
}

/* What finds classes begins fresh where there are others; a network of another size is refused. */
START_TEST(a_detector)
{
    weights_report r;
    model m;
    lt_params *set = model_of("csp_seg", "{\"classes\": 23}", NULL, &m);
    lt_array *first;

    put_detector("{\"classes\": 80}");
    load(&m, &r);
    ck_assert_str_eq(r.family, "YOLOv8's layout");
    ck_assert_str_eq(r.taken, "model.");
    ck_assert_int_eq(r.n_missing, 36);
    ck_assert_int_eq(r.n_left_over, 36);
    ck_assert_int_eq(r.n_loaded + r.n_missing, (int)n);
    ck_assert_str_eq(r.missing[0], "head.class.0.0.conv.weight");
    expect_first(set, "backbone.0.conv.weight", 0);
    n = 0;
    put_detector("{\"classes\": 23}");
    load(&m, &r);
    ck_assert_int_eq(r.n_missing, 0);
    first = &list[0].array;
    first->shape[0] = 32;
    first->data = lt_arena_alloc(arena, lt_array_count(first) * sizeof(float));
    check_ok(lt_safetensors_write(in_folder("l.safetensors"), list, n, NULL, 0));
    check_error(weights_init(arena, in_folder("l.safetensors"), &m, &r), LT_EINVAL, "\"backbone.0.conv.weight\"");
    lt_params_free(set);
}
END_TEST

/* DeepSORT's arrays under our names, in an .npz: its norms have no scale. Its graph itself is refused. */
START_TEST(a_reid)
{
    weights_report r;
    model m;
    lt_params *set = model_of("reid", "{\"reid_compat\": \"tf\"}", NULL, &m);
    int scales = 0;

    for (const lt_param *p = lt_params_first(set); p; p = p->next) {
        const char *end = strrchr(p->name, '.');

        if (p->shape.rank == 1 && strcmp(end, ".weight") == 0)
            scales++;
        else
            put(p->name, p->shape.rank, p->shape.dim[0], p->shape.dim[1], p->shape.dim[2], p->shape.dim[3]);
    }
    ck_assert_int_eq(scales, 15);
    check_ok(lt_npz_write(in_folder("mars.npz"), list, n, false));
    check_ok(weights_init(arena, in_folder("mars.npz"), &m, &r));
    ck_assert_str_eq(r.format, "NumPy (npz)");
    ck_assert_int_eq(r.n_missing, scales);
    ck_assert_int_eq(r.n_loaded, (int)n);
    expect_first(set, "conv1_1.conv.weight", 0);
    put_file(in_folder("mars-small128.pb"), "\n\x10\n\5image", 8);
    check_error(weights_init(arena, in_folder("mars-small128.pb"), &m, &r), LT_EFORMAT, "a frozen graph of TensorFlow");
    lt_params_free(set);
}
END_TEST

/* The names of IDEA-Research/OSX's snapshots, of the whole network, as DataParallel has them */
static void put_osx(void)
{
    put("module.encoder.pos_embed", 3, 1, 193, C, 0);
    put("module.encoder.task_tokens", 3, 1, 31, C, 0);
    put("module.encoder.patch_embed.proj.weight", 4, C, 3, 16, 16);
    put("module.encoder.patch_embed.proj.bias", 1, C, 0, 0, 0);
    put_layer("", 0, "module.encoder.last_norm", C, 0);
    for (int i = 0; i < 12; i++) {
        put_layer("module.encoder.blocks.%d.", i, "norm1", C, 0);
        put_layer("module.encoder.blocks.%d.", i, "attn.qkv", 3 * C, C);
        put_layer("module.encoder.blocks.%d.", i, "attn.proj", C, C);
        put_layer("module.encoder.blocks.%d.", i, "norm2", C, 0);
        put_layer("module.encoder.blocks.%d.", i, "mlp.fc1", 4 * C, C);
        put_layer("module.encoder.blocks.%d.", i, "mlp.fc2", C, 4 * C);
    }
    put_layer("", 0, "module.body_regressor.cam_out.0", 3, C);
}

START_TEST(a_body)
{
    weights_report r;
    model m;
    lt_params *set = model_of("osx", "{}", NULL, &m);

    put_osx();
    check_ok(lt_safetensors_write(in_folder("t.safetensors"), list, n, NULL, 0));
    check_ok(weights_init(arena, in_folder("t.safetensors"), &m, &r));
    ck_assert_str_eq(r.family, "OSX");
    ck_assert_str_eq(r.taken, "module.");
    ck_assert_int_eq(r.n_loaded, 8 + 12 * 16);
    ck_assert_int_eq(r.n_left_over, 0);
    expect_first(set, "encoder.pos_embed", 0);
    expect_first(set, "encoder.blocks.11.attn.k.weight",
                 index_of("module.encoder.blocks.11.attn.qkv.weight") + C / 1024.);
    expect_first(set, "encoder.blocks.11.attn.out.bias", index_of("module.encoder.blocks.11.attn.proj.bias"));
    expect_first(set, "body_regressor.cam_out.0.weight", index_of("module.body_regressor.cam_out.0.weight"));
    lt_params_free(set);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, start, stop);
    tcase_add_loop_test(t, a_tower, 0, (int)LT_COUNT(towers));
    tcase_add_test(t, another_size_is_refused);
    tcase_add_test(t, lpips_in_two_files_or_one);
    tcase_add_test(t, a_detector);
    tcase_add_test(t, a_reid);
    tcase_add_test(t, a_body);
}

int main(void)
{
    return run_suite("weights of parts", add_tests);
}
