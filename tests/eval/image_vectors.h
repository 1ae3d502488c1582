/* SPDX-License-Identifier: Apache-2.0 */
/* PSNR of all and of bright pixels, SSIM valid and zero-padded, of five pairs of pictures. */
/* Made by scripts/vectors/metrics.py; do not edit. */
static const double image_wanted[5][4] = {
    {
        38.6980030525, 38.6790686697, 0.999134549861, 0.999214087291,
    },
    {
        15.2368081688, 15.0604043991, 0.804231188917, 0.881083393961,
    },
    {
        4.77996086801, 4.84463264647, 0.323662875403, 0.35762104675,
    },
    {
        24.5665067329, 24.7021286664, 0.979775444455, 0.983692708378,
    },
    {
        50.7779694849, 50.7950844595, 0.995214824625, 0.99728595531,
    },
};
