/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/sizes.h"

#define ALL_INPUTS .global = true, .pixel = true, .gaussian = true

const hogs_sizes hogs_full = {
    .vpm = { ALL_INPUTS, .vit = 768, .condition = 256, .trunk = 128, .appearance = 256,
             .grid = { .levels = 16, .base = 16, .finest = 2048, .log2_size = 16 } },
    .gpm = { .encoding = 32, .condition = 256,
             .level = { .points = 512, .samples = 32, .radius = 0.2, .width = { 64, 64, 128 } },
             .layers = 3, .heads = 5, .ffn = 1024, .dropout = 0.1 },
    .avatar = { .grid = { .levels = 16, .base = 16, .finest = 2048, .log2_size = 16 },
                .deform = 128, .look = 64, .feature = 32 },
    .skin_width = 128, .gpm_points = 2048, .crop = 224, .map = 7,
};

const hogs_sizes hogs_cpu = {
    .vpm = { ALL_INPUTS, .vit = 192, .condition = 128, .trunk = 64, .appearance = 64,
             .grid = { .levels = 8, .base = 16, .finest = 256, .log2_size = 13 } },
    .gpm = { .encoding = 16, .condition = 128,
             .level = { .points = 128, .samples = 16, .radius = 0.2, .width = { 32, 32, 64 } },
             .width = 64, .layers = 2, .heads = 4, .ffn = 128, .dropout = 0.1 },
    .avatar = { .grid = { .levels = 8, .base = 16, .finest = 256, .log2_size = 13 },
                .deform = 64, .look = 32, .feature = 16 },
    .skin_width = 64, .gpm_points = 512, .crop = 112, .map = 7,
};
