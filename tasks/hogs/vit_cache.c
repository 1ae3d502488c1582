/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/vit_cache.h"

#include <string.h>

static int64_t feature_count(const hogs *m)
{
    return m->sizes.vpm.vit;
}

static int64_t patches_count(const hogs *m)
{
    return (int64_t)m->sizes.map * m->sizes.map * m->sizes.vpm.vit;
}

size_t vit_cache_bytes(const hogs *m)
{
    return (size_t)(feature_count(m) + patches_count(m)) * sizeof(lt_real);
}

lt_status vit_cache_new(const hogs *m, int64_t frames, size_t bytes, vit_cache *out)
{
    *out = (vit_cache){ .m = m, .frames = frames, .room = (int64_t)(bytes / vit_cache_bytes(m)),
                        .kept = lt_alloc((size_t)frames * sizeof(*out->kept)) };
    return out->kept ? LT_OK
                     : lt_error(LT_ENOMEM, "no memory to keep what is seen of %lld frames", (long long)frames);
}

void vit_cache_free(vit_cache *c)
{
    for (int64_t i = 0; i < c->frames && c->kept; i++)
        lt_release(c->kept[i]);
    lt_release(c->kept);
    lt_plan_free(c->plan);
    lt_graph_free(c->g);
    *c = (vit_cache){ .m = NULL };
}

/* Not packed: a plan that packs does so again whenever the model's other weights have moved. */
lt_status vit_cache_begin(vit_cache *c)
{
    const int64_t S = c->m->sizes.crop, shape[] = { 1, 3, S, S };

    if (c->plan)
        return LT_OK;
    c->g = lt_graph_new();
    if (!c->g)
        return lt_last_status();
    c->image = lt_input(c->g, "image", LT_F32, 4, shape);
    c->seen = hogs_see(c->m, c->image);
    lt_output(c->seen.feature, "feature");
    lt_output(c->seen.patches, "patches");
    c->plan = lt_compile(c->g, &(lt_compile_opts){ .no_fusion = true });
    return c->plan ? LT_OK : lt_last_status();
}

static void look(vit_cache *c, const float *image, lt_real *feature, lt_real *patches)
{
    lt_real *x = lt_plan_data(c->plan, c->image);

    for (int64_t i = 0; i < lt_numel(c->image); i++)
        x[i] = (lt_real)image[i];
    lt_run(c->plan);
    memcpy(feature, lt_plan_data(c->plan, c->seen.feature), (size_t)feature_count(c->m) * sizeof(*feature));
    memcpy(patches, lt_plan_data(c->plan, c->seen.patches), (size_t)patches_count(c->m) * sizeof(*patches));
}

/* Without memory it is looked at again the next time. */
static void keep(vit_cache *c, int64_t frame, const lt_real *feature, const lt_real *patches)
{
    lt_real *x = c->room > 0 ? lt_alloc(vit_cache_bytes(c->m)) : NULL;

    if (!x)
        return;
    memcpy(x, feature, (size_t)feature_count(c->m) * sizeof(*x));
    memcpy(x + feature_count(c->m), patches, (size_t)patches_count(c->m) * sizeof(*x));
    c->kept[frame] = x;
    c->room--;
}

void vit_cache_look(vit_cache *c, int64_t frame, const float *image, lt_real *feature, lt_real *patches)
{
    const lt_real *x = c->kept[frame];

    if (!x) {
        look(c, image, feature, patches);
        keep(c, frame, feature, patches);
        return;
    }
    memcpy(feature, x, (size_t)feature_count(c->m) * sizeof(*x));
    memcpy(patches, x + feature_count(c->m), (size_t)patches_count(c->m) * sizeof(*x));
}
