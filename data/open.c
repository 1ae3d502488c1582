/* SPDX-License-Identifier: Apache-2.0 */
#include "data/open.h"

#include "data/dexycb/dexycb.h"
#include "data/ho3d/ho3d.h"

#include <dirent.h>
#include <errno.h>
#include <string.h>

lt_status dataset_find_layout(const char *root, dataset_layout *out)
{
    DIR *dir = opendir(root);
    const struct dirent *e;
    bool ho3d = false, dexycb = false;

    if (!dir)
        return lt_error(lt_errno_status(errno), "%s: %s; give the folder of a dataset, or make a synthetic one with `palmar synth`",
                        root, strerror(errno));
    while ((e = readdir(dir))) {
        ho3d = ho3d || !strcmp(e->d_name, "train.txt") || !strcmp(e->d_name, "evaluation.txt");
        dexycb = dexycb || !strcmp(e->d_name, "calibration") || strstr(e->d_name, "-subject-");
    }
    closedir(dir);
    if (!ho3d && !dexycb)
        return lt_error(LT_EIO, "%s: neither train.txt and evaluation.txt, as HO3D has them, nor folders like "
                        "20200709-subject-01, as DexYCB has them", root);
    *out = ho3d ? DATASET_HO3D : DATASET_DEXYCB;
    return LT_OK;
}

static lt_status open_dexycb(const dataset_options *o, const char *models, dataset **out)
{
    dexycb_options dexycb = { .root = o->root, .setup = o->setup ? o->setup : "s0", .split = o->split,
                              .models = models, .hand = o->hand, .left = o->left };
    const lt_status st = dexycb_parse_filter(o->filter ? o->filter : "valid", &dexycb.filter);

    return st ? st : dexycb_open(&dexycb, out);
}

lt_status dataset_open(const dataset_options *o, dataset **out)
{
    const char *models = o->models && *o->models ? o->models : NULL;
    dataset_layout layout;
    const lt_status st = dataset_find_layout(o->root, &layout);

    if (st)
        return st;
    if (layout == DATASET_DEXYCB)
        return open_dexycb(o, models, out);
    return ho3d_open(&(ho3d_options){ .root = o->root, .split = o->split, .models = models, .vertices = o->vertices },
                     out);
}
