/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/splats/trained.h"

#include "estimate/checkpoint/checkpoint.h"

#include <math.h>
#include <string.h>

void splats_trained_close(splats_trained *o)
{
    compiled_free(&o->drawing);
    lt_params_free(o->params);
}

lt_status splats_trained_load(lt_arena *arena, train_config *config, const char *checkpoint, splats_trained *o)
{
    lt_status st;

    *o = (splats_trained){ .run = { .arena = arena, .config = config, .m = &o->m }, .params = lt_params_new() };
    st = o->params ? train_config_model(config, NULL, o->params, &o->m)
                   : lt_error(LT_ENOMEM, "no memory for the model");
    return st ? st : checkpoint_load_model(checkpoint, &o->m);
}

lt_status splats_trained_open(lt_arena *arena, train_config *config, const char *checkpoint, const char *split,
                              splats_trained *o)
{
    lt_status st = splats_trained_load(arena, config, checkpoint, o);
    const splats_config *c;
    task_run *r = &o->run;
    recipe by;

    if (st)
        return st;
    c = &splats_of(&o->m)->config;
    st = splats_open_views(r, config, c->white);
    if (st)
        return st;
    for (int i = 0; i < r->set.n; i++)
        if (r->picture[i].width > c->width || r->picture[i].height > c->height)
            return lt_error(LT_EINVAL, "%s: is %d x %d, but the run draws up to %d x %d", r->set.view[i].image,
                            r->picture[i].width, r->picture[i].height, c->width, c->height);
    o->views = (split && strcmp(split, "train") == 0) || r->held_out.count == 0 ? &r->train : &r->held_out;
    by = splats_recipe(o->views, false);
    return compiled_new(&by, 1, false, &o->drawing);
}

void splats_trained_draw(const splats_trained *o, int view)
{
    splats_feed(&o->run, o->drawing.plan, &o->drawing.record, view, 3);
    lt_run(o->drawing.plan);
}

void splats_trained_picture(const splats_trained *o, int view, int64_t row, uint8_t *out)
{
    const splats_config *c = &splats_of(&o->m)->config;
    const transforms_picture *v = &o->run.picture[view];
    const int64_t W = c->width, plane = W * c->height;
    const lt_real *drawn = compiled_output(&o->drawing, "picture");

    for (int64_t y = 0; y < v->height; y++)
        for (int64_t i = 0; i < 3 * (int64_t)v->width; i++)
            out[y * row + i] = (uint8_t)lround(255 * fmin(1, fmax(0, (double)drawn[i % 3 * plane + y * W + i / 3])));
}
