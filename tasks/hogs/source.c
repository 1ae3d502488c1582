/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/source.h"

#include "data/dexycb/dexycb.h"
#include "data/kind.h"
#include "estimate/checkpoint/checkpoint.h"
#include "libtensor/io/file.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

/* ---- opening --------------------------------------------------------------------------------------------- */

static dataset_options options_of(const task_run *r, const hogs_data_config *d)
{
    return (dataset_options){
        .root = d->common.dir, .split = "train", .models = d->objects, .setup = dexycb_setups[d->setup],
        .filter = dexycb_filters[d->filter], .hand = r->hands.right, .left = r->hands.left, .needs = SAMPLE_OBJECT,
    };
}

/* The file that is named, or the dataset's own, or the truth and noise */
static const char *poses_path(const task_run *r, const hogs_data_config *d)
{
    const char *own;

    if (*d->poses)
        return access(d->poses, F_OK) == 0 ? lt_path_whole(r->arena, d->poses) : d->poses;
    own = lt_arena_printf(r->arena, "%s/poses/independent.json", d->common.dir);
    return own && access(own, R_OK) == 0 ? own : "truth+independent";
}

static lt_status read_poses(const task_run *r, const train_config *c, const dataset *of, const dataset *other,
                            initial_poses **out)
{
    const initial_poses_options o = {
        .path = hogs_data_of(c)->poses, .data = of, .other = other, .hand = r->hands.right,
        .seed = (uint64_t)c->loop.seed,
    };

    return initial_poses_read(&o, out);
}

static lt_status keep_paths(const task_run *r, train_config *c)
{
    hogs_data_config *d = (hogs_data_config *)c->data;

    d->hand = r->hands.path;
    d->common.dir = lt_path_whole(r->arena, d->common.dir);
    if (*d->objects)
        d->objects = lt_path_whole(r->arena, d->objects);
    if (d->common.dir)
        d->poses = poses_path(r, d);
    return d->common.dir && d->objects && d->poses ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

static lt_status check_subjects(const train_config *c, const dataset *d)
{
    return d->kind->subject ? LT_OK
        : lt_error(LT_EINVAL, "%s: data.dir: %s does not say whose hands it shows", c->path, d->title);
}

/* Both splits, as a file of poses may have the frames of both. */
static lt_status open_splits(task_run *r, train_config *c, const char *split)
{
    dataset_options o = options_of(r, hogs_data_of(c));
    lt_status st = dataset_find_kind(o.root, &o.kind);

    if (st)
        return st;
    o.split = split ? split : "train";
    o.vertices = split != NULL;                         /* the true hand's, for scores */
    st = dataset_open(&o, &r->train);
    o.vertices = false;
    o.split = strcmp(o.split, "train") == 0 ? dataset_validation_split(o.kind, o.root) : "train";
    if (!st && o.split)
        st = dataset_open(&o, &r->evaluation);
    return st ? st : check_subjects(c, r->train);
}

lt_status hogs_open_data(task_run *r, train_config *c, const char *split)
{
    lt_status st = hands_open(r->arena, hogs_data_of(c)->hand, &r->hands);

    if (!st && !*c->data->dir)
        st = lt_error(LT_EUSAGE, "%s: data.dir: no dataset given; name its folder with --data or --set data.dir=FOLDER",
                      c->path);
    if (!st)
        st = open_splits(r, c, split);
    if (!st && !split)
        st = dataset_check_tips(r->train, r->hands.right, NULL);
    if (!st && !split)
        memcpy(r->tips, r->train->tips, sizeof(r->tips));
    if (!st)
        st = keep_paths(r, c);
    if (!st)
        st = read_poses(r, c, r->train, r->evaluation, &r->train_poses);
    if (!st && r->evaluation && !split && read_poses(r, c, r->evaluation, r->train, &r->check_poses) == LT_ENOMEM)
        st = LT_ENOMEM;                 /* a split without poses is not validated on: HO3D keeps them to itself */
    return st;
}

void hogs_close_data(task_run *r)
{
    for (int i = 0; i < r->sets.hands && r->rig; i++)
        hogs_rig_free(&r->rig[i]);
    initial_poses_free(r->train_poses);
    initial_poses_free(r->check_poses);
    dataset_free(r->train);
    dataset_free(r->evaluation);
}

/* ---- sets ------------------------------------------------------------------------------------------------ */

enum { MOST_SUBJECTS = 64 };

typedef struct {
    int n, id[MOST_SUBJECTS];
    float beta[MOST_SUBJECTS][LT_HAND_BETAS];
} subjects;

/* Whose hands there are, ascending, and their shapes in the first frame of each */
static lt_status find_subjects(const task_run *r, subjects *out)
{
    const hogs_source *s = &r->train_source;

    out->n = 0;
    for (int64_t i = 0; i < s->count; i++) {
        const char *name = dataset_name(s->data, s->index[i]);
        const int id = s->data->kind->subject(name);
        const initial_pose *p = initial_poses_at(s->poses, s->index[i]);
        int at = 0;

        while (at < out->n && out->id[at] < id)
            at++;
        if (at < out->n && out->id[at] == id)
            continue;
        if (id < 0 || out->n == MOST_SUBJECTS)
            return lt_error(LT_EINVAL, id < 0 ? "%s: nothing says whose hand it is" : "%s: of more subjects than %d",
                            name, MOST_SUBJECTS);
        memmove(&out->id[at + 1], &out->id[at], (size_t)(out->n - at) * sizeof(out->id[0]));
        memmove(&out->beta[at + 1], &out->beta[at], (size_t)(out->n - at) * sizeof(out->beta[0]));
        out->id[at] = id;
        for (int k = 0; k < LT_HAND_BETAS; k++)
            out->beta[at][k] = (float)p->beta[k];
        out->n++;
    }
    return LT_OK;
}

static hogs_set object_set(const dataset_object *o)
{
    hogs_set s = { .id = o->ycb_id, .lo = { INFINITY, INFINITY, INFINITY }, .hi = { -INFINITY, -INFINITY, -INFINITY } };

    for (int i = 0; i < o->n_points; i++)
        for (int k = 0; k < 3; k++) {
            s.lo[k] = fmin(s.lo[k], (double)o->point[i][k]);
            s.hi[k] = fmax(s.hi[k], (double)o->point[i][k]);
        }
    return s;
}

static lt_status make_sets(task_run *r, const subjects *who)
{
    hogs_sets *s = &r->sets;
    lt_status st = LT_OK;

    *s = (hogs_sets){ .hands = who->n, .objects = r->train->n_objects };
    s->set = lt_arena_array(r->arena, (size_t)(s->hands + s->objects), sizeof(*s->set));
    r->rig = lt_arena_array(r->arena, (size_t)s->hands, sizeof(*r->rig));
    if (!s->set || !r->rig)
        return lt_error(LT_ENOMEM, "no memory for %d sets", s->hands + s->objects);
    for (int i = 0; i < s->hands && !st; i++) {
        st = hogs_rig_new(r->arena, r->hands.right, r->tips, who->beta[i], &r->rig[i]);
        if (!st)
            s->set[i] = hogs_rig_set(&r->rig[i], who->id[i], who->beta[i]);
    }
    for (int i = 0; i < s->objects; i++)
        s->set[s->hands + i] = object_set(&r->train->objects[i]);
    return st;
}

/* ---- what the configuration leaves to the data ----------------------------------------------------------- */

static bool leave_to_data(cJSON *keys, const char *name, int value)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(keys, name);

    if (cJSON_IsNumber(item) && item->valuedouble != 0)
        return true;
    cJSON_DeleteItemFromObjectCaseSensitive(keys, name);
    return cJSON_AddNumberToObject(keys, name, value);
}

static lt_status fill_config(const task_run *r, train_config *c)
{
    const hogs_source *s = &r->train_source;
    lt_arena *arena = lt_arena_new();
    dataset_sample first;
    lt_status st = arena ? dataset_read(s->data, s->index[0], 0, arena, &first)
                         : lt_error(LT_ENOMEM, "no memory to begin");

    if (!st && !(leave_to_data(c->model_keys, "hands", r->sets.hands)
                 && leave_to_data(c->model_keys, "objects", r->sets.objects)
                 && leave_to_data(c->model_keys, "frames", (int)s->count)
                 && leave_to_data(c->model_keys, "width", first.width)
                 && leave_to_data(c->model_keys, "height", first.height)))
        st = lt_error(LT_ENOMEM, "no memory for the configuration");
    lt_arena_free(arena);
    return st;
}

lt_status hogs_find_training_sets(task_run *r, train_config *c)
{
    subjects *who = lt_arena_alloc(r->arena, sizeof(*who));
    lt_status st = who ? find_subjects(r, who) : lt_error(LT_ENOMEM, "no memory to begin");

    if (!st)
        st = make_sets(r, who);
    return st ? st : fill_config(r, c);
}

/* Of the model's subjects, by their shapes */
static lt_status make_rigs(task_run *r)
{
    const hogs *m = hogs_of(r->m);
    lt_status st;

    r->sets.hands = 0;
    r->rig = lt_arena_array(r->arena, (size_t)m->config.hands, sizeof(*r->rig));
    st = r->rig ? LT_OK : lt_error(LT_ENOMEM, "no memory for %d hands", m->config.hands);
    for (int i = 0; i < m->config.hands && !st; i++) {
        float beta[LT_HAND_BETAS];

        hogs_beta(m, i, beta);
        r->sets.hands++;
        st = hogs_rig_new(r->arena, r->hands.right, r->tips, beta, &r->rig[i]);
    }
    return st;
}

lt_status hogs_open_model(task_run *r, const char *checkpoint, lt_params *set)
{
    lt_status st = train_config_model(r->config, NULL, set, r->m);

    memcpy(r->tips, r->train->tips, sizeof(r->tips));
    if (!st)
        st = checkpoint_load_model(checkpoint, r->m);
    if (!st)
        st = make_rigs(r);
    if (!st)
        st = hogs_lists_make(&r->lists, hogs_of(r->m), r->rig);
    r->schedule.lpips_every = 1;
    r->feeder[HOGS_RENDER] = (hogs_feeder){ r, HOGS_RENDER };
    return st;
}

hogs_source hogs_source_of(const task_run *r, const dataset *data, const initial_poses *poses)
{
    const hogs_data_config *d = hogs_data_of(r->config);

    return (hogs_source){ .data = data, .poses = poses, .m = r->m, .masks = (hogs_masks)d->masks,
                          .hand = r->hands.right, .jitter = d->jitter, .seed = (uint64_t)r->config->loop.seed };
}
