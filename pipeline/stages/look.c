/* SPDX-License-Identifier: Apache-2.0 */
/* look: which hands there are and what each of them holds, as listed, as given, or as detected. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static void close_models(void *state)
{
    predict_models *m = state;

    lt_arena_free(m->arena);
    lt_release(m);
}

static lt_status open_models(const predict_options *o, void **state)
{
    predict_models *m = lt_alloc(sizeof(*m));

    if (!m)
        return lt_error(LT_ENOMEM, "no memory to predict with");
    *m = (predict_models){ .o = o, .arena = lt_arena_new() };
    m->of = m->arena ? lt_arena_array(m->arena, o->detector ? (size_t)o->detector->n : 0, sizeof(*m->of)) : NULL;
    if (!m->of) {
        close_models(m);
        return lt_error(LT_ENOMEM, "no memory to predict with");
    }
    *state = m;
    return LT_OK;
}

static lt_status run(void *state, predict_frame *f)
{
    const lt_status st = f->detected ? predict_views_detected(f, state)
                         : f->o->m ? predict_views_listed(f) : predict_views_new(f, 0);

    if (!st)
        predict_note_assumed(f);
    return st;
}

/* A box outside of the image */
static bool forgives(lt_status st)
{
    return st == LT_EINVAL;
}

const stage look_stage = {
    .name = "look", .needs = FRAME_SCENE, .gives = FRAME_VIEWS, .forgives = forgives,
    .open = open_models, .run = run, .close = close_models,
};
