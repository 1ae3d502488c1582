/* SPDX-License-Identifier: Apache-2.0 */
/* Gaussians on the screen and on a tile, and their gradients, against the generic entries, bit by bit: sizes from a dot
 * to the whole tile, thin and round, off the tile, too near, no numbers. */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/rng.h"

#include <math.h>
#include <string.h>

enum { MOST = 300, WIDTH = 40, HEIGHT = 30 };

typedef struct {
    int n;
    lt_splat_cloud cloud;
    float *centre, *axes, *opacity, *colour, *offset;
} cloud;

static float awkward(lt_rng *r, double low, double high)
{
    static const float odd[] = { NAN, INFINITY, -INFINITY, 3e38f, -1e20f, 0, 1e-40f };

    if (lt_rng_below(r, 200) == 0)
        return odd[lt_rng_below(r, (uint32_t)LT_COUNT(odd))];
    return (float)lt_rng_range(r, low, high);
}

static cloud new_cloud(int n)
{
    lt_rng r = lt_rng_make(50, (uint64_t)n);
    cloud c = { .n = n };
    const size_t N = (size_t)n;

    c.centre = zero_array(3 * N), c.axes = zero_array(9 * N), c.opacity = zero_array(N), c.colour = zero_array(3 * N);
    c.offset = zero_array(2 * N);
    for (int i = 0; i < n; i++) {
        const double size = exp(lt_rng_range(&r, -8, 0)), far = i % 7 ? 0.5 : 3;

        for (int k = 0; k < 3; k++)
            c.centre[3 * i + k] = k < 2 ? awkward(&r, -far, far) : awkward(&r, 0.1, 3);
        for (int k = 0; k < 9; k++)
            c.axes[9 * i + k] = awkward(&r, -size, size) * (k % 3 == 2 && i % 3 == 0 ? 1e-3f : 1);
        c.opacity[i] = awkward(&r, 0, 1);
        for (int k = 0; k < 3; k++)
            c.colour[3 * i + k] = awkward(&r, 0, 1);
        c.offset[2 * i] = awkward(&r, -1, 1), c.offset[2 * i + 1] = awkward(&r, -1, 1);
    }
    c.cloud = (lt_splat_cloud){ n, c.centre, c.axes, c.opacity, c.colour, n % 2 ? c.offset : NULL };
    return c;
}

static void free_cloud(cloud *c)
{
    free_array(c->centre), free_array(c->axes), free_array(c->opacity), free_array(c->colour), free_array(c->offset);
}

static const lt_splat_view view = { 25, 27, 19.5f, 14, 0.2f, WIDTH, HEIGHT };

static void check_project(const lt_kernels *k, const lt_kernels *generic, const cloud *c, float *seen)
{
    const size_t n = (size_t)c->n, size = sizeof(lt_splat_seen) / sizeof(float);
    float *got = guarded_array(size * n), *radius = guarded_array(n), *want_radius = guarded_array(n);

    generic->splat.project((lt_splat_seen *)(void *)seen, want_radius, &c->cloud, &view, 0, c->n);
    k->splat.project((lt_splat_seen *)(void *)got, radius, &c->cloud, &view, 0, c->n);
    expect_bits(got, seen, size * n, "splat project, %d", c->n);
    expect_bits(radius, want_radius, n, "splat project, radii of %d", c->n);
    free_array(got), free_array(radius), free_array(want_radius);
}

/* All that is drawn, each with an instance of its own, in the order of numbers: any order may be blended. */
static int64_t list_of(lt_splat_entry *entry, const float *seen, int n)
{
    const lt_splat_seen *g = (const void *)seen;
    int64_t drawn = 0;

    for (int i = 0; i < n; i++)
        if (g[i].tall > 0)
            entry[drawn] = (lt_splat_entry){ (uint32_t)i, (uint32_t)drawn }, drawn++;
    return drawn;
}

static void start(float *state)
{
    for (int i = 0; i < LT_SPLAT_CELLS; i++)
        state[i] = i % 16 < 13 ? 1 : -1;
}

static void check_blend(const lt_kernels *k, const lt_kernels *generic, const lt_splat_tile *t)
{
    float *want = zero_array(LT_SPLAT_PLANES * LT_SPLAT_CELLS), *got = zero_array(LT_SPLAT_PLANES * LT_SPLAT_CELLS);

    start(want), start(got);
    generic->splat.blend(want, t);
    k->splat.blend(got, t);
    expect_bits(got, want, LT_SPLAT_PLANES * LT_SPLAT_CELLS, "splat blend, %d, sets %d, depth %d", (int)t->n, t->sets,
                t->depth);
    free_array(want), free_array(got);
}

/* Returns the generic slopes. */
static float *check_blend_grad(const lt_kernels *k, const lt_kernels *generic, const lt_splat_tile *t)
{
    const size_t n = (size_t)t->n * LT_SPLAT_SLOPES, planes = LT_SPLAT_GRAD_PLANES * LT_SPLAT_CELLS;
    float *want = guarded_array(n), *got = guarded_array(n), *light = zero_array(LT_SPLAT_CELLS);
    float *other = zero_array(LT_SPLAT_CELLS), *grad = random_array(planes, 4), *other_grad = random_array(planes, 4);

    start(light), start(other);
    generic->splat.blend_grad((float (*)[LT_SPLAT_SLOPES])(void *)want, light, grad, t);
    k->splat.blend_grad((float (*)[LT_SPLAT_SLOPES])(void *)got, other, other_grad, t);
    expect_bits(got, want, n, "splat blend_grad, %d, sets %d, depth %d", (int)t->n, t->sets, t->depth);
    expect_bits(other, light, LT_SPLAT_CELLS, "splat blend_grad, light of %d", (int)t->n);
    expect_bits(other_grad, grad, planes, "splat blend_grad, planes of %d", (int)t->n);
    free_array(got), free_array(light), free_array(other), free_array(grad), free_array(other_grad);
    return want;
}

static void check_project_grad(const lt_kernels *k, const lt_kernels *generic, const cloud *c,
                               const lt_splat_entry *entry, int64_t drawn, const float *slopes)
{
    static const size_t width[5] = { 3, 9, 1, 3, 2 };
    const lt_kernels *const both[2] = { generic, k };
    uint32_t gaussian[MOST];
    float *to[2][5];

    for (int64_t i = 0; i < drawn; i++)
        gaussian[i] = entry[i].gaussian;
    for (int b = 0; b < 2; b++) {
        for (int i = 0; i < 5; i++)
            to[b][i] = random_array(width[i] * (size_t)c->n, 9);
        both[b]->splat.project_grad(&(lt_splat_cloud_grad){ to[b][0], to[b][1], to[b][2], to[b][3], to[b][4] },
                                    &c->cloud, &view, gaussian,
                                    (const float (*)[LT_SPLAT_SLOPES])(const void *)slopes, drawn);
    }
    for (int i = 0; i < 5; i++) {
        expect_bits(to[1][i], to[0][i], width[i] * (size_t)c->n, "splat project_grad, %d of %d", i, c->n);
        free_array(to[0][i]), free_array(to[1][i]);
    }
}

static void check_count(const lt_kernels *k, const lt_kernels *generic, int n)
{
    cloud c = new_cloud(n);
    float *seen = guarded_array((size_t)n * sizeof(lt_splat_seen) / sizeof(float));
    lt_splat_entry entry[MOST];
    lt_splat_tile t = { .seen = (const void *)seen, .entry = entry, .first = (uint32_t)n / 2, .x0 = 16, .y0 = 0 };

    check_project(k, generic, &c, seen);
    t.n = list_of(entry, seen, n);
    for (int i = 0; i < 4; i++) {
        float *slopes;

        t.sets = i % 2, t.depth = i / 2;
        check_blend(k, generic, &t);
        slopes = check_blend_grad(k, generic, &t);
        check_project_grad(k, generic, &c, entry, t.n, slopes);
        free_array(slopes);
    }
    free_array(seen);
    free_cloud(&c);
}

/* Rays through Gaussians from a hair to a hand's breadth; some points lie on the eye, before it, nowhere. */
static void check_dim(const lt_kernels *k, const lt_kernels *generic, int n)
{
    enum { POINTS = 5 * LT_POINTS, LD = POINTS + 3 };
    lt_rng r = lt_rng_make(51, (uint64_t)n);
    lt_splat_round *g = (void *)zero_array(sizeof(*g) / sizeof(float) * (size_t)n);
    float *eye = zero_array(3 * (size_t)n), *x = zero_array(3 * LD);
    float *want = zero_array(POINTS), *got = zero_array(POINTS);
    uint32_t number[MOST];
    const lt_splat_rays rays = { g, (const float (*)[3])(void *)eye, number, n };

    for (int i = 0; i < n; i++) {
        const double narrow = exp(lt_rng_range(&r, 1, 8));

        number[i] = lt_rng_below(&r, (uint32_t)n);
        g[i].top = awkward(&r, -8, 0);
        for (int a = 0; a < 3; a++)
            g[i].centre[a] = awkward(&r, -0.1, 0.1);
        for (int a = 0; a < 9; a++)
            g[i].white[a] = awkward(&r, -narrow, narrow);
        for (int a = 0; a < 3; a++)
            eye[3 * i + a] = awkward(&r, -narrow, narrow);
    }
    for (int i = 0; i < 3 * LD; i++)
        x[i] = awkward(&r, -0.1, 0.1);
    for (int i = 0; i < POINTS; i++)
        want[i] = got[i] = i % 5 ? 1 : 0.25f;
    generic->splat.dim(want, x, LD, POINTS, &rays);
    k->splat.dim(got, x, LD, POINTS, &rays);
    expect_bits(got, want, POINTS, "splat dim, %d", n);
    free_array((float *)(void *)g), free_array(eye), free_array(x), free_array(want), free_array(got);
}

void check_splat(const lt_kernels *k, const lt_kernels *generic)
{
    for (int n = 0; n < 35; n++)
        check_count(k, generic, n);
    for (int n = 0; n < MOST; n += 37)
        check_dim(k, generic, n);
    check_count(k, generic, MOST - 1);
    check_count(k, generic, MOST);
}
