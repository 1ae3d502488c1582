/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Every draw stands in a statement of its own: C leaves the order of arguments open, and the same seed
 * must give the same room under every compiler.
 */
#include "synth/room/clutter.h"
#include "synth/room/pattern.h"
#include "synth/room/primitive.h"

#include <math.h>
#include <string.h>

static const double origin[3] = { 0, 0, 0 };

enum { SEGMENTS = 40 };

/* Adds a part at (x, y, z), turned about z. */
static void add(lt_arena *arena, clutter *c, lt_mesh mesh, synth_material material,
                const double at[3], double turn)
{
    lt_mesh *kept = lt_arena_alloc(arena, sizeof(*kept));
    synth_instance *in = &c->part[c->n_parts];
    const double R[9] = { cos(turn), -sin(turn), 0, sin(turn), cos(turn), 0, 0, 0, 1 };

    if (!kept || mesh.n_vertices == 0)
        return;
    *kept = mesh;
    in->mesh = kept;
    in->material = material;
    memcpy(in->R_world_obj, R, sizeof(R));
    memcpy(in->t_world_obj, at, sizeof(in->t_world_obj));
    c->n_parts++;
}

static double draw_turn(lt_rng *r)
{
    return lt_rng_range(r, 0, 2 * M_PI);
}

static float draw(lt_rng *r, double lo, double hi)
{
    return (float)lt_rng_range(r, lo, hi);
}

static synth_material printed(synth_texture *texture, float specular, float shininess)
{
    return (synth_material){ .albedo = { 1, 1, 1 }, .texture = texture, .specular = specular,
                             .shininess = shininess };
}

/* One colour of any hue, with saturation and value up to these. */
static synth_material painted(lt_rng *r, double saturation, double value_lo, double value_hi,
                              float shininess)
{
    synth_material m = { .specular = 0.045f, .shininess = shininess };

    pattern_draw_color(r, 0, saturation, value_lo, value_hi, m.albedo);
    for (int c = 0; c < 3; c++)
        m.albedo[c] = powf(m.albedo[c], 2.2f);
    return m;
}

static synth_material tin(void)
{
    return (synth_material){ .albedo = { 0.75f, 0.74f, 0.72f }, .specular = 0.6f, .shininess = 90,
                             .metal = 0.8f };
}

static void draw_size(lt_rng *r, const double lo[3], const double hi[3], double size[3])
{
    for (int k = 0; k < 3; k++)
        size[k] = lt_rng_range(r, lo[k], hi[k]);
}

static void make_can(lt_arena *arena, lt_rng *r, clutter *c)
{
    const float radius = draw(r, 0.028, 0.052);
    const float h = draw(r, 0.06, 0.16), in = h - 0.003f;
    const double turn = draw_turn(r);
    const float body[2][2] = { { radius, 0.003f }, { radius, in } };
    const float lid[6][2] = { { radius, in }, { radius + 0.001f, h }, { radius - 0.002f, h },
                              { radius - 0.003f, in }, { 0.01f, in }, { 0, in } };

    add(arena, c, primitive_lathe(arena, body, 2, SEGMENTS),
        printed(pattern_label(arena, r), 0.05f, 45), origin, turn);
    add(arena, c, primitive_lathe(arena, lid, 6, SEGMENTS), tin(), origin, 0);
    c->radius = radius;
}

static void make_bottle(lt_arena *arena, lt_rng *r, clutter *c)
{
    const float radius = draw(r, 0.028, 0.042);
    const float h = draw(r, 0.16, 0.27);
    const float neck = radius * draw(r, 0.3, 0.5);
    const float shoulder = h * draw(r, 0.6, 0.75);
    const synth_material glass = painted(r, 0.9, 0.2, 0.9, 70), lid = painted(r, 0.9, 0.1, 0.95, 40);
    const double turn = draw_turn(r);
    const float body[9][2] = {
        { 0, 0 }, { radius - 0.004f, 0 }, { radius, 0.004f }, { radius, 0.1f * h },
        { radius, shoulder }, { 0.9f * radius, shoulder + 0.06f * h },
        { 0.5f * (radius + neck), shoulder + 0.12f * h }, { neck, shoulder + 0.19f * h }, { neck, h },
    };
    const float cap[4][2] = { { neck + 0.002f, 0.94f * h }, { neck + 0.002f, h + 0.004f },
                              { neck, h + 0.006f }, { 0, h + 0.006f } };
    const float label[2][2] = { { radius + 0.0004f, 0.15f * h },
                                { radius + 0.0004f, shoulder - 0.05f * h } };

    add(arena, c, primitive_lathe(arena, body, 9, SEGMENTS), glass, origin, 0);
    add(arena, c, primitive_lathe(arena, cap, 4, SEGMENTS), lid, origin, 0);
    add(arena, c, primitive_lathe(arena, label, 2, SEGMENTS),
        printed(pattern_label(arena, r), 0.04f, 30), origin, turn);
    c->radius = radius;
}

/* Half a ring from the upper to the lower end on the side of a mug. */
static lt_mesh handle(lt_arena *arena, float radius, float h)
{
    const float side[3] = { 0, 1, 0 };
    float path[13][3], thick[13];

    for (int i = 0; i < 13; i++) {
        const double a = -0.5 * M_PI + M_PI * i / 12;

        path[i][0] = radius - 0.003f + 0.026f * (float)cos(a);
        path[i][1] = 0;
        path[i][2] = 0.52f * h + 0.33f * h * (float)sin(a);
        thick[i] = 0.0065f;
    }
    return primitive_tube(arena, (const float (*)[3])path, thick, 13, 0.6f, side, 14);
}

static void make_mug(lt_arena *arena, lt_rng *r, clutter *c)
{
    const float radius = draw(r, 0.036, 0.046);
    const float h = draw(r, 0.075, 0.11);
    const float wall = 0.0035f, foot = radius * draw(r, 0.7, 1);
    const synth_material glaze = painted(r, 0.85, 0.2, 0.97, 80);
    const double turn = draw_turn(r);
    const float cup[9][2] = {
        { 0, 0 }, { foot - 0.003f, 0 }, { foot, 0.003f }, { radius, 0.35f * h }, { radius, h },
        { radius - wall / 2, h + 0.0015f }, { radius - wall, h }, { radius - wall, 0.02f },
        { 0, 0.006f },
    };

    add(arena, c, primitive_lathe(arena, cup, 9, SEGMENTS), glaze, origin, 0);
    add(arena, c, handle(arena, radius, h), glaze, origin, turn);
    c->radius = radius + 0.03;
}

static void make_box(lt_arena *arena, lt_rng *r, clutter *c)
{
    static const double lo[3] = { 0.06, 0.03, 0.04 }, hi[3] = { 0.2, 0.09, 0.24 };
    const double turn = draw_turn(r);
    double size[3];

    draw_size(r, lo, hi, size);
    add(arena, c, primitive_box(arena, size, 0.0015), printed(pattern_label(arena, r), 0.04f, 25),
        origin, turn);
    c->radius = hypot(size[0], size[1]) / 2;
}

static void make_books(lt_arena *arena, lt_rng *r, clutter *c)
{
    static const double lo[3] = { 0.11, 0.17, 0.012 }, hi[3] = { 0.16, 0.22, 0.04 };
    const int n = 1 + (int)lt_rng_below(r, CLUTTER_PARTS);
    const double turn = draw_turn(r);
    double at[3] = { 0, 0, 0 }, size[3];

    for (int i = 0; i < n; i++) {
        const double askew = turn + lt_rng_range(r, -0.2, 0.2);

        draw_size(r, lo, hi, size);
        add(arena, c, primitive_box(arena, size, 0.0015), printed(pattern_label(arena, r), 0.03f, 20),
            at, askew);
        at[2] += size[2];
    }
    c->radius = 0.13;
}

static void make_bowl(lt_arena *arena, lt_rng *r, clutter *c)
{
    const float radius = draw(r, 0.06, 0.1);
    const float h = draw(r, 0.035, 0.08);
    float profile[16][2];

    for (int i = 0; i < 8; i++) {
        const double a = 0.5 * M_PI * (i + 1) / 8;

        profile[i][0] = radius * (float)sin(a);
        profile[i][1] = h * (1 - (float)cos(a));
        profile[15 - i][0] = (radius - 0.004f) * (float)sin(a);
        profile[15 - i][1] = 0.004f + (h - 0.003f) * (1 - (float)cos(a));
    }
    profile[15][0] = 0;
    add(arena, c, primitive_lathe(arena, (const float (*)[2])profile, 16, SEGMENTS),
        painted(r, 0.7, 0.3, 0.97, 70), origin, 0);
    c->radius = radius;
}

/* An apple, an orange, a lemon: a ball pulled in at the poles or drawn out. */
static void make_fruit(lt_arena *arena, lt_rng *r, clutter *c)
{
    const float radius = draw(r, 0.03, 0.042);
    const double dimple = lt_rng_range(r, -0.15, 0.3), turn = draw_turn(r);
    float profile[18][2], lowest = 0;

    for (int i = 0; i < 18; i++) {
        const double a = M_PI * i / 17, pull = 1 - dimple * exp(-12 * (1 - fabs(cos(a))));

        profile[i][0] = radius * (float)sin(a) + 1e-5f;
        profile[i][1] = radius * -0.92f * (float)(cos(a) * pull);
        lowest = fminf(lowest, profile[i][1]);
    }
    for (int i = 0; i < 18; i++)
        profile[i][1] -= lowest;
    add(arena, c, primitive_lathe(arena, (const float (*)[2])profile, 18, SEGMENTS),
        printed(pattern_fruit(arena, r), 0.04f, 35), origin, turn);
    c->radius = radius;
}

/* A page or a cloth: thin and flat. */
static void make_flat(lt_arena *arena, lt_rng *r, clutter *c)
{
    static const double lo[3] = { 0.09, 0.1, 0 }, hi[3] = { 0.17, 0.2, 0 };
    const double at[3] = { 0, 0, 0.002 }, turn = draw_turn(r);
    const uint32_t kind = lt_rng_below(r, 4);
    double size[3];

    draw_size(r, lo, hi, size);
    add(arena, c, primitive_sheet(arena, size[0], size[1], 1, 1),
        printed(kind == 0 ? pattern_checks(arena, r) :
                kind == 1 ? pattern_stripes(arena, r) : pattern_page(arena, r), 0.01f, 8),
        at, turn);
    c->radius = hypot(size[0], size[1]) / 2;
}

/* A telephone, a remote control: a slab with a dark glossy front. */
static void make_slab(lt_arena *arena, lt_rng *r, clutter *c)
{
    static const double lo[3] = { 0.045, 0.13, 0.008 }, hi[3] = { 0.08, 0.17, 0.02 };
    const synth_material glass = { .albedo = { 0.01f, 0.01f, 0.012f }, .specular = 0.06f, .shininess = 200 };
    const double turn = draw_turn(r);
    double size[3];

    draw_size(r, lo, hi, size);
    const double at[3] = { 0, 0, size[2] + 2e-4 };

    add(arena, c, primitive_box(arena, size, 0.003), painted(r, 0.2, 0.05, 0.5, 40), origin, turn);
    add(arena, c, primitive_sheet(arena, size[0] - 0.008, size[1] - 0.008, 1, 1), glass, at, turn);
    c->radius = hypot(size[0], size[1]) / 2;
}

/* A roll of tape or kitchen paper. */
static void make_roll(lt_arena *arena, lt_rng *r, clutter *c)
{
    const float radius = draw(r, 0.03, 0.06);
    const float hole = radius * draw(r, 0.3, 0.7);
    const bool low = lt_rng_below(r, 2);
    const float h = low ? draw(r, 0.015, 0.04) : draw(r, 0.1, 0.24);
    const float ring[5][2] = { { hole, 0 }, { radius, 0 }, { radius, h }, { hole, h }, { hole, 0 } };

    add(arena, c, primitive_lathe(arena, ring, 5, SEGMENTS), painted(r, 0.6, 0.3, 0.97, 15), origin, 0);
    c->radius = radius;
}

bool clutter_make(lt_arena *arena, lt_rng *r, clutter *out)
{
    static void (*const kinds[])(lt_arena *, lt_rng *, clutter *) = {
        make_can, make_bottle, make_mug, make_box, make_box, make_books, make_bowl, make_fruit,
        make_fruit, make_flat, make_slab, make_roll,
    };

    memset(out, 0, sizeof(*out));
    kinds[lt_rng_below(r, LT_COUNT(kinds))](arena, r, out);
    return out->n_parts > 0;
}
