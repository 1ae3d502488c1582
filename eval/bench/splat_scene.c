/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/bench/splat_scene.h"

#include <math.h>

/* ---- RandomState: Mersenne Twister, doubles of 53 bits, normals by the polar method --------------------- */

enum { WORDS = 624, MIDDLE = 397, SEED = 7 };       /* [Matsumoto and Nishimura 1998] */

typedef struct {
    uint32_t word[WORDS];
    int at;
    bool has_next;
    double next;                /* the second normal of a pair */
} twister;

static void seed(twister *t)
{
    *t = (twister){ .at = WORDS, .word = { SEED } };
    for (uint32_t i = 1; i < WORDS; i++)
        t->word[i] = 1812433253u * (t->word[i - 1] ^ t->word[i - 1] >> 30) + i;
}

static void refill(twister *t)
{
    for (int i = 0; i < WORDS; i++) {
        const uint32_t y = (t->word[i] & 0x80000000u) | (t->word[(i + 1) % WORDS] & 0x7fffffffu);

        t->word[i] = t->word[(i + MIDDLE) % WORDS] ^ y >> 1 ^ (y & 1 ? 0x9908b0dfu : 0);
    }
    t->at = 0;
}

static uint32_t draw(twister *t)
{
    uint32_t y;

    if (t->at == WORDS)
        refill(t);
    y = t->word[t->at++];
    y ^= y >> 11;
    y ^= y << 7 & 0x9d2c5680u;
    y ^= y << 15 & 0xefc60000u;
    return y ^ y >> 18;
}

static double uniform(twister *t)
{
    const uint32_t a = draw(t) >> 5, b = draw(t) >> 6;

    return (a * 67108864.0 + b) / 9007199254740992.0;
}

static double normal(twister *t)
{
    double x1, x2, r, s;

    t->has_next = !t->has_next;
    if (!t->has_next)
        return t->next;
    do {
        x1 = 2 * uniform(t) - 1;
        x2 = 2 * uniform(t) - 1;
        r = x1 * x1 + x2 * x2;
    } while (r >= 1 || r == 0);
    s = sqrt(-2 * log(r) / r);
    t->next = s * x1;
    return s * x2;
}

/* ---- the scene ------------------------------------------------------------------------------------------ */

static void make_shell(twister *t, float *centre, int64_t n)
{
    static const double radius[3] = { .055, .095, .035 }, at[3] = { -.02, 0, .6 };

    for (int64_t i = 0; i < n; i++) {
        const double d[3] = { normal(t), normal(t), normal(t) };
        const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);

        for (int k = 0; k < 3; k++)
            centre[3 * i + k] = (float)(d[k] / length * radius[k] + at[k]);
    }
}

static void make_box(twister *t, float *centre, int64_t n)
{
    static const double size[3] = { .10, .07, .07 }, at[3] = { .03, .02, .58 };

    for (int64_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            centre[3 * i + k] = (float)((uniform(t) - .5) * size[k] + at[k]);
}

lt_status splat_scene_new(lt_arena *arena, int64_t n, splat_scene *out)
{
    const splat_scene s = {
        n, lt_arena_array(arena, 3 * n, sizeof(float)), lt_arena_array(arena, 3 * n, sizeof(float)),
        lt_arena_array(arena, 4 * n, sizeof(float)), lt_arena_array(arena, n, sizeof(float)),
        lt_arena_array(arena, 3 * n, sizeof(float)),
    };
    twister t;

    if (!s.centre || !s.scale || !s.quaternion || !s.opacity || !s.colour)
        return lt_error(LT_ENOMEM, "no memory for %lld Gaussians", (long long)n);
    seed(&t);
    make_shell(&t, s.centre, n / 2);
    make_box(&t, s.centre + 3 * (n / 2), n - n / 2);
    for (int64_t i = 0; i < 3 * n; i++)
        s.scale[i] = (float)(.0022 * exp(.35 * normal(&t)));
    for (int64_t i = 0; i < 4 * n; i++)
        s.quaternion[i] = (float)normal(&t);
    for (int64_t i = 0; i < n; i++)
        s.opacity[i] = (float)(1 / (1 + exp(-(1.5 * normal(&t) + .5))));
    for (int64_t i = 0; i < 3 * n; i++)
        s.colour[i] = (float)uniform(&t);
    *out = s;
    return LT_OK;
}

void splat_scene_axes(const splat_scene *s, lt_real *axes)
{
    for (int64_t i = 0; i < s->n; i++) {
        const float *q = s->quaternion + 4 * i;
        const double norm = sqrt((double)q[0] * q[0] + (double)q[1] * q[1] + (double)q[2] * q[2] + (double)q[3] * q[3]);
        const double w = q[0] / norm, x = q[1] / norm, y = q[2] / norm, z = q[3] / norm;
        const double R[9] = {
            1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
            2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
        };

        for (int k = 0; k < 9; k++)
            axes[9 * i + k] = (lt_real)(R[k] * (double)s->scale[3 * i + k % 3]);
    }
}

double splat_scene_focal(int size)
{
    return size * .6 / .24;
}
