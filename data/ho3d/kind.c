/* SPDX-License-Identifier: Apache-2.0 */
/* HO3D as one of the kinds of datasets. */
#include "data/ho3d/ho3d.h"
#include "data/kind.h"

#include <string.h>

static const char *const splits[] = { "train", "evaluation", NULL };

static bool is_list(const char *name)
{
    return !strcmp(name, "train.txt") || !strcmp(name, "evaluation.txt");
}

static bool probe(const char *root)
{
    return dataset_folder_has(root, is_list);
}

static lt_status open_split(const dataset_options *o, dataset **out)
{
    return ho3d_open(&(ho3d_options){ .root = o->root, .split = o->split, .models = o->models,
                                      .vertices = o->vertices }, out);
}

/* The evaluation's truth came years after the data; where it is not, nothing can be validated on that split. */
const dataset_kind ho3d_kind = {
    .title = "HO3D", .splits = splits, .counted = "samples",
    .fields = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_HAND_BOX | SAMPLE_OBJECT | SAMPLE_VERTICES |
              SAMPLE_DEPTH | SAMPLE_SEGMENTS,
    .validation = "evaluation", .validation_truth = "evaluation_xyz.json",
    .probe = probe, .looks_like = "train.txt and evaluation.txt, as HO3D has them",
    .open = open_split,
};
