/* SPDX-License-Identifier: Apache-2.0 */
/* A convolution and the gradient of its input: which algorithm each has. */
#include "libtensor/kernels/conv/depthwise.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/tapwise.h"
#include "libtensor/kernels/conv/turned.h"
#include "libtensor/kernels/conv/way.h"
#include "libtensor/kernels/conv/winograd.h"
#include "libtensor/kernels/conv/winograd2.h"

#include <assert.h>
#include <string.h>

/* ---- which algorithm ---------------------------------------------------------------------------------- */

lt_conv_algorithm lt_conv2d_algorithm(const lt_conv2d_params *p)
{
    enum { MANY = 8 };          /* outputs of one map: worth packing its windows */

    if (conv_group_c(p) == 1 && conv_group_o(p) < MANY)
        return LT_CONV_DEPTHWISE;
    if (lt_few_suits(p))
        return LT_CONV_FEW;
    if (lt_winograd2_suits(p))
        return LT_CONV_WINOGRAD2;
    if (lt_winograd_suits(p))
        return LT_CONV_WINOGRAD;
    if (lt_tapwise_suits(p, CONV_FORWARD))
        return LT_CONV_TAPWISE;
    if (conv_forward_on_tiles(p))
        return LT_CONV_TILES;
    return lt_turned_suits(p) ? LT_CONV_TURNED : LT_CONV_DIRECT;
}

/* Forward and this need not be alike: small maps of a strided convolution go tap by tap here. */
static lt_conv_algorithm data_algorithm(const lt_conv2d_params *p)
{
    const lt_conv_algorithm forward = lt_conv2d_algorithm(p);

    if (forward == LT_CONV_DEPTHWISE || forward == LT_CONV_WINOGRAD || forward == LT_CONV_WINOGRAD2)
        return forward;
    if (lt_tapwise_suits(p, CONV_DATA))
        return LT_CONV_TAPWISE;
    return conv_data_on_tiles(p) ? LT_CONV_TILES : LT_CONV_DIRECT;
}

static const conv_way *way_of(const lt_conv2d_params *p, conv_direction d)
{
    static const conv_way *const ways[][2] = {
        [LT_CONV_DIRECT] = { &conv_direct, &conv_data_direct },
        [LT_CONV_TILES] = { &conv_direct, &conv_data_direct },
        [LT_CONV_TURNED] = { &conv_turned, NULL },
        [LT_CONV_TAPWISE] = { &conv_tapwise, &conv_tapwise },
        [LT_CONV_WINOGRAD] = { &conv_winograd, &conv_winograd },
        [LT_CONV_WINOGRAD2] = { &conv_winograd2, &conv_winograd2 },
        [LT_CONV_DEPTHWISE] = { &conv_depthwise, &conv_depthwise },
        [LT_CONV_FEW] = { &conv_depthwise, NULL },
    };

    return ways[d == CONV_FORWARD ? lt_conv2d_algorithm(p) : data_algorithm(p)][d];
}

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    return conv_nothing(p) ? 0 : way_of(p, d)->packed(p, d);
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    if (!conv_nothing(p))
        way_of(p, d)->pack(p, d, weights, packed);
}

static size_t work_bytes(const lt_conv2d_params *p, conv_direction d)
{
    return conv_nothing(p) ? 0 : way_of(p, d)->work(p, d);
}

/* ---- forward -------------------------------------------------------------------------------------------- */

int64_t lt_conv2d_packed(const lt_conv2d_params *p)
{
    return packed_elements(p, CONV_FORWARD);
}

void lt_conv2d_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    pack(p, CONV_FORWARD, weights, packed);
}

size_t lt_conv2d_forward_work(const lt_conv2d_params *p)
{
    return work_bytes(p, CONV_FORWARD);
}

bool lt_conv2d_takes_gate(const lt_conv2d_params *p)
{
    return conv_pointwise(p) && p->groups == 1 && lt_conv2d_algorithm(p) != LT_CONV_DEPTHWISE;
}

bool lt_conv2d_makes_mean(const lt_conv2d_params *p)
{
    return lt_conv2d_algorithm(p) == LT_CONV_DEPTHWISE;
}

void lt_conv2d_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                       const lt_conv2d_around *around, lt_real *y, void *work)
{
    assert(!around->gate || lt_conv2d_takes_gate(p));
    assert(!around->mean || lt_conv2d_makes_mean(p));
    if (!conv_nothing(p))
        way_of(p, CONV_FORWARD)->run(p, CONV_FORWARD, x, packed, around, y, work);
}

/* ---- a part of one image -------------------------------------------------------------------------------- */

bool lt_conv2d_takes_rect(const lt_conv2d_params *p)
{
    const lt_conv_algorithm a = lt_conv2d_algorithm(p);
    const bool known = a == LT_CONV_DIRECT || a == LT_CONV_TILES || a == LT_CONV_WINOGRAD;

    return p->groups == 1 && p->stride_h == 1 && p->stride_w == 1 && known;
}

size_t lt_conv2d_rect_work(const lt_conv2d_params *p)
{
    return lt_conv2d_algorithm(p) == LT_CONV_WINOGRAD ? lt_winograd_rect_work(p) : 0;
}

void lt_conv2d_forward_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                            const lt_real *bias, const lt_real *residual, lt_act act, lt_real *y, void *work)
{
    const lt_epilogue e = { .row_bias = bias, .residual = residual, .act = act };

    if (conv_nothing(p) || r.y0 >= r.y1 || r.x0 >= r.x1)
        return;
    if (lt_conv2d_algorithm(p) == LT_CONV_WINOGRAD)
        lt_winograd_run_rect(p, r, x, packed, &e, y, work);
    else
        conv_direct_rect(p, r, x, packed, &e, y);
}

/* ---- the gradient of x ---------------------------------------------------------------------------------- */

int64_t lt_conv2d_data_packed(const lt_conv2d_params *p)
{
    return packed_elements(p, CONV_DATA);
}

void lt_conv2d_data_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    pack(p, CONV_DATA, weights, packed);
}

size_t lt_conv2d_backward_data_work(const lt_conv2d_params *p)
{
    return work_bytes(p, CONV_DATA);
}

void lt_conv2d_backward_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *packed, bool add,
                             lt_real *dx, void *work)
{
    const lt_conv2d_around around = { .residual = add ? dx : NULL };

    if (!conv_nothing(p))
        way_of(p, CONV_DATA)->run(p, CONV_DATA, dy, packed, &around, dx, work);
    else if (!add)
        memset(dx, 0, (size_t)(p->n * p->c * p->h * p->w) * sizeof(lt_real));
}
