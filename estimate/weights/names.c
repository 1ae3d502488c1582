/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/weights/names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One part of a block: what they call it, and where it stands in torchvision's list. */
typedef struct {
    const char *theirs;
    int place;
    const char *part;
} part_name;

/* Text behind prefix, or NULL. */
static const char *behind(const char *text, const char *prefix)
{
    const size_t n = strlen(prefix);

    return strncmp(text, prefix, n) == 0 ? text + n : NULL;
}

/* "12.rest" -> 12, and *rest; -1 when there is no number. */
static int take_number(const char *text, const char **rest)
{
    char *end;
    const long n = strtol(text, &end, 10);

    *rest = end + 1;
    return end == text || *end != '.' || n < 0 || n > 999 ? -1 : (int)n;
}

/* The first of list whose name, with a dot behind it, begins text; *rest is behind the dot. */
static const part_name *find(const part_name *list, const char *text, const char **rest)
{
    for (; list->theirs; list++) {
        *rest = behind(text, list->theirs);
        if (*rest && **rest == '.') {
            (*rest)++;
            return list;
        }
    }
    return NULL;
}

/* Whether snprintf had room. */
static bool fits(int length)
{
    return length > 0 && length < WEIGHT_NAME;
}

/* ---- torchvision: ours -------------------------------------------------------------------------------- */

/* PyTorch wraps single layers as well, in parts that begin with "_": "layer1._orig_mod.0.conv1.weight" is
 * "layer1.0.conv1.weight". */
static bool same_name(const char *theirs, char *out)
{
    char *to = out;

    if (!fits(snprintf(out, WEIGHT_NAME, "%s", theirs)))
        return false;
    for (const char *from = out;; from++) {
        while (from[0] == '.' && from[1] == '_')
            from += 1 + strcspn(from + 1, ".");
        *to++ = *from;
        if (!*from)
            return true;
    }
}

/* ---- EfficientNet-B0 ------------------------------------------------------------------------------------ */

enum { STAGES = 7 };
static const int blocks_of_stage[STAGES] = { 1, 2, 2, 3, 3, 4, 1 };

/* What stands outside of blocks. */
static bool outer_name(const part_name *list, const char *theirs, char *out)
{
    const char *rest;
    const part_name *r = find(list, theirs, &rest);

    return r && fits(snprintf(out, WEIGHT_NAME, "%s%s", r->part, rest));
}

/* Part of block k of stage s (from 1). The first stage has no expansion, so its parts stand one earlier. */
static bool block_name(const part_name *list, int s, int k, const char *theirs, char *out)
{
    const char *rest;
    const part_name *r = find(list, theirs, &rest);

    return r && fits(snprintf(out, WEIGHT_NAME, "features.%d.%d.block.%d.%s%s", s, k, r->place - (s == 1),
                                  r->part, rest));
}

/* efficientnet_pytorch numbers all blocks in one row. */
static bool lukemelas_name(const char *theirs, char *out)
{
    static const part_name outer[] = {
        { "_conv_stem", 0, "features.0.0." }, { "_bn0", 0, "features.0.1." }, { "_conv_head", 0, "features.8.0." },
        { "_bn1", 0, "features.8.1." }, { "_fc", 0, "classifier.1." }, { 0 },
    };
    static const part_name inner[] = {
        { "_expand_conv", 0, "0." }, { "_bn0", 0, "1." }, { "_depthwise_conv", 1, "0." }, { "_bn1", 1, "1." },
        { "_se_reduce", 2, "fc1." }, { "_se_expand", 2, "fc2." }, { "_project_conv", 3, "0." }, { "_bn2", 3, "1." },
        { 0 },
    };
    const char *block = behind(theirs, "_blocks."), *rest;
    int n, s = 0;

    if (!block)
        return outer_name(outer, theirs, out);
    n = take_number(block, &rest);
    while (n >= 0 && s < STAGES && n >= blocks_of_stage[s])
        n -= blocks_of_stage[s++];
    return n >= 0 && s < STAGES && block_name(inner, s + 1, n, rest, out);
}

/* timm's first stage has another kind of block, whose norms count from its depthwise convolution. */
static bool timm_name(const char *theirs, char *out)
{
    static const part_name outer[] = {
        { "conv_stem", 0, "features.0.0." }, { "bn1", 0, "features.0.1." }, { "conv_head", 0, "features.8.0." },
        { "bn2", 0, "features.8.1." }, { "classifier", 0, "classifier.1." }, { 0 },
    };
    static const part_name first[] = {
        { "conv_dw", 1, "0." }, { "bn1", 1, "1." }, { "se.conv_reduce", 2, "fc1." }, { "se.conv_expand", 2, "fc2." },
        { "conv_pw", 3, "0." }, { "bn2", 3, "1." }, { 0 },
    };
    static const part_name inner[] = {
        { "conv_pw", 0, "0." }, { "bn1", 0, "1." }, { "conv_dw", 1, "0." }, { "bn2", 1, "1." },
        { "se.conv_reduce", 2, "fc1." }, { "se.conv_expand", 2, "fc2." }, { "conv_pwl", 3, "0." }, { "bn3", 3, "1." },
        { 0 },
    };
    const char *block = behind(theirs, "blocks."), *rest, *part;
    int s, k;

    if (!block)
        return outer_name(outer, theirs, out);
    s = take_number(block, &rest);
    k = s < 0 ? -1 : take_number(rest, &part);
    return k >= 0 && block_name(s == 0 ? first : inner, s + 1, k, part, out);
}

/* ---- ResNet within HFL-Net and Semi-Hand-Object ------------------------------------------------------------ */

/* "layer0_h.0." is conv1, "layer0_h.1." bn1, "layer2_h.0.3." layer2.3; the object's copies have no place. */
static bool hfl_name(const char *theirs, char *out)
{
    const char *layer = behind(theirs, "layer"), *rest;
    const int n = layer ? atoi(layer) : -1;

    rest = layer && *layer >= '0' && *layer <= '4' ? behind(layer + 1, "_h.") : NULL;
    if (!rest)
        return false;
    if (n == 0 && behind(rest, "0."))
        return fits(snprintf(out, WEIGHT_NAME, "conv1.%s", rest + 2));
    if (n == 0 && behind(rest, "1."))
        return fits(snprintf(out, WEIGHT_NAME, "bn1.%s", rest + 2));
    rest = n > 0 ? behind(rest, "0.") : NULL;
    return rest && fits(snprintf(out, WEIGHT_NAME, "layer%d.%s", n, rest));
}

/* ---- CLIP's image tower, and other vision transformers --------------------------------------------------- */

/* Names of a tower: whole ones, prefixes of what stands outside of blocks, and within them. Queries, keys and values
 * that a file has in one array are three by now: weight_split.h. */
typedef struct {
    const char *blocks;
    part_name whole[3], outer[4], inner[9];
} tower_names;

static bool tower_name(const tower_names *t, const char *theirs, char *out)
{
    const char *block = behind(theirs, t->blocks), *rest, *part;
    const part_name *r;
    int n;

    for (r = t->whole; r->theirs; r++)
        if (strcmp(r->theirs, theirs) == 0)
            return fits(snprintf(out, WEIGHT_NAME, "%s", r->part));
    if (!block)
        return outer_name(t->outer, theirs, out);
    n = take_number(block, &rest);
    r = n < 0 ? NULL : find(t->inner, rest, &part);
    return r && fits(snprintf(out, WEIGHT_NAME, "blocks.%d.%s%s", n, r->part, part));
}

static bool openai_name(const char *theirs, char *out)
{
    static const tower_names names = {
        "transformer.resblocks.",
        { { "class_embedding", 0, "embed.class_token" }, { "positional_embedding", 0, "embed.position" } },
        { { "conv1", 0, "embed.patch." }, { "ln_pre", 0, "norm_pre." }, { "ln_post", 0, "norm." } },
        { { "ln_1", 0, "norm1." }, { "ln_2", 0, "norm2." }, { "attn.q_proj", 0, "attn.q." },
          { "attn.k_proj", 0, "attn.k." }, { "attn.v_proj", 0, "attn.v." }, { "attn.out_proj", 0, "attn.out." },
          { "mlp.c_fc", 0, "mlp.fc1." }, { "mlp.c_proj", 0, "mlp.fc2." } },
    };

    return tower_name(&names, theirs, out);
}

/* pre_layrnorm is spelt so. */
static bool hugging_face_name(const char *theirs, char *out)
{
    static const tower_names names = {
        "encoder.layers.",
        { { "embeddings.class_embedding", 0, "embed.class_token" },
          { "embeddings.position_embedding.weight", 0, "embed.position" } },
        { { "embeddings.patch_embedding", 0, "embed.patch." }, { "pre_layrnorm", 0, "norm_pre." },
          { "post_layernorm", 0, "norm." } },
        { { "layer_norm1", 0, "norm1." }, { "layer_norm2", 0, "norm2." }, { "self_attn.q_proj", 0, "attn.q." },
          { "self_attn.k_proj", 0, "attn.k." }, { "self_attn.v_proj", 0, "attn.v." },
          { "self_attn.out_proj", 0, "attn.out." }, { "mlp.fc1", 0, "mlp.fc1." }, { "mlp.fc2", 0, "mlp.fc2." } },
    };

    return tower_name(&names, theirs, out);
}

static bool timm_vit_name(const char *theirs, char *out)
{
    static const tower_names names = {
        "blocks.",
        { { "cls_token", 0, "embed.class_token" }, { "pos_embed", 0, "embed.position" } },
        { { "patch_embed.proj", 0, "embed.patch." }, { "norm_pre", 0, "norm_pre." }, { "norm", 0, "norm." } },
        { { "norm1", 0, "norm1." }, { "norm2", 0, "norm2." }, { "attn.q_proj", 0, "attn.q." },
          { "attn.k_proj", 0, "attn.k." }, { "attn.v_proj", 0, "attn.v." }, { "attn.proj", 0, "attn.out." },
          { "mlp.fc1", 0, "mlp.fc1." }, { "mlp.fc2", 0, "mlp.fc2." } },
    };

    return tower_name(&names, theirs, out);
}

/* OSX's encoder has timm's blocks; everything else is called as here. */
static bool osx_name(const char *theirs, char *out)
{
    static const part_name inner[] = {
        { "attn.q_proj", 0, "attn.q." }, { "attn.k_proj", 0, "attn.k." }, { "attn.v_proj", 0, "attn.v." },
        { "attn.proj", 0, "attn.out." }, { 0 },
    };
    const char *block = behind(theirs, "encoder.blocks."), *rest, *part;
    const int n = block ? take_number(block, &rest) : -1;
    const part_name *r = n < 0 ? NULL : find(inner, rest, &part);

    return r ? fits(snprintf(out, WEIGHT_NAME, "encoder.blocks.%d.%s%s", n, r->part, part)) : same_name(theirs, out);
}

/* ---- LPIPS -------------------------------------------------------------------------------------------------- */

/* The whole network's file has torchvision's places behind its slices: "net.slice2.3." is features.3. */
static bool lpips_name_of(const char *theirs, char *out)
{
    const char *slice = behind(theirs, "net.slice"), *place;

    if (!slice)
        return behind(theirs, "lin") && same_name(theirs, out);
    return take_number(slice, &place) > 0 && fits(snprintf(out, WEIGHT_NAME, "features.%s", place));
}

/* ---- csp_seg, in the YOLOv8 layout ----------------------------------------------------------------------- */

/* Layers have the figure's numbers: 0 to 9 are the backbone, 22 the head, what lies between the neck. */
static bool yolo_name(const char *theirs, char *out)
{
    static const part_name head[] = { { "cv2", 0, "box" }, { "cv3", 0, "class" }, { "cv4", 0, "mask" },
                                      { "proto", 0, "proto" }, { "dfl", 0, "dfl" }, { 0 } };
    enum { NECK = 10, HEAD = 22 };
    const char *rest, *part;
    const int n = take_number(theirs, &rest);
    const part_name *r;

    if (n < 0 || n > HEAD)
        return false;
    if (n < HEAD)
        return fits(snprintf(out, WEIGHT_NAME, "%s.%s", n < NECK ? "backbone" : "neck", theirs));
    r = find(head, rest, &part);
    return r && fits(snprintf(out, WEIGHT_NAME, "head.%s.%s", r->part, part));
}

/* ---- families --------------------------------------------------------------------------------------------- */

const weight_family weight_families[] = {
    { "torchvision and palmar", NULL, same_name },
    { "timm", "if they are of a tf_ model, they were trained with TensorFlow's padding and a norm's eps of 1e-3",
      timm_name },
    { "efficientnet_pytorch",
      "its weights were trained with TensorFlow's padding and a norm's eps of 1e-3; here padding is symmetric and "
      "eps 1e-5, so expect to train on", lukemelas_name },
    { "HFL-Net", NULL, hfl_name },
    { "OpenAI's CLIP", NULL, openai_name },
    { "Hugging Face's CLIP", NULL, hugging_face_name },
    { "timm's ViT",
      "those that are not of CLIP were trained with exact GELU and a bias of the patches, which this network has not: "
      "expect to train on", timm_vit_name },
    { "OSX", NULL, osx_name },
    { "LPIPS", NULL, lpips_name_of },
    { "YOLOv8's layout", NULL, yolo_name },
    { 0 },
};
