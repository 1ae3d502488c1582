/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/torch/weights_file.h"

#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/torch/torch.h"

static const char *const formats[] = {
    [LT_TORCH_NONE] = "safetensors", [LT_TORCH_ZIP] = "PyTorch (zip)", [LT_TORCH_STREAM] = "PyTorch (stream)",
    [LT_TORCH_TAR] = "PyTorch (tar)",
};

/* Before it is read as safetensors, whose first 8 bytes may be anything: what people have in the place of one. */
static lt_status check_kind(const char *path, const uint8_t *bytes, size_t n)
{
    const lt_kind kind = lt_kind_of(bytes, n);

    if (kind == LT_KIND_PICKLE)
        return lt_error(LT_EFORMAT, "%s: a plain pickle; read it in Python, and write its weights with torch.save or "
                        "as safetensors", path);
    if (kind && kind != LT_KIND_SAFETENSORS)
        return lt_refuse(path, bytes, n, "safetensors or a checkpoint of PyTorch");
    return LT_OK;
}

lt_status lt_weights_read(lt_arena *arena, const char *path, lt_weights_file *out)
{
    lt_weights_file f = { .path = lt_arena_strdup(arena, path) };
    lt_torch_container container;
    lt_safetensors s;
    lt_torch_file t;
    uint8_t *bytes;
    size_t n;
    lt_status st = f.path ? lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n)
                          : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (st)
        return st;
    container = lt_torch_sniff(bytes, n);
    if (!container)
        st = check_kind(path, bytes, n);
    if (st)
        return st;
    st = container ? lt_torch_parse(arena, path, bytes, n, &t) : lt_safetensors_parse(arena, path, bytes, n, &s);
    if (st)
        return st;
    f.format = formats[container];
    f.n = container ? t.n : s.n;
    f.entry = container ? t.entry : s.entry;
    *out = f;
    return LT_OK;
}
