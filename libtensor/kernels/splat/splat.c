/* SPDX-License-Identifier: Apache-2.0 */
/* Gaussians on the screen, and on its tiles. */
#include "libtensor/kernels/vec/vec.h"

#include "libtensor/kernels/vec/math.inc"
#include "libtensor/kernels/splat/project.inc"
#include "libtensor/kernels/splat/alpha.inc"
#include "libtensor/kernels/splat/blend.inc"
#include "libtensor/kernels/splat/blend_grad.inc"
#include "libtensor/kernels/splat/dim.inc"

void ISA(add_splat)(lt_kernels *k)
{
    k->splat = (lt_splat_kernels){
        .project = project, .project_grad = project_grad, .blend = blend, .blend_grad = blend_grad,
        .dim = dim,
    };
}
