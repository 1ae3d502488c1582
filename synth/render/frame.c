/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/render/frame.h"

#include "synth/render/render.h"

static bool frame_alloc(synth_frame *f)
{
    const size_t n = (size_t)f->width * (size_t)f->height;
    struct synth_scratch *s = f->scratch = lt_alloc(sizeof(*s));

    if (!s)
        return false;
    for (int i = 0; i < SYNTH_MAX_LIGHTS; i++)
        if (!shadow_init(&s->shadow[i]))
            return false;
    s->open = lt_alloc(n * sizeof(float));
    s->half[0] = lt_alloc(n * sizeof(float));
    s->half[1] = lt_alloc(n * sizeof(float));
    f->work[0] = lt_alloc(n * sizeof(*f->work[0]));
    f->work[1] = lt_alloc(n * sizeof(*f->work[1]));
    f->radiance = lt_alloc(n * sizeof(*f->radiance));
    f->rgb = lt_alloc(n * sizeof(*f->rgb));
    f->depth = lt_alloc(n * sizeof(float));
    f->hand_depth = lt_alloc(n * sizeof(float));
    f->object_depth = lt_alloc(n * sizeof(float));
    f->label = lt_alloc(n);
    f->moving = lt_alloc(n);
    f->hand_mask = lt_alloc(n);
    f->object_mask = lt_alloc(n);
    return s->open && s->half[0] && s->half[1] && f->work[0] && f->work[1] && f->radiance && f->rgb && f->depth &&
           f->hand_depth && f->object_depth && f->label && f->moving && f->hand_mask && f->object_mask;
}

synth_frame *synth_frame_new(int width, int height)
{
    synth_frame *f;

    if (width < 1 || height < 1 || width > SYNTH_MAX_SIDE || height > SYNTH_MAX_SIDE)
        return NULL;
    f = lt_alloc(sizeof(*f));
    if (!f)
        return NULL;
    f->width = width;
    f->height = height;
    if (frame_alloc(f))
        return f;
    synth_frame_free(f);
    return NULL;
}

static void scratch_free(struct synth_scratch *s)
{
    if (!s)
        return;
    raster_list_fini(&s->list);
    raster_list_fini(&s->shadow_list);
    for (int i = 0; i < SYNTH_MAX_LIGHTS; i++)
        shadow_fini(&s->shadow[i]);
    shade_fini(&s->shade);
    lt_release(s->open);
    lt_release(s->half[0]);
    lt_release(s->half[1]);
    lt_release(s);
}

void synth_frame_free(synth_frame *f)
{
    if (!f)
        return;
    scratch_free(f->scratch);
    lt_release(f->radiance);
    lt_release(f->work[0]);
    lt_release(f->work[1]);
    lt_release(f->rgb);
    lt_release(f->depth);
    lt_release(f->hand_depth);
    lt_release(f->object_depth);
    lt_release(f->label);
    lt_release(f->moving);
    lt_release(f->hand_mask);
    lt_release(f->object_mask);
    lt_release(f);
}
