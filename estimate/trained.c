/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/trained.h"

#include "assets/hands.h"
#include "estimate/checkpoint/checkpoint.h"
#include "estimate/checkpoint/folder.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <string.h>

/* The text of a key of the group "data"; "" where it is not there. */
static const char *data_text(const cJSON *config, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(config, "data"), key);

    return cJSON_IsString(item) ? item->valuestring : "";
}

static bool data_flag(const cJSON *config, const char *key)
{
    return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(config, "data"), key));
}

static lt_status find_class(const trained *t, const char *task, const cJSON *config, const model_class **out)
{
    const cJSON *group = cJSON_GetObjectItemCaseSensitive(config, "model");
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(group, "name");
    lt_status st;

    if (!cJSON_IsString(name))
        return lt_error(LT_EFORMAT, "%s: its configuration names no model", t->path);
    st = model_find(name->valuestring, out);
    if (st)
        return lt_error_prefix(LT_EINVAL, "%s: model.name", t->path);
    if (!(*out)->task || strcmp((*out)->task, task) != 0)
        return lt_error(LT_EINVAL, "%s: %s is trained for %s, want a model for %s", t->path, (*out)->name,
                        (*out)->task ? (*out)->task : "nothing here", task);
    return LT_OK;
}

static lt_status open_hand(trained *t, const char *path, const int tips[5])
{
    hands both;
    lt_status st = hands_open(t->arena, path, &both);

    if (st)
        return st;
    t->hand = both.right;
    return lt_hand_layer_new(t->arena, t->hand, tips, &t->layer);
}

static lt_status make_model(trained *t, const model_class *cls, cJSON *config)
{
    const char *where = lt_arena_printf(t->arena, "%s: model", t->path);
    cJSON *keys = cJSON_GetObjectItemCaseSensitive(config, "model");

    t->params = lt_params_new();
    if (!where || !t->params)
        return lt_error(LT_ENOMEM, "%s: no memory for the model", t->path);
    cJSON_DeleteItemFromObjectCaseSensitive(keys, "name");
    lt_params_defer(t->params);
    return model_create(cls, where, keys, t->layer, t->params, &t->m);
}

static lt_status open_config(trained *t, const char *task, const char *hand, const checkpoint_head *head, cJSON *config)
{
    const model_class *cls;
    lt_status st = find_class(t, task, config, &cls);

    t->bilinear = data_flag(config, "bilinear");
    t->names = lt_arena_strdup(t->arena, data_text(config, "names"));
    t->body = lt_arena_strdup(t->arena, data_text(config, "body"));
    if (!t->names || !t->body)
        return lt_error(LT_ENOMEM, "%s: no memory for the model", t->path);
    if (!st && strcmp(task, "hand-object") == 0)
        st = open_hand(t, hand ? hand : data_text(config, "hand"), head->tips);
    st = st ? st : make_model(t, cls, config);
    return st ? st : checkpoint_load_model(t->path, &t->m);
}

lt_status trained_open(const char *path, const char *task, const char *hand, trained *out)
{
    cJSON *config = NULL;
    checkpoint_head head;
    lt_status st;

    *out = (trained){ .arena = lt_arena_new() };
    out->path = out->arena ? checkpoint_last(out->arena, path) : NULL;
    st = out->path ? checkpoint_head_read(out->arena, out->path, &head)
                   : lt_error(LT_ENOMEM, "no memory to open %s", path);
    st = st ? st : lt_json_parse(out->path, head.config, strlen(head.config), &config);
    st = st ? st : open_config(out, task, hand, &head, config);
    cJSON_Delete(config);
    return st;
}

void trained_close(trained *t)
{
    lt_params_free(t->params);
    lt_arena_free(t->arena);
}
