/* SPDX-License-Identifier: Apache-2.0 */
/* DexYCB's sequences and calibration: which sequences a split has, and what is said of each. */
#include "data/dexycb/internal.h"

#include "assets/ycb/ycb.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/yaml.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct {
    dexycb *d;
    lt_arena *scratch;
    int n_subjects, n_sequences;    /* of the whole dataset: 10 and 100, or what synthetic.json says */
    dexycb_folders subjects;
    const lt_yaml *mano[DEXYCB_SUBJECTS];       /* read once for each subject's calibration */
    const char *mano_id[DEXYCB_SUBJECTS];
    int n_mano;
} tree;

/* ---- a sequence's meta.yml ---- */

static lt_status read_objects(const lt_yaml *meta, dexycb_sequence *q)
{
    const lt_yaml *list, *grasped;
    lt_status st = lt_yaml_get(meta, "ycb_ids", &list);

    if (!st)
        st = lt_yaml_list(list, -1);
    if (!st && (list->n < 1 || list->n > DEXYCB_MAX_OBJECTS))
        st = lt_error(LT_EFORMAT, "%s:%d: ycb_ids has %d objects, expected 1 to %d", list->path, list->line, list->n,
                      DEXYCB_MAX_OBJECTS);
    for (const lt_yaml *v = st ? NULL : list->first; !st && v; v = v->next)
        st = lt_yaml_int(v, 1, YCB_COUNT, &q->object[q->n_objects++]);
    if (!st)
        st = lt_yaml_get(meta, "ycb_grasp_ind", &grasped);
    return st ? st : lt_yaml_int(grasped, 0, q->n_objects - 1, &q->grasped);
}

/* The one text in a list: a sequence has one hand. */
static lt_status only_text(const lt_yaml *meta, const char *key, const char **out)
{
    const lt_yaml *list;
    lt_status st = lt_yaml_get(meta, key, &list);

    if (!st)
        st = lt_yaml_list(list, 1);
    return st ? st : lt_yaml_text(list->first, out);
}

static lt_status read_side(const lt_yaml *meta, dexycb_sequence *q)
{
    const char *side;
    const lt_status st = only_text(meta, "mano_sides", &side);

    if (st)
        return st;
    if (strcmp(side, "left") && strcmp(side, "right"))
        return lt_error(LT_EFORMAT, "%s: mano_sides is \"%.20s\", expected left or right", meta->path, side);
    q->left = !strcmp(side, "left");
    return LT_OK;
}

/* A name from a file that becomes part of a path. */
static lt_status safe_id(const lt_yaml *meta, const char *key, const char *id)
{
    if (lt_path_is_inside(id) && !strchr(id, '/') && strlen(id) < 64)
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s: %s is \"%.40s\", expected the name of a calibration", meta->path, key, id);
}

static lt_status read_extrinsics_id(const tree *t, const lt_yaml *meta, dexycb_sequence *q)
{
    const lt_yaml *v;
    const char *id;
    lt_status st = lt_yaml_get(meta, "extrinsics", &v);

    if (!st)
        st = lt_yaml_text(v, &id);
    if (!st)
        st = safe_id(meta, "extrinsics", id);
    if (!st && !(q->extrinsics = lt_arena_strdup(t->d->arena, id)))
        st = lt_error(LT_ENOMEM, "%s: no memory", meta->path);
    return st;
}

/* calibration/mano_<id>/mano.yml, read once. */
static lt_status find_mano(tree *t, const char *id, const lt_yaml **out)
{
    const char *path;
    lt_status st;

    for (int i = 0; i < t->n_mano; i++)
        if (!strcmp(t->mano_id[i], id)) {
            *out = t->mano[i];
            return LT_OK;
        }
    path = lt_arena_printf(t->scratch, "%s/calibration/mano_%s/mano.yml", t->d->base.root, id);
    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", id);
    st = lt_yaml_read(t->scratch, path, out);
    if (!st && t->n_mano < DEXYCB_SUBJECTS) {
        t->mano_id[t->n_mano] = id;
        t->mano[t->n_mano++] = *out;
    }
    return st;
}

static lt_status read_betas(tree *t, const lt_yaml *meta, dexycb_sequence *q)
{
    const lt_yaml *mano, *betas;
    const char *id;
    double beta[LT_HAND_BETAS];
    lt_status st = only_text(meta, "mano_calib", &id);

    if (!st)
        st = safe_id(meta, "mano_calib", id);
    if (!st)
        st = find_mano(t, id, &mano);
    if (!st)
        st = lt_yaml_get(mano, "betas", &betas);
    if (!st)
        st = lt_yaml_numbers(betas, beta, LT_HAND_BETAS);
    for (int i = 0; !st && i < LT_HAND_BETAS; i++)
        q->beta[i] = (float)beta[i];
    return st;
}

/* The first sequence's serials are the dataset's; the others have the same. */
static lt_status read_serials(tree *t, const lt_yaml *meta)
{
    dexycb *d = t->d;
    const lt_yaml *list;
    int i = 0;
    lt_status st = lt_yaml_get(meta, "serials", &list);

    if (!st)
        st = lt_yaml_list(list, d->n_serials ? d->n_serials : -1);
    if (!st && (list->n < 1 || list->n > DEXYCB_CAMERAS))
        st = lt_error(LT_EFORMAT, "%s:%d: %d serials, expected 1 to %d", list->path, list->line, list->n,
                      DEXYCB_CAMERAS);
    for (const lt_yaml *v = st ? NULL : list->first; !st && v; v = v->next, i++) {
        const char *serial;
        st = lt_yaml_text(v, &serial);
        if (!st)
            st = safe_id(meta, "serials", serial);
        if (!st && d->serial[i] && strcmp(serial, d->serial[i]))
            st = lt_error(LT_EFORMAT, "%s:%d: camera %d is %s, in other sequences it is %s", v->path, v->line, i,
                          serial, d->serial[i]);
        if (!st && !d->serial[i] && !(d->serial[i] = lt_arena_strdup(d->arena, serial)))
            st = lt_error(LT_ENOMEM, "%s: no memory", meta->path);
    }
    if (!st)
        d->n_serials = list->n;
    return st;
}

static lt_status read_sequence(tree *t, const char *folder, dexycb_sequence *q)
{
    const char *path = lt_arena_printf(t->scratch, "%s/%s/meta.yml", t->d->base.root, folder);
    const lt_yaml *meta, *frames;
    lt_status st;

    *q = (dexycb_sequence){ .folder = lt_arena_strdup(t->d->arena, folder) };
    if (!path || !q->folder)
        return lt_error(LT_ENOMEM, "%s: no memory", folder);
    st = lt_yaml_read(t->scratch, path, &meta);
    if (!st)
        st = lt_yaml_get(meta, "num_frames", &frames);
    if (!st)
        st = lt_yaml_int(frames, 1, DEXYCB_MAX_FRAMES, &q->frames);
    if (!st)
        st = read_objects(meta, q);
    if (!st)
        st = read_side(meta, q);
    if (!st)
        st = read_extrinsics_id(t, meta, q);
    if (!st)
        st = read_betas(t, meta, q);
    return st ? st : read_serials(t, meta);
}

/* ---- the split ---- */

static lt_status add_subject(tree *t, const char *subject)
{
    dexycb *d = t->d;
    dexycb_folders sequences;
    lt_status st = dexycb_list_sequences(t->scratch, d->base.root, subject, &sequences);

    if (st)
        return st;
    if (sequences.n != t->n_sequences)
        return lt_error(LT_EFORMAT, "%s/%s: %d sequences, expected %d; the splits count them, so that all have to "
                        "be there", d->base.root, subject, sequences.n, t->n_sequences);
    for (int i = 0; !st && i < sequences.n; i++) {
        const char *folder;
        if (!dexycb_has_sequence(d->split, i))
            continue;
        folder = lt_arena_printf(t->scratch, "%s/%s", subject, sequences.name[i]);
        st = folder ? read_sequence(t, folder, &d->sequence[d->n_sequences++])
                    : lt_error(LT_ENOMEM, "%s: no memory", subject);
    }
    return st;
}

/* "1, 2, 5" of a set of subjects, whose numbers are counted from 1 */
static const char *numbers_of(unsigned subjects, char out[40])
{
    int n = 0;

    out[0] = 0;
    for (int i = 0; i < DEXYCB_SUBJECTS; i++)
        if (subjects & 1u << i)
            n += sprintf(out + n, n ? ", %d" : "%d", i + 1);
    return out;
}

/* Few have room for all subjects: the split is of those that are there, and says so. */
static lt_status say_what_is_missing(const tree *t, unsigned there, unsigned missing)
{
    dexycb *d = t->d;
    const char *split = dexycb_split_name(d->split);
    char have[40], lack[40];

    if (!missing)
        return LT_OK;
    numbers_of(there, have);
    numbers_of(missing, lack);
    if (!there)
        return lt_error(LT_EIO, "%s: split %s of s%d is of subjects %s, and no folder like ########-subject-%02d is "
                        "there", d->base.root, split, d->split.setup, lack, atoi(lack));
    d->base.partial = lt_arena_printf(d->arena, "split %s of s%d is of subject%s %s alone: there is no folder of %s; "
                                      "what is scored is a part of the split, and result files count the samples of "
                                      "that part",
                                      split, d->split.setup, strchr(have, ',') ? "s" : "", have, lack);
    d->base.title = lt_arena_printf(d->arena, "%s (part)", d->base.title);
    return d->base.partial && d->base.title ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", d->base.root);
}

static lt_status add_subjects(tree *t)
{
    dexycb *d = t->d;
    unsigned there = 0, missing = 0;
    lt_status st = LT_OK;

    d->sequence = lt_arena_array(d->arena, (size_t)t->n_subjects * (size_t)t->n_sequences, sizeof(*d->sequence));
    if (!d->sequence)
        return lt_error(LT_ENOMEM, "%s: no memory", d->base.root);
    for (int i = 0; !st && i < t->n_subjects; i++) {
        const char *subject = dexycb_find_subject(&t->subjects, i);
        if (!dexycb_has_subject(d->split, i))
            continue;
        *(subject ? &there : &missing) |= 1u << i;
        if (subject)
            st = add_subject(t, subject);
    }
    return st ? st : say_what_is_missing(t, there, missing);
}

static lt_status add_sequences(tree *t)
{
    dexycb *d = t->d;
    lt_status st = add_subjects(t);

    for (int i = 0; i < d->n_serials; i++)
        if (dexycb_has_camera(d->split, i))
            d->camera[d->n_cameras++] = i;
    for (int i = 0; !st && i < d->n_sequences; i++) {
        d->sequence[i].first = d->total;
        d->total += (int64_t)d->sequence[i].frames * d->n_cameras;
    }
    if (!st && !d->total)
        st = lt_error(LT_EINVAL, "%s: split %s of s%d has no samples: the dataset has %d subjects of %d sequences, and "
                      "%d of these are in it, seen by %d of its cameras", d->base.root, dexycb_split_name(d->split),
                      d->split.setup, t->n_subjects, t->n_sequences, d->n_sequences, d->n_cameras);
    return st;
}

static lt_status read_intrinsics(tree *t, int camera)
{
    static const char *const key[4] = { "fx", "fy", "ppx", "ppy" };
    const char *path = lt_arena_printf(t->scratch, "%s/calibration/intrinsics/%s_640x480.yml", t->d->base.root,
                                       t->d->serial[camera]);
    const lt_yaml *root, *color, *v;
    double x[4];
    lt_status st = path ? lt_yaml_read(t->scratch, path, &root) : lt_error(LT_ENOMEM, "%s: no memory", t->d->base.root);

    if (!st)
        st = lt_yaml_get(root, "color", &color);
    for (int i = 0; !st && i < 4; i++) {
        st = lt_yaml_get(color, key[i], &v);
        if (!st)
            st = lt_yaml_numbers(v, &x[i], 1);
    }
    if (!st && !(x[0] > 0 && x[1] > 0 && x[0] < 1e6 && x[1] < 1e6))
        st = lt_error(LT_EFORMAT, "%s: focal lengths %g, %g, expected positive pixels", path, x[0], x[1]);
    if (!st)
        t->d->intrinsics[camera] = (lt_camera){ x[0], x[1], x[2], x[3] };
    return st;
}

/* ---- how large the dataset is ---- */

static lt_status count_of(const char *path, const struct cJSON *root, const char *key, int most, int *out)
{
    const cJSON *v = cJSON_GetObjectItemCaseSensitive(root, key);

    if (!cJSON_IsNumber(v) || v->valueint < 1 || v->valueint > most || v->valuedouble != v->valueint)
        return lt_error(LT_EFORMAT, "%s: %s: expected a whole number from 1 to %d", path, key, most);
    *out = v->valueint;
    return LT_OK;
}

/* Our own generator may leave out subjects and sequences, and says so. */
static lt_status read_marker(tree *t)
{
    const char *path = lt_path_join(t->scratch, t->d->base.root, "synthetic.json");
    struct cJSON *root = NULL;
    lt_status st;

    t->n_subjects = DEXYCB_SUBJECTS;
    t->n_sequences = DEXYCB_SEQUENCES;
    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", t->d->base.root);
    if (access(path, F_OK))
        return LT_OK;
    t->d->base.synthetic = true;
    st = lt_json_read(path, &root);
    if (!st)
        st = count_of(path, root, "subjects", DEXYCB_SUBJECTS, &t->n_subjects);
    if (!st)
        st = count_of(path, root, "sequences", DEXYCB_SEQUENCES, &t->n_sequences);
    cJSON_Delete(root);
    return st;
}

static lt_status open_tree(tree *t)
{
    lt_status st = read_marker(t);

    if (!st)
        st = dexycb_list_subjects(t->scratch, t->d->base.root, &t->subjects);
    if (!st && !t->subjects.n)
        st = lt_error(LT_EIO, "%s: no folder like 20200709-subject-01; give the folder that DexYCB's archives were "
                      "unpacked into, or make a synthetic one with `palmar synth --layout dexycb`", t->d->base.root);
    if (!st)
        st = add_sequences(t);
    for (int i = 0; !st && i < t->d->n_serials; i++)
        st = read_intrinsics(t, i);
    return st;
}

lt_status dexycb_open_tree(dexycb *d)
{
    tree t = { .d = d, .scratch = lt_arena_new() };
    const lt_status st = t.scratch ? open_tree(&t) : lt_error(LT_ENOMEM, "%s: no memory", d->base.root);

    lt_arena_free(t.scratch);
    return st;
}

dexycb_spot dexycb_find(const dexycb *d, int64_t at)
{
    int lo = 0, hi = d->n_sequences - 1;
    const dexycb_sequence *q;

    while (lo < hi) {
        const int middle = (lo + hi + 1) / 2;
        if (d->sequence[middle].first <= at)
            lo = middle;
        else
            hi = middle - 1;
    }
    q = &d->sequence[lo];
    at -= q->first;
    return (dexycb_spot){ q, lo, d->camera[at / q->frames], (int)(at % q->frames) };
}
