/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/checkpoint/internal.h"

#include "estimate/int8/table.h"
#include "estimate/param_arrays.h"
#include "libtensor/base/cpu.h"
#include "libtensor/io/text/json.h"
#include "libtensor/kernels/kernels.h"

#include <cjson/cJSON.h>
#include <config.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double MOST_HALF = 65504;

/* ---- writing ------------------------------------------------------------------------------------------ */

enum { META = 18 };             /* and some for the check sum and a table */

typedef struct {
    lt_arena *arena;
    lt_named_array *entry;
    size_t n;
    lt_text_pair meta[META];
    size_t n_meta;
    bool no_memory;
} contents;

/* optim, own: or NULL */
static bool collect(contents *c, const model *m, const lt_optim *optim, const checkpoint_own *own)
{
    const int states = optim ? lt_optim_state_count(optim) : 0, room = own ? CHECKPOINT_OWN : 0;

    c->entry = param_arrays(c->arena, m->params, (size_t)(states + room), &c->n);
    if (!c->entry)
        return false;
    for (int i = 0; i < states; i++) {
        const lt_optim_state s = lt_optim_state_at(optim, i);

        c->entry[c->n++] = (lt_named_array){ s.name, reals_array(&s.shape, s.data) };
    }
    if (own)
        c->n += (size_t)own->save(own->ctx, c->entry + c->n, room);
    return true;
}

static void put(contents *c, const char *key, const char *value)
{
    c->no_memory |= !value;
    c->meta[c->n_meta++] = (lt_text_pair){ key, value };
}

static void put_int(contents *c, const char *key, int64_t value)
{
    put(c, key, lt_arena_printf(c->arena, "%" PRId64, value));
}

/* Which vertices of the hand the data's annotation calls finger tips. */
static void put_tips(contents *c, const lt_hand_layer *hand)
{
    int t[5];

    lt_hand_layer_tips(hand, t);
    put(c, "tips", lt_arena_printf(c->arena, "%d %d %d %d %d", t[0], t[1], t[2], t[3], t[4]));
}

static bool describe(contents *c, const model *m, const char *config, const checkpoint_state *s)
{
    char best[LT_JSON_NUMBER];

    put(c, "format", CHECKPOINT_FORMAT);
    put(c, "version", PACKAGE_VERSION);
    put(c, "model", m->cls->name);
    put(c, "variant", m->variant);
    put(c, "config", config);
    put_int(c, "step", s->step);
    put_int(c, "epoch", (int64_t)s->position.epoch);
    put_int(c, "next", s->position.next);
    put_int(c, "seed", (int64_t)s->seed);
    put_int(c, "skipped", s->skipped);
    put_int(c, "optim_steps", s->optim_steps);
    put_int(c, "validated", s->validated);
    put(c, "best", lt_arena_strdup(c->arena, lt_json_number(s->best, best)));
    put_int(c, "best_step", s->best_step);
    put(c, "isa", lt_isa_name(lt_k->isa));
    if (m->hand)
        put_tips(c, m->hand);
    return !c->no_memory;
}

static lt_status check_finite(const char *path, const contents *c)
{
    for (size_t i = 0; i < c->n; i++) {
        const lt_array *a = &c->entry[i].array;
        const lt_real *x = a->data;

        for (size_t k = 0; k < lt_array_count(a); k++)
            if (!isfinite(x[k]))
                return lt_error(LT_ENUMERIC, "%s: not written, for \"%s\" is not finite at %zu", path,
                                c->entry[i].name, k);
    }
    return LT_OK;
}

/* Matrices and kernels in half precision; what has one dimension is small, and may need its range. */
static lt_status halve(const char *path, contents *c)
{
    for (size_t i = 0; i < c->n; i++) {
        lt_array *a = &c->entry[i].array;
        const size_t n = lt_array_count(a);
        const lt_real *x = a->data;
        uint16_t *half = a->rank > 1 ? lt_arena_array(c->arena, n, sizeof(*half)) : NULL;

        if (a->rank < 2)
            continue;
        if (!half)
            return lt_error(LT_ENOMEM, "%s: no memory for the checkpoint", path);
        for (size_t k = 0; k < n; k++) {
            if (fabs((double)x[k]) > MOST_HALF)
                return lt_error(LT_ENUMERIC, "%s: not written, for \"%s\" is %g at %zu, and half precision ends at %g",
                                path, c->entry[i].name, (double)x[k], k, MOST_HALF);
            half[k] = lt_f32_to_f16((float)x[k]);
        }
        *a = lt_array_make(LT_ELEM_F2, a->rank, a->shape, half);
    }
    return LT_OK;
}

static lt_status write_contents(const char *path, contents *c, bool half)
{
    lt_status st = check_finite(path, c);
    char crc[16];

    if (!st && half)
        st = halve(path, c);
    if (st)
        return st;
    snprintf(crc, sizeof(crc), "%08" PRIx32, checkpoint_crc(c->entry, c->n, c->meta, c->n_meta));
    put(c, "crc32", crc);
    st = lt_safetensors_write(path, c->entry, c->n, c->meta, c->n_meta);
    c->n_meta--;
    return st;
}

lt_status checkpoint_save(const char *path, const model *m, const lt_optim *optim, const char *config,
                          const checkpoint_state *state, const checkpoint_own *own)
{
    contents c = { .arena = lt_arena_new() };
    lt_status st;

    if (!c.arena || !collect(&c, m, optim, own) || !describe(&c, m, config, state)) {
        lt_arena_free(c.arena);
        return lt_error(LT_ENOMEM, "%s: no memory for the checkpoint", path);
    }
    st = write_contents(path, &c, false);
    lt_arena_free(c.arena);
    return st;
}

/* In the header of a file: what an entry takes, name and shape and where its data is; all metadata, and a configuration
 * takes most of that */
enum { ENTRY_BYTES = 160, META_BYTES = 8192 };

size_t checkpoint_bytes(const model *m, const lt_optim *optim)
{
    size_t n = 0, names = 0;

    for (const lt_param *p = lt_params_first(m->params); p; p = p->next, names++)
        n += (size_t)lt_param_numel(p);
    for (int i = 0; i < lt_optim_state_count(optim); i++, names++) {
        const lt_optim_state s = lt_optim_state_at(optim, i);

        n += (size_t)lt_shape_numel(&s.shape);
    }
    return n * sizeof(lt_real) + ENTRY_BYTES * names + META_BYTES;
}

static char *print_json(lt_arena *arena, const cJSON *value)
{
    char *text = NULL, *copy;
    size_t n;
    FILE *f = open_memstream(&text, &n);

    if (!f)
        return NULL;
    lt_json_print(f, value);
    copy = fclose(f) ? NULL : lt_arena_strdup(arena, text);
    free(text);
    return copy;
}

/* Of the folder that it was trained on, the last name alone: the rest says where it lay on somebody's machine. */
static lt_status anonymous(contents *c, const char *path, const char *config, const char **out)
{
    cJSON *root, *dir;
    const char *last;
    lt_status st = lt_json_parse(path, config, strlen(config), &root);

    if (st)
        return st;
    dir = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(root, "data"), "dir");
    last = cJSON_IsString(dir) ? strrchr(dir->valuestring, '/') : NULL;
    *out = config;
    if (last) {
        memmove(dir->valuestring, last + 1, strlen(last));
        *out = print_json(c->arena, root);
    }
    cJSON_Delete(root);
    return *out ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", path);
}

/* All that the file says of itself, but what is made anew. */
static lt_status copy_meta(contents *c, const lt_safetensors *f)
{
    lt_status st = LT_OK;

    for (size_t i = 0; i < f->n_meta && !st; i++) {
        const char *key = f->meta[i].key, *value = f->meta[i].value;

        if (strcmp(key, "crc32") == 0 || strcmp(key, "int8") == 0)
            continue;
        if (c->n_meta == META - 2)
            return lt_error(LT_EFORMAT, "%s: more metadata than a checkpoint has", f->path);
        if (strcmp(key, "config") == 0)
            st = anonymous(c, f->path, value, &value);
        put(c, key, value);
    }
    return st;
}

lt_status checkpoint_save_inference(const char *path, const char *from, const model *m, bool half)
{
    contents c = { .arena = lt_arena_new() };
    lt_safetensors f;
    lt_status st = c.arena ? checkpoint_read_file(c.arena, from, &f) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (st == LT_OK)
        st = copy_meta(&c, &f);
    if (st == LT_OK) {
        if (m->int8)
            put(&c, "int8", int8_table_text(c.arena, m->int8));
        st = collect(&c, m, NULL, NULL) && !c.no_memory ? write_contents(path, &c, half)
                                                  : lt_error(LT_ENOMEM, "%s: no memory for the checkpoint", path);
    }
    lt_arena_free(c.arena);
    return st;
}
