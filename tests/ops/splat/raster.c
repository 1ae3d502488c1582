/* SPDX-License-Identifier: Apache-2.0 */
/* splat_raster against every Gaussian at every pixel in torch (scripts/vectors/splat.py). Gradients are held against
 * differences where all alphas stay clear of their limits: large Gaussians of middling opacity. */
#include "tests/ops/suite.h"

enum { W = 21, H = 18, NO_SETS = -1 };

static lt_tensor *raster(lt_tensor **in, int32_t first, const lt_splat_opts *o)
{
    static const lt_real camera[4] = { 20, 22, (lt_real)9.5, 8 };
    lt_graph *g = in[0]->graph;
    const lt_splat_in cloud = {
        in[0], in[1], in[2], in[3], lt_constant(g, LT_F32, LT_SHAPE(4), camera), in[4],
        first == NO_SETS ? NULL : lt_constant(g, LT_I32, (lt_shape){ 0 }, &first),
    };

    return lt_splat_raster(&cloud, o);
}

/* The image without radii and counts, which move by jumps */
static lt_tensor *image(lt_tensor **in, int32_t first, const lt_splat_opts *o)
{
    return lt_scale(raster(in, first, o), 1);
}

#define OPTS(...) &(lt_splat_opts){ .width = W, .height = H, .near_z = 0.2, __VA_ARGS__ }

static lt_tensor *one(lt_tensor **in) { return image(in, NO_SETS, OPTS(.white = false)); }
static lt_tensor *one_white(lt_tensor **in)
{
    return image(in, NO_SETS, OPTS(.white = true, .opacity = true, .depth = true));
}
static lt_tensor *sets(lt_tensor **in) { return image(in, 3, OPTS(.sets = true, .depth = true)); }
static lt_tensor *sets_white(lt_tensor **in) { return image(in, 2, OPTS(.sets = true, .white = true)); }
static lt_tensor *slanted(lt_tensor **in) { return image(in, 1, OPTS(.sets = true)); }
static lt_tensor *with_opacity(lt_tensor **in) { return image(in, NO_SETS, OPTS(.opacity = true)); }
static lt_tensor *small(lt_tensor **in) { return raster(in, 30, OPTS(.sets = true, .depth = true)); }
static lt_tensor *dense(lt_tensor **in) { return raster(in, 40, OPTS(.sets = true)); }
static lt_tensor *degenerate(lt_tensor **in) { return raster(in, 4, OPTS(.sets = true)); }
static lt_tensor *only_white(lt_tensor **in) { return raster(in, NO_SETS, OPTS(.white = true)); }

static lt_tensor *without_first(lt_tensor **in) { return raster(in, NO_SETS, OPTS(.sets = true)); }
static lt_tensor *without_pixels(lt_tensor **in) { return raster(in, NO_SETS, &(lt_splat_opts){ 0, 5, .near_z = 1 }); }
static lt_tensor *too_near(lt_tensor **in) { return raster(in, NO_SETS, &(lt_splat_opts){ 5, 5, .near_z = 0 }); }
static lt_tensor *real_first(lt_tensor **in)
{
    lt_tensor *camera = lt_constant(in[0]->graph, LT_F32, LT_SHAPE(4), (lt_real[]){ 1, 1, 1, 1 });

    return lt_splat_raster(&(lt_splat_in){ in[0], in[1], in[2], in[3], camera, NULL, in[4] }, OPTS(.sets = true));
}
static lt_tensor *three_of_camera(lt_tensor **in)
{
    return lt_splat_raster(&(lt_splat_in){ in[0], in[1], in[2], in[3], in[4], NULL, NULL }, OPTS(.sets = false));
}

/* Around z = 2, apart in depth; `far` to the side, where the projection's derivative is held */
static double value_at(int input, int64_t i, lt_rng *r, double far)
{
    switch (input) {
    case 0: return i % 3 == 2 ? 1.5 + 0.1 * (double)(i / 3) : lt_rng_range(r, -0.3, 0.3) + far * (i % 3 == 0);
    case 1: return lt_rng_range(r, -0.2, 0.2) + (i % 9 % 4 == 0 ? 1.8 : 0);
    case 2: return lt_rng_range(r, 0.2, 0.5);
    case 3: return lt_rng_range(r, 0, 1);
    default: return lt_rng_range(r, -0.3, 0.3);
    }
}

static void fill_at(int input, lt_real *v, int64_t n, lt_rng *r, double far)
{
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)value_at(input, i, r, far);
}

static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    fill_at(input, v, n, r, 0);
}

static void fill_aside(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    fill_at(input, v, n, r, 1.5);
}

/* Nothing of these is drawn: behind, no numbers, no opacity */
static void fill_hidden(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    fill(c, input, v, n, r);
    for (int64_t i = 0; i < n; i++)
        if (input == 0 && i / 3 % 2)
            v[i] = -v[i];
        else if (input == 2 && i % 2 == 0)
            v[i] = 0;
}

#define CLOUD(n) S(n, 3), S(n, 3, 3), S(n), S(n, 3)

static const op_case cases[] = {
    { "one", one, .in = { CLOUD(6), S(6, 2) }, .fill = fill },
    { "one_white", one_white, .in = { CLOUD(6), S(6, 2) }, .fill = fill },
    { "sets", sets, .in = { CLOUD(6), S(6, 2) }, .fill = fill },
    { "sets_white", sets_white, .in = { CLOUD(6), S(6, 2) }, .fill = fill },
    { "slanted", slanted, .in = { CLOUD(4), S(4, 2) }, .fill = fill_aside },
    { "without_offset", with_opacity, .in = { CLOUD(5) }, .fill = fill },
    { "small", small, .in = { CLOUD(60), S(60, 2) }, .fill = fill_hidden },
    { "dense", dense, .in = { CLOUD(80), S(80, 2) }, .fill = fill_hidden },
    { "degenerate", degenerate, .in = { CLOUD(8), S(8, 2) }, .fill = fill_hidden },
    { "none", only_white, .in = { CLOUD(0), S(0, 2) }, .fill = fill },
};

static const op_bad_case bad[] = {
    { one, { S(6, 2), S(6, 3, 3), S(6), S(6, 3) }, "splat_raster: centre is (6, 2), want (6, 3)" },
    { one, { S(6, 3), S(5, 3, 3), S(6), S(6, 3) }, "splat_raster: axes is (5, 3, 3), want (6, 3, 3)" },
    { one, { S(6, 3), S(6, 3, 3), S(6, 1), S(6, 3) }, "splat_raster: opacity is (6, 1), want (6)" },
    { one, { S(6, 3), S(6, 3, 3), S(6), S(6) }, "splat_raster: colour is (6), want (6, 3)" },
    { one, { CLOUD(6), S(6, 3) }, "splat_raster: offset is (6, 3), want (6, 2)" },
    { three_of_camera, { CLOUD(6), S(3) }, "splat_raster: camera is (3), want (4)" },
    { without_first, { CLOUD(6) }, "splat_raster: images of two sets want the number of Gaussians in the first one" },
    { real_first, { CLOUD(6), C(1) },
      "splat_raster: the size of the first set is (1) and no LT_I32, want one integer" },
    { without_pixels, { CLOUD(6) }, "splat_raster: the image is 0 x 5, want 1 to 16384 either way" },
    { too_near, { CLOUD(6) }, "splat_raster: near_z is 0, want a distance above 0" },
};

const op_suite splat_raster_suite = { "splat_raster", CASES(cases), BAD(bad), .value_tol = 2e-6, .grad_tol = 2e-5 };
