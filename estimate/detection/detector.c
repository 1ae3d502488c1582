/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/detection/detector.h"

#include "estimate/checkpoint/checkpoint.h"
#include "estimate/detection/class_names.h"
#include "estimate/weights/weights.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/json.h"
#include "models/detect/csp_seg.h"
#include "vision/detection/letterbox.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

/* ---- weights by themselves ------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), m = strlen(end);

    return n >= m && strcmp(text + n - m, end) == 0;
}

/* How many classes a file's weights tell apart: what its last layer for them has outputs. 0: it has no such layer */
static lt_status count_classes(lt_arena *arena, const char *path, int *out)
{
    lt_weights_file f;
    const lt_status st = lt_weights_read(arena, path, &f);

    *out = 0;
    for (size_t i = 0; i < (st ? 0 : f.n) && !*out; i++) {
        const char *name = f.entry[i].name;

        if (ends_with(name, "22.cv3.0.2.bias") || ends_with(name, "head.class.0.2.bias"))
            *out = (int)lt_min_i64(lt_array_count(&f.entry[i].array), INT32_MAX);
    }
    if (!st && !*out)
        return lt_error(LT_EINVAL, "%s: no weights of a detector: want a run of csp_seg, or YOLOv8n-seg's", path);
    return st;
}

static lt_status create(trained *t, int classes)
{
    cJSON *config = cJSON_CreateObject();
    lt_status st;

    t->params = lt_params_new();
    if (!t->params || !config || !cJSON_AddNumberToObject(config, "classes", classes))
        st = lt_error(LT_ENOMEM, "%s: no memory for the model", t->path);
    else
        st = model_create(&csp_seg_class, t->path, config, NULL, t->params, &t->m);
    cJSON_Delete(config);
    return st;
}

static lt_status load_weights(trained *t)
{
    weights_report r;
    const lt_status st = weights_init(t->arena, t->path, &t->m, &r);

    if (st || !r.n_missing)
        return st;
    return lt_error(LT_EINVAL, "%s: has no weights for %d of the detector's parameters, the first of them %s; want all "
                    "of YOLOv8n-seg's", t->path, r.n_missing, r.missing[0]);
}

static lt_status open_weights(trained *t, const char *path)
{
    const lt_kind kind = lt_kind_of_file(path);
    int classes;
    lt_status st = count_classes(t->arena, path, &classes);

    t->path = path;
    t->names = "";
    st = st ? st : create(t, classes);
    st = st ? st : load_weights(t);
    if (!st && (kind == LT_KIND_TORCH_ZIP || kind == LT_KIND_TORCH_STREAM))
        st = class_names_saved(t->arena, path, &t->names);
    return st;
}

/* ---- opening --------------------------------------------------------------------------------------------- */

static lt_status record(const void *ctx, model_record *r)
{
    const model *m = ctx;

    m->cls->record(m, false, r);
    return LT_OK;
}

static bool is_checkpoint(const char *path)
{
    lt_arena *arena = lt_arena_new();
    checkpoint_head head;
    const bool is = lt_is_folder(path) || (arena && checkpoint_head_read(arena, path, &head) != LT_EFORMAT);

    lt_arena_free(arena);
    return is;
}

static lt_status open_model(const char *path, detector *d)
{
    if (is_checkpoint(path))
        return trained_open(path, "detect", NULL, &d->t);
    d->t = (trained){ .arena = lt_arena_new() };
    return d->t.arena ? open_weights(&d->t, path) : lt_error(LT_ENOMEM, "no memory to open %s", path);
}

lt_status detector_open(const char *path, detector *out)
{
    detector *d = out;
    recipe by = { .record = record };
    lt_status st;

    *d = (detector){ .n = 0 };
    st = open_model(path, d);
    if (st)
        return st;
    by.ctx = &d->t.m;
    d->n = csp_seg_config_of(&d->t.m)->classes;
    d->name = class_names_of(d->t.arena, d->t.names, d->n);
    if (!d->name)
        return lt_error(LT_ENOMEM, "no memory to open %s", path);
    return compiled_new(&by, 1, false, &d->c);
}

void detector_close(detector *d)
{
    compiled_free(&d->c);
    trained_close(&d->t);
}

/* ---- at work --------------------------------------------------------------------------------------------- */

/* A class's score that is not a number would be no candidate, and pass for nothing found. */
static bool finite_scores(const compiled *c)
{
    float sum = 0;

    for (int i = DETECT_LEVELS; i < 2 * DETECT_LEVELS; i++) {
        const lt_tensor *t = model_port_find(&c->record.outputs, csp_seg_output[i]);
        const float *x = (const float *)lt_plan_data(c->plan, t);

        for (int64_t k = 0; k < lt_numel(t); k++)
            sum += x[k];
    }
    return isfinite(sum);
}

lt_status detector_run(detector *d, const uint8_t *rgb, int width, int height, const detection_rules *rules,
                       lt_arena *arena, detect_found **out, int *n)
{
    const int size = d->t.m.image_size;
    const letterbox l = letterbox_of(width, height, size);
    const lt_image picture = { width, height, 3, 8, (uint8_t *)rgb };
    const lt_tensor *image = model_port_find(&d->c.record.inputs, "image");

    letterbox_picture(&l, &picture, size, lt_plan_data(d->c.plan, image));
    lt_run(d->c.plan);
    if (!finite_scores(&d->c))
        return lt_error(LT_ENUMERIC, "the detector's answer is not finite: its weights are damaged");
    return detect_found_in(&d->c, &d->t.m, 0, width, height, rules, arena, out, n);
}
