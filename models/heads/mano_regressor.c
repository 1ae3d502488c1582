/* SPDX-License-Identifier: Apache-2.0 */
#include "models/heads/mano_regressor.h"

static const double SLOPE = 0.01;

void residual_tower_new(residual_tower *m, lt_params *set, const char *prefix, int channels, int levels)
{
    m->levels = levels;
    for (int i = 0; i < levels; i++)
        for (int k = 0; k < 2; k++)
            m->block[i][k] = preact_bottleneck_new(set, lt_name(set, "%s.%d.%d", prefix, i, k), channels);
}

lt_tensor *residual_tower_forward(const residual_tower *m, lt_tensor *x)
{
    for (int i = 0; i < m->levels; i++) {
        for (int k = 0; k < 2; k++)
            x = preact_bottleneck_forward(&m->block[i][k], x);
        x = lt_max_pool2d(x, 2, 2, 0, true);
    }
    return lt_reshape(x, LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1) * lt_dim(x, 2) * lt_dim(x, 3)));
}

void fusion_encoder_new(fusion_encoder *m, lt_params *set, const char *prefix, int channels, int joints,
                        int levels)
{
    m->heatmap_conv = lt_conv_layer_new(set, lt_name(set, "%s.heatmap_conv", prefix), joints, channels, 1,
                                        true, NULL);
    m->encoding_conv = lt_conv_layer_new(set, lt_name(set, "%s.encoding_conv", prefix), channels, channels, 1,
                                         true, NULL);
    residual_tower_new(&m->tower, set, lt_name(set, "%s.reg", prefix), channels, levels);
}

lt_tensor *fusion_encoder_forward(const fusion_encoder *m, lt_tensor *heatmaps, lt_tensor *encoding)
{
    lt_tensor *x = lt_add(lt_conv_layer_forward(&m->heatmap_conv, heatmaps),
                          lt_conv_layer_forward(&m->encoding_conv, encoding));

    return residual_tower_forward(&m->tower, x);
}

void mano_regressor_new(mano_regressor *m, lt_params *set, const char *prefix, int features, int hidden1,
                        int hidden2, const lt_hand_layer *hand)
{
    m->fc1 = lt_linear_layer_new(set, lt_name(set, "%s.fc1", prefix), features, hidden1, true);
    m->fc2 = lt_linear_layer_new(set, lt_name(set, "%s.fc2", prefix), hidden1, hidden2, true);
    m->pose = lt_linear_layer_new(set, lt_name(set, "%s.pose", prefix), hidden2, 6 * LT_HAND_JOINTS, true);
    m->shape = lt_linear_layer_new(set, lt_name(set, "%s.shape", prefix), hidden2, LT_HAND_BETAS, true);
    m->hand = hand;
}

mano_out mano_regressor_forward(const mano_regressor *m, lt_tensor *features)
{
    lt_tensor *x = lt_leaky_relu(lt_linear_layer_forward(&m->fc1, features), SLOPE);
    lt_tensor *six;
    mano_out out;

    x = lt_leaky_relu(lt_linear_layer_forward(&m->fc2, x), SLOPE);
    six = lt_linear_layer_forward(&m->pose, x);
    out.rotation = lt_rot6d(lt_reshape(six, LT_SHAPE(lt_dim(six, 0), LT_HAND_JOINTS, 6)));
    out.beta = lt_linear_layer_forward(&m->shape, x);
    out.vertices = lt_skin(m->hand, out.rotation, out.beta);
    out.joints = lt_result(out.vertices, 1);
    return out;
}
