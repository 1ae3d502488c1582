/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/torch/weights_file.h"

#include "libtensor/io/array/npz.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/torch/torch.h"

#include <cjson/cJSON.h>
#include <string.h>

enum { SHARDS_MAX = 1024 };

static const char wanted[] = "safetensors, .npz or a checkpoint of PyTorch";

static const char *const formats[] = {
    [LT_TORCH_NONE] = "safetensors", [LT_TORCH_ZIP] = "PyTorch (zip)", [LT_TORCH_STREAM] = "PyTorch (stream)",
    [LT_TORCH_TAR] = "PyTorch (tar)",
};

/* ---- one file ------------------------------------------------------------------------------------------ */

/* Before it is read as safetensors, whose first 8 bytes may be anything: what people have in the place of one. */
static lt_status check_kind(const char *path, const uint8_t *bytes, size_t n)
{
    const lt_kind kind = lt_kind_of(bytes, n);

    if (kind == LT_KIND_PICKLE)
        return lt_error(LT_EFORMAT, "%s: a plain pickle; read it in Python, and write its weights with torch.save or "
                        "as safetensors", path);
    return n ? lt_refuse_other(path, bytes, n, LT_KIND_SAFETENSORS, wanted) : lt_refuse(path, bytes, n, wanted);
}

static lt_status parse_safetensors(lt_arena *arena, const char *path, const uint8_t *bytes, size_t n,
                                   lt_weights_file *f)
{
    lt_safetensors s;
    lt_status st = check_kind(path, bytes, n);

    if (!st)
        st = lt_safetensors_parse(arena, path, bytes, n, &s);
    if (st)
        return st;
    f->entry = s.entry;
    f->n = s.n;
    f->refused = s.refused;
    f->n_refused = s.n_refused;
    f->within = lt_arena_array(arena, s.n, sizeof(*f->within));
    return f->within ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", path);
}

static lt_status parse_npz(lt_arena *arena, const char *path, const uint8_t *bytes, size_t n, lt_weights_file *f)
{
    lt_npz z;
    const lt_status st = lt_npz_parse(arena, path, bytes, n, &z);

    if (st)
        return st;
    f->format = "NumPy (npz)";
    f->entry = z.entry;
    f->n = z.n;
    f->refused = z.refused;
    f->n_refused = z.n_refused;
    f->within = lt_arena_array(arena, z.n, sizeof(*f->within));
    return f->within ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", path);
}

static lt_status parse_torch(lt_arena *arena, const char *path, const uint8_t *bytes, size_t n, lt_weights_file *f)
{
    lt_torch_file t;
    const lt_status st = lt_torch_parse(arena, path, bytes, n, &t);

    if (st)
        return st;
    f->entry = t.entry;
    f->within = t.within;
    f->n = t.n;
    f->refused = t.refused;
    f->n_refused = t.n_refused;
    return LT_OK;
}

static lt_status parse(lt_arena *arena, const char *path, const uint8_t *bytes, size_t n, lt_weights_file *f)
{
    const lt_torch_container container = lt_torch_sniff(bytes, n);

    if (lt_kind_of(bytes, n) == LT_KIND_NPZ)
        return parse_npz(arena, path, bytes, n, f);
    f->format = formats[container];
    return container ? parse_torch(arena, path, bytes, n, f) : parse_safetensors(arena, path, bytes, n, f);
}

/* ---- an index of several ------------------------------------------------------------------------------- */

typedef struct {
    const char *name[SHARDS_MAX];
    int n;
} shards;

/* The files that a map from arrays to files names, each once. */
static lt_status list_shards(const char *path, const cJSON *map, shards *out)
{
    const cJSON *item;

    cJSON_ArrayForEach(item, map) {
        const char *name = cJSON_GetStringValue(item);
        int i = out->n - 1;

        if (!name || !lt_path_is_inside(name))
            return lt_error(LT_EFORMAT, "%s: weight_map: \"%s\": want a file in its own folder, found \"%s\"", path,
                            item->string, name ? name : "no text");
        while (i >= 0 && strcmp(out->name[i], name) != 0)
            i--;
        if (i >= 0)
            continue;
        if (out->n == SHARDS_MAX)
            return lt_error(LT_EFORMAT, "%s: weight_map: more than %d files", path, SHARDS_MAX);
        out->name[out->n++] = name;
    }
    return out->n ? LT_OK : lt_error(LT_EFORMAT, "%s: weight_map: names no file", path);
}

static lt_status read_shard(lt_arena *arena, const char *index, const char *name, lt_weights_file *f)
{
    const char *folder = lt_path_folder(arena, index);
    const char *path = folder ? lt_path_join(arena, folder, name) : NULL;
    uint8_t *bytes;
    size_t n;
    lt_status st = path ? lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n)
                        : lt_error(LT_ENOMEM, "%s: no memory", index);

    if (st == LT_EIO)
        return lt_error_prefix(st, "%s: an index, whose files lie in its folder", index);
    return st ? st : parse(arena, path, bytes, n, f);
}

/* All that several files have, as if it were one's. */
static lt_status join(lt_arena *arena, const lt_weights_file *part, int n, lt_weights_file *out)
{
    size_t entries = 0, refused = 0;

    for (int i = 0; i < n; i++) {
        entries += part[i].n;
        refused += part[i].n_refused;
    }
    out->format = lt_arena_printf(arena, "%s in %d file%s", part[0].format, n, n > 1 ? "s" : "");
    out->entry = lt_arena_array(arena, entries, sizeof(*out->entry));
    out->within = lt_arena_array(arena, entries, sizeof(*out->within));
    out->refused = lt_arena_array(arena, refused, sizeof(*out->refused));
    if (!out->format || !out->entry || !out->within || !out->refused)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu arrays", out->path, entries);
    for (int i = 0; i < n; i++) {
        for (size_t k = 0; k < part[i].n; k++, out->n++) {
            out->entry[out->n] = part[i].entry[k];
            out->within[out->n] = part[i].within[k];
        }
        for (size_t k = 0; k < part[i].n_refused; k++)
            out->refused[out->n_refused++] = part[i].refused[k];
    }
    return LT_OK;
}

static lt_status read_shards(lt_arena *arena, const cJSON *map, lt_weights_file *out)
{
    shards list = { .n = 0 };
    lt_weights_file *part;
    lt_status st = list_shards(out->path, map, &list);

    if (st)
        return st;
    part = lt_arena_array(arena, (size_t)list.n, sizeof(*part));
    if (!part)
        return lt_error(LT_ENOMEM, "%s: no memory", out->path);
    for (int i = 0; !st && i < list.n; i++)
        st = read_shard(arena, out->path, list.name[i], &part[i]);
    return st ? st : join(arena, part, list.n, out);
}

static lt_status parse_index(lt_arena *arena, const uint8_t *bytes, size_t n, lt_weights_file *out)
{
    const cJSON *map;
    cJSON *root;
    lt_status st = lt_json_parse(out->path, (const char *)bytes, n, &root);

    if (st)
        return st;
    map = cJSON_GetObjectItemCaseSensitive(root, "weight_map");
    st = cJSON_IsObject(map) ? read_shards(arena, map, out) : lt_refuse(out->path, bytes, n, wanted);
    cJSON_Delete(root);
    return st;
}

lt_status lt_weights_read(lt_arena *arena, const char *path, lt_weights_file *out)
{
    lt_weights_file f = { .path = lt_arena_strdup(arena, path) };
    uint8_t *bytes;
    size_t n;
    lt_status st = f.path ? lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n)
                          : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = lt_kind_of(bytes, n) == LT_KIND_JSON ? parse_index(arena, bytes, n, &f) : parse(arena, path, bytes, n, &f);
    if (!st)
        *out = f;
    return st;
}
