/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/weight_names.h"

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

/* ---- families --------------------------------------------------------------------------------------------- */

const weight_family weight_families[] = {
    { "torchvision and palmar", NULL, same_name },
    { "timm", "if they are of a tf_ model, they were trained with TensorFlow's padding and a norm's eps of 1e-3",
      timm_name },
    { "efficientnet_pytorch",
      "its weights were trained with TensorFlow's padding and a norm's eps of 1e-3; here padding is symmetric and "
      "eps 1e-5, so expect to train on", lukemelas_name },
    { "HFL-Net", NULL, hfl_name },
    { 0 },
};
