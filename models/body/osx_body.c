/* SPDX-License-Identifier: Apache-2.0 */
/* Where the joints are, and from there and the tokens how the body is turned and what shape it has. */
#include "models/body/osx_parts.h"

#include "libtensor/nn/init.h"

#include <math.h>

static const double FOCAL = 5000, CAMERA_SIZE = 2.5;        /* of the virtual camera: pixels, metres */

osx_position osx_position_new(lt_params *set, const char *prefix, int width, int joints, int depth)
{
    return (osx_position){
        .conv = lt_conv_layer_new(set, lt_name(set, "%s.conv.0", prefix), width, joints * depth, 1, true, NULL),
        .joints = joints, .depth = depth,
    };
}

/* Column, row and depth of every cell: (3, depth rows columns), as the weights of a linear layer */
static lt_tensor *cell_places(lt_graph *g, int64_t depth, int64_t rows, int64_t columns)
{
    const int64_t n = depth * rows * columns;
    lt_tensor *out;
    lt_real *x = lt_constant_reals(g, LT_SHAPE(3, n), &out);

    for (int64_t i = 0; x && i < n; i++) {
        x[i] = (lt_real)(i % columns);
        x[n + i] = (lt_real)(i / columns % rows);
        x[2 * n + i] = (lt_real)(i / columns / rows);
    }
    return out;
}

osx_places osx_position_forward(const osx_position *m, lt_tensor *map)
{
    const int64_t B = lt_dim(map, 0), H = lt_dim(map, 2), W = lt_dim(map, 3);
    lt_tensor *logits = lt_reshape(lt_conv_layer_forward(&m->conv, map), LT_SHAPE(B, m->joints, m->depth * H * W));
    lt_tensor *heat = lt_softmax(logits);

    return (osx_places){
        .logits = logits, .heat = heat, .place = lt_linear(heat, cell_places(map->graph, m->depth, H, W), NULL),
    };
}

lt_tensor *osx_sample(lt_tensor *map, lt_tensor *place)
{
    const int64_t B = lt_dim(map, 0), C = lt_dim(map, 1), N = lt_dim(place, 1);
    const lt_real w = 2 / (lt_real)lt_dim(map, 3), h = 2 / (lt_real)lt_dim(map, 2);
    const lt_real scale[2] = { w, h }, shift[2] = { w / 2 - 1, h / 2 - 1 };     /* to -1 and 1 on the outer edges */
    lt_graph *g = map->graph;
    lt_tensor *grid = lt_mul(lt_detach(place), lt_constant(g, LT_F32, LT_SHAPE(2), scale));

    grid = lt_add(grid, lt_constant(g, LT_F32, LT_SHAPE(2), shift));
    map = lt_grid_sample(map, lt_reshape(grid, LT_SHAPE(B, 1, N, 2)));          /* (B, C, 1, N) */
    return lt_permute(lt_reshape(map, LT_SHAPE(B, C, N)), (int[]){ 0, 2, 1 });
}

lt_tensor *osx_rotations(lt_tensor *six)
{
    const int64_t B = lt_dim(six, 0), n = lt_dim(six, 1) / 6;
    lt_tensor *columns = lt_permute(lt_reshape(six, LT_SHAPE(B, n, 3, 2)), (int[]){ 0, 1, 3, 2 });

    return lt_rot6d(lt_reshape(columns, LT_SHAPE(B, n, 6)));
}

void osx_rotations_init(const lt_linear_layer *l, uint64_t seed)
{
    lt_init_xavier(l->weight, seed, 0.01);
    for (int64_t i = 0; i < lt_param_numel(l->bias); i++)
        l->bias->data[i] = i % 6 == 0 || i % 6 == 3;
}

osx_body osx_body_new(lt_params *set, const char *prefix, osx_sizes size)
{
    const int joint = size.fc + 3;

    return (osx_body){
        .conv = lt_linear_layer_new(set, lt_name(set, "%s.body_conv.0", prefix), size.width, size.fc, true),
        .root = lt_linear_layer_new(set, lt_name(set, "%s.root_pose_out.0", prefix), OSX_BODY_JOINTS * joint, 6, true),
        .pose = lt_linear_layer_new(set, lt_name(set, "%s.body_pose_out.0", prefix), OSX_BODY_JOINTS * joint,
                                    (OSX_BODY_ROTATIONS - 1) * 6, true),
        .shape = lt_linear_layer_new(set, lt_name(set, "%s.shape_out.0", prefix), size.width, OSX_SHAPES, true),
        .camera = lt_linear_layer_new(set, lt_name(set, "%s.cam_out.0", prefix), size.width, 3, true),
    };
}

lt_tensor *osx_of_token(const lt_linear_layer *l, lt_tensor *tokens, int i)
{
    lt_tensor *one = lt_reshape(lt_slice(tokens, 1, i, 1), LT_SHAPE(lt_dim(tokens, 0), lt_dim(tokens, 2)));

    return lt_linear_layer_forward(l, one);
}

/* The place beside is as it comes, the distance positive: that at which CAMERA_SIZE fills the image, and less */
static lt_tensor *camera(lt_tensor *x)
{
    const double farthest = sqrt(FOCAL * FOCAL * CAMERA_SIZE * CAMERA_SIZE / (OSX_HEIGHT * OSX_WIDTH));
    lt_tensor *distance = lt_scale(lt_sigmoid(lt_slice(x, 1, 2, 1)), farthest);

    return lt_concat((lt_tensor *[]){ lt_slice(x, 1, 0, 2), distance }, 2, 1);
}

osx_body_out osx_body_forward(const osx_body *m, lt_tensor *tokens, lt_tensor *place)
{
    const int64_t B = lt_dim(tokens, 0);
    lt_tensor *joint = lt_linear_layer_forward(&m->conv, lt_slice(tokens, 1, OSX_BODY_TOKEN, OSX_BODY_JOINTS));
    lt_tensor *six;

    joint = lt_concat((lt_tensor *[]){ joint, lt_detach(place) }, 2, 2);
    joint = lt_reshape(joint, LT_SHAPE(B, lt_dim(joint, 1) * lt_dim(joint, 2)));
    six = lt_concat((lt_tensor *[]){ lt_linear_layer_forward(&m->root, joint),
                                     lt_linear_layer_forward(&m->pose, joint) }, 2, 1);
    return (osx_body_out){
        .rotation = osx_rotations(six),
        .shape = osx_of_token(&m->shape, tokens, OSX_SHAPE_TOKEN),
        .camera = camera(osx_of_token(&m->camera, tokens, OSX_CAMERA_TOKEN)),
    };
}
