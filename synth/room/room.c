/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Walls, floor, table, what hangs on the walls and stands on the table, and the lamps. Every draw stands
 * in a statement of its own, as C leaves the order of arguments open.
 */
#include "libtensor/geometry/mat3.h"
#include "synth/room/clutter.h"
#include "synth/room/pattern.h"
#include "synth/room/primitive.h"

#include <math.h>
#include <string.h>

enum { MAX_THINGS = 12 };

typedef struct {
    lt_arena *arena;
    lt_rng r;
    synth_room *room;
    const synth_room_measures *measures;        /* NULL: drawn */
    bool failed;
} builder;

/* Puts a mesh into the room; R may be NULL for the identity. */
static synth_instance *put(builder *b, lt_mesh mesh, synth_material material, const double *R,
                           const double t[3])
{
    static const double identity[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 };
    lt_mesh *kept = lt_arena_alloc(b->arena, sizeof(*kept));
    synth_instance *in = &b->room->instance[b->room->n_instances];

    if (b->room->n_instances == SYNTH_ROOM_INSTANCES)
        return NULL;
    if (!kept || mesh.n_vertices == 0) {
        b->failed = true;
        return NULL;
    }
    *kept = mesh;
    memset(in, 0, sizeof(*in));
    in->mesh = kept;
    in->material = material;
    memcpy(in->R_world_obj, R ? R : identity, sizeof(in->R_world_obj));
    memcpy(in->t_world_obj, t, sizeof(in->t_world_obj));
    b->room->n_instances++;
    return in;
}

static synth_material matt(synth_texture *texture, double specular, double shininess)
{
    return (synth_material){ .albedo = { 1, 1, 1 }, .texture = texture, .specular = (float)specular,
                             .shininess = (float)shininess };
}

/* ---- walls ----------------------------------------------------------------------------------- */

/* A sheet stands up against a wall: its x runs along the wall, its y up, its front into the room. */
static void wall_rotation(int wall, double R[9])
{
    const double a = -0.5 * M_PI * wall, c = cos(a), s = sin(a);
    const double M[9] = { c, 0, s, s, 0, -c, 0, 1, 0 };

    memcpy(R, M, sizeof(M));
}

/* Where (along, up) on a wall lies, off metres in front of it. */
static void wall_point(int wall, double distance, double along, double up, double off,
                       double out[3])
{
    double R[9];

    wall_rotation(wall, R);
    for (int k = 0; k < 3; k++)
        out[k] = R[3 * k] * along + R[3 * k + 1] * up - (distance - off) * R[3 * k + 2];
}

static synth_texture *wall_texture(builder *b)
{
    switch (lt_rng_below(&b->r, 6)) {
    case 0: return pattern_tiles(b->arena, &b->r);
    case 1: return pattern_wood(b->arena, &b->r);
    case 2: return pattern_stripes(b->arena, &b->r);
    default: return pattern_plaster(b->arena, &b->r);
    }
}

/* A picture, a cupboard door, or a bright window. */
static void decorate(builder *b, int wall, double distance)
{
    const double width = lt_rng_range(&b->r, 0.25, 0.9), height = lt_rng_range(&b->r, 0.25, 0.9);
    const double along = lt_rng_range(&b->r, -0.9, 0.9), up = lt_rng_range(&b->r, 0, 0.8);
    synth_material m = matt(NULL, 0.04, 20), frame = matt(NULL, 0.04, 30);
    double R[9], t[3];

    for (int c = 0; c < 3; c++)
        frame.albedo[c] = (float)lt_rng_range(&b->r, 0.02, 0.7);
    switch (lt_rng_below(&b->r, 5)) {
    case 0: m.albedo[0] = m.albedo[1] = m.albedo[2] = (float)lt_rng_range(&b->r, 1.6, 2.4); break;
    case 1: m.texture = pattern_page(b->arena, &b->r); break;
    case 2: m.texture = pattern_wood(b->arena, &b->r); break;
    default: m.texture = pattern_label(b->arena, &b->r);
    }
    wall_rotation(wall, R);
    wall_point(wall, distance, along, up, 0.01, t);
    put(b, primitive_sheet(b->arena, width + 0.05, height + 0.05, 1, 1), frame, R, t);
    wall_point(wall, distance, along, up, 0.014, t);
    put(b, primitive_sheet(b->arena, width, height, 1, 1), m, R, t);
}

/* Furniture before a wall: a box with a face of boards. */
static void furnish(builder *b, int wall, double distance)
{
    static const double lo[3] = { 0.4, 0.2, 0.5 }, hi[3] = { 1.1, 0.4, 1.7 };
    const double c = cos(-0.5 * M_PI * wall), s = sin(-0.5 * M_PI * wall), R[9] = { c, -s, 0, s, c, 0, 0, 0, 1 };
    const bool wooden = lt_rng_below(&b->r, 3) > 0;
    double size[3], t[3];

    for (int k = 0; k < 3; k++)
        size[k] = lt_rng_range(&b->r, lo[k], hi[k]);
    wall_point(wall, distance, lt_rng_range(&b->r, -1, 1), 0, size[1] / 2, t);
    t[2] = -0.75;
    put(b, primitive_box(b->arena, size, 0.004),
        matt((wooden ? pattern_wood : pattern_plaster)(b->arena, &b->r), 0.04, 20), R, t);
}

/* Metres of a wall, and of the floor's sides */
static double wide(const builder *b) { return b->measures ? 9 : 8; }

static void build_walls(builder *b)
{
    const double near = b->measures ? b->measures->walls[0] : 1.35, far = b->measures ? b->measures->walls[1] : 2.4;
    synth_texture *paper = wall_texture(b);

    for (int wall = 0; wall < 4; wall++) {
        const double distance = lt_rng_range(&b->r, near, far), repeat = lt_rng_range(&b->r, 3, 7);
        const int decorations = 1 + (int)lt_rng_below(&b->r, 3);
        double R[9], t[3];

        wall_rotation(wall, R);
        wall_point(wall, distance, 0, 0.7, 0, t);
        put(b, primitive_sheet(b->arena, wide(b), 3.2, wide(b) / 8 * repeat, 0.4 * repeat), matt(paper, 0.02, 8), R, t);
        for (int i = 0; i < decorations; i++)
            decorate(b, wall, distance);
        if (distance > 1.8 || lt_rng_below(&b->r, 2))
            furnish(b, wall, distance);
    }
}

static void build_floor(builder *b)
{
    const double t[3] = { 0, 0, -0.75 };
    const bool wooden = lt_rng_below(&b->r, 2);

    put(b, primitive_sheet(b->arena, wide(b), wide(b), 0.75 * wide(b), 0.75 * wide(b)),
        matt((wooden ? pattern_wood : pattern_tiles)(b->arena, &b->r), 0.03, 20), NULL, t);
}

/* ---- the table ------------------------------------------------------------------------------- */

static synth_texture *table_texture(builder *b)
{
    switch (lt_rng_below(&b->r, 9)) {
    case 0: return pattern_checks(b->arena, &b->r);
    case 1: return pattern_stripes(b->arena, &b->r);
    case 2: return pattern_tiles(b->arena, &b->r);
    case 3: return pattern_stone(b->arena, &b->r);
    case 4: return pattern_plaster(b->arena, &b->r);
    default: return pattern_wood(b->arena, &b->r);
    }
}

static void build_table(builder *b)
{
    synth_texture *texture = table_texture(b);
    const double gloss = lt_rng_range(&b->r, 0.01, 0.05), shininess = lt_rng_range(&b->r, 8, 60);
    const double repeat = lt_rng_range(&b->r, 1, 2.5);
    double size[3], t[3];
    synth_instance *edge;

    b->room->table[0] = -lt_rng_range(&b->r, 0.5, 1);
    b->room->table[1] = -lt_rng_range(&b->r, 0.35, 0.6);
    b->room->table[2] = lt_rng_range(&b->r, 0.5, 1);
    b->room->table[3] = lt_rng_range(&b->r, 0.35, 0.8);
    if (b->measures)
        memcpy(b->room->table, b->measures->table, sizeof(b->room->table));
    for (int k = 0; k < 2; k++) {
        size[k] = b->room->table[2 + k] - b->room->table[k];
        t[k] = (b->room->table[2 + k] + b->room->table[k]) / 2;
    }
    t[2] = 0;
    put(b, primitive_sheet(b->arena, size[0], size[1], repeat * size[0], repeat * size[1]),
        matt(texture, gloss, shininess), NULL, t);
    size[2] = lt_rng_range(&b->r, 0.02, 0.04);
    size[0] += 0.004;
    size[1] += 0.004;
    t[2] = -size[2] - 0.001;
    edge = put(b, primitive_box(b->arena, size, 0.005), matt(texture, gloss, shininess), NULL, t);
    if (edge)
        edge->no_shadow = true;
}

/* A free place for a thing of this radius on the table; false after some tries. */
static bool find_place(builder *b, double radius, double clear, const double (*taken)[3], int n,
                       double at[3])
{
    const double left = fmax(b->room->table[0], -0.65), right = fmin(b->room->table[2], 0.65);

    for (int attempt = 0; attempt < 40; attempt++) {
        const double x = lt_rng_range(&b->r, left + radius, right - radius);
        const double y = lt_rng_range(&b->r, b->room->table[1] + radius, b->room->table[3] - radius);
        bool free = hypot(x, y) > clear + radius;

        for (int i = 0; i < n && free; i++)
            free = hypot(x - taken[i][0], y - taken[i][1]) > taken[i][2] + radius + 0.005;
        if (free) {
            at[0] = x;
            at[1] = y;
            at[2] = 0;
            return true;
        }
    }
    return false;
}

static void build_things(builder *b, double clear, int most)
{
    const int drawn = 3 + (int)lt_rng_below(&b->r, MAX_THINGS - 2), wanted = drawn < most ? drawn : most;
    double taken[MAX_THINGS][3];
    int n = 0;

    for (int i = 0; i < wanted; i++) {
        clutter c;
        double at[3];

        if (!clutter_make(b->arena, &b->r, &c)) {
            b->failed = true;
            return;
        }
        if (!find_place(b, c.radius, clear, (const double (*)[3])taken, n, at))
            continue;
        for (int k = 0; k < c.n_parts && b->room->n_instances < SYNTH_ROOM_INSTANCES; k++) {
            synth_instance *in = &b->room->instance[b->room->n_instances++];

            *in = c.part[k];
            for (int d = 0; d < 3; d++)
                in->t_world_obj[d] += at[d];
        }
        taken[n][0] = at[0];
        taken[n][1] = at[1];
        taken[n++][2] = c.radius;
    }
}

/* ---- lamps ----------------------------------------------------------------------------------- */

/* Linear RGB of a lamp as a camera balanced for 5000 K sees it, green kept at 1. */
static void lamp_color(double kelvin, double strength, float rgb[3])
{
    const double x = log(kelvin / 5000);

    rgb[0] = (float)(strength * exp(-0.72 * x));
    rgb[1] = (float)strength;
    rgb[2] = (float)(strength * exp(1.05 * x));
}

/* What a lamp may be: its height over the table, distance and size, temperature, share of light. */
typedef struct {
    double degrees[2], distance[2], log_radius[2], kelvin[2], strength[2];
} lamp_range;

static double draw(lt_rng *r, const double range[2])
{
    return lt_rng_range(r, range[0], range[1]);
}

static void add_lamp(builder *b, const lamp_range *k, double azimuth, double strength)
{
    synth_light *l = &b->room->light[b->room->n_lights++];
    const double up = draw(&b->r, k->degrees) * M_PI / 180, distance = draw(&b->r, k->distance);
    const double kelvin = draw(&b->r, k->kelvin), share = draw(&b->r, k->strength);

    l->position[0] = b->room->focus[0] + distance * cos(up) * cos(azimuth);
    l->position[1] = b->room->focus[1] + distance * cos(up) * sin(azimuth);
    l->position[2] = b->room->focus[2] + distance * sin(up);
    l->radius = exp(draw(&b->r, k->log_radius));
    lamp_color(kelvin, strength * share, l->color);
}

/* A main light, two times in three a weaker one from another side, and one in three a third from above. */
static void build_lamps(builder *b)
{
    static const lamp_range ranges[3] = {
        { { 32, 75 }, { 1, 2.4 }, { -3.9, -1.4 }, { 3300, 7000 }, { 1, 1 } },
        { { 20, 65 }, { 1.2, 3 }, { -2.3, -0.8 }, { 3000, 7000 }, { 0.15, 0.5 } },
        { { 60, 85 }, { 1.5, 3 }, { -1.6, -0.7 }, { 3500, 6500 }, { 0.1, 0.35 } },
    };
    const double strength = lt_rng_range(&b->r, 0.65, 1.05), ambient = lt_rng_range(&b->r, 0.22, 0.42);
    const double day = lt_rng_range(&b->r, 4200, 7000), floor = lt_rng_range(&b->r, 3200, 5200);
    const int n = 1 + (int)lt_rng_below(&b->r, 3);
    double azimuth = lt_rng_range(&b->r, 0, 2 * M_PI);

    for (int i = 0; i < n; i++) {
        add_lamp(b, &ranges[i], azimuth, strength);
        azimuth += lt_rng_range(&b->r, 1.5, 4.8);
    }
    lamp_color(day, ambient, b->room->sky);
    lamp_color(floor, ambient * lt_rng_range(&b->r, 0.4, 0.75), b->room->ground);
}

/* A lamp goes up along its ray, out of the way of heads, and shines as brightly on the table. */
static void raise_lamps(builder *b)
{
    const double *at = b->room->focus;

    for (int i = 0; i < b->room->n_lights; i++) {
        double *p = b->room->light[i].position;
        const double by = fmax(1, (b->measures->lamps - at[2]) / (p[2] - at[2]));

        for (int k = 0; k < 3; k++)
            p[k] = at[k] + by * (p[k] - at[k]);
    }
}

static synth_room *build(builder *b, double clear, int things)
{
    synth_room *room = b->room;

    if (!room)
        return NULL;
    room->up[2] = 1;
    room->focus[2] = 0.12;
    room->focus_radius = 0.62;
    build_floor(b);
    build_table(b);
    build_walls(b);
    for (int i = 0; i < room->n_instances; i++)
        room->instance[i].no_shadow = true;
    build_things(b, clear, things);
    build_lamps(b);
    if (b->measures)
        raise_lamps(b);
    return b->failed ? NULL : room;
}

synth_room *synth_room_new(lt_arena *arena, uint64_t seed, uint64_t stream, double clear)
{
    builder b = { .arena = arena, .r = lt_rng_make(seed, lt_rng_mix(stream, 0x8003)),
                  .room = lt_arena_alloc(arena, sizeof(*b.room)) };

    return build(&b, clear, MAX_THINGS);
}

synth_room *synth_room_new_of(lt_arena *arena, uint64_t seed, uint64_t stream, const synth_room_measures *measures,
                              int things)
{
    builder b = { .arena = arena, .r = lt_rng_make(seed, lt_rng_mix(stream, 0x8003)),
                  .room = lt_arena_alloc(arena, sizeof(*b.room)), .measures = measures };

    return build(&b, measures->clear, things);
}

/* ---- painting it ----------------------------------------------------------------------------- */

/* Whether a mesh lies wholly beyond one side of a camera's pyramid, or two pixels past its edge. */
static bool out_of_sight(const synth_instance *in, const synth_camera *c)
{
    const double left = c->cx + 2, right = c->width + 1 - c->cx, top = c->cy + 2, below = c->height + 1 - c->cy;
    int beyond[5] = { 0 };

    for (int v = 0; v < in->mesh->n_vertices; v++) {
        const float *at = in->mesh->vertex[v];
        const double x[3] = { at[0], at[1], at[2] };
        double w[3], p[3];

        lt_rigid_apply(in->R_world_obj, in->t_world_obj, x, w);
        lt_rigid_apply(c->R_cam_world, c->t_cam_world, w, p);
        beyond[0] += p[2] < 0;
        beyond[1] += c->fx * p[0] + left * p[2] < 0;
        beyond[2] += right * p[2] - c->fx * p[0] < 0;
        beyond[3] += c->fy * p[1] + top * p[2] < 0;
        beyond[4] += below * p[2] - c->fy * p[1] < 0;
    }
    for (int i = 0; i < 5; i++)
        if (beyond[i] == in->mesh->n_vertices)
            return true;
    return false;
}

bool synth_room_paint(synth_room *room, const synth_camera *camera, int n)
{
    for (int i = 0; i < room->n_instances; i++) {
        const synth_instance *in = &room->instance[i];
        bool seen = false;

        for (int k = 0; k < n && in->material.texture; k++)
            seen |= !out_of_sight(in, &camera[k]);
        if (seen && !synth_texture_paint(in->material.texture))
            return false;
    }
    return true;
}
