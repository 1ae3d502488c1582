/* SPDX-License-Identifier: Apache-2.0 */
/* Tetrahedra of points: against Qhull's where there is one answer, and against what makes them Delaunay where many
 * points lie on one sphere. */
#include "libtensor/geometry/delaunay/delaunay.h"

#include "libtensor/base/rng.h"
#include "libtensor/geometry/delaunay/marching.h"
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 400 };

static lt_arena *arena;

static void setup(void)
{
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_arena_free(arena);
}

/* ---- one answer ---------------------------------------------------------------------------------------------- */

static int by_points(const void *a, const void *b)
{
    return memcmp(a, b, 4 * sizeof(int32_t));           /* of numbers that are stored high byte first */
}

/* Rows with their points ascending, and ascending themselves, to compare sets of them; high byte first */
static void put_in_order(int32_t (*tet)[4], int64_t n)
{
    for (int64_t i = 0; i < n; i++) {
        for (int k = 1; k < 4; k++)
            for (int j = k; j > 0 && tet[i][j] < tet[i][j - 1]; j--) {
                const int32_t t = tet[i][j];

                tet[i][j] = tet[i][j - 1];
                tet[i][j - 1] = t;
            }
        for (int k = 0; k < 4; k++)
            tet[i][k] = (int32_t)__builtin_bswap32((uint32_t)tet[i][k]);
    }
    qsort(tet, (size_t)n, sizeof(*tet), by_points);
}

START_TEST(as_qhull)
{
    const char *srcdir = getenv("srcdir");
    lt_npz npz;
    const lt_array *points, *tets;
    lt_tetrahedra t;
    int32_t (*want)[4];
    int64_t n;

    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/delaunay.npz", srcdir ? srcdir : ".."), &npz));
    points = lt_npz_find(&npz, "points"), tets = lt_npz_find(&npz, "tets");
    n = tets->shape[0];
    check_ok(lt_delaunay(arena, points->shape[0], points->data, &t));
    ck_assert_double_eq(t.step, 1);
    ck_assert_int_eq(t.n, n);
    want = lt_arena_array(arena, (size_t)n, sizeof(*want));
    memcpy(want, tets->data, (size_t)n * sizeof(*want));
    put_in_order(want, n);
    put_in_order(t.tet, t.n);
    ck_assert_int_eq(memcmp(want, t.tet, (size_t)n * sizeof(*want)), 0);
}
END_TEST

/* ---- many on a sphere ---------------------------------------------------------------------------------------- */

typedef struct {
    const char *name;
    void (*draw)(lt_rng *rng, int i, double out[3]);
    double volume;                  /* of the hull, where it is known; else 0 */
} cloud;

static void in_cube(lt_rng *rng, int i, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = i < 8 ? i >> k & 1 : lt_rng_uniform(rng);
}

static void on_lattice(lt_rng *rng, int i, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = i < 8 ? 4 * (i >> k & 1) : (double)lt_rng_below(rng, 5);
}

static void on_sphere(lt_rng *rng, int i, double out[3])
{
    double norm = 0;

    (void)i;
    for (int k = 0; k < 3; k++) {
        out[k] = lt_rng_normal(rng);
        norm += out[k] * out[k];
    }
    for (int k = 0; k < 3; k++)
        out[k] /= sqrt(norm);
}

static void on_two_planes(lt_rng *rng, int i, double out[3])
{
    in_cube(rng, i, out);
    out[2] = out[2] < 0.5 ? 0 : 0.001;
}

/* As extraction has them: corners of boxes, of which eight at a time are on a sphere */
static void corners_of_boxes(lt_rng *rng, int i, double out[3])
{
    lt_rng box = lt_rng_make(3, (uint64_t)i / 8);

    (void)rng;
    for (int k = 0; k < 3; k++) {
        const double middle = lt_rng_uniform(&box), half = lt_rng_range(&box, 0.001, 0.1);

        out[k] = middle + (i >> k & 1 ? half : -half);
    }
}

static const cloud clouds[] = {
    { "cube", in_cube, 1 }, { "lattice", on_lattice, 64 }, { "sphere", on_sphere, 0 },
    { "two planes", on_two_planes, 0.001 }, { "boxes", corners_of_boxes, 0 },
};

static double (*draw(const cloud *c, int n))[3]
{
    double (*x)[3] = lt_arena_array(arena, (size_t)n, sizeof(*x));
    lt_rng rng = lt_rng_make(5, 6);

    for (int i = 0; i < n; i++)
        c->draw(&rng, i, x[i]);
    return x;
}

static __int128 determinant(const int64_t a[3], const int64_t b[3], const int64_t c[3])
{
    return (__int128)a[0] * (b[1] * c[2] - b[2] * c[1]) + (__int128)a[1] * (b[2] * c[0] - b[0] * c[2])
         + (__int128)a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Six times the tetrahedron's volume, and whether no point is inside of its sphere: all in whole numbers */
static double look_at(const lt_tetrahedra *t, int64_t which, int n)
{
    const int32_t (*g)[3] = (const int32_t (*)[3])t->grid, *v = t->tet[which];
    int64_t e[3][3], lift[3];
    __int128 six, part[3];
    int inside = 0;

    for (int i = 0; i < 3; i++) {
        lift[i] = 0;
        for (int k = 0; k < 3; k++) {
            e[i][k] = g[v[i + 1]][k] - g[v[0]][k];
            lift[i] += e[i][k] * e[i][k];
        }
    }
    six = determinant(e[0], e[1], e[2]);
    ck_assert_msg(six > 0, "tetrahedron %lld is flat, or left-handed", (long long)which);
    for (int p = 0; p < n; p++) {
        int64_t x[3], square = 0;

        for (int k = 0; k < 3; k++) {
            x[k] = g[p][k] - g[v[0]][k];
            square += x[k] * x[k];
        }
        part[0] = determinant(x, e[1], e[2]);
        part[1] = determinant(e[0], x, e[2]);
        part[2] = determinant(e[0], e[1], x);
        inside += part[0] * lift[0] + part[1] * lift[1] + part[2] * lift[2] - six * square > 0;
    }
    ck_assert_msg(inside == 0, "%d points are inside of the sphere of tetrahedron %lld", inside, (long long)which);
    return (double)six;
}

START_TEST(nothing_in_the_spheres)
{
    const cloud *c = &clouds[_i];
    lt_tetrahedra t;
    double volume = 0;

    check_ok(lt_delaunay(arena, MOST, (const double (*)[3])draw(c, MOST), &t));
    for (int64_t i = 0; i < t.n; i++)
        volume += look_at(&t, i, MOST) / 6;
    volume *= pow(t.step, 3);
    if (c->volume > 0)
        ck_assert_msg(fabs(volume / c->volume - 1) < 1e-3, "%s: volume %g, not %g", c->name, volume, c->volume);
    for (int i = 0; i < MOST; i++) {
        ck_assert_int_le(t.same[t.same[i]], t.same[i]);
        ck_assert_int_eq(memcmp(t.grid[i], t.grid[t.same[i]], sizeof(t.grid[0])), 0);
    }
}
END_TEST

/* Places say which tetrahedra there are, not the order in which they come. */
START_TEST(any_order)
{
    const cloud *c = &clouds[_i];
    double (*x)[3] = draw(c, MOST), back[MOST][3];
    lt_tetrahedra a, b;

    for (int i = 0; i < MOST; i++)
        memcpy(back[i], x[MOST - 1 - i], sizeof(back[i]));
    check_ok(lt_delaunay(arena, MOST, (const double (*)[3])x, &a));
    check_ok(lt_delaunay(arena, MOST, (const double (*)[3])back, &b));
    ck_assert_int_eq(a.n, b.n);
    for (int64_t i = 0; i < a.n; i++)
        for (int k = 0; k < 4; k++) {
            int first = 0;                              /* at that place, in a's order */

            while (memcmp(a.grid[first], b.grid[b.tet[i][k]], sizeof(a.grid[0])) != 0)
                first++;
            b.tet[i][k] = a.same[first];
        }
    put_in_order(a.tet, a.n);
    put_in_order(b.tet, b.n);
    ck_assert_int_eq(memcmp(a.tet, b.tet, (size_t)a.n * sizeof(*a.tet)), 0);
}
END_TEST

/* ---- surfaces ------------------------------------------------------------------------------------------------ */

enum { FIELD = 3000 };
static const double RADIUS = 0.35;

static double distance_from_middle(const double p[3])
{
    return sqrt(pow(p[0] - 0.5, 2) + pow(p[1] - 0.5, 2) + pow(p[2] - 0.5, 2));
}

static int64_t key_of(const void *edge)
{
    const int32_t *e = edge;

    return (int64_t)e[0] << 32 | e[1];
}

static int by_key(const void *a, const void *b)
{
    const int64_t x = key_of(a), y = key_of(b);

    return (x > y) - (x < y);
}

/* Each edge is walked once each way. */
static void check_closed(const lt_level_surface *s)
{
    int32_t (*edge)[2] = lt_arena_array(arena, (size_t)(3 * s->n_faces), sizeof(*edge));
    int64_t open = 0, twice = 0;

    for (int64_t i = 0; i < 3 * s->n_faces; i++) {
        edge[i][0] = s->face[i / 3][i % 3];
        edge[i][1] = s->face[i / 3][(i + 1) % 3];
    }
    qsort(edge, (size_t)(3 * s->n_faces), sizeof(*edge), by_key);
    for (int64_t i = 0; i < 3 * s->n_faces; i++) {
        const int32_t back[2] = { edge[i][1], edge[i][0] };

        twice += i > 0 && key_of(edge[i]) == key_of(edge[i - 1]);
        open += !bsearch(back, edge, (size_t)(3 * s->n_faces), sizeof(*edge), by_key);
    }
    ck_assert_int_eq(open, 0);
    ck_assert_int_eq(twice, 0);
}

/* A ball among tetrahedra of random points: closed, one piece without a hole, its inside on the right side, as large as
 * it should be. Vertices stand where the distance is the radius. */
START_TEST(surface_of_a_ball)
{
    double (*x)[3] = draw(&clouds[0], FIELD), value[FIELD], volume = 0;
    lt_level_surface s;
    lt_tetrahedra t;

    for (int i = 0; i < FIELD; i++)
        value[i] = -distance_from_middle(x[i]);
    check_ok(lt_delaunay(arena, FIELD, (const double (*)[3])x, &t));
    check_ok(lt_marching_tetrahedra(arena, t.n, (const int32_t (*)[4])t.tet, value, -RADIUS, &s));
    check_closed(&s);
    ck_assert_int_eq(s.n_vertices - 3 * s.n_faces / 2 + s.n_faces, 2);
    for (int64_t i = 0; i < s.n_faces; i++) {
        double p[3][3];

        for (int k = 0; k < 3; k++) {
            const int32_t *e = s.edge[s.face[i][k]];
            const double in = value[e[0]] + RADIUS, out = value[e[1]] + RADIUS, share = in / (in - out);

            ck_assert(in > 0 && out <= 0);
            for (int d = 0; d < 3; d++)
                p[k][d] = x[e[0]][d] + share * (x[e[1]][d] - x[e[0]][d]) - 0.5;
        }
        volume += (p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2])
                   + p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0])) / 6;
    }
    ck_assert_double_eq_tol(volume / (4 * M_PI / 3 * pow(RADIUS, 3)), 1, 0.05);
}
END_TEST

/* Nothing inside, or all of it; numbers that are none are outside. */
START_TEST(no_surface)
{
    double (*x)[3] = draw(&clouds[0], MOST), value[MOST];
    lt_level_surface s;
    lt_tetrahedra t;

    check_ok(lt_delaunay(arena, MOST, (const double (*)[3])x, &t));
    for (int i = 0; i < MOST; i++)
        value[i] = i % 2 ? NAN : -1;
    check_ok(lt_marching_tetrahedra(arena, t.n, (const int32_t (*)[4])t.tet, value, 0, &s));
    ck_assert_int_eq(s.n_faces + s.n_vertices, 0);
    for (int i = 0; i < MOST; i++)
        value[i] = 1;
    check_ok(lt_marching_tetrahedra(arena, t.n, (const int32_t (*)[4])t.tet, value, 0, &s));
    ck_assert_int_eq(s.n_faces + s.n_vertices, 0);
}
END_TEST

START_TEST(bad_points)
{
    double flat[5][3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 1, 1, 0 }, { 3, 2, 0 } };
    double one[4][3] = { { 2, 2, 2 } };
    lt_tetrahedra t;

    ck_assert_int_eq(lt_delaunay(arena, 3, (const double (*)[3])flat, &t), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "a triangulation of 3 points, expected 4 to 100000000");
    ck_assert_int_eq(lt_delaunay(arena, 5, (const double (*)[3])flat, &t), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "all 5 points of a triangulation are in one plane");
    for (int i = 1; i < 4; i++)
        memcpy(one[i], one[0], sizeof(one[0]));
    ck_assert_int_eq(lt_delaunay(arena, 4, (const double (*)[3])one, &t), LT_EINVAL);
    flat[2][1] = NAN;
    ck_assert_int_eq(lt_delaunay(arena, 5, (const double (*)[3])flat, &t), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "point 2 of a triangulation is not finite");
    flat[2][1] = -1e308, flat[1][1] = 1e308;
    ck_assert_int_eq(lt_delaunay(arena, 5, (const double (*)[3])flat, &t), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "points of a triangulation are too far from each other");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, as_qhull);
    tcase_add_loop_test(tc, nothing_in_the_spheres, 0, (int)LT_COUNT(clouds));
    tcase_add_loop_test(tc, any_order, 0, (int)LT_COUNT(clouds));
    tcase_add_test(tc, surface_of_a_ball);
    tcase_add_test(tc, no_surface);
    tcase_add_test(tc, bad_points);
}

int main(void)
{
    return run_suite("delaunay", add_tests);
}
