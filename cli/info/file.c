/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/info/file.h"

#include "assets/body_file.h"
#include "assets/hand_file.h"
#include "assets/keyed_arrays.h"
#include "estimate/checkpoint/folder.h"
#include "libtensor/graph/tensor.h"
#include "libtensor/io/array/npy_entry.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "libtensor/io/torch/torch.h"
#include "libtensor/io/torch/weights_file.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char wanted[] = "safetensors, .npz, .npy, a pickle or a checkpoint of PyTorch";

/* A file that is looked at, and what is told of it. */
typedef struct {
    lt_arena *arena;
    const char *path;
    lt_kind kind;
    cJSON *root, *notes;
} look;

enum { NOTES = 16 };                    /* that are said: a file may have thousands */

/* text: NULL without memory */
static void add_note(const look *l, const char *code, const char *text)
{
    cJSON *note = text ? cJSON_CreateObject() : NULL;

    if (!note)
        return;
    cJSON_AddStringToObject(note, "code", code);
    cJSON_AddStringToObject(note, "text", text);
    cJSON_AddItemToArray(l->notes, note);
}

/* ---- arrays ---------------------------------------------------------------------------------------------- */

/* "(778, 3) f8" */
static void add_array(cJSON *list, const char *name, const lt_array *a)
{
    char shape[LT_SHAPE_TEXT], line[LT_SHAPE_TEXT + 8];

    snprintf(line, sizeof(line), "%s %s", lt_array_shape_text(a, shape, sizeof(shape)), lt_elem_name(a->type));
    cJSON_AddStringToObject(list, name, line);
}

static cJSON *add_arrays(const look *l, const lt_named_array *entry, size_t n)
{
    cJSON *list = cJSON_AddObjectToObject(l->root, "arrays");

    for (size_t i = 0; i < n; i++)
        add_array(list, entry[i].name, &entry[i].array);
    return list;
}

static void add_refused(const look *l, cJSON *list, const lt_refused_array *refused, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        cJSON_AddStringToObject(list, refused[i].name, "not read");
        if (cJSON_GetArraySize(l->notes) < NOTES)
            add_note(l, "array_not_read", lt_arena_printf(l->arena, "\"%s\": %s", refused[i].name, refused[i].reason));
    }
}

/* A number or a short text as it is, anything else as what it is. */
static const char *value_text(const lt_pvalue *v, char *out, size_t n)
{
    if (v->kind == LT_PINT)
        snprintf(out, n, "%jd", (intmax_t)v->u.integer);
    else if (v->kind == LT_PFLOAT)
        snprintf(out, n, "%g", v->u.number);
    else if (v->kind == LT_PSTR && v->n < n)
        snprintf(out, n, "%s", v->u.text);
    else
        lt_pdescribe(v, out, n);
    return out;
}

/* Objects that nobody looks into; those of SciPy's and chumpy's are arrays. */
static bool is_closed(const lt_pvalue *v)
{
    return v->kind == LT_POBJECT && strncmp(v->u.object.class_name, "scipy.sparse.", 13) != 0 &&
           strncmp(v->u.object.class_name, "chumpy.", 7) != 0;
}

static void add_value(const look *l, cJSON *list, const char *name, const lt_pvalue *v)
{
    char text[160];

    if (v->kind == LT_PARRAY)
        add_array(list, name, v->u.array);
    else
        cJSON_AddStringToObject(list, name, value_text(v, text, sizeof(text)));
    if (is_closed(v) && cJSON_GetArraySize(l->notes) < NOTES)
        add_note(l, "object_closed",
                 lt_arena_printf(l->arena, "\"%s\": %s, which stays closed: nothing in a file is run", name, text));
}

/* What stands under the keys of a dict. */
static void add_keys(const look *l, const lt_pvalue *d)
{
    cJSON *keys = cJSON_AddObjectToObject(l->root, "keys");

    for (size_t i = 0; d->kind == LT_PDICT && i < d->n; i++)
        if (lt_pstr(d->u.item[2 * i]))
            add_value(l, keys, lt_pstr(d->u.item[2 * i]), d->u.item[2 * i + 1]);
}

/* ---- hands and bodies -------------------------------------------------------------------------------------- */

/* What a model of a hand lacks is told; of a body, where the hand's keys are not what it has. */
static void add_hand_check(const look *l, const keyed *k)
{
    char reason[1024];
    lt_hand_model *hand;
    body_model *body;

    if (hand_file_take(l->arena, k, &hand) == LT_OK) {
        cJSON_AddStringToObject(l->root, "hand model", hand->synthetic ? "complete, synthetic" : "complete");
        cJSON_AddStringToObject(l->root, "side", hand->left ? "left" : "right");
        return;
    }
    snprintf(reason, sizeof(reason), "%s", lt_last_error());
    if (body_file_take(l->arena, k, &body) == LT_OK) {
        cJSON_AddStringToObject(l->root, "body model", body->synthetic ? "complete, synthetic" : "complete");
        cJSON_AddNumberToObject(l->root, "shape directions", body->shapes);
        cJSON_AddNumberToObject(l->root, "expressions", body->expressions);
        return;
    }
    cJSON_AddStringToObject(l->root, "hand model", reason);
    cJSON_AddStringToObject(l->root, "body model", lt_last_error());
    if (keyed_has(k, "v_template"))
        add_note(l, "hand_unusable", reason);
}

/* The same of a file that is a hand's by a name in it. */
static lt_status check_hand_in(const look *l, bool is_hand)
{
    keyed k;
    const lt_status st = is_hand ? keyed_open(l->arena, l->path, &k) : LT_OK;

    if (st == LT_OK && is_hand)
        add_hand_check(l, &k);
    return st;
}

/* An .npz: its arrays, and of those of Python's objects what these are. */
static lt_status info_npz(const look *l)
{
    keyed k;
    lt_status st = keyed_open(l->arena, l->path, &k);
    cJSON *list;

    if (st)
        return st;
    list = add_arrays(l, k.npz.entry, k.npz.n);
    for (size_t i = 0; !st && i < k.npz.n_refused; i++) {
        const lt_pvalue *v;

        st = keyed_value(&k, k.npz.refused[i].name, &v);
        if (!st && v)
            add_value(l, list, k.npz.refused[i].name, v);
        else if (!st)
            add_refused(l, list, &k.npz.refused[i], 1);
    }
    if (!st)
        add_hand_check(l, &k);
    return st;
}

/* The value of a pickle in n bytes. */
static lt_status info_value(const look *l, const uint8_t *bytes, size_t n)
{
    keyed k = { .arena = l->arena, .path = l->path, .kind = l->kind };
    const lt_status st = lt_pickle_parse(l->arena, l->path, bytes, n, &k.dict);
    char text[160];

    if (st)
        return st;
    cJSON_AddStringToObject(l->root, "value", value_text(k.dict, text, sizeof(text)));
    add_keys(l, k.dict);
    if (k.dict->kind == LT_PDICT)
        add_hand_check(l, &k);
    return LT_OK;
}

/* ---- files -------------------------------------------------------------------------------------------------- */

static lt_status info_safetensors(const look *l)
{
    lt_safetensors s;
    lt_status st = lt_safetensors_read(l->arena, l->path, &s);
    cJSON *meta;

    if (st)
        return st;
    meta = cJSON_AddObjectToObject(l->root, "metadata");
    for (size_t i = 0; i < s.n_meta; i++) {
        cJSON *value = cJSON_Parse(s.meta[i].value);

        if (cJSON_IsObject(value)) {
            cJSON_AddItemToObject(meta, s.meta[i].key, value);
            continue;
        }
        cJSON_AddStringToObject(meta, s.meta[i].key, s.meta[i].value);
        cJSON_Delete(value);
    }
    add_refused(l, add_arrays(l, s.entry, s.n), s.refused, s.n_refused);
    return check_hand_in(l, lt_safetensors_find(&s, "v_template") != NULL);
}

static lt_status info_torch(const look *l)
{
    static const char *const container[] = {
        [LT_TORCH_ZIP] = "zip", [LT_TORCH_STREAM] = "stream of pickles", [LT_TORCH_TAR] = "tar",
    };
    lt_torch_file f;
    lt_status st = lt_torch_read(l->arena, l->path, &f);

    if (st)
        return st;
    cJSON_AddStringToObject(l->root, "format", "PyTorch checkpoint");
    cJSON_AddStringToObject(l->root, "container", container[f.container]);
    add_keys(l, f.value);
    add_refused(l, add_arrays(l, f.entry, f.n), f.refused, f.n_refused);
    return check_hand_in(l, lt_pdict_get(f.value, "v_template") != NULL);
}

/* A pickle, or a .npy: one array, or what Python's objects numpy.save wrote. */
static lt_status info_one(const look *l)
{
    lt_refused_array refused = { .reason = NULL };
    lt_array a;
    uint8_t *bytes;
    size_t n;
    lt_status st = lt_read_file(l->arena, l->path, LT_FILE_MAX, &bytes, &n);

    if (!st && l->kind != LT_KIND_NPY)
        return lt_pickle_sniff(bytes, n) ? info_value(l, bytes, n) : lt_refuse_kind(l->path, l->kind, wanted);
    if (!st)
        st = lt_npy_parse_entry(l->arena, l->path, bytes, n, &a, &refused);
    if (st)
        return st;
    if (refused.pickle)
        return info_value(l, refused.pickle, refused.n);
    if (refused.reason)
        return lt_error(LT_EFORMAT, "%s: %s", l->path, refused.reason);
    add_array(l->root, "array", &a);
    return LT_OK;
}

/* An index of weights in several files. */
static lt_status info_json(const look *l)
{
    lt_weights_file f;
    const lt_status st = lt_weights_read(l->arena, l->path, &f);

    if (st)
        return st;
    cJSON_AddStringToObject(l->root, "format", f.format);
    add_refused(l, add_arrays(l, f.entry, f.n), f.refused, f.n_refused);
    return LT_OK;
}

/* An archive that is neither's at first sight may have been packed again. */
static lt_status info_zip(const look *l)
{
    lt_torch_file f;

    return lt_torch_read(l->arena, l->path, &f) == LT_OK ? info_torch(l) : info_npz(l);
}

static lt_status info_by_kind(const look *l)
{
    switch (l->kind) {
    case LT_KIND_SAFETENSORS:
        return info_safetensors(l);
    case LT_KIND_TORCH_ZIP: case LT_KIND_TORCH_STREAM: case LT_KIND_TAR:
        return info_torch(l);
    case LT_KIND_ZIP:
        return info_zip(l);
    case LT_KIND_NPZ:
        return info_npz(l);
    case LT_KIND_NPY: case LT_KIND_PICKLE: case LT_KIND_UNKNOWN:
        return info_one(l);
    case LT_KIND_JSON:
        return info_json(l);
    default:
        return lt_refuse_kind(l->path, l->kind, wanted);
    }
}

/* A name that promises another kind than the file is. */
static void note_ending(const look *l)
{
    static const struct {
        const char *ending;
        lt_kind kind[3];
    } endings[] = {
        { ".safetensors", { LT_KIND_SAFETENSORS } }, { ".npz", { LT_KIND_NPZ, LT_KIND_ZIP } },
        { ".npy", { LT_KIND_NPY } },
        { ".pkl", { LT_KIND_PICKLE, LT_KIND_UNKNOWN } },
        { ".pth", { LT_KIND_TORCH_ZIP, LT_KIND_TORCH_STREAM, LT_KIND_ZIP } },
        { ".pt", { LT_KIND_TORCH_ZIP, LT_KIND_TORCH_STREAM, LT_KIND_ZIP } },
    };

    for (size_t i = 0; i < LT_COUNT(endings); i++) {
        bool promised = !lt_ends_with(l->path, endings[i].ending);
        const char *text;

        for (int k = 0; k < 3; k++)
            promised |= endings[i].kind[k] == l->kind;
        text = promised ? NULL : lt_arena_printf(l->arena, "called %s, and is %s", endings[i].ending,
                                                 lt_kind_name(l->kind));
        if (text)
            add_note(l, "other_ending", text);
    }
}

static lt_status look_at(look *l, const char *name)
{
    lt_status st;

    l->path = checkpoint_last(l->arena, name);
    if (!l->path)
        return lt_error(LT_ENOMEM, "no memory to read %s", name);
    if (access(l->path, F_OK) != 0)
        return lt_error(lt_errno_status(errno), "%s: %s%s", l->path, strerror(errno),
                        l->path == name ? "" : "; a dataset goes behind --data");
    cJSON_AddStringToObject(l->root, "file", l->path);
    l->kind = lt_kind_of_file(l->path);
    note_ending(l);
    st = info_by_kind(l);
    if (st == LT_OK && cJSON_AddItemToObject(l->root, "notes", l->notes))
        l->notes = NULL;
    return st;
}

lt_status info_file(const char *name, cJSON *root)
{
    look l = { .arena = lt_arena_new(), .root = root, .notes = cJSON_CreateArray() };
    const lt_status st = l.arena && l.notes ? look_at(&l, name) : lt_error(LT_ENOMEM, "no memory to read %s", name);

    cJSON_Delete(l.notes);
    lt_arena_free(l.arena);
    return st;
}
