/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/world/seen.h"

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mat3.h"
#include "vision/silhouette.h"

#include <math.h>
#include <string.h>

static bool belongs(const synth_world *w, int part, int thing)
{
    return part == thing || (part >= 0 && w->thing[part].owner == thing);
}

synth_pixels synth_pixels_of(const uint8_t *mask, int width, int height, int64_t *n)
{
    synth_pixels b = { width, height, 0, 0 };

    *n = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            if (mask[(size_t)y * (size_t)width + (size_t)x]) {
                b.x0 = x < b.x0 ? x : b.x0;
                b.x1 = x >= b.x1 ? x + 1 : b.x1;
                b.y0 = y < b.y0 ? y : b.y0;
                b.y1 = y + 1;
                ++*n;
            }
    return *n ? b : (synth_pixels){ 0, 0, 0, 0 };
}

static bool at_border(const synth_pixels *b, const synth_frame *f)
{
    return b->x0 == 0 || b->y0 == 0 || b->x1 == f->width || b->y1 == f->height;
}

/* From the instance's frame to the camera's. */
static void to_camera(const synth_instance *in, const synth_camera *c, double R[9], double t[3])
{
    lt_mat3_mul(c->R_cam_world, in->R_world_obj, R);
    lt_rigid_apply(c->R_cam_world, c->t_cam_world, in->t_world_obj, t);
}

/* Whether some vertex before the camera lies more than a pixel past the border. */
static bool reaches_out(const synth_instance *in, const synth_camera *c)
{
    double R[9], t[3];

    to_camera(in, c, R, t);
    for (int v = 0; v < in->mesh->n_vertices; v++) {
        const float *at = in->mesh->vertex[v];
        const double x[3] = { at[0], at[1], at[2] };
        double p[3], u, s;
        lt_rigid_apply(R, t, x, p);
        u = c->fx * p[0] / p[2] + c->cx;
        s = c->fy * p[1] / p[2] + c->cy;
        if (p[2] < 0.01 || u < -1.5 || s < -1.5 || u > c->width + 0.5 || s > c->height + 0.5)
            return true;
    }
    return false;
}

lt_status synth_world_cover(lt_arena *arena, const synth_world *w, const synth_camera *c, int thing, uint8_t *mask,
                            bool *cut)
{
    const lt_camera camera = { c->fx, c->fy, c->cx, c->cy };

    for (int i = 0; i < w->n_instances; i++) {
        const synth_instance *in = &w->instance[i];
        double R[9], t[3];
        float Rf[9], tf[3];
        lt_status st;

        if (!belongs(w, in->label - 1, thing))
            continue;
        to_camera(in, c, R, t);
        for (int k = 0; k < 9; k++)
            Rf[k] = (float)R[k];
        for (int k = 0; k < 3; k++)
            tf[k] = (float)t[k];
        st = silhouette_draw(in->mesh, Rf, tf, &camera, mask, c->width, c->height, arena);
        if (st)
            return st;
        *cut = *cut || reaches_out(in, c);
    }
    return LT_OK;
}

lt_status synth_world_look(lt_arena *arena, const synth_world *w, const synth_camera *camera, const synth_frame *frame,
                           bool (*wanted)(const synth_thing *thing), synth_seen **out)
{
    const size_t n = (size_t)frame->width * (size_t)frame->height;
    synth_seen *seen = lt_arena_array(arena, (size_t)w->n_things, sizeof(*seen));
    uint8_t *whole = lt_arena_alloc(arena, n);
    lt_status st = seen && whole ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for masks");

    for (int i = 0; !st && i < w->n_things; i++) {
        uint8_t *mask;
        synth_seen *s = &seen[i];

        if (wanted && !wanted(&w->thing[i]))
            continue;
        mask = lt_arena_alloc(arena, n);
        if (!mask)
            return lt_error(LT_ENOMEM, "synth: no memory for masks");
        for (size_t k = 0; k < n; k++)
            mask[k] = belongs(w, frame->label[k] - 1, i);
        memcpy(whole, mask, n);
        st = synth_world_cover(arena, w, camera, i, whole, &s->cut);
        s->mask = mask;
        s->box = synth_pixels_of(mask, frame->width, frame->height, &s->visible);
        s->whole_box = synth_pixels_of(whole, frame->width, frame->height, &s->whole);
        s->cut = s->cut && at_border(&s->box, frame);
    }
    *out = seen;
    return st;
}
