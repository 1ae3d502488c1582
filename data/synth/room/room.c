/* SPDX-License-Identifier: Apache-2.0 */
/* Walls, floor, table, what hangs on the walls and stands on the table, and the lamps. */
#include "data/synth/room/clutter.h"
#include "data/synth/room/pattern.h"
#include "data/synth/room/primitive.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

enum { MAX_THINGS = 12 };

typedef struct {
    lt_arena *arena;
    lt_rng r;
    synth_room *room;
    double table[4];                /* x0 y0 x1 y1 */
    bool failed;
} builder;

/* Puts a mesh into the room; R may be NULL for the identity. */
static synth_instance *put(builder *b, lt_mesh mesh, synth_material material, const double *R, const double t[3])
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

static synth_material matt(const synth_texture *texture, double specular, double shininess)
{
    return (synth_material){ .albedo = { 1, 1, 1 }, .texture = texture, .specular = (float)specular,
                             .shininess = (float)shininess };
}

/* ---- walls ----------------------------------------------------------------------------------- */

/* A sheet stands up against a wall: its x runs along the wall, its y up, its front into the room. */
static void wall_rotation(int wall, double R[9])
{
    const double a = -0.5 * PI * wall, c = cos(a), s = sin(a);
    const double M[9] = { c, 0, s, s, 0, -c, 0, 1, 0 };

    memcpy(R, M, sizeof(M));
}

/* Where (along, up) on a wall lies, off metres in front of it. */
static void wall_point(int wall, double distance, double along, double up, double off, double out[3])
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
    const uint32_t kind = lt_rng_below(&b->r, 5);
    synth_material m = matt(NULL, 0.04, 20), frame = matt(NULL, 0.04, 30);
    double R[9], t[3];

    if (kind == 0) {
        for (int c = 0; c < 3; c++)
            m.albedo[c] = (float)lt_rng_range(&b->r, 1.6, 2.4);
    } else {
        m.texture = kind == 1 ? pattern_page(b->arena, &b->r) : kind == 2 ? pattern_wood(b->arena, &b->r) :
                                                                          pattern_label(b->arena, &b->r);
    }
    for (int c = 0; c < 3; c++)
        frame.albedo[c] = kind == 0 ? 0.75f : (float)lt_rng_range(&b->r, 0.02, 0.6);
    wall_rotation(wall, R);
    wall_point(wall, distance, along, up, 0.01, t);
    put(b, primitive_sheet(b->arena, width + 0.05, height + 0.05, 1, 1), frame, R, t);
    wall_point(wall, distance, along, up, 0.014, t);
    put(b, primitive_sheet(b->arena, width, height, 1, 1), m, R, t);
}

/* Furniture before a wall: a box with a face of boards. */
static void furnish(builder *b, int wall, double distance)
{
    const double size[3] = { lt_rng_range(&b->r, 0.4, 1.1), lt_rng_range(&b->r, 0.2, 0.4), lt_rng_range(&b->r, 0.5, 1.7) };
    const double turn = -0.5 * PI * wall, R[9] = { cos(turn), -sin(turn), 0, sin(turn), cos(turn), 0, 0, 0, 1 };
    double t[3];

    wall_point(wall, distance, lt_rng_range(&b->r, -1, 1), 0, size[1] / 2, t);
    t[2] = -0.75;
    put(b, primitive_box(b->arena, size, 0.004),
        matt(lt_rng_below(&b->r, 3) ? pattern_wood(b->arena, &b->r) : pattern_plaster(b->arena, &b->r), 0.04, 20), R, t);
}

static void build_walls(builder *b)
{
    synth_texture *paper = wall_texture(b);

    for (int wall = 0; wall < 4; wall++) {
        const double distance = lt_rng_range(&b->r, 1.35, 2.4), repeat = lt_rng_range(&b->r, 3, 7);
        const int decorations = 1 + (int)lt_rng_below(&b->r, 3);
        double R[9], t[3];

        wall_rotation(wall, R);
        wall_point(wall, distance, 0, 0.7, 0, t);
        put(b, primitive_sheet(b->arena, 8, 3.2, repeat, 0.4 * repeat), matt(paper, 0.02, 8), R, t);
        for (int i = 0; i < decorations; i++)
            decorate(b, wall, distance);
        if (distance > 1.8 || lt_rng_below(&b->r, 2))
            furnish(b, wall, distance);
    }
}

static void build_floor(builder *b)
{
    const double t[3] = { 0, 0, -0.75 };
    synth_texture *texture = lt_rng_below(&b->r, 2) ? pattern_wood(b->arena, &b->r) : pattern_tiles(b->arena, &b->r);

    put(b, primitive_sheet(b->arena, 8, 8, 6, 6), matt(texture, 0.03, 20), NULL, t);
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

    b->table[0] = -lt_rng_range(&b->r, 0.5, 1);
    b->table[1] = -lt_rng_range(&b->r, 0.35, 0.6);
    b->table[2] = lt_rng_range(&b->r, 0.5, 1);
    b->table[3] = lt_rng_range(&b->r, 0.35, 0.8);
    for (int k = 0; k < 2; k++) {
        size[k] = b->table[2 + k] - b->table[k];
        t[k] = (b->table[2 + k] + b->table[k]) / 2;
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
static bool find_place(builder *b, double radius, double clear, const double (*taken)[3], int n, double at[3])
{
    for (int attempt = 0; attempt < 40; attempt++) {
        const double x = lt_rng_range(&b->r, fmax(b->table[0], -0.65) + radius, fmin(b->table[2], 0.65) - radius);
        const double y = lt_rng_range(&b->r, b->table[1] + radius, b->table[3] - radius);
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

static void build_things(builder *b, double clear)
{
    const int wanted = 3 + (int)lt_rng_below(&b->r, MAX_THINGS - 2);
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

static void add_lamp(builder *b, double azimuth, double height_deg, double distance, double radius, double kelvin,
                     double strength)
{
    synth_light *l = &b->room->light[b->room->n_lights++];
    const double up = height_deg * PI / 180;

    l->position[0] = b->room->focus[0] + distance * cos(up) * cos(azimuth);
    l->position[1] = b->room->focus[1] + distance * cos(up) * sin(azimuth);
    l->position[2] = b->room->focus[2] + distance * sin(up);
    l->radius = radius;
    lamp_color(kelvin, strength, l->color);
}

/* A main light from any side but straight behind, a weaker one across from it, now and then a third. */
static void build_lamps(builder *b)
{
    lt_rng *r = &b->r;
    const double azimuth = lt_rng_range(r, 0, 2 * PI), ambient = lt_rng_range(r, 0.22, 0.42);
    const double main_kelvin = lt_rng_range(r, 3300, 7000), main_light = lt_rng_range(r, 0.65, 1.05);
    const int extra = (int)lt_rng_below(r, 3);

    add_lamp(b, azimuth, lt_rng_range(r, 32, 75), lt_rng_range(r, 1.0, 2.4), exp(lt_rng_range(r, log(0.02), log(0.25))),
             main_kelvin, main_light);
    if (extra > 0)
        add_lamp(b, azimuth + lt_rng_range(r, 1.5, 4.8), lt_rng_range(r, 20, 65), lt_rng_range(r, 1.2, 3),
                 lt_rng_range(r, 0.1, 0.45), lt_rng_range(r, 3000, 7000), main_light * lt_rng_range(r, 0.15, 0.5));
    if (extra > 1)
        add_lamp(b, azimuth + lt_rng_range(r, 1.5, 4.8), lt_rng_range(r, 60, 85), lt_rng_range(r, 1.5, 3),
                 lt_rng_range(r, 0.2, 0.5), lt_rng_range(r, 3500, 6500), main_light * lt_rng_range(r, 0.1, 0.35));
    lamp_color(lt_rng_range(r, 4200, 7000), ambient, b->room->sky);
    lamp_color(lt_rng_range(r, 3200, 5200), ambient * lt_rng_range(r, 0.4, 0.75), b->room->ground);
}

synth_room *synth_room_new(lt_arena *arena, uint64_t seed, uint64_t stream, double clear)
{
    synth_room *room = lt_arena_alloc(arena, sizeof(*room));
    builder b = { .arena = arena, .r = lt_rng_make(seed, lt_rng_mix(stream, 0x8003)), .room = room };

    if (!room)
        return NULL;
    room->up[2] = 1;
    room->focus[2] = 0.12;
    room->focus_radius = 0.62;
    build_floor(&b);
    build_table(&b);
    build_walls(&b);
    for (int i = 0; i < room->n_instances; i++)
        room->instance[i].no_shadow = true;
    build_things(&b, clear);
    build_lamps(&b);
    return b.failed ? NULL : room;
}

/* ---- moving it ------------------------------------------------------------------------------- */

static void turn(const double R[9], const double x[3], double out[3])
{
    double y[3];

    for (int i = 0; i < 3; i++)
        y[i] = R[3 * i] * x[0] + R[3 * i + 1] * x[1] + R[3 * i + 2] * x[2];
    memcpy(out, y, sizeof(y));
}

static void move_point(const double R[9], const double t[3], double x[3])
{
    turn(R, x, x);
    for (int i = 0; i < 3; i++)
        x[i] += t[i];
}

void synth_room_place(synth_room *room, const double R[9], const double t[3])
{
    const double up[3] = { room->up[0], room->up[1], room->up[2] };
    double turned[3];

    for (int i = 0; i < room->n_instances; i++) {
        synth_instance *in = &room->instance[i];
        double M[9];

        for (int row = 0; row < 3; row++)
            for (int col = 0; col < 3; col++)
                M[3 * row + col] = R[3 * row] * in->R_world_obj[col] + R[3 * row + 1] * in->R_world_obj[3 + col] +
                                   R[3 * row + 2] * in->R_world_obj[6 + col];
        memcpy(in->R_world_obj, M, sizeof(M));
        move_point(R, t, in->t_world_obj);
    }
    for (int i = 0; i < room->n_lights; i++)
        move_point(R, t, room->light[i].position);
    move_point(R, t, room->focus);
    turn(R, up, turned);
    for (int i = 0; i < 3; i++)
        room->up[i] = (float)turned[i];
}
