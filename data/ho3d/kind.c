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

/* By the letters that sequences begin with; the generator's say it by a digit. */
static int subject(const char *name)
{
    static const struct { const char *letters; int subject; } of[] = {
        { "ABF", 0 }, { "BB", 1 }, { "GPMF", 2 }, { "GSF", 2 }, { "MC", 3 }, { "MDF", 4 }, { "ND", 5 }, { "SMu", 6 },
        { "SM", 6 }, { "ShSu", 7 }, { "SiBF", 8 }, { "SiS", 8 }, { "SS", 9 }, { "SB", 10 }, { "AP", 11 }, { "MPM", 12 },
        { "SHSU", 7 },
    };

    if (strncmp(name, "SYN", 3) == 0 && name[3] >= '0' && name[3] <= '9')
        return name[3] - '0';
    for (size_t i = 0; i < LT_COUNT(of); i++)
        if (strncmp(name, of[i].letters, strlen(of[i].letters)) == 0)
            return of[i].subject;
    return -1;
}

/* The evaluation's truth came years after the data; where it is not, nothing can be validated on that split. */
const dataset_kind ho3d_kind = {
    .title = "HO3D", .splits = splits, .counted = "samples",
    .fields = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_HAND_BOX | SAMPLE_OBJECT | SAMPLE_VERTICES |
              SAMPLE_DEPTH | SAMPLE_SEGMENTS,
    .validation = "evaluation", .validation_truth = "evaluation_xyz.json",
    .subject = subject, .probe = probe, .looks_like = "train.txt and evaluation.txt, as HO3D has them",
    .open = open_split,
};
