/* SPDX-License-Identifier: Apache-2.0 */
/* Where hands and face are: centres as the mean places of maps, sizes from what the map has there. */
#include "models/body/osx_parts.h"

static const char *const part[OSX_BOXES] = { "lhand", "rhand", "face" };

osx_up osx_up_new(lt_params *set, const char *prefix, int number, int in, int out)
{
    const char *conv = lt_name(set, "%s.deconv.%d", prefix, 3 * number);        /* a norm and a ReLU behind each */

    return (osx_up){
        .weight = lt_params_add(set, conv, "weight", LT_WEIGHT, LT_SHAPE(in, out, 4, 4)),
        .bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.deconv.%d", prefix, 3 * number + 1), out),
    };
}

lt_tensor *osx_up_forward(const osx_up *m, lt_tensor *x)
{
    x = lt_conv_transpose2d(x, lt_use(x->graph, m->weight), NULL, 2, 1);
    return lt_relu(lt_batch_norm_layer_forward(&m->bn, x));
}

osx_box_net osx_box_net_new(lt_params *set, const char *prefix, osx_sizes size)
{
    osx_box_net m;

    for (int i = 0; i < OSX_BOX_UPS; i++)
        m.up[i] = osx_up_new(set, prefix, i, i ? size.box : size.width + OSX_BODY_JOINTS * OSX_DEPTHS, size.box);
    m.centre = lt_conv_layer_new(set, lt_name(set, "%s.bbox_center.0", prefix), size.box, OSX_BOXES, 1, true, NULL);
    for (int i = 0; i < OSX_BOXES; i++)
        for (int k = 0; k < 2; k++)
            m.size[i][k] = lt_linear_layer_new(set, lt_name(set, "%s.%s_size.%d", prefix, part[i], 2 * k), size.box,
                                               k ? 2 : size.box, true);
    return m;
}

/* Expected column and row of each map: (B, n, H, W) -> (B, n, 2) */
static lt_tensor *mean_places(lt_tensor *map)
{
    const int64_t B = lt_dim(map, 0), n = lt_dim(map, 1), H = lt_dim(map, 2), W = lt_dim(map, 3);
    const lt_real scale[2] = { (lt_real)W, (lt_real)H }, shift[2] = { -0.5, -0.5 };
    lt_tensor *heat = lt_softmax(lt_reshape(map, LT_SHAPE(B, n, H * W)));
    lt_tensor *place = lt_soft_argmax2d(lt_reshape(heat, LT_SHAPE(B, n, H, W)));

    place = lt_mul(place, lt_constant(map->graph, LT_F32, LT_SHAPE(2), scale));
    return lt_add(place, lt_constant(map->graph, LT_F32, LT_SHAPE(2), shift));
}

/* The sizes, (B, OSX_BOXES, 2), from what a map has at the centres */
static lt_tensor *sizes_at(const osx_box_net *m, lt_tensor *map, lt_tensor *centre)
{
    const int64_t B = lt_dim(map, 0), C = lt_dim(map, 1);
    lt_tensor *at = osx_sample(map, centre), *size[OSX_BOXES];

    for (int i = 0; i < OSX_BOXES; i++) {
        lt_tensor *x = lt_reshape(lt_slice(at, 1, i, 1), LT_SHAPE(B, C));

        x = lt_relu(lt_linear_layer_forward(&m->size[i][0], x));
        size[i] = lt_reshape(lt_linear_layer_forward(&m->size[i][1], x), LT_SHAPE(B, 1, 2));
    }
    return lt_concat(size, OSX_BOXES, 1);
}

osx_boxes osx_box_net_forward(const osx_box_net *m, lt_tensor *map, lt_tensor *heat)
{
    const int64_t B = lt_dim(map, 0);
    lt_tensor *x, *centre;

    heat = lt_reshape(lt_detach(heat), LT_SHAPE(B, OSX_BODY_JOINTS * OSX_DEPTHS, OSX_ROWS, OSX_COLUMNS));
    x = lt_concat((lt_tensor *[]){ map, heat }, 2, 1);
    for (int i = 0; i < OSX_BOX_UPS; i++)
        x = osx_up_forward(&m->up[i], x);
    centre = mean_places(lt_conv_layer_forward(&m->centre, x));
    return (osx_boxes){ .centre = lt_scale(centre, 1.0 / (1 << OSX_BOX_UPS)), .size = sizes_at(m, x, centre) };
}

/* The larger of both numbers of (B, 2), in both places */
static lt_tensor *larger(lt_tensor *x)
{
    lt_tensor *w = lt_slice(x, 1, 0, 1), *h = lt_slice(x, 1, 1, 1), *most = lt_add(w, lt_relu(lt_sub(h, w)));

    return lt_concat((lt_tensor *[]){ most, most }, 2, 1);
}

lt_tensor *osx_box_pixels(const osx_boxes *b, int i, double times)
{
    const int64_t B = lt_dim(b->centre, 0);
    const double pixels = OSX_WIDTH / (double)OSX_COLUMNS;
    lt_tensor *centre = lt_reshape(lt_slice(lt_detach(b->centre), 1, i, 1), LT_SHAPE(B, 2));
    lt_tensor *size = lt_reshape(lt_slice(lt_detach(b->size), 1, i, 1), LT_SHAPE(B, 2));
    lt_tensor *half = lt_scale(larger(size), times * pixels / 2);

    centre = lt_scale(centre, pixels);
    return lt_concat((lt_tensor *[]){ lt_sample_index(centre), lt_sub(centre, half), lt_add(centre, half) }, 3, 1);
}
