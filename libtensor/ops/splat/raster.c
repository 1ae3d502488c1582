/* SPDX-License-Identifier: Apache-2.0 */
/* splat_raster: Gaussians as images.             [Zwicker et al. 2001; Kerbl et al. 2023, "3D Gaussian splatting"]
 *   centre (N, 3)   axes (N, 3, 3)   opacity (N)   colour (N, 3)   camera (4)   offset (N, 2)   first ()
 *   ->   image (C, H, W)   radius (N)   instances ()
 * With alpha_i a Gaussian's share of a pixel and T the light that those before it leave, near to far:
 *   w_i = alpha_i T,   T *= 1 - alpha_i,   colour = sum of w_i c_i + T background,   opacity = sum of w_i
 *
 * Gaussians go to the screen, are sorted and dealt to tiles (libtensor/kernels/splat), and each tile is drawn by one
 * task. Backward follows each tile near to far again, writes what an instance gives to a place of its own, and adds up
 * those of each Gaussian in order: the same bits for any number of threads. Lists that are too short for all instances
 * are filled several times, with nearer Gaussians first, and tiles go on from where they were: the same bits again.
 */
#include "libtensor/ops/splat/raster.h"

enum { MOST_PIXELS = 16384 };

static lt_status check_size(lt_call *c, const lt_splat_opts *o)
{
    if (o->width < 1 || o->height < 1 || o->width > MOST_PIXELS || o->height > MOST_PIXELS)
        return lt_fail(c, "the image is %lld x %lld, want 1 to %d either way", (long long)o->width,
                       (long long)o->height, MOST_PIXELS);
    if (!(o->near_z > 0) || isinf(o->near_z))
        return lt_fail(c, "near_z is %g, want a distance above 0", o->near_z);
    return LT_OK;
}

static lt_status check_first(lt_call *c)
{
    const lt_tensor *first = c->in[RASTER_FIRST];
    const raster_attr *a = c->attr;
    char text[LT_SHAPE_TEXT];

    if (a->o.sets && !first)
        return lt_fail(c, "images of two sets want the number of Gaussians in the first one");
    if (first && (first->dtype != LT_I32 || lt_numel(first) != 1))
        return lt_fail(c, "the size of the first set is %s%s, want one integer", lt_shape_text(&first->shape, text),
                       first->dtype == LT_I32 ? "" : " and no LT_I32");
    return LT_OK;
}

static lt_status infer(lt_call *c)
{
    const raster_attr *a = c->attr;
    int64_t N;

    if (lt_want_rank(c, RASTER_CENTRE, "centre", 2))
        return LT_ESHAPE;
    N = lt_dim(c->in[RASTER_CENTRE], 0);
    if (lt_want_shape(c, RASTER_CENTRE, "centre", LT_SHAPE(N, 3))
        || lt_want_shape(c, RASTER_AXES, "axes", LT_SHAPE(N, 3, 3))
        || lt_want_shape(c, RASTER_OPACITY, "opacity", LT_SHAPE(N))
        || lt_want_shape(c, RASTER_COLOUR, "colour", LT_SHAPE(N, 3))
        || lt_want_shape(c, RASTER_CAMERA, "camera", LT_SHAPE(4))
        || (c->in[RASTER_OFFSET] && lt_want_shape(c, RASTER_OFFSET, "offset", LT_SHAPE(N, 2)))
        || check_first(c) || check_size(c, &a->o))
        return LT_ESHAPE;
    c->outs[RASTER_IMAGE]->shape = LT_SHAPE(raster_channels_of(&a->o).n, a->o.height, a->o.width);
    c->outs[RASTER_RADIUS]->shape = LT_SHAPE(N);
    c->outs[RASTER_INSTANCES]->shape = (lt_shape){ 0 };
    return LT_OK;
}

static void plan(lt_call *c)
{
    if (c->train) {
        c->saved_bytes[0] = raster_frame_bytes(c);
        c->work_bytes = raster_grad_bytes(c);
    } else {
        c->work_bytes = raster_frame_bytes(c);
    }
}

/* ---- what both directions look at ----------------------------------------------------------------------- */

raster_channels raster_channels_of(const lt_splat_opts *o)
{
    raster_channels at = { .colour = 0, .set_colour = -1, .opacity = -1, .set_opacity = -1, .depth = -1, .n = 3 };

    if (o->sets)
        at.set_colour = 3, at.opacity = 9, at.set_opacity = 10, at.n = 12;
    else if (o->opacity)
        at.opacity = at.n++;
    if (o->depth)
        at.depth = at.n++;
    return at;
}

lt_splat_view raster_view(const lt_call *c)
{
    const lt_splat_opts *o = raster_opts(c);
    const lt_real *k = c->in[RASTER_CAMERA]->data;

    return (lt_splat_view){
        .fx = k[0], .fy = k[1], .cx = k[2], .cy = k[3], .near_z = (lt_real)o->near_z, .width = o->width,
        .height = o->height,
    };
}

lt_splat_cloud raster_cloud(const lt_call *c)
{
    return (lt_splat_cloud){
        .n = lt_dim(c->in[RASTER_CENTRE], 0), .centre = c->in[RASTER_CENTRE]->data, .axes = c->in[RASTER_AXES]->data,
        .opacity = c->in[RASTER_OPACITY]->data, .colour = c->in[RASTER_COLOUR]->data,
        .offset = c->in[RASTER_OFFSET] ? c->in[RASTER_OFFSET]->data : NULL,
    };
}

/* Of any integer that `first` may be */
static uint32_t size_of_first(const lt_call *c)
{
    const lt_tensor *first = c->in[RASTER_FIRST];

    return first ? (uint32_t)lt_max_i64(0, *(const int32_t *)first->data) : 0;
}

lt_splat_tile raster_tile(const lt_call *c, const raster_frame *f, int64_t tile)
{
    const lt_splat_opts *o = raster_opts(c);
    const lt_splat_lists *l = &f->lists;

    return (lt_splat_tile){
        .seen = f->seen, .entry = l->entry + l->start[tile], .n = l->start[tile + 1] - l->start[tile],
        .x0 = (lt_real)(tile % l->across * LT_SPLAT_TILE), .y0 = (lt_real)(tile / l->across * LT_SPLAT_TILE),
        .first = size_of_first(c), .sets = o->sets, .depth = o->depth,
    };
}

void raster_start_light(lt_real light[LT_SPLAT_CELLS], const lt_splat_opts *o, const lt_splat_tile *t)
{
    const int64_t columns = o->width - (int64_t)t->x0, rows = o->height - (int64_t)t->y0;

    for (int i = 0; i < LT_SPLAT_CELLS; i++)
        light[i] = i % LT_SPLAT_TILE < columns && i / LT_SPLAT_TILE < rows ? 1 : -1;
}

static const lt_op splat_raster_op = {
    .name = "splat_raster", .n_out = 3, .keeps = (1u << RASTER_IN) - 1,
    .optional = LT_OPTIONAL_IN(RASTER_OFFSET) | LT_OPTIONAL_IN(RASTER_FIRST), .any_type = LT_ANY_TYPE_IN(RASTER_FIRST),
    .infer = infer, .plan = plan, .forward = raster_forward, .backward = raster_backward,
};

lt_tensor *(lt_splat_raster)(const lt_splat_in *in, const lt_splat_opts *opts)
{
    const raster_attr a = { *opts };

    return lt_apply(&splat_raster_op, &a, sizeof(a),
                    (lt_tensor *[]){ in->centre, in->axes, in->opacity, in->colour, in->camera, in->offset, in->first },
                    RASTER_IN);
}
