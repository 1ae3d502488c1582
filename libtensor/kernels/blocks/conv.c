/* SPDX-License-Identifier: Apache-2.0 */
/* Which algorithm a convolution of maps in blocks has: each is in a file of its own. */
#include "libtensor/kernels/blocks/conv.h"

#include "libtensor/kernels/blocks/depthwise.h"
#include "libtensor/kernels/blocks/expand.h"
#include "libtensor/kernels/blocks/product.h"
#include "libtensor/kernels/blocks/stem.h"
#include "libtensor/kernels/blocks/tall.h"
#include "libtensor/kernels/blocks/tiles.h"
#include "libtensor/kernels/blocks/winograd.h"
#include "libtensor/kernels/conv/internal.h"

#include <assert.h>

typedef enum { NONE, PRODUCT, TILES, WINOGRAD, TALL, WINDOWS, STEM } blocks_algorithm;

static blocks_algorithm algorithm_of(const lt_conv2d_params *p)
{
    const bool square = p->kh == p->kw && p->stride_h == p->stride_w && p->pad_h == p->pad_w;

    if (lt_stem_suits(p))
        return STEM;
    if (p->c < LT_BLOCK || p->o < LT_BLOCK || conv_nothing(p))
        return NONE;
    if (p->groups > 1)
        return p->groups == p->c && p->o == p->c && square && lt_depthwise_blocks_suits(p) ? WINDOWS : NONE;
    if (lt_winograd_blocks_side(p))
        return WINOGRAD;
    if (lt_conv_tiles_suits(p))
        return TILES;
    return lt_tall_suits(p) ? TALL : PRODUCT;
}

bool lt_conv_blocks_takes(const lt_conv2d_params *p)
{
    return algorithm_of(p) != NONE;
}

bool lt_conv_blocks_reads_plain(const lt_conv2d_params *p)
{
    return algorithm_of(p) == STEM;
}

const char *lt_conv_blocks_name(const lt_conv2d_params *p)
{
    static const char *const names[] = {
        [PRODUCT] = "blocks", [TILES] = "tiles blocks", [WINOGRAD] = "winograd blocks", [TALL] = "winograd tall blocks",
        [WINDOWS] = "depthwise blocks", [STEM] = "stem to blocks",
    };
    const blocks_algorithm a = algorithm_of(p);

    assert(a != NONE);
    return names[a];
}

int64_t lt_conv_blocks_packed(const lt_conv2d_params *p)
{
    switch (algorithm_of(p)) {
    case PRODUCT: return lt_blocks_product_packed(p);
    case TILES: return lt_conv_tiles_packed(p);
    case WINOGRAD: return lt_winograd_blocks_packed(p);
    case TALL: return lt_tall_packed(p);
    case WINDOWS: return lt_depthwise_blocks_packed(p);
    case STEM: return lt_stem_packed(p);
    case NONE: break;
    }
    return 0;
}

void lt_conv_blocks_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    switch (algorithm_of(p)) {
    case PRODUCT: lt_blocks_product_pack(p, weights, packed); break;
    case TILES: lt_conv_tiles_pack(p, weights, packed); break;
    case WINOGRAD: lt_winograd_blocks_pack(p, weights, packed); break;
    case TALL: lt_tall_pack(p, weights, packed); break;
    case WINDOWS: lt_depthwise_blocks_pack(p, weights, packed); break;
    case STEM: lt_stem_pack(p, weights, packed); break;
    case NONE: break;
    }
}

size_t lt_conv_blocks_work(const lt_conv2d_params *p)
{
    switch (algorithm_of(p)) {
    case PRODUCT: return lt_blocks_product_work(p);
    case WINOGRAD: return lt_winograd_blocks_work(p);
    case TALL: return lt_tall_work(p);
    case WINDOWS: return lt_depthwise_blocks_work(p);
    case TILES:
    case STEM:
    case NONE: break;
    }
    return 0;
}

void lt_conv_blocks_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                            const lt_conv2d_around *around, lt_real *y, void *work)
{
    switch (algorithm_of(p)) {
    case PRODUCT: lt_blocks_product_forward(p, x, packed, around, y, work); break;
    case TILES: lt_conv_tiles_forward(p, x, packed, around, y); break;
    case WINOGRAD: lt_winograd_blocks_forward(p, x, packed, around, y, work); break;
    case TALL: lt_tall_forward(p, x, packed, around, y, work); break;
    case WINDOWS: lt_depthwise_blocks_forward(p, x, packed, around, y, work); break;
    case STEM: lt_stem_forward(p, x, packed, around, y); break;
    case NONE: break;
    }
}

/* ---- two in a row ------------------------------------------------------------------------------------ */

bool lt_conv_blocks_pair_suits(const lt_conv2d_params *first, const lt_conv2d_params *second)
{
    return algorithm_of(first) == PRODUCT && conv_pointwise(first) && algorithm_of(second) == WINDOWS
           && lt_expand_blocks_suits(first, second);
}

size_t lt_conv_blocks_pair_work(const lt_conv2d_params *first, const lt_conv2d_params *second)
{
    return lt_expand_blocks_work(first, second);
}

void lt_conv_blocks_pair_forward(const lt_conv_blocks_step *first, const lt_conv_blocks_step *second, const lt_real *x,
                                 lt_real *y, void *work)
{
    lt_expand_blocks_forward(first, second, x, y, work);
}
