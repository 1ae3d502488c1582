/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/embedder.h"

#include "estimate/checkpoint/checkpoint.h"
#include "estimate/checkpoint/folder.h"
#include "estimate/compiled.h"
#include "libtensor/io/text/json.h"
#include "vision/track/look.h"

#include <cjson/cJSON.h>
#include <string.h>

struct embedder {
    lt_arena *arena;                /* NULL where the model is the caller's, as are its */
    lt_params *params;
    model m;
    compiled net;
};

/* One box at a time, so that the bits of an embedding do not depend on who else is in the picture */
static lt_status record(const void *m, model_record *r)
{
    ((const model *)m)->cls->record(m, false, r);
    return LT_OK;
}

static lt_status compile(embedder *e)
{
    return compiled_new(&(recipe){ .ctx = &e->m, .record = record }, 1, false, &e->net);
}

lt_status embedder_new(const model *m, embedder **out)
{
    embedder *e = lt_alloc(sizeof(*e));
    lt_status st = e ? LT_OK : lt_error(LT_ENOMEM, "no memory for embeddings");

    if (st)
        return st;
    e->m = *m;
    st = compile(e);
    if (st)
        embedder_free(e);
    else
        *out = e;
    return st;
}

static lt_status load(embedder *e, const char *path, cJSON *config)
{
    cJSON *keys = cJSON_GetObjectItemCaseSensitive(config, "model");
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(keys, "name"));
    const char *where = lt_arena_printf(e->arena, "%s: model", path);
    lt_status st;

    if (!name || strcmp(name, reid_class.name) != 0)
        return lt_error(LT_EINVAL, "%s: a model %s, expected %s, which embeds looks", path,
                        name ? name : "without a name", reid_class.name);
    e->params = lt_params_new();
    if (!where || !e->params)
        return lt_error(LT_ENOMEM, "%s: no memory for the model", path);
    cJSON_DeleteItemFromObjectCaseSensitive(keys, "name");
    lt_params_defer(e->params);
    st = model_create(&reid_class, where, keys, NULL, e->params, &e->m);
    if (!st)
        st = checkpoint_load_model(path, &e->m);
    return st ? st : compile(e);
}

lt_status embedder_open(const char *path, embedder **out)
{
    embedder *e = lt_alloc(sizeof(*e));
    cJSON *config = NULL;
    checkpoint_head head;
    lt_status st;

    if (e)
        e->arena = lt_arena_new();
    path = e && e->arena ? checkpoint_last(e->arena, path) : NULL;
    st = path ? checkpoint_head_read(e->arena, path, &head) : lt_error(LT_ENOMEM, "no memory for embeddings");
    if (!st)
        st = lt_json_parse(path, head.config, strlen(head.config), &config);
    if (!st)
        st = load(e, path, config);
    cJSON_Delete(config);
    if (st)
        embedder_free(e);
    else
        *out = e;
    return st;
}

void embedder_free(embedder *e)
{
    if (!e)
        return;
    compiled_free(&e->net);
    lt_params_free(e->params);
    lt_arena_free(e->arena);
    lt_release(e);
}

bool embedder_run(embedder *e, const lt_image *rgb, const float box[4], bool person, float *out)
{
    lt_real *image = lt_plan_data(e->net.plan, model_port_find(&e->net.record.inputs, "image"));

    if (!look_cut(rgb, box, person, REID_WIDTH, REID_HEIGHT, image))
        return false;
    lt_run(e->net.plan);
    memcpy(out, compiled_output(&e->net, "embedding"), REID_EMBEDDING * sizeof(*out));
    return true;
}
