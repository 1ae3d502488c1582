/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PyTorch's checkpoints: telling the containers apart, and what they have in common.
 */
#include "libtensor/io/torch/torch.h"

#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/torch/internal.h"

lt_torch_container lt_torch_sniff(const uint8_t *bytes, size_t n)
{
    const lt_kind kind = lt_kind_of(bytes, n);

    if (lt_kind_is_zip(kind))
        return LT_TORCH_ZIP;
    if (kind == LT_KIND_TORCH_STREAM)
        return LT_TORCH_STREAM;
    return kind == LT_KIND_TAR ? LT_TORCH_TAR : LT_TORCH_NONE;
}

static lt_status read_container(lt_torch *t, lt_torch_container container, const lt_pvalue **value)
{
    switch (container) {
    case LT_TORCH_ZIP:    return lt_torch_zip(t, value);
    case LT_TORCH_STREAM: return lt_torch_stream(t, value);
    case LT_TORCH_TAR:    return lt_torch_tar(t, value);
    default:              return lt_refuse(t->path, t->bytes, t->n, "a checkpoint of PyTorch");
    }
}

lt_status lt_torch_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_torch_file *out)
{
    lt_torch t = { .arena = arena, .path = lt_arena_strdup(arena, name), .bytes = bytes, .n = n };
    lt_torch_file f = { .path = t.path, .container = lt_torch_sniff(bytes, n) };
    lt_status st;

    if (!t.path)
        return lt_error(LT_ENOMEM, "%s: no memory", name);
    st = read_container(&t, f.container, &f.value);
    if (!st)
        st = lt_torch_fill(&t);
    if (!st)
        st = lt_torch_names(&t, f.value, &f);
    if (!st)
        *out = f;
    return st;
}

lt_status lt_torch_read(lt_arena *arena, const char *path, lt_torch_file *out)
{
    uint8_t *bytes;
    size_t n;
    const lt_status st = lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n);

    return st ? st : lt_torch_parse(arena, path, bytes, n, out);
}
