/* SPDX-License-Identifier: Apache-2.0 */
/* Initial weights from other people's files: every published name finds its parameter, and only that. */
#include "assets/hand/hand.h"
#include "estimate/weights/place.h"
#include "estimate/weights/weights.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "tasks/tasks.h"
#include "tests/estimate/weight_names.h"
#include "tests/models/model_of.h"
#include "tests/suite.h"
#include "train/config.h"

#include <math.h>

static const char small_resnet[] = "{ \"width\": 8, \"classes\": 4, \"image_size\": 32 }";

/* ---- names -------------------------------------------------------------------------------------------- */

static const struct {
    const char *const *theirs, *const *ours;
    int n;
    const char *family, *model, *config;
} families[] = {
    { names_resnet50, names_resnet50, LT_COUNT(names_resnet50), "torchvision and palmar", "resnet50", small_resnet },
    { names_resnet50_hfl, names_resnet50, LT_COUNT(names_resnet50_hfl), "HFL-Net", "resnet50", small_resnet },
    { names_efficientnet, names_efficientnet, LT_COUNT(names_efficientnet), "torchvision and palmar", "efficientnet_b0",
      "{}" },
    { names_efficientnet_timm, names_efficientnet, LT_COUNT(names_efficientnet_timm), "timm", "efficientnet_b0",
      "{}" },
    { names_efficientnet_lukemelas, names_efficientnet, LT_COUNT(names_efficientnet_lukemelas),
      "efficientnet_pytorch", "efficientnet_b0", "{}" },
    { names_pointnet2_ulip, names_pointnet2, LT_COUNT(names_pointnet2_ulip), "torchvision and palmar", "pointnet2",
      "{ \"variant\": \"ulip\" }" },
};

/* Arrays of these names, shaped as the parameters that they should be. */
static void list_arrays(const lt_params *set, int family, lt_named_array *list, size_t *within)
{
    for (int i = 0; i < families[family].n; i++) {
        const lt_param *p = lt_params_find(set, families[family].ours[i]);

        ck_assert_msg(p != NULL, "%s is no parameter", families[family].ours[i]);
        list[i].name = families[family].theirs[i];
        list[i].array = lt_array_make(LT_ELEM_F4, p->shape.rank, p->shape.dim, NULL);
        within[i] = 0;
    }
}

START_TEST(every_name)
{
    lt_named_array list[320] = { { 0 } };
    size_t within[320];
    const lt_weights_file file = { .path = "x", .n = (size_t)families[_i].n, .entry = list, .within = within };
    lt_arena *arena = lt_arena_new();
    weight_place place;
    model m;
    lt_params *set = model_of(families[_i].model, families[_i].config, NULL, &m);

    list_arrays(set, _i, list, within);
    check_ok(weight_place_find(arena, &file, &m, &place));
    ck_assert_str_eq(place.family->name, families[_i].family);
    ck_assert_int_eq(place.fit, families[_i].n);
    ck_assert_int_eq(place.n_also, 0);
    for (int i = 0; i < families[_i].n; i++)
        ck_assert_ptr_eq(weight_param(&place, &m, list[i].name), lt_params_find(set, families[_i].ours[i]));
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

START_TEST(no_name)
{
    static const struct {
        const char *family, *theirs;
    } cases[] = {
        { "timm", "blocks.7.0.conv_pw.weight.x" }, { "timm", "blocks.x.0.conv_pw.weight" },
        { "timm", "blocks.1.conv_pw.weight" }, { "timm", "blocks.1.0.conv_xx.weight" },
        { "efficientnet_pytorch", "_blocks.16._bn0.weight" }, { "efficientnet_pytorch", "_blocks.-1._bn0.weight" },
        { "efficientnet_pytorch", "_blocks." }, { "efficientnet_pytorch", "swish" },
        { "HFL-Net", "layer2_o.0.1.conv1.weight" }, { "HFL-Net", "layer9_h.0.1.conv1.weight" },
        { "HFL-Net", "layer0_h.2.weight" }, { "HFL-Net", "layer1_h.3.weight" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        const weight_family *f = weight_families;
        char name[WEIGHT_NAME];
        lt_params *set;
        model m;

        while (strcmp(f->name, cases[i].family) != 0)
            f++;
        if (!f->ours(cases[i].theirs, name))
            continue;
        set = model_of("efficientnet_b0", "{}", NULL, &m);
        ck_assert_msg(!lt_params_find(set, name), "%s became %s", cases[i].theirs, name);
        lt_params_free(set);
    }
}
END_TEST

/* ---- files -------------------------------------------------------------------------------------------- */

START_TEST(from_pytorch)
{
    lt_arena *arena = lt_arena_new();
    weights_report r;
    model m;
    lt_params *set = model_of("resnet50", small_resnet, NULL, &m);

    put_file(in_folder("stem.pth"), resnet_stem, sizeof(resnet_stem));
    check_ok(weights_init(arena, in_folder("stem.pth"), &m, &r));
    ck_assert_str_eq(r.format, "PyTorch (zip)");
    ck_assert_str_eq(r.family, "torchvision and palmar");
    ck_assert_int_eq(r.n_loaded, 3);
    ck_assert_int_eq(r.n_missing, (int)LT_COUNT(names_resnet50) - 3);
    ck_assert_str_eq(r.missing[0], "bn1.bias");
    ck_assert_int_eq(r.n_left_over, 1);
    ck_assert_str_eq(r.left_over[0], "module.head.weight");
    ck_assert(lt_params_find(set, "conv1.weight")->data[1175] == (lt_real)1175 / 8);
    ck_assert(lt_params_find(set, "bn1.weight")->data[7] == 7);
    ck_assert(lt_params_find(set, "bn1.running_var")->data[3] == 2);
    ck_assert_str_eq(weights_list(arena, r.left_over, 1), "module.head.weight");
    ck_assert_str_eq(weights_list(arena, r.left_over, 0), "none");
    ck_assert_ptr_nonnull(strstr(weights_list(arena, r.missing, r.n_missing), " and 256 more"));
    lt_params_free(set);
    set = model_of("resnet50", "{ \"width\": 16, \"classes\": 4, \"image_size\": 32 }", NULL, &m);
    check_error(weights_init(arena, in_folder("stem.pth"), &m, &r), LT_EINVAL,
                "\"module.conv1.weight\" is (8, 3, 7, 7), the model's \"conv1.weight\" is (16, 3, 7, 7)");
    lt_params_free(set);
    set = model_of("efficientnet_b0", "{}", NULL, &m);
    check_error(weights_init(arena, in_folder("stem.pth"), &m, &r), LT_EINVAL, "none of its 5 arrays");
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

static lt_named_array array_of(const char *name, int rank, const int64_t *shape, const float *data)
{
    return (lt_named_array){ name, lt_array_make(LT_ELEM_F4, rank, shape, data) };
}

START_TEST(translated)
{
    float data[32 * 27] = { 1, 2, 3 };
    const lt_named_array list[] = {
        array_of("module._conv_stem.weight", 4, (int64_t[]){ 32, 3, 3, 3 }, data),
        array_of("module._bn0.weight", 1, (int64_t[]){ 32 }, data + 1),
        array_of("module._blocks.5._bn0.weight", 1, (int64_t[]){ 240 }, data + 2),
        array_of("optim.m._fc.weight", 1, (int64_t[]){ 1 }, data),
    };
    lt_arena *arena = lt_arena_new();
    weights_report r;
    model m;
    lt_params *set = model_of("efficientnet_b0", "{}", NULL, &m);

    check_ok(lt_safetensors_write(in_folder("e.safetensors"), list, LT_COUNT(list), NULL, 0));
    check_ok(weights_init(arena, in_folder("e.safetensors"), &m, &r));
    ck_assert_str_eq(r.format, "safetensors");
    ck_assert_int_eq(r.n_loaded, 3);
    ck_assert_int_eq(r.n_left_over, 0);
    ck_assert_ptr_nonnull(strstr(r.note, "TensorFlow"));
    ck_assert(lt_params_find(set, "features.0.0.weight")->data[0] == 1);
    ck_assert(lt_params_find(set, "features.0.1.weight")->data[0] == 2);
    ck_assert(lt_params_find(set, "features.4.0.block.0.1.weight")->data[0] == 3);
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

/* What programs put before names, today and next year: dicts and wrappers of any name, one in another. */
START_TEST(behind_any_prefix)
{
    static const char *const prefixes[] = {
        "", "module.", "_orig_mod.", "model.", "net.", "backbone.", "module.module.", "encoder_q.",
        "base.model.backbone.", "what.comes.next.year.", "x.0.",
    };
    static const char *const names[] = { "conv1.weight", "bn1.weight", "bn1.bias", "layer1.0.bn1.weight" };
    float data[8 * 3 * 49] = { 1, 2, 3 };
    lt_arena *arena = lt_arena_new();

    for (size_t i = 0; i < LT_COUNT(prefixes); i++) {
        lt_named_array list[LT_COUNT(names) + 1] = { array_of("other.bn1.weight", 1, (int64_t[]){ 5 }, data) };
        weights_report r;
        model m;
        lt_params *set = model_of("resnet50", small_resnet, NULL, &m);

        for (size_t k = 0; k < LT_COUNT(names); k++)
            list[k + 1] = array_of(lt_arena_printf(arena, "%s%s", prefixes[i], names[k]), k ? 1 : 4,
                                   k ? (int64_t[]){ 8 } : (int64_t[]){ 8, 3, 7, 7 }, data);
        check_ok(lt_safetensors_write(in_folder("p.safetensors"), list, LT_COUNT(list), NULL, 0));
        check_ok(weights_init(arena, in_folder("p.safetensors"), &m, &r));
        ck_assert_str_eq(r.taken, prefixes[i]);
        ck_assert_int_eq(r.n_loaded, (int)LT_COUNT(names));
        ck_assert_int_eq(r.n_also, 0);
        ck_assert_int_eq(r.n_left_over, 1);
        ck_assert(lt_params_find(set, "layer1.0.bn1.weight")->data[1] == 2);
        lt_params_free(set);
    }
    lt_arena_free(arena);
}
END_TEST

/* Single layers may be wrapped too: torch.compile, FSDP and checkpoints of activations leave a part within the name. */
START_TEST(wrapped_within)
{
    float data[8] = { 1, 2 };
    const lt_named_array list[] = {
        array_of("net.bn1._orig_mod.weight", 1, (int64_t[]){ 8 }, data),
        array_of("net.bn1._orig_mod.bias", 1, (int64_t[]){ 8 }, data),
        array_of("net.layer1._fsdp_wrapped_module._orig_mod.0._checkpoint_wrapped_module.bn1.weight", 1,
                 (int64_t[]){ 8 }, data),
        array_of("net._orig_mod_", 1, (int64_t[]){ 8 }, data), array_of("net._", 1, (int64_t[]){ 8 }, data),
    };
    lt_arena *arena = lt_arena_new();
    weights_report r;
    model m;
    lt_params *set = model_of("resnet50", small_resnet, NULL, &m);

    check_ok(lt_safetensors_write(in_folder("w.safetensors"), list, LT_COUNT(list), NULL, 0));
    check_ok(weights_init(arena, in_folder("w.safetensors"), &m, &r));
    ck_assert_str_eq(r.taken, "net.");
    ck_assert_int_eq(r.n_loaded, 3);
    ck_assert_int_eq(r.n_left_over, 2);
    ck_assert(lt_params_find(set, "layer1.0.bn1.weight")->data[1] == 2);
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

/* Names alone do not tell: those behind which the shapes are the model's are taken. Of two alike the first, and both
 * are named. */
START_TEST(two_places)
{
    float data[16] = { 1 }, other[16] = { 2 };
    lt_named_array list[] = {
        array_of("teacher.bn1.weight", 1, (int64_t[]){ 16 }, data),
        array_of("teacher.bn1.bias", 1, (int64_t[]){ 16 }, data),
        array_of("encoder_q.bn1.weight", 1, (int64_t[]){ 8 }, other),
        array_of("encoder_k.bn1.weight", 1, (int64_t[]){ 8 }, data),
    };
    lt_arena *arena = lt_arena_new();
    weights_report r;
    model m;
    lt_params *set = model_of("resnet50", small_resnet, NULL, &m);

    check_ok(lt_safetensors_write(in_folder("two.safetensors"), list, LT_COUNT(list), NULL, 0));
    check_ok(weights_init(arena, in_folder("two.safetensors"), &m, &r));
    ck_assert_str_eq(r.taken, "encoder_q.");
    ck_assert_int_eq(r.n_also, 1);
    ck_assert_str_eq(r.also[0], "encoder_k.");
    ck_assert_int_eq(r.n_loaded, 1);
    ck_assert(lt_params_find(set, "bn1.weight")->data[0] == 2);
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

/* A file of 8-bit floats is read for what else it has, and refused by him who wants one of them. */
START_TEST(unread_elements)
{
    static const char text[] = "{\"bn1.weight\":{\"dtype\":\"F32\",\"shape\":[8],\"data_offsets\":[0,32]},"
                               "\"%s\":{\"dtype\":\"F8_E4M3\",\"shape\":[8],\"data_offsets\":[32,40]}}";
    static const char *const names[] = { "scale", "bn1.bias" };
    lt_arena *arena = lt_arena_new();

    for (int i = 0; i < 2; i++) {
        uint8_t bytes[256] = { 0 };
        weights_report r;
        model m;
        lt_params *set = model_of("resnet50", small_resnet, NULL, &m);
        const int n = snprintf((char *)bytes + 8, sizeof(bytes) - 8, text, names[i]);

        bytes[0] = (uint8_t)n;
        memset(bytes + 8 + n, 0, 40);
        put_file(in_folder("f8.safetensors"), bytes, 8 + (size_t)n + 40);
        if (i == 0) {
            check_ok(weights_init(arena, in_folder("f8.safetensors"), &m, &r));
            ck_assert_int_eq(r.n_loaded, 1);
        } else {
            check_error(weights_init(arena, in_folder("f8.safetensors"), &m, &r), LT_EFORMAT,
                        "\"bn1.bias\", which \"bn1.bias\" wants: dtype \"F8_E4M3\" is not read, want one of F32 ");
        }
        lt_params_free(set);
    }
    lt_arena_free(arena);
}
END_TEST

/* Weights in several files, by their index, whose names stay in its folder. */
START_TEST(in_several_files)
{
    static const char index[] = "{\"metadata\": {}, \"weight_map\": {\"bn1.weight\": \"a.safetensors\", "
                                "\"bn1.bias\": \"deep/b.safetensors\", \"bn1.running_mean\": \"a.safetensors\"}}";
    static const char *const outside[] = { "../a.safetensors", "/etc/passwd", "a/../../b", "", "C:x" };
    float data[8] = { 1, 2 };
    const lt_named_array a[] = { array_of("bn1.weight", 1, (int64_t[]){ 8 }, data),
                                 array_of("bn1.running_mean", 1, (int64_t[]){ 8 }, data) };
    const lt_named_array b[] = { array_of("bn1.bias", 1, (int64_t[]){ 8 }, data) };
    lt_arena *arena = lt_arena_new();
    char text[256];
    weights_report r;
    model m;
    lt_params *set = model_of("resnet50", small_resnet, NULL, &m);

    check_ok(lt_make_dirs(in_folder("deep")));
    put_file(in_folder("model.safetensors.index.json"), index, sizeof(index) - 1);
    check_ok(lt_safetensors_write(in_folder("a.safetensors"), a, 2, NULL, 0));
    check_error(weights_init(arena, in_folder("model.safetensors.index.json"), &m, &r), LT_EIO,
                "index.json: an index, whose files lie in its folder: ");
    check_ok(lt_safetensors_write(in_folder("deep/b.safetensors"), b, 1, NULL, 0));
    check_ok(weights_init(arena, in_folder("model.safetensors.index.json"), &m, &r));
    ck_assert_int_eq(r.n_loaded, 3);
    ck_assert_str_eq(r.format, "safetensors in 2 files");
    ck_assert(lt_params_find(set, "bn1.bias")->data[1] == 2);
    put_file(in_folder("pytorch_model-1.bin"), resnet_stem, sizeof(resnet_stem));
    snprintf(text, sizeof(text), "{\"weight_map\": {\"conv1.weight\": \"pytorch_model-1.bin\"}}");
    put_file(in_folder("pytorch_model.bin.index.json"), text, strlen(text));
    check_ok(weights_init(arena, in_folder("pytorch_model.bin.index.json"), &m, &r));
    ck_assert_str_eq(r.format, "PyTorch (zip) in 1 file");
    ck_assert_int_eq(r.n_loaded, 3);
    for (size_t i = 0; i < LT_COUNT(outside); i++) {
        snprintf(text, sizeof(text), "{\"weight_map\": {\"x\": \"%s\"}}", outside[i]);
        put_file(in_folder("out.json"), text, strlen(text));
        check_error(weights_init(arena, in_folder("out.json"), &m, &r), LT_EFORMAT, "want a file in its own folder");
    }
    put_file(in_folder("out.json"), "{\"weight_map\": {}}", 18);
    check_error(weights_init(arena, in_folder("out.json"), &m, &r), LT_EFORMAT, "names no file");
    put_file(in_folder("out.json"), "{\"model\": {}}", 13);
    check_error(weights_init(arena, in_folder("out.json"), &m, &r), LT_EFORMAT, "out.json: a JSON file, want ");
    snprintf(text, sizeof(text), "{\"weight_map\": {\"x\": \"out.json\"}}");
    put_file(in_folder("out.json"), text, strlen(text));
    check_error(weights_init(arena, in_folder("out.json"), &m, &r), LT_EFORMAT, "out.json: a JSON file, want ");
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

START_TEST(refused)
{
    float data[8] = { 0 };
    lt_named_array list[] = { array_of("bn1.weight", 1, (int64_t[]){ 8 }, data) };
    lt_named_array strange[] = {
        array_of("a.kernel", 1, (int64_t[]){ 8 }, data), array_of("b", 1, (int64_t[]){ 8 }, data),
    };
    lt_arena *arena = lt_arena_new();
    weights_report r;
    model m;
    lt_params *set = model_of("resnet50", small_resnet, NULL, &m);

    check_ok(lt_safetensors_write(in_folder("strange.safetensors"), strange, 2, NULL, 0));
    check_error(weights_init(arena, in_folder("strange.safetensors"), &m, &r), LT_EINVAL,
                "none of its 2 arrays has the name of a parameter of resnet50; it has a.kernel, b, and wanted are "
                "conv1.weight, bn1.weight, bn1.bias ...");
    data[5] = 1.0f / 0.0f;
    check_ok(lt_safetensors_write(in_folder("inf.safetensors"), list, 1, NULL, 0));
    check_error(weights_init(arena, in_folder("inf.safetensors"), &m, &r), LT_EFORMAT, "is not finite at 5");
    check_error(weights_init(arena, in_folder("none.pth"), &m, &r), LT_EIO, "No such file");
    put_file(in_folder("text.pth"), "hello, world", 12);
    check_error(weights_init(arena, in_folder("text.pth"), &m, &r), LT_EFORMAT, "not a safetensors file");
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

/* torchvision's names behind the block that HOCAT has them in */
START_TEST(into_hocat)
{
    static const char text[] = "{ \"model\": { \"name\": \"hocat\", \"image_size\": 64, \"width\": 8, "
                               "\"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 1, \"heads\": 2 } }";
    float data[8] = { 0 };
    const lt_named_array twice[] = { array_of("bn1.weight", 1, (int64_t[]){ 8 }, data),
                                     array_of("trunk.bn1.weight", 1, (int64_t[]){ 8 }, data) };
    lt_arena *arena = lt_arena_new();
    lt_params *set = lt_params_new();
    lt_hand_model *hand;
    lt_hand_layer *layer;
    weights_report r;
    train_config c;
    model m;

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(lt_hand_layer_new(arena, hand, lt_hand_tips_ho3d, &layer));
    check_ok(train_config_parse(arena, tasks, "tiny", text, NULL, 0, &c));
    check_ok(train_config_model(&c, layer, set, &m));
    check_ok(train_config_init(&c, &m));
    put_file(in_folder("stem.pth"), resnet_stem, sizeof(resnet_stem));
    check_ok(weights_init(arena, in_folder("stem.pth"), &m, &r));
    ck_assert_int_eq(r.n_loaded, 3);
    ck_assert(lt_params_find(set, "trunk.conv1.weight")->data[1175] == (lt_real)1175 / 8);
    check_ok(lt_safetensors_write(in_folder("twice.safetensors"), twice, 2, NULL, 0));
    check_error(weights_init(arena, in_folder("twice.safetensors"), &m, &r), LT_EFORMAT,
                "\"trunk.bn1.weight\" is the second array for \"trunk.bn1.weight\"");
    train_config_fini(&c);
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

/* Both streams of the unified estimator begin as one EfficientNet; the depth's first layer as the sum of the colours'.
 * What has names of both is nobody's twin. */
START_TEST(into_both_streams)
{
    static const char text[] = "{ \"model\": { \"name\": \"unified\", \"image_size\": 64 } }";
    float stem[32 * 27] = { 0 }, norm[32] = { 5, 6 };
    lt_named_array list[] = {
        array_of("features.0.0.weight", 4, (int64_t[]){ 32, 3, 3, 3 }, stem),
        array_of("features.0.1.weight", 1, (int64_t[]){ 32 }, norm),
    };
    lt_arena *arena = lt_arena_new();
    lt_params *set = lt_params_new();
    const lt_param *depth;
    lt_hand_model *hand;
    lt_hand_layer *layer;
    weights_report r;
    train_config c;
    model m;

    for (int i = 0; i < 32 * 27; i++)
        stem[i] = (float)i;
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(lt_hand_layer_new(arena, hand, lt_hand_tips_ho3d, &layer));
    check_ok(train_config_parse(arena, tasks, "unified", text, NULL, 0, &c));
    check_ok(train_config_model(&c, layer, set, &m));
    check_ok(train_config_init(&c, &m));
    check_ok(lt_safetensors_write(in_folder("b0.safetensors"), list, 2, NULL, 0));
    check_ok(weights_init(arena, in_folder("b0.safetensors"), &m, &r));
    ck_assert_int_eq(r.n_loaded, 4);
    depth = lt_params_find(set, "depth.features.0.0.weight");
    ck_assert_int_eq(depth->shape.dim[1], 1);
    ck_assert(depth->data[9 * 7 + 4] == (lt_real)(3 * (27 * 7 + 9 + 4)));
    ck_assert(lt_params_find(set, "depth.features.0.1.weight")->data[1] == 6);
    ck_assert(lt_params_find(set, "rgb.features.0.1.weight")->data[1] == 6);
    list[0].name = "rgb.features.0.0.weight", list[1].name = "rgb.features.0.1.weight";
    check_ok(lt_safetensors_write(in_folder("b0.safetensors"), list, 2, NULL, 0));
    check_ok(weights_init(arena, in_folder("b0.safetensors"), &m, &r));
    ck_assert_int_eq(r.n_loaded, 2);
    train_config_fini(&c);
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

/* What a run of ours left: its folder names its last checkpoint, whose averages are better than its weights. */
START_TEST(from_a_run)
{
    float data[8] = { 1 }, average[8] = { 2 };
    lt_named_array list[] = {
        array_of("bn1.weight", 1, (int64_t[]){ 8 }, data), array_of("bn1.bias", 1, (int64_t[]){ 8 }, data),
        array_of("optim.ema.bn1.weight", 1, (int64_t[]){ 8 }, average),
        array_of("optim.m.bn1.bias", 1, (int64_t[]){ 8 }, average),
    };
    lt_arena *arena = lt_arena_new();
    weights_report r;
    model m;
    lt_params *set = model_of("resnet50", small_resnet, NULL, &m);

    check_error(weights_init(arena, in_folder("."), &m, &r), LT_EIO, "/checkpoints/last.safetensors: No such file");
    check_ok(lt_make_dirs(in_folder("run/checkpoints")));
    check_ok(lt_safetensors_write(in_folder("run/checkpoints/last.safetensors"), list, LT_COUNT(list), NULL, 0));
    check_ok(weights_init(arena, in_folder("run"), &m, &r));
    ck_assert_int_eq(r.n_loaded, 2);
    ck_assert_int_eq(r.n_left_over, 0);
    ck_assert(lt_params_find(set, "bn1.weight")->data[0] == 2);
    ck_assert(lt_params_find(set, "bn1.bias")->data[0] == 1);
    average[7] = NAN;
    check_ok(lt_safetensors_write(in_folder("run/checkpoints/last.safetensors"), list, LT_COUNT(list), NULL, 0));
    check_error(weights_init(arena, in_folder("run"), &m, &r), LT_EFORMAT,
                "\"optim.ema.bn1.weight\" is not finite at 7");
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, every_name, 0, LT_COUNT(families));
    tcase_add_test(tc, no_name);
    tcase_add_test(tc, from_pytorch);
    tcase_add_test(tc, translated);
    tcase_add_test(tc, behind_any_prefix);
    tcase_add_test(tc, wrapped_within);
    tcase_add_test(tc, two_places);
    tcase_add_test(tc, unread_elements);
    tcase_add_test(tc, in_several_files);
    tcase_add_test(tc, refused);
    tcase_add_test(tc, into_hocat);
    tcase_add_test(tc, into_both_streams);
    tcase_add_test(tc, from_a_run);
}

int main(void)
{
    return run_suite("weights", add_tests);
}
