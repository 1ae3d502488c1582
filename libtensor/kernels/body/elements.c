/* SPDX-License-Identifier: Apache-2.0 */
/* What goes element by element, along a row or over a plane. */
#include "libtensor/kernels/vec/vec.h"

#include "libtensor/kernels/vec/math.inc"
#include "libtensor/kernels/vec/each.inc"
#include "libtensor/kernels/vec/epilogue.inc"
#include "libtensor/kernels/body/eltwise.inc"
#include "libtensor/kernels/vec/sum.inc"
#include "libtensor/kernels/body/reduce.inc"
#include "libtensor/kernels/body/rows.inc"
#include "libtensor/kernels/body/pool.inc"
#include "libtensor/kernels/vec/turn.inc"
#include "libtensor/kernels/body/resample.inc"
#include "libtensor/kernels/body/sample.inc"
#include "libtensor/kernels/body/skin.inc"
#include "libtensor/kernels/body/points.inc"
#include "libtensor/kernels/body/links.inc"
#include "libtensor/kernels/body/hash.inc"
#include "libtensor/kernels/body/optim.inc"
#include "libtensor/kernels/body/random.inc"

void ISA(add_elements)(lt_kernels *k)
{
    add_eltwise(k);
    add_reduce(k);
    add_rows(k);
    add_pool(k);
    add_resample(k);
    add_sample(k);
    add_skin(k);
    add_points(k);
    add_links(k);
    add_hash(k);
    add_optim(k);
    add_random(k);
}
