/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The ways to compute a convolution of plain maps, or the gradient of its input. Each is a conv_way in a file of its
 * own; conv.c chooses. For a new one: its file, its name in lt_conv_algorithm, and in conv.c when it is chosen and its
 * line of the table.
 */
#ifndef LT_KERNELS_CONV_WAY_H
#define LT_KERNELS_CONV_WAY_H

#include "libtensor/kernels/conv/conv.h"

/* CONV_DATA: dy's o maps come in and dx's c maps go out, with nothing around but a residual, which is dx itself where
 * the gradient is added. */
typedef enum { CONV_FORWARD, CONV_DATA } conv_direction;

/* packed: elements of the packed weights; work: bytes; the rest as in conv.h. Not for convolutions of nothing. */
typedef struct {
    int64_t (*packed)(const lt_conv2d_params *p, conv_direction d);
    void (*pack)(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed);
    size_t (*work)(const lt_conv2d_params *p, conv_direction d);
    void (*run)(const lt_conv2d_params *p, conv_direction d, const lt_real *x, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *y, void *work);
} conv_way;

extern const conv_way conv_direct;          /* LT_CONV_DIRECT and LT_CONV_TILES, forward: direct.c */
extern const conv_way conv_data_direct;     /* the same of CONV_DATA: data_direct.c */
extern const conv_way conv_turned;          /* forward */
extern const conv_way conv_tapwise;
extern const conv_way conv_winograd;
extern const conv_way conv_winograd2;
extern const conv_way conv_depthwise;       /* LT_CONV_DEPTHWISE, and forward LT_CONV_FEW */

/* Maps that come in and go out */
static inline int64_t conv_maps_in(const lt_conv2d_params *p, conv_direction d)
{
    return d == CONV_FORWARD ? p->c : p->o;
}

static inline int64_t conv_maps_out(const lt_conv2d_params *p, conv_direction d)
{
    return d == CONV_FORWARD ? p->o : p->c;
}

#endif
