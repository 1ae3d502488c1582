/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/checkpoint/internal.h"

#include "estimate/int8/table.h"
#include "estimate/param_arrays.h"
#include "libtensor/graph/rows.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/number.h"

#include <config.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* ---- the check sum: one flipped bit anywhere changes it -------------------------------------------------- */

static uint32_t crc_text(uint32_t crc, const char *text)
{
    return (uint32_t)crc32(crc, (const uint8_t *)text, (uInt)strlen(text) + 1);
}

static uint32_t crc_array(uint32_t crc, const lt_named_array *e)
{
    size_t bytes = 0;

    lt_array_bytes(&e->array, &bytes);
    crc = crc_text(crc, e->name);
    crc = (uint32_t)crc32(crc, (const uint8_t *)e->array.shape,
                          (uInt)((size_t)e->array.rank * sizeof(*e->array.shape)));
    return (uint32_t)crc32_z(crc, e->array.data, bytes);
}

uint32_t checkpoint_crc(const lt_named_array *entry, size_t n, const lt_text_pair *meta, size_t n_meta)
{
    uint32_t crc = 0;

    for (size_t i = 0; i < n; i++)
        crc = crc_array(crc, &entry[i]);
    for (size_t i = 0; i < n_meta; i++)
        if (strcmp(meta[i].key, "crc32") != 0)
            crc = crc_text(crc_text(crc, meta[i].key), meta[i].value);
    return crc;
}

/* ---- reading ------------------------------------------------------------------------------------------ */

/* What people give for one of ours. */
static lt_status check_kind(const char *path)
{
    const lt_kind kind = lt_kind_of_file(path);

    if (kind == LT_KIND_TORCH_ZIP || kind == LT_KIND_TORCH_STREAM)
        return lt_error(LT_EFORMAT, "%s: a checkpoint of PyTorch, want one of palmar train; palmar train --init %s "
                        "begins with its weights", path, path);
    if (kind && kind != LT_KIND_SAFETENSORS)
        return lt_refuse_kind(path, kind, "a checkpoint of palmar train");
    return LT_OK;
}

/* Three numbers; false where they are none. */
static bool take_version(const char *text, int out[3])
{
    int end = 0;

    return text && sscanf(text, "%9d.%9d.%9d%n", &out[0], &out[1], &out[2], &end) == 3 && !text[end];
}

/* A later version may write what this one cannot know of. */
static lt_status check_version(const lt_safetensors *f)
{
    const char *text = lt_safetensors_meta(f, "version");
    int theirs[3], ours[3];

    if (!take_version(text, theirs) || !take_version(PACKAGE_VERSION, ours))
        return lt_error(LT_EFORMAT, "%s: metadata \"version\" is no version", f->path);
    for (int i = 0; i < 3; i++) {
        if (theirs[i] > ours[i])
            return lt_error(LT_EINVAL, "%s: written by palmar %s, and this is %s: want a palmar that is no older",
                            f->path, text, PACKAGE_VERSION);
        if (theirs[i] < ours[i])
            break;
    }
    return LT_OK;
}

static lt_status check_sum(const lt_safetensors *f, const char *crc)
{
    char found[16];

    snprintf(found, sizeof(found), "%08" PRIx32, checkpoint_crc(f->entry, f->n, f->meta, f->n_meta));
    if (strcmp(found, crc) != 0)
        return lt_error(LT_EFORMAT, "%s: is damaged: its check sum is %s, its contents give %s", f->path, crc, found);
    return LT_OK;
}

lt_status checkpoint_read_file(lt_arena *arena, const char *path, lt_safetensors *f)
{
    const char *format, *crc;
    lt_status st = check_kind(path);

    if (!st)
        st = lt_safetensors_read(arena, path, f);
    if (st)
        return st;
    format = lt_safetensors_meta(f, "format");
    crc = lt_safetensors_meta(f, "crc32");
    if (!format || strcmp(format, CHECKPOINT_FORMAT) != 0)
        return lt_error(LT_EFORMAT, "%s: has weights, but is no checkpoint of palmar train; palmar train --init %s "
                        "begins with them", path, path);
    st = check_version(f);
    if (!st && !crc)
        st = lt_error(LT_EFORMAT, "%s: is damaged: has no check sum", path);
    return st ? st : check_sum(f, crc);
}

static lt_status check_model(const lt_safetensors *f, const model *m)
{
    const char *name = lt_safetensors_meta(f, "model"), *variant = lt_safetensors_meta(f, "variant");

    if (!name || !variant)
        return lt_error(LT_EFORMAT, "%s: does not say which model it is of", f->path);
    if (strcmp(name, m->cls->name) != 0 || strcmp(variant, m->variant) != 0)
        return lt_error(LT_EINVAL, "%s: is of model %s (%s), not of %s (%s)", f->path, name, variant,
                        m->cls->name, m->variant);
    return LT_OK;
}

static lt_status check_entry(const lt_safetensors *f, const char *name, const lt_shape *shape)
{
    const lt_array *a = lt_safetensors_find(f, name);

    if (!a)
        return lt_error(LT_EINVAL, "%s: has no \"%s\"; it is of another model or optimiser", f->path, name);
    return array_check(f->path, name, a, name, shape);
}

static lt_status check_params(const lt_safetensors *f, const model *m)
{
    lt_status st = LT_OK;

    for (const lt_param *p = lt_params_first(m->params); st == LT_OK && p; p = p->next)
        st = check_entry(f, p->name, &p->shape);
    return st;
}

/* Parameters whose rows come and go have as many as the file says. */
static lt_status take_rows(const lt_safetensors *f, const model *m)
{
    lt_status st = LT_OK;

    for (lt_param *p = lt_params_first(m->params); st == LT_OK && p; p = p->next) {
        const lt_array *a = p->rows ? lt_safetensors_find(f, p->name) : NULL;

        if (a && a->rank == p->shape.rank && a->shape[0] != p->shape.dim[0])
            st = lt_param_resize(p, a->shape[0]);
    }
    return st ? lt_error_prefix(LT_EINVAL, "%s", f->path) : LT_OK;
}

static lt_status read_for(lt_arena *arena, const char *path, const model *m, const checkpoint_own *own,
                          lt_safetensors *f)
{
    lt_status st = arena ? checkpoint_read_file(arena, path, f) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (st == LT_OK)
        st = check_model(f, m);
    if (st == LT_OK)
        st = take_rows(f, m);
    if (st == LT_OK && own)
        st = own->load(own->ctx, path, f->entry, f->n);
    return st ? st : check_params(f, m);
}

lt_status checkpoint_check(const char *path, const model *m)
{
    lt_arena *arena = lt_arena_new();
    lt_safetensors f;
    const lt_status st = read_for(arena, path, m, NULL, &f);

    lt_arena_free(arena);
    return st;
}

static lt_status check_optim(const lt_safetensors *f, const lt_optim *optim)
{
    lt_status st = LT_OK;

    for (int i = 0; st == LT_OK && i < lt_optim_state_count(optim); i++) {
        const lt_optim_state s = lt_optim_state_at(optim, i);

        st = check_entry(f, s.name, &s.shape);
    }
    return st;
}

static lt_status get_int(const lt_safetensors *f, const char *key, int64_t *out)
{
    const char *text = lt_safetensors_meta(f, key);
    char *end = NULL;

    *out = text ? strtoll(text, &end, 10) : 0;
    if (!text || end == text || *end || *out < 0)
        return lt_error(LT_EFORMAT, "%s: metadata \"%s\" is no count", f->path, key);
    return LT_OK;
}

static lt_status get_state(const lt_safetensors *f, checkpoint_state *out)
{
    const char *best = lt_safetensors_meta(f, "best");
    const char *end = NULL;
    int64_t epoch, seed;
    lt_status st = get_int(f, "step", &out->step);

    if (st == LT_OK)
        st = get_int(f, "skipped", &out->skipped);
    if (st == LT_OK)
        st = get_int(f, "optim_steps", &out->optim_steps);
    if (st == LT_OK)
        st = get_int(f, "validated", &out->validated);
    if (st == LT_OK)
        st = get_int(f, "best_step", &out->best_step);
    if (st == LT_OK)
        st = get_int(f, "epoch", &epoch);
    if (st == LT_OK)
        st = get_int(f, "next", &out->position.next);
    if (st == LT_OK)
        st = get_int(f, "seed", &seed);
    if (st)
        return st;
    out->position.epoch = (uint64_t)epoch;
    out->seed = (uint64_t)seed;
    out->best = best ? lt_strtod(best, &end) : INFINITY;
    if (best && end == best)
        out->best = INFINITY;                /* "null": no validation yet */
    return LT_OK;
}

static void put_back(const lt_safetensors *f, const model *m, lt_optim *optim, const checkpoint_state *s)
{
    for (lt_param *p = lt_params_first(m->params); p; p = p->next)
        array_load(lt_safetensors_find(f, p->name), p->data);
    for (int i = 0; i < lt_optim_state_count(optim); i++) {
        const lt_optim_state state = lt_optim_state_at(optim, i);

        array_load(lt_safetensors_find(f, state.name), state.data);
    }
    lt_optim_set_steps(optim, s->optim_steps);
    lt_params_changed(m->params);
}

lt_status checkpoint_load(const char *path, const model *m, lt_optim *optim, checkpoint_state *state,
                          const checkpoint_own *own)
{
    lt_arena *arena = lt_arena_new();
    checkpoint_state s;
    lt_safetensors f;
    lt_status st = read_for(arena, path, m, own, &f);

    if (st == LT_OK)
        st = check_optim(&f, optim);
    if (st == LT_OK)
        st = get_state(&f, &s);
    if (st == LT_OK) {
        put_back(&f, m, optim, &s);
        *state = s;
    }
    lt_arena_free(arena);
    return st;
}

const lt_named_array *checkpoint_average(const lt_named_array *entry, size_t n, const char *weight)
{
    static const char prefix[] = "optim.ema.";              /* as lt_optim_state_at has it */
    const size_t length = strlen(prefix);

    for (size_t i = 0; i < n; i++)
        if (strncmp(entry[i].name, prefix, length) == 0 && strcmp(entry[i].name + length, weight) == 0)
            return &entry[i];
    return NULL;
}

/* The average of a weight where the file has one, else the weight. */
static const lt_array *best_of(const lt_safetensors *f, const lt_param *p)
{
    const lt_named_array *average = checkpoint_average(f->entry, f->n, p->name);

    return average && array_fits(&average->array, &p->shape) ? &average->array : lt_safetensors_find(f, p->name);
}

static lt_status read_table(const lt_safetensors *f, model *m)
{
    const char *text = lt_safetensors_meta(f, "int8");

    m->int8 = NULL;
    return text ? int8_table_parse(lt_params_arena(m->params), f->path, text, m->params, &m->int8) : LT_OK;
}

lt_status checkpoint_load_model(const char *path, model *m)
{
    lt_arena *arena = lt_arena_new();
    lt_safetensors f;
    lt_status st = read_for(arena, path, m, NULL, &f);

    if (st == LT_OK)
        st = read_table(&f, m);
    if (st == LT_OK)
        st = lt_params_allocate(m->params);
    for (lt_param *p = lt_params_first(m->params); st == LT_OK && p; p = p->next)
        array_load(best_of(&f, p), p->data);
    lt_params_changed(m->params);
    lt_arena_free(arena);
    return st;
}

static lt_status get_tips(const lt_safetensors *f, int tips[5])
{
    const char *text = lt_safetensors_meta(f, "tips");
    int end = 0;

    memcpy(tips, lt_hand_tips_ho3d, sizeof(lt_hand_tips_ho3d));
    if (!text)
        return LT_OK;
    if (sscanf(text, "%4d %4d %4d %4d %4d%n", &tips[0], &tips[1], &tips[2], &tips[3], &tips[4], &end) != 5 || text[end])
        return lt_error(LT_EFORMAT, "%s: metadata \"tips\" is not five vertices", f->path);
    return LT_OK;
}

lt_status checkpoint_head_read(lt_arena *arena, const char *path, checkpoint_head *out)
{
    lt_safetensors f;
    lt_status st = checkpoint_read_file(arena, path, &f);

    if (st)
        return st;
    out->config = lt_safetensors_meta(&f, "config");
    if (!out->config)
        return lt_error(LT_EFORMAT, "%s: carries no configuration", path);
    out->isa = lt_safetensors_meta(&f, "isa");
    st = get_tips(&f, out->tips);
    return st ? st : get_int(&f, "step", &out->step);
}
