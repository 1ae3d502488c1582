/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/weights_file.h"

#include "libtensor/io/file.h"
#include "libtensor/io/safetensors.h"
#include "libtensor/io/torch_file.h"

static const char *const formats[] = {
    [LT_TORCH_NONE] = "safetensors", [LT_TORCH_ZIP] = "PyTorch (zip)", [LT_TORCH_STREAM] = "PyTorch (stream)",
    [LT_TORCH_TAR] = "PyTorch (tar)",
};

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
    st = container ? lt_torch_parse(arena, path, bytes, n, &t) : lt_safetensors_parse(arena, path, bytes, n, &s);
    if (st)
        return st;
    f.format = formats[container];
    f.n = container ? t.n : s.n;
    f.entry = container ? t.entry : s.entry;
    *out = f;
    return LT_OK;
}
