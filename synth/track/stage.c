/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/track/stage.h"

#include "libtensor/geometry/mat3.h"
#include "synth/room/pattern.h"
#include "synth/room/primitive.h"
#include "synth/take/clearing.h"
#include "synth/take/view.h"

#include <math.h>
#include <string.h>

enum { HALL = 0x48414c4c, TABLE = 0x5441424c, SCREEN = 0x5343524e };

typedef struct {
    lt_arena *arena;
    lt_rng r;
    track_stage *stage;
    bool failed;
} builder;

typedef synth_texture *(*pattern)(lt_arena *arena, lt_rng *r);

static synth_texture *draw_pattern(builder *b)
{
    static const pattern all[] = { pattern_wood, pattern_stone, pattern_plaster, pattern_stripes, pattern_checks,
                                   pattern_tiles };

    return all[lt_rng_below(&b->r, LT_COUNT(all))](b->arena, &b->r);
}

static void put(builder *b, lt_mesh mesh, synth_texture *texture, const double R[9], const double t[3], bool shadow)
{
    synth_room *room = b->stage->room;
    synth_instance *in = &room->instance[room->n_instances];
    lt_mesh *kept = lt_arena_alloc(b->arena, sizeof(*kept));

    if (room->n_instances == SYNTH_ROOM_INSTANCES)
        return;
    if (!kept || !mesh.n_vertices || !texture) {
        b->failed = true;
        return;
    }
    *kept = mesh;
    *in = (synth_instance){ .mesh = kept, .no_shadow = !shadow,
                            .material = { .albedo = { 1, 1, 1 }, .texture = texture, .specular = 0.02f,
                                          .shininess = 10 } };
    memcpy(in->R_world_obj, R, sizeof(in->R_world_obj));
    memcpy(in->t_world_obj, t, sizeof(in->t_world_obj));
    room->n_instances++;
}

static const double flat[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, ceiling[9] = { 1, 0, 0, 0, -1, 0, 0, 0, -1 };
static const double back[9] = { 1, 0, 0, 0, 0, -1, 0, 1, 0 };                   /* looks towards the viewer */
static const double side[2][9] = { { 0, 0, 1, 1, 0, 0, 0, 1, 0 }, { 0, 0, -1, -1, 0, 0, 0, 1, 0 } };

/* ---- lanes and screens ---- */

/* Lanes from `first` on, `apart` from each other, and how far the view reaches at each. */
static void set_lanes(track_stage *s, double first, double apart)
{
    for (int i = 0; i < TRACK_LANES; i++) {
        const double p[3] = { 0, first + i * apart, 0 };
        double x[3];
        s->lane[i] = p[1];
        lt_rigid_apply(s->camera.R_cam_world, s->camera.t_cam_world, p, x);
        s->half[i] = x[2] * TRACK_WIDTH / 2 / s->camera.fx;
    }
}

/* Before a lane each, on either side of the view, wide enough to hide what is size wide in that lane, and nearer to the
 * lane in front of it, for what is carried is carried ahead. */
static void build_screens(builder *b, double size, double height, double thick)
{
    const double ahead = 0.6;                   /* from a lane to the one in front of it */
    track_stage *s = b->stage;

    for (int i = 0; i < TRACK_SCREENS; i++) {
        const int lane = 1 + i + (int)lt_rng_below(&b->r, 2);
        const double middle = (i ? 0.45 : -0.45) + lt_rng_range(&b->r, -0.15, 0.15);
        const double more = lt_rng_range(&b->r, 1.05, 1.6);
        const double y = s->lane[lane] + ahead * (s->lane[lane - 1] - s->lane[lane]);
        const double half = s->half[lane] + ahead * (s->half[lane - 1] - s->half[lane]);
        const double box[3] = { size * more, thick, height * lt_rng_range(&b->r, 1, 1.12) };
        const double at[3] = { middle * half, y, 0 };
        s->screen[i] = (track_screen){ middle, lane };
        put(b, primitive_box(b->arena, box, thick / 4), draw_pattern(b), flat, at, true);
    }
}

static lt_status paint(builder *b)
{
    synth_room *room = b->stage->room;

    for (int i = 0; !b->failed && i < room->n_instances; i++)
        if (room->instance[i].material.texture && !synth_texture_paint(room->instance[i].material.texture))
            b->failed = true;
    return b->failed ? lt_error(LT_ENOMEM, "synth: no memory for a place") : LT_OK;
}

/* ---- the hall ---- */

static void build_hall(builder *b)
{
    const double depth = lt_rng_range(&b->r, 5, 6.5), wide = lt_rng_range(&b->r, 5, 6.5), high = 3;
    const int pictures = 3 + (int)lt_rng_below(&b->r, 4);
    synth_texture *wall = draw_pattern(b), *floor = draw_pattern(b);

    put(b, primitive_sheet(b->arena, 20, 20, 14, 14), floor, flat, (const double[]){ 0, 0, 0 }, false);
    put(b, primitive_sheet(b->arena, 20, 20, 6, 6), pattern_plaster(b->arena, &b->r), ceiling,
        (const double[]){ 0, 0, high }, false);
    put(b, primitive_sheet(b->arena, 2 * wide, high, wide, high / 2), wall, back,
        (const double[]){ 0, depth, high / 2 }, false);
    for (int i = 0; i < 2; i++)
        put(b, primitive_sheet(b->arena, 20, high, 10, high / 2), wall, side[i],
            (const double[]){ i ? wide : -wide, 0, high / 2 }, false);
    for (int i = 0; i < pictures; i++) {
        const double width = lt_rng_range(&b->r, 0.5, 1.3), height = lt_rng_range(&b->r, 0.5, 1.2);
        const double x = lt_rng_range(&b->r, -wide + 1, wide - 1), z = lt_rng_range(&b->r, 1.2, 2.2);
        const pattern what = lt_rng_below(&b->r, 2) ? pattern_page : pattern_label;
        put(b, primitive_sheet(b->arena, width, height, 1, 1), what(b->arena, &b->r), back,
            (const double[]){ x, depth - 0.01, z }, false);
    }
}

static void light_hall(builder *b)
{
    synth_room *room = b->stage->room;
    const double strength = lt_rng_range(&b->r, 0.5, 0.85), ambient = lt_rng_range(&b->r, 0.35, 0.55);
    const double warm = lt_rng_range(&b->r, -0.12, 0.12);
    double around = lt_rng_range(&b->r, 0, 2 * M_PI);

    room->n_lights = 2;
    for (int i = 0; i < room->n_lights; i++) {
        synth_light *l = &room->light[i];
        *l = (synth_light){ .position = { 4 * cos(around), 2 + 3 * sin(around), 4.5 }, .radius = 0.3 };
        for (int c = 0; c < 3; c++)
            l->color[c] = (float)(strength / (1 + i) * (1 + warm * (1 - c)));
        around += lt_rng_range(&b->r, 1.5, 4.5);
    }
    for (int c = 0; c < 3; c++) {
        room->sky[c] = (float)ambient;
        room->ground[c] = (float)(0.6 * ambient);
    }
    room->up[2] = 1;
    room->focus[1] = 1.6;
    room->focus[2] = 0.9;
    room->focus_radius = 4;
}

static void set_camera(builder *b, const double eye[3], const double target[3], double f)
{
    synth_camera *c = &b->stage->camera;

    *c = (synth_camera){ .fx = f, .fy = f, .cx = (TRACK_WIDTH - 1) / 2., .cy = (TRACK_HEIGHT - 1) / 2.,
                         .width = TRACK_WIDTH, .height = TRACK_HEIGHT };
    synth_view_look(eye, target, 0, c);
}

lt_status track_hall_new(lt_arena *arena, uint64_t seed, uint64_t stream, track_stage *out)
{
    builder b = { .arena = arena, .r = lt_rng_make(seed, lt_rng_mix(stream, HALL)), .stage = out };
    const double aside = lt_rng_range(&b.r, -0.4, 0.4), high = lt_rng_range(&b.r, 1.3, 2);
    const double aim = lt_rng_range(&b.r, 0.75, 0.95), f = lt_rng_range(&b.r, 370, 430);

    memset(out, 0, sizeof(*out));
    out->room = lt_arena_alloc(arena, sizeof(*out->room));
    if (!out->room)
        return lt_error(LT_ENOMEM, "synth: no memory for a hall");
    set_camera(&b, (const double[]){ aside, -3.4, high }, (const double[]){ 0, 1.5, aim }, f);
    set_lanes(out, 0, 0.9);
    build_hall(&b);
    build_screens(&b, 0.85, 1.95, 0.06);
    light_hall(&b);
    return paint(&b);
}

/* ---- the table ---- */

/* What stands on the table gives way to the lanes. */
static void clear_lanes(builder *b)
{
    enum { STEPS = 9 };
    synth_ball ball[TRACK_LANES * STEPS];

    for (int i = 0; i < TRACK_LANES; i++)
        for (int k = 0; k < STEPS; k++)
            ball[i * STEPS + k] = (synth_ball){
                .centre = { b->stage->half[i] * (k - STEPS / 2) / (STEPS / 2), b->stage->lane[i], 0.15 },
                .radius = 0.15,
            };
    synth_clear_way(b->stage->room, ball, TRACK_LANES * STEPS);
}

lt_status track_table_new(lt_arena *arena, uint64_t seed, uint64_t stream, track_stage *out)
{
    builder b = { .arena = arena, .r = lt_rng_make(seed, lt_rng_mix(stream, TABLE)), .stage = out };
    const double aside = lt_rng_range(&b.r, -0.1, 0.1), high = lt_rng_range(&b.r, 0.35, 0.5);
    const double aim = lt_rng_range(&b.r, 0.1, 0.14), f = lt_rng_range(&b.r, 440, 500);

    memset(out, 0, sizeof(*out));
    out->room = synth_room_new(arena, seed, stream, 0.1);
    if (!out->room)
        return lt_error(LT_ENOMEM, "synth: no memory for a table");
    set_camera(&b, (const double[]){ aside, -0.95, high }, (const double[]){ 0, 0.1, aim }, f);
    set_lanes(out, -0.35, 0.22);
    clear_lanes(&b);
    build_screens(&b, 0.2, 0.24, 0.02);
    return paint(&b);
}
