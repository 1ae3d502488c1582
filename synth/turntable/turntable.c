/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/turntable/turntable.h"

#include "assets/ycb/objects.h"
#include "libtensor/base/rng.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/ply.h"
#include "synth/preset.h"
#include "synth/render/render.h"
#include "synth/take/prop.h"
#include "synth/write/growing.h"

#include <math.h>
#include <string.h>

enum { MOST_VIEWS = 9999, ROUNDS = 3, OBJECT = 1 };

static const double LOWEST = 0.1, HIGHEST = 1.0;        /* radians above the horizon */
static const double NEAREST = 0.45, FILLS = 0.7;        /* metres; of the picture's width */

typedef struct {
    const synth_options *opt;
    lt_arena *arena;
    synth_prop prop;
    double middle[3], diameter, distance;
    synth_scene scene;
    synth_instance instance;
    synth_light lamp[2];
    synth_frame *frame;
    synth_growing json;
    synth_manifest manifest;
} run;

/* ---- the scene ------------------------------------------------------------------------------------------- */

static void find_middle(run *r)
{
    const lt_mesh *m = &r->prop.mesh;
    double square = 0;

    for (int k = 0; k < 3; k++) {
        double lo = INFINITY, hi = -INFINITY;

        for (int i = 0; i < m->n_vertices; i++) {
            lo = fmin(lo, (double)m->vertex[i][k]);
            hi = fmax(hi, (double)m->vertex[i][k]);
        }
        r->middle[k] = 0.5 * (lo + hi);
        square += (hi - lo) * (hi - lo);
    }
    r->diameter = sqrt(square);
    r->distance = fmax(NEAREST, 2.5 * r->diameter);
}

static synth_light lamp_at(const run *r, double turn, double above, float bright)
{
    const double far = 4 * r->diameter;
    const synth_light l = {
        .position = { r->middle[0] + far * cos(turn) * cos(above), r->middle[1] + far * sin(turn) * cos(above),
                      r->middle[2] + far * sin(above) },
        .radius = 0.3 * r->diameter, .color = { bright, bright, bright },
    };

    return l;
}

static lt_status make_scene(run *r)
{
    lt_rng rng = lt_rng_make(r->opt->seed, 0x7475726e);
    const int id = 1 + (int)(lt_rng_uniform(&rng) * YCB_COUNT);
    const double turn = 2 * M_PI * lt_rng_uniform(&rng);
    const lt_status st = synth_prop_new_bare(r->arena, id, &r->prop);

    if (st)
        return st;
    find_middle(r);
    r->instance = (synth_instance){
        .mesh = &r->prop.mesh, .R_world_obj = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .label = OBJECT,
        .material = { .albedo = { 1, 1, 1 }, .specular = 0.02f, .shininess = 20, .texture = r->prop.texture },
    };
    r->lamp[0] = lamp_at(r, turn, 0.9, 0.6f);
    r->lamp[1] = lamp_at(r, turn + 2.5, 0.5, 0.25f);
    r->scene = (synth_scene){
        .instance = &r->instance, .n_instances = 1, .light = r->lamp, .n_lights = 2,
        .sky = { 0.35f, 0.35f, 0.35f }, .ground = { 0.2f, 0.2f, 0.2f }, .up = { 0, 0, 1 },
        .focus_radius = r->diameter, .target = OBJECT,
    };
    memcpy(r->scene.focus, r->middle, sizeof(r->middle));
    r->frame = synth_frame_new(TURNTABLE_SIDE, TURNTABLE_SIDE);
    return r->frame ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for a picture");
}

/* View i of n: some rounds about the object, ever higher, looking at its middle */
static synth_camera camera_at(const run *r, int i, int n)
{
    const double at = (i + 0.5) / n, turn = 2 * M_PI * ROUNDS * at, above = LOWEST + (HIGHEST - LOWEST) * at;
    const double from[3] = { cos(turn) * cos(above), sin(turn) * cos(above), sin(above) };
    const double R[9] = { -sin(turn), cos(turn), 0,
                          cos(turn) * sin(above), sin(turn) * sin(above), -cos(above),
                          -from[0], -from[1], -from[2] };
    const double focal = FILLS * TURNTABLE_SIDE * r->distance / r->diameter, centre = 0.5 * TURNTABLE_SIDE - 0.5;
    synth_camera c = { .fx = focal, .fy = focal, .cx = centre, .cy = centre, .width = TURNTABLE_SIDE,
                       .height = TURNTABLE_SIDE };

    memcpy(c.R_cam_world, R, sizeof(R));
    for (int k = 0; k < 3; k++)
        for (int b = 0; b < 3; b++)
            c.t_cam_world[k] -= R[3 * k + b] * (r->middle[b] + r->distance * from[b]);
    return c;
}

/* ---- files ----------------------------------------------------------------------------------------------- */

static lt_status write_png(run *r, const char *within, int channels, const void *data)
{
    const lt_image im = { TURNTABLE_SIDE, TURNTABLE_SIDE, channels, 8, (uint8_t *)(uintptr_t)data };
    lt_arena *scratch = lt_arena_new();
    const char *path = scratch ? lt_path_join(scratch, r->opt->out, within) : NULL;
    const lt_status st = path ? lt_png_write_fast(path, &im) : lt_error(LT_ENOMEM, "synth: no memory");

    lt_arena_free(scratch);
    return st ? st : synth_manifest_file(&r->manifest, r->opt->out, within);
}

/* Camera to world, x right, y up, z backward */
static void print_matrix(FILE *f, const synth_camera *c)
{
    fprintf(f, "\"transform_matrix\": [");
    for (int i = 0; i < 3; i++) {
        const double *R = c->R_cam_world, *t = c->t_cam_world;

        fprintf(f, "[%.9f, %.9f, %.9f, %.9f], ", R[i], -R[3 + i], -R[6 + i],
                -(R[i] * t[0] + R[3 + i] * t[1] + R[6 + i] * t[2]));
    }
    fprintf(f, "[0, 0, 0, 1]]}");
}

static void add_frame(run *r, int i, const synth_camera *c)
{
    FILE *f = r->json.stream;

    fprintf(f, "%s\n  {\"file_path\": \"images/%04d.png\", \"mask_path\": \"masks/%04d.png\", \"fl_x\": %.6f, "
            "\"fl_y\": %.6f, \"cx\": %g, \"cy\": %g, \"w\": %d, \"h\": %d, \"k1\": 0, "
            "\"k2\": 0, \"p1\": 0, \"p2\": 0,\n   ",
            i ? "," : "", i, i, c->fx, c->fy, c->cx + 0.5, c->cy + 0.5, c->width, c->height);
    print_matrix(f, c);
}

static lt_status write_view(run *r, int i, int n)
{
    const synth_sensor sensor = { .exposure = 1, .white = { 1, 1, 1 }, .gamma = 1 };
    char name[64];
    lt_status st;

    r->scene.camera = camera_at(r, i, n);
    st = synth_render(&r->scene, r->frame);
    if (st)
        return st;
    synth_sensor_image(&sensor, r->frame);
    snprintf(name, sizeof(name), "images/%04d.png", i);
    st = write_png(r, name, 3, r->frame->rgb);
    snprintf(name, sizeof(name), "masks/%04d.png", i);
    if (!st)
        st = write_png(r, name, 1, r->frame->object_mask);
    if (!st)
        add_frame(r, i, &r->scene.camera);
    return st;
}

static lt_status write_points(run *r)
{
    lt_mesh m = r->prop.mesh;
    const char *path = lt_path_join(r->arena, r->opt->out, "points.ply");
    lt_status st;

    m.color = lt_arena_array(r->arena, (size_t)m.n_vertices, sizeof(*m.color));
    if (!path || !m.color)
        return lt_error(LT_ENOMEM, "synth: no memory for points");
    for (int i = 0; i < m.n_vertices; i++) {
        const int x = (int)((double)m.uv[i][0] * (SYNTH_TEXTURE - 1));
        const int y = (int)((1 - (double)m.uv[i][1]) * (SYNTH_TEXTURE - 1));
        const int64_t texel = (int64_t)(y & (SYNTH_TEXTURE - 1)) * SYNTH_TEXTURE + (x & (SYNTH_TEXTURE - 1));

        for (int k = 0; k < 3; k++)
            m.color[i][k] = r->prop.rgb[texel][k] / 255.0f;
    }
    m.n_faces = 0;
    m.uv = NULL;
    m.normal = NULL;
    st = lt_ply_write_mesh(path, &m);
    return st ? st : synth_manifest_file(&r->manifest, r->opt->out, "points.ply");
}

/* ---- the whole ------------------------------------------------------------------------------------------- */

static lt_status write_views(run *r, int n)
{
    lt_status st = synth_growing_open(&r->json, "transforms.json");

    if (st)
        return st;
    fprintf(r->json.stream, "{\"camera_model\": \"OPENCV\", \"ply_file_path\": \"points.ply\", \"frames\": [");
    for (int i = 0; i < n && !st; i++) {
        st = write_view(r, i, n);
        st = st ? st : synth_tell(r->opt, "views", "views", i + 1, n);
    }
    fprintf(r->json.stream, "\n]}\n");
    return st ? st : synth_growing_write(&r->json, r->opt->out, "transforms.json", &r->manifest);
}

lt_status synth_turntable(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n)
{
    static const char *const folders[] = { "images", "masks" };
    const int views = options->frames ? options->frames : TURNTABLE_VIEWS;
    run r = { .opt = options, .arena = lt_arena_new() };
    lt_status st = LT_OK;

    (void)figures;
    if (!r.arena)
        return lt_error(LT_ENOMEM, "synth: no memory");
    r.manifest = (synth_manifest){ .arena = r.arena, .layout = "transforms", .axes = "opengl", .width = TURNTABLE_SIDE,
                                   .height = TURNTABLE_SIDE };
    if (views > MOST_VIEWS)
        st = lt_error(LT_EINVAL, "%d views of a turntable, want at most %d", views, MOST_VIEWS);
    if (!st)
        st = make_scene(&r);
    if (!st)
        st = synth_folders(options->out, folders, LT_COUNT(folders));
    if (!st)
        st = write_views(&r, views);
    if (!st)
        st = write_points(&r);
    if (!st)
        st = synth_manifest_write(&r.manifest, options, NULL);
    *n = 0;
    synth_growing_fini(&r.json);
    synth_frame_free(r.frame);
    lt_arena_free(r.arena);
    return st;
}
