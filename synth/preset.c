/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/preset.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"

lt_status synth_folders(const char *out, const char *const *within, size_t n)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", out);

    for (size_t i = 0; i < n && !st; i++) {
        const char *path = lt_path_join(arena, out, within[i]);

        st = path ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", out);
    }
    lt_arena_free(arena);
    return st;
}

lt_status synth_tell(const synth_options *o, const char *step, const char *counted, int64_t done, int64_t total)
{
    if (!o->progress || o->progress(o->progress_ctx, step, done, total))
        return LT_OK;
    return lt_error(LT_ESTOPPED, "%s: stopped after %lld of %lld %s; it is not complete", o->out, (long long)done,
                    (long long)total, counted);
}

lt_status synth_jpeg(const char *root, const char *within, const synth_frame *f, int quality, synth_file *out)
{
    const lt_image img = { f->width, f->height, 3, 8, &f->rgb[0][0] };
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? lt_path_join(arena, root, within) : NULL;
    lt_status st = path ? lt_jpeg_write(path, &img, quality) : lt_error(LT_ENOMEM, "%s: no memory", within);

    lt_arena_free(arena);
    return st ? st : synth_describe_file(root, within, out);
}

static lt_status check(const char *out, const synth_result *r)
{
    for (int i = 0; r->strict && i < r->n; i++)
        if (!synth_figure_within(&r->figure[i]))
            return lt_error(LT_ENUMERIC, "%s/stats.json: %s: found %.3f, wanted %.2f to %.2f", out, r->figure[i].name,
                            r->figure[i].value, r->figure[i].lo, r->figure[i].hi);
    return LT_OK;
}

lt_status synth_finish(synth_manifest *m, const synth_options *o, const lt_hand_model *hand, const synth_result *r)
{
    lt_status st = synth_figures_write(o->out, r->counted, r->count, r->figure, r->n);

    if (!st)
        st = synth_manifest_file(m, o->out, "stats.json");
    if (!st)
        st = check(o->out, r);
    return st ? st : synth_manifest_write(m, o, hand);
}
