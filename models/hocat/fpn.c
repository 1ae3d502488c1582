/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hocat/fpn.h"

enum { SE_REDUCTION = 16 };
static const double P2_SCALE = 0.25;     /* pixels of the image to cells of P2 */

static bool gates_laterals(hocat_se_place se)
{
    return se == SE_LATERAL_AND_OUT || se == SE_LATERAL;
}

static bool gates_out(hocat_se_place se)
{
    return se == SE_LATERAL_AND_OUT || se == SE_OUT;
}

void hocat_fpn_new(hocat_fpn *m, lt_params *set, const char *prefix, const int channels[RESNET_STAGES],
                   int out, hocat_se_place se)
{
    m->se = se;
    m->top = lt_conv_layer_new(set, lt_name(set, "%s.top", prefix), channels[3], out, 1, true, NULL);
    for (int i = 2; i >= 0; i--) {
        m->lateral[i] = lt_conv_layer_new(set, lt_name(set, "%s.lateral%d", prefix, i + 2), channels[i], out, 1,
                                          true, NULL);
        if (gates_laterals(se))
            m->gate[i] = lt_se_layer_new(set, lt_name(set, "%s.se%d", prefix, i + 2), channels[i], SE_REDUCTION);
    }
    m->smooth = lt_conv_layer_new(set, lt_name(set, "%s.smooth", prefix), out, out, 3, true,
                                  &(lt_conv_opts){ .pad = 1 });
    if (gates_out(se))
        m->gate_out = lt_se_layer_new(set, lt_name(set, "%s.se_out", prefix), out, SE_REDUCTION);
}

static lt_tensor *gated(const hocat_fpn *m, int i, lt_tensor *c)
{
    return gates_laterals(m->se) ? lt_se_layer_forward(&m->gate[i], c) : c;
}

/* P_i = up(P_{i+1}) + lat_i(g_i C_i) */
static lt_tensor *top_down(const hocat_fpn *m, int i, lt_tensor *above, lt_tensor *c)
{
    lt_tensor *lateral = lt_conv_layer_forward(&m->lateral[i], gated(m, i, c));

    return lt_add(lateral, lt_resize_bilinear(above, lt_dim(lateral, 2), lt_dim(lateral, 3)));
}

static lt_tensor *whole(const hocat_fpn *m, lt_tensor *above, lt_tensor *c2)
{
    lt_tensor *p = lt_conv_layer_forward(&m->smooth, top_down(m, 0, above, c2));

    return gates_out(m->se) ? lt_se_layer_forward(&m->gate_out, p) : p;
}

/* ---- P2 in boxes ---------------------------------------------------------------------------------------- */

static lt_tensor *conv_within(const lt_conv_layer *m, lt_tensor *x, lt_tensor *region)
{
    lt_graph *g = x->graph;

    return lt_conv2d_within(x, lt_use(g, m->weight), lt_use(g, m->bias), &m->opts, region);
}

/* The share of all positions where tap (ky, kx) lies inside the map */
static lt_tensor *shares(lt_graph *g, double H, double W)
{
    lt_real share[9];

    for (int k = 0; k < 9; k++)
        share[k] = (lt_real)((k / 3 == 1 ? 1 : (H - 1) / H) * (k % 3 == 1 ? 1 : (W - 1) / W));
    return lt_constant(g, LT_F32, LT_SHAPE(1, 1, 3, 3), share);
}

/* The mean of smooth(P2'), (B, C), from the means of P3 and the gated C2: all between them is linear. */
static lt_tensor *smooth_mean(const hocat_fpn *m, lt_tensor *above, lt_tensor *c2)
{
    const int64_t H = lt_dim(c2, 2), W = lt_dim(c2, 3);
    lt_tensor *seen = lt_add(lt_conv_layer_forward(&m->lateral[0], lt_window_means(c2, H, W)),
                             lt_window_means(above, H, W));
    lt_graph *g = c2->graph;
    lt_tensor *mean = lt_conv2d(lt_mul(seen, shares(g, (double)H, (double)W)), lt_use(g, m->smooth.weight),
                                lt_use(g, m->smooth.bias), NULL);

    return lt_reshape(mean, LT_SHAPE(lt_dim(mean, 0), lt_dim(mean, 1)));
}

static lt_tensor *within(const hocat_fpn *m, lt_tensor *above, lt_tensor *c, lt_tensor *const *read, int n)
{
    const int64_t B = lt_dim(c, 0), H = lt_dim(c, 2), W = lt_dim(c, 3);
    lt_tensor *c2 = gated(m, 0, c);
    lt_tensor *p = lt_add(conv_within(&m->lateral[0], c2, lt_box_region(read, n, B, H, W, P2_SCALE, 1)),
                          lt_resize_bilinear(above, H, W));

    p = conv_within(&m->smooth, p, lt_box_region(read, n, B, H, W, P2_SCALE, 0));
    return gates_out(m->se) ? lt_mul(p, lt_se_layer_gate(&m->gate_out, smooth_mean(m, above, c2))) : p;
}

lt_tensor *hocat_fpn_forward(const hocat_fpn *m, const resnet_out *c, lt_tensor *const *read, int n)
{
    lt_tensor *p = lt_conv_layer_forward(&m->top, c->c[3]);             /* P5, stride 32 */

    for (int i = 2; i > 0; i--)
        p = top_down(m, i, p, c->c[i]);                                 /* P4, P3 */
    return n ? within(m, p, c->c[0], read, n) : whole(m, p, c->c[0]);   /* P2, stride 4 */
}
