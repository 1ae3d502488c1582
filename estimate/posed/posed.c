/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/posed/posed.h"

#include <string.h>

lt_status posed_surface(const posed_frame *f, int part, lt_opacity_rule rule, double iso, lt_arena *arena,
                        lt_mesh *out)
{
    const lt_status st = f->surface(f, part, rule, iso, arena, out);

    if (st != LT_EINVAL)
        return st;
    *out = (lt_mesh){ 0 };
    return LT_OK;
}

void posed_beside(const posed_frame *f, uint8_t *out)
{
    const size_t row = 3 * (size_t)f->width;

    for (int y = 0; y < f->height; y++) {
        memcpy(out + 2 * row * (size_t)y, f->truth + row * (size_t)y, row);
        memcpy(out + 2 * row * (size_t)y + row, f->drawn + row * (size_t)y, row);
    }
}
