/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/info_file.h"

#include "assets/body_file.h"
#include "assets/hand_file.h"
#include "estimate/checkpoint_folder.h"
#include "libtensor/graph/tensor.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "libtensor/io/pickle/pickle.h"
#include "libtensor/io/torch/torch.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* "(778, 3) f8" */
static void add_array(cJSON *list, const char *name, const lt_array *a)
{
    char shape[LT_SHAPE_TEXT], line[LT_SHAPE_TEXT + 8];

    snprintf(line, sizeof(line), "%s %s", lt_array_shape_text(a, shape, sizeof(shape)), lt_elem_name(a->type));
    cJSON_AddStringToObject(list, name, line);
}

static void add_arrays(cJSON *root, const lt_named_array *entry, size_t n)
{
    cJSON *list = cJSON_AddObjectToObject(root, "arrays");

    for (size_t i = 0; i < n; i++)
        add_array(list, entry[i].name, &entry[i].array);
}

static lt_status info_safetensors(lt_arena *arena, const char *path, cJSON *root)
{
    lt_safetensors s;
    lt_status st = lt_safetensors_read(arena, path, &s);
    cJSON *meta;

    if (st)
        return st;
    meta = cJSON_AddObjectToObject(root, "metadata");
    for (size_t i = 0; i < s.n_meta; i++) {
        cJSON *value = cJSON_Parse(s.meta[i].value);

        if (cJSON_IsObject(value)) {
            cJSON_AddItemToObject(meta, s.meta[i].key, value);
            continue;
        }
        cJSON_AddStringToObject(meta, s.meta[i].key, s.meta[i].value);
        cJSON_Delete(value);
    }
    add_arrays(root, s.entry, s.n);
    return LT_OK;
}

static lt_status info_torch(lt_arena *arena, const char *path, cJSON *root)
{
    static const char *const container[] = {
        [LT_TORCH_ZIP] = "zip", [LT_TORCH_STREAM] = "stream of pickles", [LT_TORCH_TAR] = "tar",
    };
    lt_torch_file f;
    lt_status st = lt_torch_read(arena, path, &f);

    if (st)
        return st;
    cJSON_AddStringToObject(root, "format", "PyTorch checkpoint");
    cJSON_AddStringToObject(root, "container", container[f.container]);
    add_arrays(root, f.entry, f.n);
    return LT_OK;
}

static lt_status info_npz(lt_arena *arena, const char *path, cJSON *root)
{
    lt_npz z;
    lt_status st = lt_npz_read(arena, path, &z);

    if (st == LT_OK)
        add_arrays(root, z.entry, z.n);
    return st;
}

static lt_status info_pickle(lt_arena *arena, const char *path, cJSON *root)
{
    static const char *const kind[] = {
        "None", "bool", "int", "float", "str", "bytes", "list", "tuple", "set", "dict", "array", "object",
        "class", "dtype",
    };
    const lt_pvalue *v;
    lt_status st = lt_pickle_read(arena, path, &v);
    cJSON *keys;

    if (st)
        return st;
    cJSON_AddStringToObject(root, "value", kind[v->kind]);
    keys = cJSON_AddObjectToObject(root, "keys");
    for (size_t i = 0; v->kind == LT_PDICT && i < v->n; i++) {
        const char *key = lt_pstr(v->u.item[2 * i]);
        const lt_pvalue *item = v->u.item[2 * i + 1];

        if (key && item->kind == LT_PARRAY)
            add_array(keys, key, item->u.array);
        else if (key)
            cJSON_AddStringToObject(keys, key, item->kind == LT_POBJECT ? item->u.object.class_name : kind[item->kind]);
    }
    return LT_OK;
}

/* What a model of a hand lacks is told; of a body, where the hand's keys are not what it has. */
static void add_hand_check(lt_arena *arena, const char *path, cJSON *root)
{
    char reason[1024];
    lt_hand_model *hand;
    body_model *body;

    if (hand_file_read(arena, path, &hand) == LT_OK) {
        cJSON_AddStringToObject(root, "hand model", hand->synthetic ? "complete, synthetic" : "complete");
        cJSON_AddStringToObject(root, "side", hand->left ? "left" : "right");
        return;
    }
    snprintf(reason, sizeof(reason), "%s", lt_last_error());
    if (body_file_read(arena, path, &body) == LT_OK) {
        cJSON_AddStringToObject(root, "body model", "complete");
        cJSON_AddNumberToObject(root, "shape directions", body->shapes);
        cJSON_AddNumberToObject(root, "expressions", body->expressions);
    } else {
        cJSON_AddStringToObject(root, "hand model", reason);
        cJSON_AddStringToObject(root, "body model", lt_last_error());
    }
}

static bool is_torch(const char *path)
{
    return lt_ends_with(path, ".pth") || lt_ends_with(path, ".pt") || lt_ends_with(path, ".tar") ||
           lt_ends_with(path, ".ckpt");
}

static lt_status info_by_ending(lt_arena *arena, const char *path, cJSON *root)
{
    lt_status st;

    if (lt_ends_with(path, ".safetensors"))
        return info_safetensors(arena, path, root);
    if (is_torch(path))
        return info_torch(arena, path, root);
    if (!lt_ends_with(path, ".npz") && !lt_ends_with(path, ".pkl"))
        return lt_error(LT_EINVAL, "%s: want a file ending in .safetensors, .npz, .pkl, .pth, .pt, .ckpt or .pth.tar, "
                        "or a dataset with --data", path);
    st = lt_ends_with(path, ".npz") ? info_npz(arena, path, root) : info_pickle(arena, path, root);
    if (st == LT_OK)
        add_hand_check(arena, path, root);
    return st;
}

lt_status info_file(const char *name, cJSON *root)
{
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? checkpoint_last(arena, name) : NULL;
    lt_status st;

    if (!path) {
        st = lt_error(LT_ENOMEM, "no memory to read %s", name);
    } else if (access(path, F_OK) != 0) {
        st = lt_error(lt_errno_status(errno), "%s: %s%s", path, strerror(errno), path == name ? "" : "; a dataset goes behind --data");
    } else {
        cJSON_AddStringToObject(root, "file", path);
        st = info_by_ending(arena, path, root);
    }
    lt_arena_free(arena);
    return st;
}
