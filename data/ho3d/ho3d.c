/* SPDX-License-Identifier: Apache-2.0 */
/* Opens an HO3D tree: its list, the objects' models, the truth of the evaluation. */
#include "data/ho3d/internal.h"

#include "assets/ycb/ycb.h"
#include "libtensor/io/file.h"
#include "libtensor/io/pickle/pickle.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* ---- its files ---- */

static const char *missing_file(const dataset *d, int64_t index, lt_arena *arena)
{
    const ho3d *h = (const ho3d *)d;
    const char *const file[] = { ho3d_picture(h, index, arena, "rgb"), ho3d_picture(h, index, arena, "depth"),
                                 ho3d_meta_path(h, index, arena) };

    for (size_t i = 0; i < LT_COUNT(file); i++)
        if (file[i] && access(file[i], F_OK))
            return file[i];
    return NULL;
}

static const char *sample_name(const dataset *d, int64_t index)
{
    return ((const ho3d *)d)->name[index];
}

static void free_dataset(dataset *d)
{
    ho3d *h = (ho3d *)d;

    pthread_mutex_destroy(&h->masks.lock);
    lt_arena_free(h->arena);
}

static const dataset_ops ops = {
    ho3d_read_sample, ho3d_read_annotation, missing_file, sample_name, free_dataset,
};

/* ---- opening ---- */

static bool good_name(const char *name)
{
    const char *slash = strchr(name, '/');

    return slash && slash > name && slash[1] && !strchr(slash + 1, '/') && lt_path_is_inside(name);
}

/* The lines of text into h->name, in place. */
static lt_status split_list(ho3d *h, const char *path, char *text)
{
    char *rest = NULL;
    size_t lines = 1;

    for (const char *p = text; *p; p++)
        lines += *p == '\n';
    h->name = lt_arena_array(h->arena, lines, sizeof(*h->name));
    if (!h->name)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    for (char *line = strtok_r(text, "\r\n", &rest); line; line = strtok_r(NULL, "\r\n", &rest)) {
        if (!good_name(line))
            return lt_error(LT_EFORMAT, "%s: entry %lld is \"%.40s\", expected SEQUENCE/FRAME, such as "
                            "ABF10/0123", path, (long long)h->base.count + 1, line);
        h->name[h->base.count++] = line;
    }
    return h->base.count ? LT_OK : lt_error(LT_EFORMAT, "%s: lists no frame", path);
}

static lt_status read_list(ho3d *h)
{
    const char *path = lt_arena_printf(h->arena, "%s/%s.txt", h->base.root, h->base.split);
    uint8_t *text;
    size_t n;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
    if (!lt_is_folder(h->base.root))
        return lt_error(LT_EIO, "%s: no such folder; give the HO3D folder that holds train.txt, or make "
                        "a synthetic one with `palmar synth`", h->base.root);
    if (access(path, F_OK))
        return lt_error(LT_EIO, "%s: no such file; the folder of HO3D v2 or v3 holds train.txt and "
                        "evaluation.txt", path);
    st = lt_read_file(h->arena, path, (size_t)64 << 20, &text, &n);
    if (!st && memchr(text, 0, n))
        st = lt_error(LT_EFORMAT, "%s: a byte 0 in the list, expected lines SEQUENCE/FRAME", path);
    return st ? st : split_list(h, path, (char *)text);
}

static int is_no_ycb_name(const struct dirent *e)
{
    return e->d_name[0] != '.' && !ycb_find_name(dataset_plain_name(e->d_name));
}

static bool is_among(const char *name, const char *const *names, int n)
{
    while (n-- > 0)
        if (!strcmp(names[n], name))
            return true;
    return false;
}

/* The 21 YCB models come first, then whatever else in the folder has a mesh: people film objects of their own. */
static lt_status name_models(const ho3d *h, const char ***out, int *n_out)
{
    struct dirent **entry;
    const int others = scandir(h->models, &entry, is_no_ycb_name, alphasort);
    const char **names;
    int n = 0;

    if (others < 0)
        return lt_error(lt_errno_status(errno), "%s: %s", h->models, strerror(errno));
    names = lt_arena_array(h->arena, (size_t)(YCB_COUNT + others), sizeof(*names));
    for (int id = 1; names && id <= YCB_COUNT; id++)
        names[n++] = ycb_find(id)->name;
    for (int i = 0; i < others; i++) {
        const char *mesh = lt_arena_printf(h->arena, "%s/%s/textured_simple.obj", h->models, entry[i]->d_name);
        const char *name = lt_arena_strdup(h->arena, dataset_plain_name(entry[i]->d_name));

        if (!mesh || !name)
            names = NULL;
        else if (names && !access(mesh, F_OK) && !is_among(name, names, n))     /* "jug" and "syn_jug" are one */
            names[n++] = name;
        free(entry[i]);
    }
    free(entry);
    *out = names;
    *n_out = n;
    return names ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", h->models);
}

static lt_status open_models(ho3d *h, const ho3d_options *o)
{
    const char **names;
    lt_status st;
    int n = 0;

    h->models = o->models ? lt_arena_strdup(h->arena, o->models)
                          : lt_arena_printf(h->arena, "%s/models", h->base.root);
    if (h->models && !o->models && access(h->models, F_OK))
        h->models = lt_arena_printf(h->arena, "%s/../models", h->base.root);
    if (!h->models)
        return lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
    if (!lt_is_folder(h->models))
        return o->models ? lt_error(LT_EIO, "%s: no such folder; name that of the YCB models", h->models)
                         : lt_error(LT_EIO, "%s/models: no such folder, nor %s; put the YCB models there (HO3D's page "
                                    "links them), or name their folder", h->base.root, h->models);
    st = name_models(h, &names, &n);
    return st ? st : dataset_load_objects(h->arena, h->models, names, n, &h->base.objects, &h->base.n_objects);
}

/* H2O-3D comes from the same authors, in the same folders, with two hands in a frame. What is wrong with a file is for
 * whoever reads it as a sample. */
static lt_status refuse_two_hands(const ho3d *h)
{
    static const char *const keys[] = { "rightHandJoints3D", "leftHandJoints3D", "rightHandPose", "leftHandPose" };
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? ho3d_meta_path(h, 0, arena) : NULL;
    const lt_pvalue *meta;
    lt_status st = path ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", h->base.root);

    if (!st && !lt_pickle_read(arena, path, &meta))
        for (size_t i = 0; !st && i < LT_COUNT(keys); i++)
            if (lt_pdict_get(meta, keys[i]))
                st = lt_error(LT_EFORMAT, "%s: H2O-3D, whose frames have two hands (%s), is not read; HO3D v2 and v3 "
                              "are", h->base.root, keys[i]);
    lt_arena_free(arena);
    return st;
}

/* One of the two files of ground truth into our axes, where it is there. */
static lt_status open_truth(ho3d *h, const char *file, int points, const float **out)
{
    const char *path = lt_arena_printf(h->arena, "%s/%s", h->base.root, file);
    float *xyz;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
    if (access(path, F_OK))
        return LT_OK;
    st = ho3d_read_truth(h->arena, path, h->base.count, points, &xyz);
    if (st)
        return st;
    for (int64_t i = 0; i < h->base.count * points; i++)
        ho3d_from_gl(xyz + 3 * i, xyz + 3 * i);
    *out = xyz;
    return LT_OK;
}

/* A size from our manifest; any that a picture may have, else the file is not ours. */
static lt_status take_size(ho3d *h, const struct cJSON *size, const char *path)
{
    const double width = cJSON_GetNumberValue(cJSON_GetArrayItem(size, 0));
    const double height = cJSON_GetNumberValue(cJSON_GetArrayItem(size, 1));

    if (!size)
        return LT_OK;
    if (!(width >= 1 && width <= 8192 && height >= 1 && height <= 8192))
        return lt_error(LT_EFORMAT, "%s: size: found %g x %g, want width and height from 1 to 8192", path, width,
                        height);
    h->width = (int)width;
    h->height = (int)height;
    return LT_OK;
}

/* Our own generator leaves a manifest that says so, and names its sequences as no real one is. */
static lt_status read_manifest(ho3d *h)
{
    const char *path = lt_arena_printf(h->arena, "%s/manifest.json", h->base.root);
    struct cJSON *manifest = NULL;
    lt_status st = LT_OK;

    h->base.synthetic = h->base.count && strncmp(h->name[0], "SYN", 3) == 0;
    if (path && !access(path, F_OK))
        st = lt_json_read(path, &manifest);
    h->base.synthetic |= cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(manifest, "synthetic"));
    if (!st)
        st = take_size(h, cJSON_GetObjectItemCaseSensitive(manifest, "size"), path);
    cJSON_Delete(manifest);
    return st;
}

static int version_of(const ho3d *h)
{
    const char *rgb = ho3d_picture(h, 0, h->arena, "rgb");

    return rgb && !strcasecmp(strrchr(rgb, '.'), ".png") && !access(rgb, F_OK) ? 2 : 3;
}

static lt_status open_all(ho3d *h, const ho3d_options *o)
{
    lt_status st = read_list(h);

    if (!st)
        st = refuse_two_hands(h);
    if (!st && !o->no_objects)
        st = open_models(h, o);
    if (!st && h->evaluation)
        st = open_truth(h, "evaluation_xyz.json", LT_HAND_KEYPOINTS, &h->xyz);
    if (!st && h->evaluation && o->vertices)
        st = open_truth(h, "evaluation_verts.json", LT_HAND_VERTICES, &h->vertices);
    if (st)
        return st;
    h->version = version_of(h);
    h->base.title = h->version == 2 ? "HO3D v2" : "HO3D v3";
    return read_manifest(h);
}

lt_status ho3d_open(const ho3d_options *o, dataset **out)
{
    lt_arena *arena = lt_arena_new();
    ho3d *h = arena ? lt_arena_alloc(arena, sizeof(*h)) : NULL;
    lt_status st;

    if (strcmp(o->split, "train") && strcmp(o->split, "evaluation")) {
        lt_arena_free(arena);
        return lt_error(LT_EINVAL, "HO3D has no split \"%s\": \"train\" or \"evaluation\"", o->split);
    }
    if (!h || !(h->base.root = lt_arena_strdup(arena, o->root))) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "%s: no memory", o->root);
    }
    h->arena = arena;
    pthread_mutex_init(&h->masks.lock, NULL);
    h->width = 640;
    h->height = 480;
    h->evaluation = !strcmp(o->split, "evaluation");
    h->base.ops = &ops;
    h->base.kind = &ho3d_kind;
    h->base.split = h->evaluation ? "evaluation" : "train";
    h->base.opengl = true;
    h->base.tips = lt_hand_tips_ho3d;
    st = open_all(h, o);
    if (st)
        free_dataset(&h->base);
    else
        *out = &h->base;
    return st;
}
