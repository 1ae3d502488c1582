/* SPDX-License-Identifier: Apache-2.0 */
/* Both hands, out of a larger map: a left one is a right one in the mirror. */
#include "models/body/osx_parts.h"

osx_hands osx_hands_new(lt_params *set, osx_sizes size)
{
    osx_hands m;

    for (int i = 0; i < OSX_HAND_UPS; i++)
        m.up[i] = osx_up_new(set, "hand_roi_net", i, size.width >> i, size.width >> (i + 1));
    m.widen = lt_conv_layer_new(set, "hand_roi_net.conv.0", size.width >> OSX_HAND_UPS, size.width, 1, true, NULL);
    m.position = osx_position_new(set, "hand_position_net", size.width, OSX_HAND_JOINTS, OSX_HAND_CELLS);
    m.conv = lt_conv_layer_new(set, "hand_regressor.hand_conv.0", size.width, size.fc, 1, true, NULL);
    m.bn = lt_batch_norm_layer_new(set, "hand_regressor.hand_conv.1", size.fc);
    m.pose = lt_linear_layer_new(set, "hand_regressor.hand_pose_out.0", OSX_HAND_JOINTS * (size.fc + 3),
                                 OSX_HAND_ROTATIONS * 6, true);
    return m;
}

/* Columns from right to left */
static lt_tensor *flip(lt_tensor *map)
{
    enum { N = OSX_HAND_CELLS };
    lt_real reverse[N * N] = { 0 };

    for (int i = 0; i < N; i++)
        reverse[i * N + N - 1 - i] = 1;
    return lt_linear(map, lt_constant(map->graph, LT_F32, LT_SHAPE(N, N), reverse), NULL);
}

/* (2 B, joints, C + 3): at each place what the map has there, and the place */
static lt_tensor *joint_features(lt_tensor *map, lt_tensor *place)
{
    const int64_t n = lt_dim(map, 0);
    lt_tensor *at = osx_sample(map, lt_slice(place, 2, 0, 2));

    at = lt_concat((lt_tensor *[]){ at, lt_detach(place) }, 2, 2);
    return lt_reshape(at, LT_SHAPE(n, lt_dim(at, 1) * lt_dim(at, 2)));
}

/* A place seen in the mirror */
static lt_tensor *mirror_place(lt_tensor *place)
{
    const lt_real sign[3] = { -1, 1, 1 }, shift[3] = { OSX_HAND_CELLS - 1, 0, 0 };
    lt_graph *g = place->graph;

    place = lt_mul(place, lt_constant(g, LT_F32, LT_SHAPE(3), sign));
    return lt_add(place, lt_constant(g, LT_F32, LT_SHAPE(3), shift));
}

/* M R M with M = diag(-1, 1, 1): of the axis, y and z change sign */
static lt_tensor *mirror_rotation(lt_tensor *R)
{
    const lt_real sign[9] = { 1, -1, -1, -1, 1, 1, -1, 1, 1 };

    return lt_mul(R, lt_constant(R->graph, LT_F32, LT_SHAPE(3, 3), sign));
}

/* What belongs to hand h: (2 B, n, ...) -> (B, n, ...) */
static lt_tensor *of_hand(lt_tensor *x, int h)
{
    const int64_t n = lt_dim(x, 1);
    lt_shape shape = x->shape;

    shape.dim[0] /= 2;
    shape.dim[1] *= 2;
    return lt_slice(lt_reshape(x, shape), 1, h * n, n);
}

osx_hands_out osx_hands_forward(const osx_hands *m, lt_tensor *map, lt_tensor *const box[2])
{
    const int64_t B = lt_dim(map, 0);
    const double scale = (OSX_COLUMNS << OSX_HAND_UPS) / (double)OSX_WIDTH;
    lt_tensor *hand[2], *both, *place, *rotation, *x = map;

    for (int i = 0; i < OSX_HAND_UPS; i++)
        x = osx_up_forward(&m->up[i], x);
    for (int i = 0; i < 2; i++)
        hand[i] = lt_roi_align(x, box[i], OSX_HAND_CELLS, OSX_HAND_CELLS, scale);
    both = lt_concat((lt_tensor *[]){ flip(hand[0]), hand[1] }, 2, 1);
    both = lt_reshape(both, LT_SHAPE(2 * B, lt_dim(x, 1), OSX_HAND_CELLS, OSX_HAND_CELLS));     /* left, right, .. */
    both = lt_conv_layer_forward(&m->widen, both);
    place = osx_position_forward(&m->position, both).place;
    both = lt_relu(lt_batch_norm_layer_forward(&m->bn, lt_conv_layer_forward(&m->conv, both)));
    rotation = osx_rotations(lt_linear_layer_forward(&m->pose, joint_features(both, place)));
    return (osx_hands_out){
        .place = { mirror_place(of_hand(place, 0)), of_hand(place, 1) },
        .rotation = { mirror_rotation(of_hand(rotation, 0)), of_hand(rotation, 1) },
    };
}

lt_tensor *osx_hand_in_picture(lt_tensor *place, lt_tensor *box)
{
    const double cell = OSX_WIDTH / (double)OSX_COLUMNS;
    const int64_t B = lt_dim(place, 0);
    lt_tensor *corner = lt_reshape(lt_slice(box, 1, 1, 2), LT_SHAPE(B, 1, 2));
    lt_tensor *side = lt_reshape(lt_sub(lt_slice(box, 1, 3, 1), lt_slice(box, 1, 1, 1)), LT_SHAPE(B, 1, 1));
    lt_tensor *in_box = lt_mul(lt_slice(place, 2, 0, 2), lt_scale(side, 1 / (cell * OSX_HAND_CELLS)));

    return lt_concat((lt_tensor *[]){ lt_add(lt_scale(corner, 1 / cell), in_box), lt_slice(place, 2, 2, 1) }, 2, 2);
}
