/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/pointnet2.h"

const pointnet2_level_opts ulip_levels[POINTNET2_LEVELS] = {
    { .points = 512, .samples = 32, .radius = 0.2, .width = { 64, 64, 128 } },
    { .points = 128, .samples = 64, .radius = 0.4, .width = { 128, 128, 256 } },
    { .width = { 256, 512, 1024 } },
};

void pointnet2_level_new(pointnet2_level *m, lt_params *set, const char *prefix, const char *first, int features,
                         const pointnet2_level_opts *opts)
{
    int in = 3 + features;

    m->opts = *opts;
    for (int i = 0; i < POINTNET2_CONVS; i++) {
        const char *name = i ? lt_name(set, "%s.mlp_convs.%d", prefix, i) : lt_name(set, "%s.%s", prefix, first);

        m->conv[i] = lt_conv_layer_new(set, name, in, opts->width[i], 1, true, NULL);
        m->norm[i] = lt_batch_norm_layer_new(set, lt_name(set, "%s.mlp_bns.%d", prefix, i), opts->width[i]);
        in = opts->width[i];
    }
}

/* (B, N, C) -> (B, C, 1, N) */
static lt_tensor *rows_to_map(lt_tensor *x)
{
    x = lt_permute(x, (int[]){ 0, 2, 1 });
    return lt_reshape(x, LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1), 1, lt_dim(x, 2)));
}

static lt_tensor *without_row(lt_tensor *map)
{
    return lt_reshape(map, LT_SHAPE(lt_dim(map, 0), lt_dim(map, 1), lt_dim(map, 3)));
}

/*
 * The first convolution of what is known of the points around each centre: (B, C, M, K). It is linear, and of a group
 * only the place counts from the centre: W [x_j - c_i; f_j] + b = (W [x_j; f_j] + b) - W_x c_i. So each point goes
 * through it once, and not with every group that it is in.
 */
static lt_tensor *first_of_groups(const pointnet2_level *m, lt_tensor *map, const pointnet2_out *centre,
                                  lt_tensor *around)
{
    const lt_conv_layer *conv = &m->conv[0];
    lt_tensor *of_place = lt_slice(lt_use(map->graph, conv->weight), 1, 0, 3);
    lt_tensor *shift = lt_conv2d(rows_to_map(centre->points), of_place, NULL, NULL);

    return lt_group(without_row(lt_conv_layer_forward(conv, map)), without_row(shift), around);
}

pointnet2_out pointnet2_level_forward(const pointnet2_level *m, lt_tensor *points, lt_tensor *features,
                                      lt_tensor *start)
{
    const pointnet2_level_opts *o = &m->opts;
    lt_tensor *map = rows_to_map(features ? lt_concat((lt_tensor *[]){ points, features }, 2, 2) : points), *x;
    pointnet2_out out = { NULL };

    if (o->points) {
        out.index = lt_farthest_point_sampling(points, start, o->points);
        out.points = lt_gather(points, out.index);
        x = first_of_groups(m, map, &out, lt_ball_query(points, out.points, o->radius, o->samples));
    } else {
        x = lt_conv_layer_forward(&m->conv[0], map);
    }
    x = lt_relu(lt_batch_norm_layer_forward(&m->norm[0], x));
    for (int i = 1; i < POINTNET2_CONVS; i++)
        x = lt_relu(lt_batch_norm_layer_forward(&m->norm[i], lt_conv_layer_forward(&m->conv[i], x)));
    out.features = lt_permute(lt_max(x), (int[]){ 0, 2, 1 });
    return out;
}

void pointnet2_new(pointnet2 *m, lt_params *set, const char *prefix, const pointnet2_level_opts *sa1, double dropout)
{
    const char *dot = *prefix ? "." : "";
    int features = 0;

    m->dropout = dropout;
    for (int i = 0; i < POINTNET2_LEVELS; i++) {
        const pointnet2_level_opts *o = i == 0 && sa1 ? sa1 : &ulip_levels[i];

        pointnet2_level_new(&m->level[i], set, lt_name(set, "%s%ssa%d", prefix, dot, i + 1), "mlp_convs.0", features,
                            o);
        features = o->width[POINTNET2_CONVS - 1];
    }
    m->fc1 = lt_linear_layer_new(set, lt_name(set, "%s%sfc1", prefix, dot), features, 512, true);
    m->bn1 = lt_batch_norm_layer_new(set, lt_name(set, "%s%sbn1", prefix, dot), 512);
    m->fc2 = lt_linear_layer_new(set, lt_name(set, "%s%sfc2", prefix, dot), 512, 256, true);
    m->bn2 = lt_batch_norm_layer_new(set, lt_name(set, "%s%sbn2", prefix, dot), 256);
}

static lt_tensor *dense(const lt_linear_layer *fc, const lt_batch_norm_layer *norm, double dropout, lt_tensor *x)
{
    x = lt_relu(lt_batch_norm_layer_forward(norm, lt_linear_layer_forward(fc, x)));
    return dropout > 0 ? lt_dropout(x, dropout) : x;
}

lt_tensor *pointnet2_forward(const pointnet2 *m, lt_tensor *points, lt_tensor *start)
{
    pointnet2_out o = { .points = points };
    lt_tensor *x;

    for (int i = 0; i < POINTNET2_LEVELS; i++)
        o = pointnet2_level_forward(&m->level[i], o.points, o.features, start);
    x = lt_reshape(o.features, LT_SHAPE(lt_dim(o.features, 0), lt_dim(o.features, 2)));
    return dense(&m->fc2, &m->bn2, m->dropout, dense(&m->fc1, &m->bn1, m->dropout, x));
}
