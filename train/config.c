/* SPDX-License-Identifier: Apache-2.0 */
#include "train/config.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/nearest.h"
#include "libtensor/optim/optim.h"
#include "train/task.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

/* ---- the keys ----------------------------------------------------------------------------------------- */

static const char *const kinds[] = { "sgd", "adam", "adamw", "muon", NULL };        /* as lt_optim_kind */
static const char *const schedules[] = { "constant", "step", "cosine", "linear", NULL };    /* as lt_schedule_kind */

#define OPTIM(field) #field, .offset = offsetof(train_optim_config, field)
#define LOOP(field) #field, .offset = offsetof(train_loop_config, field)

static const lt_config_key optim_keys[] = {
    { OPTIM(kind), .type = LT_CONFIG_CHOICE, .fallback = "\"adam\"", .choices = kinds,
      .doc = "adam adds weight_decay * w to the gradient, adamw takes it off the weight; muon: matrices by their "
             "gradients' orthogonal matrices, the rest as adamw" },
    { OPTIM(lr), .type = LT_CONFIG_NUMBER, .fallback = "1e-4", .lo = 0, .hi = 1e30, .doc = "highest learning rate" },
    { OPTIM(weight_decay), .type = LT_CONFIG_NUMBER, .fallback = "5e-4", .lo = 0, .hi = 1e30, .doc = "of all weights" },
    { OPTIM(beta1), .type = LT_CONFIG_NUMBER, .fallback = "0.9", .lo = 1e-9, .hi = 0.999999,
      .doc = "adam: decay of the mean" },
    { OPTIM(beta2), .type = LT_CONFIG_NUMBER, .fallback = "0.999", .lo = 1e-9, .hi = 0.999999,
      .doc = "adam: decay of the mean square" },
    { OPTIM(eps), .type = LT_CONFIG_NUMBER, .fallback = "1e-8", .lo = 1e-30, .hi = 1,
      .doc = "adam: added to the root" },
    { OPTIM(momentum), .type = LT_CONFIG_NUMBER, .fallback = "0.9", .lo = 0, .hi = 1, .doc = "of sgd and muon" },
    { OPTIM(nesterov), .type = LT_CONFIG_BOOL, .fallback = "false", .doc = "sgd: look ahead" },
    { OPTIM(clip_norm), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1e30,
      .doc = "longest gradient, L2 norm over all weights; 0: any" },
    { OPTIM(ema_decay), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1,
      .doc = "validate and predict with an average of the weights with this decay (early on, with less); 0: with the "
             "weights" },
    { OPTIM(schedule), .type = LT_CONFIG_CHOICE, .fallback = "\"step\"", .choices = schedules,
      .doc = "how the learning rate falls" },
    { OPTIM(gamma), .type = LT_CONFIG_NUMBER, .fallback = "0.7", .lo = 0, .hi = 1, .doc = "step: factor" },
    { OPTIM(every), .type = LT_CONFIG_INT, .fallback = "10", .lo = 1, .hi = 1e9,
      .doc = "step: epochs between factors" },
    { OPTIM(min_lr), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1e30,
      .doc = "cosine, linear: where it ends" },
    { OPTIM(warmup), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1e9,
      .doc = "epochs of a linear rise from 0" },
    { OPTIM(epochs), .type = LT_CONFIG_INT, .fallback = "120", .lo = 1, .hi = 1e9, .doc = "passes over the data" },
    { OPTIM(steps), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 2e9,
      .doc = "stop after so many steps; 0: after the epochs" },
    { OPTIM(batch), .type = LT_CONFIG_INT, .fallback = "32", .lo = 1, .hi = 1024, .doc = "samples in a step" },
    { OPTIM(shards), .type = LT_CONFIG_INT, .fallback = "1", .lo = 1, .hi = 1024,
      .doc = "parts of a batch with statistics of their own; divides batch" },
    { .name = NULL },
};

static const lt_config_key loop_keys[] = {
    { LOOP(seed), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 2147483647,
      .doc = "of initial weights, order and augmentation" },
    { LOOP(checkpoint_minutes), .type = LT_CONFIG_NUMBER, .fallback = "15", .lo = 0, .hi = 1e9,
      .doc = "minutes between checkpoints; 0: not by time" },
    { LOOP(checkpoint_steps), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 2e9,
      .doc = "steps between checkpoints; 0: not by steps" },
    { LOOP(keep), .type = LT_CONFIG_INT, .fallback = "3", .lo = 1, .hi = 10000,
      .doc = "newest checkpoints that stay; last and best always do" },
    { LOOP(validate_every), .type = LT_CONFIG_INT, .fallback = "1", .lo = 0, .hi = 1e9,
      .doc = "epochs between validations; 0: not by epochs" },
    { LOOP(validate_steps), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 2e9,
      .doc = "steps between validations; 0: not by steps" },
    { LOOP(validate_samples), .type = LT_CONFIG_INT, .fallback = "1000", .lo = 1, .hi = 1e9,
      .doc = "samples to validate on, at most; without evaluation truth the last ones of training" },
    { LOOP(max_bad_steps), .type = LT_CONFIG_INT, .fallback = "5", .lo = 1, .hi = 1e9,
      .doc = "steps in a row without a finite gradient that stop the run" },
    { LOOP(log_every), .type = LT_CONFIG_INT, .fallback = "1", .lo = 1, .hi = 1e9,
      .doc = "steps between lines of log.jsonl" },
    { .name = NULL },
};

/* ---- reading ------------------------------------------------------------------------------------------ */

static const char *const groups[] = { "model", "data", "optim", "train" };

static bool has_key(const lt_config_key *keys, const char *name)
{
    for (const lt_config_key *k = keys; k->name; k++)
        if (strcmp(k->name, name) == 0)
            return true;
    return false;
}

/* The group that a key is in which was given without: "epochs"; NULL: none of these */
static const char *group_of(const task *const *tasks, const char *key)
{
    for (; *tasks; tasks++)
        if (has_key((*tasks)->data_keys, key))
            return "data";
    return has_key(optim_keys, key) ? "optim" : has_key(loop_keys, key) ? "train" : NULL;
}

static lt_status unknown_group(const train_config *c, const char *name)
{
    const char *group = group_of(c->tasks, name);

    if (group)
        return lt_error(LT_EINVAL, "%s: %s: no such group; did you mean \"%s.%s\"?", c->path, name, group, name);
    return lt_unknown_name(name, groups, LT_COUNT(groups), "there are model, data, optim, train",
                           "%s: %s: no such group", c->path, name);
}

static lt_status check_groups(const train_config *c)
{
    const cJSON *tree = c->tree, *item;
    const char *path = c->path;

    if (!cJSON_IsObject(tree))
        return lt_error(LT_EINVAL, "%s: want an object with the groups model, data, optim, train", path);
    cJSON_ArrayForEach(item, tree) {
        size_t i = 0;

        while (i < LT_COUNT(groups) && strcmp(groups[i], item->string) != 0)
            i++;
        if (cJSON_GetObjectItemCaseSensitive(tree, item->string) != item)
            return lt_error(LT_EINVAL, "%s: %s: is there twice", path, item->string);
        if (i == LT_COUNT(groups))
            return unknown_group(c, item->string);
    }
    return LT_OK;
}

/* Of a task's own, else of the zoo */
static lt_status find_model(const task *const *tasks, const char *name, const model_class **out)
{
    for (; *tasks; tasks++)
        for (const model_class *const *own = (*tasks)->models; own && *own; own++)
            if (strcmp((*own)->name, name) == 0) {
                *out = *own;
                return LT_OK;
            }
    return model_find(name, out);
}

static const task *find_task(const task *const *tasks, const model_class *m)
{
    for (; m->task && *tasks; tasks++)
        if (strcmp((*tasks)->name, m->task) == 0)
            return *tasks;
    return NULL;
}

static lt_status read_model(train_config *c)
{
    const cJSON *group = cJSON_GetObjectItemCaseSensitive(c->tree, "model");
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(group, "name");

    if (!cJSON_IsString(name))
        return lt_error(LT_EINVAL, "%s: model.name: want the name of a model, such as \"%s\"", c->path,
                        model_classes[0]->name);
    if (find_model(c->tasks, name->valuestring, &c->model))
        return lt_error_prefix(LT_EINVAL, "%s: model.name", c->path);
    c->task = find_task(c->tasks, c->model);
    if (!c->task)
        return lt_error(LT_EINVAL, "%s: model.name: %s is a classifier: palmar bench and info know it, but there "
                        "is no data to train it on", c->path, c->model->name);
    c->model_keys = cJSON_Duplicate(group, true);
    if (!c->model_keys)
        return lt_error(LT_ENOMEM, "%s: no memory", c->path);
    cJSON_DeleteItemFromObjectCaseSensitive(c->model_keys, "name");
    return LT_OK;
}

static lt_status read_group(lt_arena *arena, const train_config *c, const char *name,
                            const lt_config_key *keys, void *out)
{
    const char *where = lt_arena_printf(arena, "%s: %s", c->path, name);

    return where ? lt_config_read(arena, where, cJSON_GetObjectItemCaseSensitive(c->tree, name), keys, out)
                 : lt_error(LT_ENOMEM, "%s: no memory", c->path);
}

static lt_status read_data(lt_arena *arena, train_config *c)
{
    c->data = lt_arena_alloc(arena, c->task->data_size);
    return c->data ? read_group(arena, c, "data", c->task->data_keys, c->data)
                   : lt_error(LT_ENOMEM, "%s: no memory", c->path);
}

static lt_status check_values(const train_config *c)
{
    const train_optim_config *o = &c->optim;

    if (o->batch % o->shards)
        return lt_error(LT_EINVAL, "%s: optim.shards: %d do not divide a batch of %d", c->path, o->shards,
                        o->batch);
    if (o->schedule == LT_COSINE_LR && o->warmup >= o->epochs)
        return lt_error(LT_EINVAL, "%s: optim.warmup: %g epochs leave nothing of %d for the cosine", c->path,
                        o->warmup, o->epochs);
    return LT_OK;
}

/* c->tree is there: put the overrides into it, and read the groups. */
static lt_status read_tree(lt_arena *arena, train_config *c)
{
    lt_status st = LT_OK;

    if (cJSON_IsObject(c->tree))
        for (int i = 0; st == LT_OK && i < c->n_set; i++)
            st = lt_config_set(c->tree, "--set", c->set[i]);
    if (st == LT_OK)
        st = check_groups(c);
    if (st == LT_OK)
        st = read_model(c);
    if (st == LT_OK)
        st = read_data(arena, c);
    if (st == LT_OK)
        st = read_group(arena, c, "optim", optim_keys, &c->optim);
    if (st == LT_OK)
        st = read_group(arena, c, "train", loop_keys, &c->loop);
    if (st == LT_OK)
        st = check_values(c);
    if (st) {
        st = lt_config_blame(c->path, "--set", c->set, c->n_set, st);
        train_config_fini(c);
    }
    return st;
}

lt_status train_config_load(lt_arena *arena, const task *const *tasks, const char *path, const char *const *set,
                            int n_set, train_config *out)
{
    train_config c = { .path = lt_arena_strdup(arena, path), .tasks = tasks, .set = set, .n_set = n_set };
    lt_status st;

    if (!c.path)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    st = lt_json_read(c.path, &c.tree);
    if (st == LT_OK)
        st = read_tree(arena, &c);
    if (st == LT_OK)
        *out = c;
    return st;
}

lt_status train_config_parse(lt_arena *arena, const task *const *tasks, const char *name, const char *text,
                             const char *const *set, int n_set, train_config *out)
{
    train_config c = { .path = lt_arena_strdup(arena, name), .tasks = tasks, .set = set, .n_set = n_set };
    lt_status st;

    if (!c.path)
        return lt_error(LT_ENOMEM, "%s: no memory", name);
    st = lt_json_parse(name, text, strlen(text), &c.tree);
    if (st == LT_OK)
        st = read_tree(arena, &c);
    if (st == LT_OK)
        *out = c;
    return st;
}

void train_config_fini(train_config *c)
{
    cJSON_Delete(c->tree);
    cJSON_Delete(c->model_keys);
    c->tree = c->model_keys = NULL;
}

lt_optim_group train_optim_group(const train_config *c)
{
    const train_optim_config *o = &c->optim;

    return (lt_optim_group){
        .kind = (lt_optim_kind)o->kind, .beta1 = o->beta1, .beta2 = o->beta2, .eps = o->eps, .momentum = o->momentum,
        .nesterov = o->nesterov, .clip_norm = o->clip_norm, .weight_decay = o->weight_decay,
        .schedule = { .kind = (lt_schedule_kind)o->schedule, .lr = o->lr, .min_lr = o->min_lr, .gamma = o->gamma,
                      .every = o->every, .epochs = o->epochs, .warmup = o->warmup },
    };
}

lt_status train_config_model(const train_config *c, const lt_hand_layer *hand, lt_params *set, model *out)
{
    const char *where = lt_arena_printf(lt_params_arena(set), "%s: model", c->path);
    lt_status st;

    if (!where)
        return lt_error(LT_ENOMEM, "%s: no memory", c->path);
    lt_params_defer(set);
    st = model_create(c->model, where, c->model_keys, hand, set, out);
    return st ? lt_config_blame(c->path, "--set", c->set, c->n_set, st) : LT_OK;
}

lt_status train_config_init(const train_config *c, const model *m)
{
    const lt_status st = lt_params_allocate(m->params);

    if (st == LT_OK)
        m->cls->init(m, (uint64_t)c->loop.seed);
    return st;
}

/* ---- writing ------------------------------------------------------------------------------------------ */

static cJSON *model_json(const model *m)
{
    cJSON *group = lt_config_write(m->cls->keys, m->self);
    cJSON *name = cJSON_CreateString(m->cls->name);

    if (group && name && cJSON_AddItemToObject(group, "name", name)) {
        cJSON_DetachItemViaPointer(group, name);            /* to the front, for the reader */
        cJSON_InsertItemInArray(group, 0, name);
        return group;
    }
    cJSON_Delete(name);
    cJSON_Delete(group);
    return NULL;
}

struct cJSON *train_config_json(const train_config *c, const model *m)
{
    cJSON *tree = cJSON_CreateObject();
    const struct { const char *name; cJSON *group; } part[] = {
        { "model", model_json(m) },
        { "data", lt_config_write(c->task->data_keys, c->data) },
        { "optim", lt_config_write(optim_keys, &c->optim) },
        { "train", lt_config_write(loop_keys, &c->loop) },
    };
    bool ok = tree != NULL;

    for (size_t i = 0; i < LT_COUNT(part); i++)
        if (!ok || !part[i].group || !cJSON_AddItemToObject(tree, part[i].name, part[i].group)) {
            cJSON_Delete(part[i].group);
            ok = false;
        }
    if (ok)
        return tree;
    cJSON_Delete(tree);
    return NULL;
}

/* ---- help --------------------------------------------------------------------------------------------- */

static const char *type_name(const lt_config_key *k)
{
    static const char *const name[] = {
        [LT_CONFIG_INT] = "whole number", [LT_CONFIG_NUMBER] = "number", [LT_CONFIG_BOOL] = "true or false",
        [LT_CONFIG_TEXT] = "text", [LT_CONFIG_CHOICE] = "one of", [LT_CONFIG_INTS] = "four whole numbers",
    };

    return name[k->type];
}

static void print_keys(FILE *f, const char *group, const lt_config_key *k)
{
    for (; k->name; k++) {
        fprintf(f, "  %s.%s: %s", group, k->name, type_name(k));
        for (int i = 0; k->choices && k->choices[i]; i++)
            fprintf(f, " %s", k->choices[i]);
        if (k->lo != 0 || k->hi != 0)
            fprintf(f, " from %g to %g", k->lo, k->hi);
        fprintf(f, ", default %s\n      %s\n", k->fallback, k->doc);
    }
}

void train_config_help(const task *const *tasks, FILE *f)
{
    fprintf(f, "  model.name: one of");
    for (int i = 0; model_classes[i]; i++)
        if (find_task(tasks, model_classes[i]))
            fprintf(f, " %s", model_classes[i]->name);
    fprintf(f, "\n      the model to train\n");
    for (int i = 0; model_classes[i]; i++) {
        if (!find_task(tasks, model_classes[i]))
            continue;
        fprintf(f, "\n%s\n", model_classes[i]->name);
        print_keys(f, "model", model_classes[i]->keys);
    }
    for (int i = 0; tasks[i]; i++) {
        fprintf(f, "\n%s\n", tasks[1] ? tasks[i]->name : "all models");
        print_keys(f, "data", tasks[i]->data_keys);
    }
    if (tasks[1])
        fprintf(f, "\nall models\n");
    print_keys(f, "optim", optim_keys);
    print_keys(f, "train", loop_keys);
}
