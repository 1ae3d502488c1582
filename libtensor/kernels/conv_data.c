/* SPDX-License-Identifier: Apache-2.0 */
/* The gradient of a convolution's input. */
#include "libtensor/kernels/conv_internal.h"
#include "libtensor/kernels/conv_tapwise.h"
#include "libtensor/kernels/depthwise.h"
#include "libtensor/kernels/winograd.h"
#include "libtensor/kernels/winograd2.h"

#include <string.h>

/* With stride 1 and pad 1 a 3 x 3 window is its own transpose's: dy in the place of x. */
static void data_winograd(const lt_conv2d_params *p, const lt_real *dy, const lt_real *packed, bool add, lt_real *dx,
                          void *work)
{
    const lt_epilogue e = { .residual = add ? dx : NULL };

    lt_winograd_run(p, p->c, p->o, dy, packed, &e, dx, work);
}

/* Forward and this need not be alike: small maps of a strided convolution go tap by tap here. */
static lt_conv_algorithm algorithm(const lt_conv2d_params *p)
{
    const lt_conv_algorithm forward = lt_conv2d_algorithm(p);

    if (forward == LT_CONV_DEPTHWISE || forward == LT_CONV_WINOGRAD || forward == LT_CONV_WINOGRAD2)
        return forward;
    if (lt_tapwise_suits(p, LT_TAPWISE_DATA))
        return LT_CONV_TAPWISE;
    return conv_data_on_tiles(p) ? LT_CONV_TILES : LT_CONV_DIRECT;
}

int64_t lt_conv2d_data_packed(const lt_conv2d_params *p)
{
    if (conv_nothing(p))
        return 0;
    switch (algorithm(p)) {
    case LT_CONV_WINOGRAD:
        return lt_winograd_packed(p->c, p->o);
    case LT_CONV_WINOGRAD2:
        return lt_winograd2_packed(p->c, p->o);
    case LT_CONV_TAPWISE:
        return lt_tapwise_packed(p, LT_TAPWISE_DATA);
    case LT_CONV_DEPTHWISE:
        return conv_weight_count(p);
    default:
        return conv_data_direct_packed(p);
    }
}

void lt_conv2d_data_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    if (conv_nothing(p))
        return;
    switch (algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        memcpy(packed, weights, (size_t)conv_weight_count(p) * sizeof(lt_real));
        break;
    case LT_CONV_WINOGRAD:
        lt_winograd_pack(weights, 9, p->c * 9, true, p->c, p->o, packed);
        break;
    case LT_CONV_WINOGRAD2:
        lt_winograd2_pack(weights, 9, p->c * 9, true, p->c, p->o, packed);
        break;
    case LT_CONV_TAPWISE:
        lt_tapwise_pack(p, LT_TAPWISE_DATA, weights, packed);
        break;
    default:
        conv_data_direct_pack(p, weights, packed);
        break;
    }
}

size_t lt_conv2d_backward_data_work(const lt_conv2d_params *p)
{
    if (conv_nothing(p))
        return 0;
    switch (algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        return 0;
    case LT_CONV_WINOGRAD:
        return lt_winograd_work(p, p->c, p->o);
    case LT_CONV_WINOGRAD2:
        return lt_winograd2_work(p, p->c, p->o);
    case LT_CONV_TAPWISE:
        return lt_tapwise_work(p, LT_TAPWISE_DATA);
    default:
        return conv_data_direct_work(p);
    }
}

void lt_conv2d_backward_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *packed, bool add,
                             lt_real *dx, void *work)
{
    if (conv_nothing(p)) {
        if (!add)
            memset(dx, 0, (size_t)(p->n * p->c * p->h * p->w) * sizeof(lt_real));
        return;
    }
    switch (algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        lt_depthwise_backward_data(p, dy, packed, add, dx);
        break;
    case LT_CONV_WINOGRAD:
        data_winograd(p, dy, packed, add, dx, work);
        break;
    case LT_CONV_WINOGRAD2:
        lt_winograd2_run(p, p->c, p->o, dy, packed, &(lt_conv2d_around){ .residual = add ? dx : NULL }, dx, work);
        break;
    case LT_CONV_TAPWISE:
        lt_tapwise_run(p, LT_TAPWISE_DATA, dy, packed, &(lt_conv2d_around){ 0 }, add, dx, work);
        break;
    default:
        conv_data_direct(p, dy, packed, add, dx, work);
        break;
    }
}
