/* SPDX-License-Identifier: Apache-2.0 */
/* The renderer's depth, labels and masks against geometry; the same bits on any number of threads. */
#include "libtensor/base/parallel.h"
#include "synth/render/render.h"
#include "synth/room/room.h"
#include "tests/suite.h"
#include "vision/drawing/draw.h"

#include <math.h>
#include <string.h>

enum { W = 160, H = 120, N = W * H };

static const double identity[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 };
static const synth_sensor plain_sensor = { .exposure = 1, .white = { 1, 1, 1 }, .gamma = 1 };
static lt_arena *arena;
static synth_frame *frame;

static void setup(void)
{
    arena = lt_arena_new();
    frame = synth_frame_new(W, H);
    ck_assert(arena && frame);
}

static void teardown(void)
{
    synth_frame_free(frame);
    lt_arena_free(arena);
    lt_set_threads(0);
}

/* ---- scenes ---------------------------------------------------------------------------------- */

static lt_mesh *mesh_new(int n_vertices, int n_faces)
{
    lt_mesh *m = lt_arena_alloc(arena, sizeof(*m));

    m->n_vertices = n_vertices;
    m->n_faces = n_faces;
    m->vertex = lt_arena_array(arena, (size_t)n_vertices, sizeof(*m->vertex));
    m->face = lt_arena_array(arena, (size_t)n_faces, sizeof(*m->face));
    return m;
}

static void set3(float v[3], double x, double y, double z)
{
    v[0] = (float)x;
    v[1] = (float)y;
    v[2] = (float)z;
}

/* A fan of triangles over a square about the z axis whose depth is z0 + ax x + ay y. */
static lt_mesh *plane(double half, double z0, double ax, double ay)
{
    static const int32_t faces[2][3] = { { 0, 2, 1 }, { 0, 3, 2 } };
    lt_mesh *m = mesh_new(4, 2);

    for (int i = 0; i < 4; i++) {
        const double x = i == 1 || i == 2 ? half : -half, y = i >= 2 ? half : -half;

        set3(m->vertex[i], x, y, z0 + ax * x + ay * y);
    }
    memcpy(m->face, faces, sizeof(faces));
    return m;
}

static lt_mesh *sphere(double radius, int n)
{
    lt_mesh *m = mesh_new((n + 1) * 2 * n, 4 * n * n);
    int f = 0;

    for (int v = 0; v < m->n_vertices; v++) {
        const double theta = M_PI * (v / (2 * n)) / n, phi = M_PI * (v % (2 * n)) / n;

        set3(m->vertex[v], radius * sin(theta) * cos(phi), radius * sin(theta) * sin(phi), radius * cos(theta));
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < 2 * n; j++) {
            const int a = i * 2 * n + j, b = i * 2 * n + (j + 1) % (2 * n);
            const int32_t two[2][3] = { { a, a + 2 * n, b }, { b, a + 2 * n, b + 2 * n } };

            memcpy(m->face[f], two, sizeof(two));
            f += 2;
        }
    return m;
}

static synth_instance instance(const lt_mesh *m, double x, double y, double z, int label)
{
    synth_instance in = { .mesh = m, .t_world_obj = { x, y, z }, .label = (uint8_t)label,
                          .material = { .albedo = { 0.6f, 0.5f, 0.4f }, .specular = 0.04f, .shininess = 20,
                                        .translucency = label == SYNTH_LABEL_HAND } };

    memcpy(in.R_world_obj, identity, sizeof(identity));
    return in;
}

static const synth_light lamps[2] = {
    { { 0.5, -1, -0.3 }, 0.05, { 0.8f, 0.8f, 0.7f } }, { { -1, -0.5, 0 }, 0.2, { 0.2f, 0.2f, 0.3f } },
};

static synth_scene scene_of(const synth_instance *in, int n)
{
    synth_scene s = { .instance = in, .n_instances = n, .light = lamps, .n_lights = 2, .sky = { 0.3f, 0.3f, 0.3f },
                      .ground = { 0.1f, 0.1f, 0.1f }, .up = { 0, -1, 0 }, .focus = { 0, 0, 0.6 },
                      .focus_radius = 0.4, .target = 5,
                      .camera = { .fx = 150, .fy = 152, .cx = 79.3, .cy = 60.2, .width = W, .height = H } };

    memcpy(s.camera.R_cam_world, identity, sizeof(identity));
    return s;
}

static void render(const synth_instance *in, int n)
{
    const synth_scene s = scene_of(in, n);

    ck_assert_int_eq(synth_render(&s, frame), LT_OK);
}

/* A pixel's ray at depth 1. */
static void ray(int i, double out[2])
{
    out[0] = (i % W - 79.3) / 150;
    out[1] = (i / W - 60.2) / 152;
}

static int count(const uint8_t *plane_of, int value)
{
    int n = 0;

    for (int i = 0; i < N; i++)
        n += plane_of[i] == value;
    return n;
}

/* ---- depth ----------------------------------------------------------------------------------- */

START_TEST(plane_depth)
{
    const synth_instance in = instance(plane(5, 0.8, 0.5, -0.7), 0, 0, 0, 0);

    render(&in, 1);
    for (int i = 0; i < N; i++) {
        double r[2];

        ray(i, r);
        ck_assert_double_eq_tol(frame->depth[i], 0.8 / (1 - 0.5 * r[0] + 0.7 * r[1]), 1e-4);
    }
}
END_TEST

START_TEST(sphere_depth)
{
    const double c[3] = { 0.03, -0.02, 0.5 }, radius = 0.1;
    const synth_instance in = instance(sphere(radius, 90), c[0], c[1], c[2], SYNTH_LABEL_HAND);
    int seen = 0;

    render(&in, 1);
    for (int i = 0; i < N; i++) {
        double r[2], a, b, disc;

        ray(i, r);
        a = r[0] * r[0] + r[1] * r[1] + 1;
        b = r[0] * c[0] + r[1] * c[1] + c[2];
        disc = b * b - a * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2] - radius * radius);
        if (disc < -2e-4)
            ck_assert_int_eq(frame->label[i], 0);
        if (disc < 2.5e-3)                              /* the rim is steep: a pixel spans millimetres */
            continue;
        seen++;
        ck_assert_int_eq(frame->label[i], SYNTH_LABEL_HAND);
        ck_assert_double_eq_tol(frame->depth[i], (b - sqrt(disc)) / a, 1e-4);
        ck_assert_float_eq(frame->hand_depth[i], frame->depth[i]);
    }
    ck_assert_int_gt(seen, 1400);
}
END_TEST

START_TEST(moved_camera)            /* world and camera turned and shifted together: the same depth */
{
    synth_instance in = instance(sphere(0.1, 30), 0.03, 0, 0.5, 5);
    synth_scene s = scene_of(&in, 1);
    float before[N];

    ck_assert_int_eq(synth_render(&s, frame), LT_OK);
    memcpy(before, frame->depth, sizeof(before));
    const double R[9] = { 0, 0, 1, 1, 0, 0, 0, 1, 0 }, t[3] = { 0.2, -0.4, 1 };

    memcpy(in.R_world_obj, R, sizeof(R));               /* x_world = R x_old + t */
    for (int i = 0; i < 3; i++) {
        in.t_world_obj[i] = R[3 * i] * 0.03 + R[3 * i + 2] * 0.5 + t[i];
        for (int k = 0; k < 3; k++)
            s.camera.R_cam_world[3 * i + k] = R[3 * k + i];
        s.camera.t_cam_world[i] = -(R[i] * t[0] + R[3 + i] * t[1] + R[6 + i] * t[2]);
    }
    ck_assert_int_eq(synth_render(&s, frame), LT_OK);
    for (int i = 0; i < N; i++)
        ck_assert_float_eq_tol(frame->depth[i], before[i], 1e-5f);
}
END_TEST

/* ---- labels and masks ------------------------------------------------------------------------ */

START_TEST(masks_hold_what_is_seen)
{
    const synth_instance in[4] = {
        instance(plane(3, 1, 0, 0), 0, 0, 0, 0), instance(sphere(0.1, 20), -0.05, 0, 0.6, SYNTH_LABEL_HAND),
        instance(sphere(0.1, 20), 0.06, 0.01, 0.5, 5), instance(sphere(0.05, 20), 0.1, 0.1, 0.4, 7),
    };

    render(in, 4);
    for (int i = 0; i < N; i++) {
        if (frame->label[i] == SYNTH_LABEL_HAND)
            ck_assert(frame->hand_mask[i] == 255 && frame->hand_depth[i] == frame->depth[i]);
        if (frame->label[i] == 5)
            ck_assert(frame->object_mask[i] == 255 && frame->object_depth[i] == frame->depth[i]);
        ck_assert((frame->hand_depth[i] > 0) == (frame->hand_mask[i] == 255));
        ck_assert((frame->object_depth[i] > 0) == (frame->object_mask[i] == 255));
    }
    ck_assert_int_gt(count(frame->label, 7), 100);
    ck_assert_int_gt(count(frame->hand_mask, 255), count(frame->label, SYNTH_LABEL_HAND) + 300);
    ck_assert_int_gt(count(frame->object_mask, 255), count(frame->label, 5) + 100);
}
END_TEST

START_TEST(mask_is_of_it_alone)     /* hidden or not, the mask is the same */
{
    synth_instance in[2] = { instance(sphere(0.1, 20), 0, 0, 0.6, SYNTH_LABEL_HAND),
                             instance(plane(3, 0.3, 0, 0), 0, 0, 0, 0) };
    uint8_t alone[N];

    render(in, 1);
    memcpy(alone, frame->hand_mask, N);
    render(in, 2);
    ck_assert_int_eq(count(frame->label, SYNTH_LABEL_HAND), 0);
    ck_assert_mem_eq(frame->hand_mask, alone, N);
}
END_TEST

START_TEST(no_cracks)               /* a mesh of small triangles covers the plane behind it everywhere */
{
    const synth_instance in[2] = { instance(plane(3, 1, 0, 0), 0, 0, 0, 9),
                                   instance(sphere(0.2, 150), 0, 0, 0.5, 3) };

    render(in, 2);
    for (int i = 0; i < N; i++) {
        double r[2];

        ray(i, r);
        if (hypot(r[0], r[1]) < 0.38)
            ck_assert_int_eq(frame->label[i], 3);
    }
}
END_TEST

START_TEST(shadow_falls)
{
    const synth_light lamp = { { 0, -2, 0.6 }, 0.02, { 1, 1, 1 } };
    lt_mesh *floor = plane(1, 0, 0, 0);
    synth_instance in[2] = { instance(floor, 0, 0.2, 0.6, 0), instance(sphere(0.05, 20), 0, 0.05, 0.6, 5) };
    const double lie[9] = { 1, 0, 0, 0, 0, 1, 0, 1, 0 };        /* the plane's z turns to y */
    synth_scene s = scene_of(in, 2);

    memcpy(in[0].R_world_obj, lie, sizeof(lie));
    s.light = &lamp;
    s.n_lights = 1;
    ck_assert_int_eq(synth_render(&s, frame), LT_OK);
    const int under = (int)(60.2 + 152 * 0.2 / 0.6) * W + 79, beside = under + 50;

    ck_assert_int_eq(frame->label[under], 0);
    ck_assert_float_lt(frame->radiance[under][1], 0.6f * frame->radiance[beside][1]);
}
END_TEST

/* ---- the same bits --------------------------------------------------------------------------- */

static void full_picture(int threads, uint8_t *rgb, float *depth, float *noisy)
{
    const synth_instance in[3] = { instance(plane(3, 1, 0.3, 0.2), 0, 0, 0, 0),
                                   instance(sphere(0.1, 20), 0, 0, 0.6, SYNTH_LABEL_HAND),
                                   instance(sphere(0.08, 20), 0.07, 0, 0.55, 5) };
    synth_sensor sensor = synth_sensor_random(3, 4);

    lt_set_threads(threads);
    sensor.motion[0] = 5;
    render(in, 3);
    synth_sensor_image(&sensor, frame);
    synth_sensor_depth(frame, 150, 1e-3, SYNTH_SENSOR_FAR, 3, 4, noisy);
    memcpy(rgb, frame->rgb, sizeof(*frame->rgb) * N);
    memcpy(depth, frame->depth, sizeof(float) * N);
}

START_TEST(same_bits)
{
    static uint8_t rgb[2][3 * N];
    static float depth[2][N], noisy[2][N];

    full_picture(1, rgb[0], depth[0], noisy[0]);
    full_picture(2, rgb[1], depth[1], noisy[1]);
    ck_assert_mem_eq(rgb[0], rgb[1], sizeof(rgb[0]));
    ck_assert_mem_eq(depth[0], depth[1], sizeof(depth[0]));
    ck_assert_mem_eq(noisy[0], noisy[1], sizeof(noisy[0]));
}
END_TEST

START_TEST(depth_camera)
{
    const synth_instance in = instance(plane(5, 0.8, 0, 0), 0, 0, 0, 0);
    float out[N];
    double sum = 0, sum2 = 0;
    int n = 0;

    render(&in, 1);
    synth_sensor_depth(frame, 150, 1e-3, SYNTH_SENSOR_FAR, 1, 2, out);
    for (int i = 0; i < N; i++) {
        ck_assert_double_eq_tol(out[i] * 1000, round(out[i] * 1000), 1e-3);
        if (out[i] > 0) {
            sum += out[i] - 0.8;
            sum2 += (out[i] - 0.8) * (out[i] - 0.8);
            n++;
        }
    }
    ck_assert_int_gt(n, N * 0.96);
    ck_assert_int_lt(n, N * 0.995);
    ck_assert_double_eq_tol(sum / n, 0, 2e-4);
    ck_assert_double_eq_tol(sqrt(sum2 / n), 0.08 * 0.64 / (150 * 0.055), 2e-4);
}
END_TEST

/* ---- odd scenes ------------------------------------------------------------------------------ */

START_TEST(empty)
{
    render(NULL, 0);
    for (int i = 0; i < N; i++)
        ck_assert(frame->depth[i] == 0 && frame->label[i] == 0 && !frame->hand_mask[i] &&
                  frame->radiance[i][0] == 0);
}
END_TEST

START_TEST(degenerate)
{
    static const int32_t faces[4][3] = { { 0, 0, 0 }, { 0, 1, 1 }, { 0, 1, 2 }, { 0, 1, 3 } };
    lt_mesh *m = mesh_new(4, 4);
    synth_instance in = instance(m, 0, 0, 0.5, 1);

    memcpy(m->face, faces, sizeof(faces));
    set3(m->vertex[1], 0.1, 0, 0);
    set3(m->vertex[2], 0.2, 0, 0);                      /* on the line of the first two */
    set3(m->vertex[3], NAN, INFINITY, 0);
    render(&in, 1);
    ck_assert_int_eq(count(frame->label, 1), 0);
}
END_TEST

START_TEST(across_the_camera)       /* a floor that begins behind the eye */
{
    lt_mesh *floor = plane(10, 0, 0, 0);
    synth_instance in = instance(floor, 0, 0.5, 0, 2);
    const double lie[9] = { 1, 0, 0, 0, 0, 1, 0, 1, 0 };

    memcpy(in.R_world_obj, lie, sizeof(lie));
    render(&in, 1);
    for (int i = 0; i < N; i++) {
        double r[2];

        ray(i, r);
        if (r[1] < 0)
            ck_assert_int_eq(frame->label[i], 0);
        else if (r[1] > 0.06)
            ck_assert_double_eq_tol(frame->depth[i], 0.5 / r[1], 1e-4 * 0.5 / r[1]);
    }
}
END_TEST

START_TEST(outside)
{
    const synth_instance in[5] = {
        instance(sphere(0.1, 8), 0, 0, -1, 1), instance(sphere(0.1, 8), 9, 0, 1, 1),
        instance(sphere(0.1, 8), 0, -9, 1, 1), instance(sphere(0.1, 8), 1e30, 1e30, 1, 1),
        instance(sphere(1e-12, 8), 0, 0, 1, 1),
    };

    render(in, 5);
    ck_assert_int_le(count(frame->label, 1), 1);
}
END_TEST

START_TEST(bad_scenes)
{
    lt_mesh *m = plane(1, 1, 0, 0);
    const synth_instance in = instance(m, 0, 0, 0, 1);
    synth_scene s = scene_of(&in, 1);

    s.camera.width = 7;
    ck_assert_int_eq(synth_render(&s, frame), LT_EINVAL);
    s = scene_of(&in, 1);
    s.camera.fx = 0;
    ck_assert_int_eq(synth_render(&s, frame), LT_EINVAL);
    s = scene_of(&in, 1);
    s.n_lights = SYNTH_MAX_LIGHTS + 1;
    ck_assert_int_eq(synth_render(&s, frame), LT_EINVAL);
    s = scene_of(&in, 1);
    m->face[1][2] = 4;
    ck_assert_int_eq(synth_render(&s, frame), LT_EINVAL);
    ck_assert(synth_frame_new(0, 10) == NULL && synth_frame_new(10, 5000) == NULL);
}
END_TEST

START_TEST(without_memory)
{
    const synth_instance in = instance(sphere(0.1, 8), 0, 0, 0.5, 1);
    const synth_scene s = scene_of(&in, 1);
    lt_status st = LT_ENOMEM;

    for (int n = 1; st == LT_ENOMEM; n++) {
        synth_frame *f;

        lt_alloc_fail_at(n);
        f = synth_frame_new(W, H);
        st = f ? synth_render(&s, f) : LT_ENOMEM;
        lt_alloc_fail_at(0);
        synth_frame_free(f);
    }
    ck_assert_int_eq(st, LT_OK);
}
END_TEST

/* ---- textures, sensor ------------------------------------------------------------------------ */

START_TEST(far_texture_is_grey)     /* a fine checkerboard far away: its mean, everywhere */
{
    static uint8_t board[64][64][3];
    lt_mesh *m = plane(5, 1, 0, 0);
    synth_instance in = instance(m, 0, 0, 0, 0);
    synth_scene s = scene_of(&in, 1);

    for (int i = 0; i < 64 * 64; i++)
        memset(board[i / 64][i % 64], (i + i / 64) % 2 ? 255 : 0, 3);
    m->uv = lt_arena_array(arena, 4, sizeof(*m->uv));
    for (int i = 0; i < 4; i++) {
        m->uv[i][0] = i == 1 || i == 2 ? 300 : 0;
        m->uv[i][1] = i >= 2 ? 300 : 0;
    }
    in.material = (synth_material){ .albedo = { 1, 1, 1 }, .texture = synth_texture_new(arena, board[0][0], 64, 64) };
    s.n_lights = 0;
    memcpy(s.sky, (float[3]){ 1, 1, 1 }, sizeof(s.sky));
    memcpy(s.ground, (float[3]){ 1, 1, 1 }, sizeof(s.ground));
    ck_assert_int_eq(synth_render(&s, frame), LT_OK);
    for (int i = 0; i < N; i++)
        ck_assert_float_eq_tol(frame->radiance[i][1], 0.5f, 0.01f);
}
END_TEST

/* A glossy striped wall behind a ball that throws its shadow on it. */
static void striped_wall(float grain, float (*light)[3])
{
    static uint8_t stripes[32][32][3];
    lt_mesh *wall = plane(1, 1, 0, 0);
    synth_instance in[2] = { instance(wall, 0, 0, 0, 0), instance(sphere(0.1, 20), 0, 0, 0.6, 5) };

    for (int i = 0; i < 32 * 32; i++)
        memset(stripes[i / 32][i % 32], i % 2 ? 255 : 50, 3);
    wall->uv = lt_arena_array(arena, 4, sizeof(*wall->uv));
    for (int i = 0; i < 4; i++) {
        wall->uv[i][0] = i == 1 || i == 2;
        wall->uv[i][1] = i >= 2;
    }
    in[0].material = (synth_material){ .albedo = { 1, 1, 1 }, .specular = 0.2f, .shininess = 40, .grain = grain,
                                       .texture = synth_texture_new(arena, stripes[0][0], 32, 32) };
    render(in, 2);
    memcpy(light, frame->radiance, N * sizeof(*light));
}

START_TEST(shared_light_is_right)   /* grain, however faint, has each pixel lit alone; a pixel is 7 mm here */
{
    static float shared[N][3], alone[N][3];
    int equal = 0, far = 0;         /* far: where a shadow begins between a square's middle and its pixels */

    striped_wall(0, shared);
    striped_wall(1e-6f, alone);
    for (int i = 0; i < N; i++) {
        equal += shared[i][1] == alone[i][1];
        far += fabsf(shared[i][1] - alone[i][1]) > 0.03f * alone[i][1];
    }
    ck_assert_int_lt(far, N / 200);
    ck_assert_int_lt(equal, N / 2);
}
END_TEST

START_TEST(sensor_is_srgb)
{

    for (int i = 0; i < N; i++)
        frame->radiance[i][0] = frame->radiance[i][1] = frame->radiance[i][2] = 0.6f * (float)i / N;
    synth_sensor_image(&plain_sensor, frame);
    for (int i = 0; i < N; i++) {
        const double l = 0.6 * i / N, s = l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055;

        ck_assert_double_eq_tol(frame->rgb[i][1], 255 * s, 0.75);
    }
}
END_TEST

START_TEST(motion_smears_what_moves)
{
    synth_sensor sensor = plain_sensor;

    for (int i = 0; i < N; i++) {
        frame->moving[i] = i % W >= 60 && i % W < 100;
        for (int c = 0; c < 3; c++)
            frame->radiance[i][c] = frame->moving[i] ? 0.5f : i % W < 60 ? 0.1f : 0.2f;
    }
    sensor.motion[0] = 20;
    synth_sensor_image(&sensor, frame);
    const uint8_t (*row)[3] = (const uint8_t (*)[3])&frame->rgb[60 * W];

    ck_assert(row[30][0] == row[0][0] && row[130][0] == row[159][0]);   /* untouched */
    for (int x = 52; x < 68; x++)                                       /* a ramp, both sides of the edge */
        ck_assert_int_ge(row[x + 1][0] + 1, row[x][0]);
    ck_assert_int_gt(row[55][0], row[30][0] + 5);
    ck_assert_int_lt(row[65][0], row[80][0] - 5);
}
END_TEST

/* ---- the room -------------------------------------------------------------------------------- */

START_TEST(room_leaves_room)
{
    for (uint64_t seed = 0; seed < 6; seed++) {
        const synth_room *room = synth_room_new(arena, seed, 0, 0.15);

        ck_assert_ptr_nonnull(room);
        ck_assert_int_gt(room->n_lights, 0);
        for (int i = 0; i < room->n_instances; i++) {
            const synth_instance *in = &room->instance[i];

            ck_assert_int_eq(in->label, 0);
            for (int v = 0; v < in->mesh->n_vertices && !in->no_shadow; v++) {
                double p[3];

                for (int k = 0; k < 3; k++)
                    p[k] = in->R_world_obj[3 * k] * in->mesh->vertex[v][0] + in->R_world_obj[3 * k + 1] *
                           in->mesh->vertex[v][1] + in->R_world_obj[3 * k + 2] * in->mesh->vertex[v][2] +
                           in->t_world_obj[k];
                ck_assert_double_gt(hypot(p[0], p[1]), 0.15);
                ck_assert_double_gt(p[2], -1e-6);
            }
        }
    }
}
END_TEST

/* A camera over the table's edge, turned by an angle about the room's axis: z forward, x level. */
static synth_camera camera_in_room(double around)
{
    const double c = cos(around), n = sin(around), down = 0.5, q = cos(down), p = sin(down);
    synth_camera cam = { .fx = 150, .fy = 150, .cx = (W - 1) / 2.0, .cy = (H - 1) / 2.0, .width = W, .height = H };
    const double R[9] = { c, n, 0, p * n, -p * c, -q, -q * n, q * c, -p }, eye[3] = { 0.6 * n, -0.6 * c, 0.4 };

    memcpy(cam.R_cam_world, R, sizeof(R));
    for (int i = 0; i < 3; i++)
        cam.t_cam_world[i] = -(R[3 * i] * eye[0] + R[3 * i + 1] * eye[1] + R[3 * i + 2] * eye[2]);
    return cam;
}

/* The room of a seed as camera[0] sees it, painted for n cameras. */
static void film_room(uint64_t seed, const synth_camera *camera, int n, uint8_t (*rgb)[3])
{
    synth_room *room = synth_room_new(arena, seed, 0, 0.15);
    synth_scene scene = { .camera = camera[0], .sky = { 0.5f, 0.5f, 0.5f }, .ground = { 0.3f, 0.3f, 0.3f },
                          .up = { 0, 0, 1 } };

    ck_assert(room && synth_room_paint(room, camera, n));
    scene.instance = room->instance;
    scene.n_instances = room->n_instances;
    ck_assert_int_eq(synth_render(&scene, frame), LT_OK);
    synth_sensor_image(&plain_sensor, frame);
    memcpy(rgb, frame->rgb, (size_t)W * H * 3);
}

/* What a camera does not see need not be painted for it. */
START_TEST(paints_what_is_seen)
{
    uint8_t (*alone)[3] = lt_arena_array(arena, (size_t)W * H, 3), (*all)[3] = lt_arena_array(arena, (size_t)W * H, 3);
    synth_camera camera[6];

    for (int i = 0; i < 6; i++)
        camera[i] = camera_in_room(_i + i * M_PI / 3);
    film_room((uint64_t)_i, camera, 1, alone);
    film_room((uint64_t)_i, camera, 6, all);
    ck_assert_int_eq(memcmp(alone, all, (size_t)W * H * 3), 0);
}
END_TEST

static synth_arm_spec arm_spec(float (*loop)[3], int turn)
{
    synth_arm_spec spec = { .loop = (const float (*)[3])loop, .skin = { 0.5f, 0.3f, 0.2f }, .elbow = { 0.1, 0.2, 1 },
                            .bare = 0.1, .length = 0.5 };

    for (int i = 0; i < SYNTH_WRIST_LOOP; i++) {
        const double a = 2 * M_PI * turn * i / SYNTH_WRIST_LOOP;

        set3(loop[i], 0.03 * cos(a), 0.02 * sin(a), 0.002 * sin(3 * a));
    }
    return spec;
}

/* Signed volume of the cone from the middle of the arm to each face: positive when it looks outwards. */
static double outward_share(const lt_mesh *m, const double axis[3])
{
    int out = 0;

    for (int f = 0; f < m->n_faces; f++) {
        const float *p = m->vertex[m->face[f][0]], *q = m->vertex[m->face[f][1]], *r = m->vertex[m->face[f][2]];
        const double a[3] = { q[0] - p[0], q[1] - p[1], q[2] - p[2] }, b[3] = { r[0] - p[0], r[1] - p[1], r[2] - p[2] };
        const double n[3] = { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
        const double t = p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2];

        out += n[0] * (p[0] - t * axis[0]) + n[1] * (p[1] - t * axis[1]) + n[2] * (p[2] - t * axis[2]) >= 0;
    }
    return (double)out / m->n_faces;
}

START_TEST(arm_starts_at_the_loop)
{
    const double axis[3] = { 0.1 / 1.0247, 0.2 / 1.0247, 1 / 1.0247 };
    float loop[SYNTH_WRIST_LOOP][3];
    const synth_arm_spec spec = arm_spec(loop, _i ? 1 : -1);
    synth_arm arm;

    ck_assert_int_eq(synth_arm_new(arena, &spec, &arm), LT_OK);
    for (int i = 0; i < SYNTH_WRIST_LOOP; i++) {
        int found = 0;

        for (int v = 0; v < arm.skin.n_vertices; v++)
            found += memcmp(arm.skin.vertex[v], loop[i], sizeof(loop[i])) == 0;
        ck_assert_int_ge(found, 1);
    }
    ck_assert_double_gt(outward_share(&arm.skin, axis), 0.98);
    ck_assert_double_gt(outward_share(&arm.sleeve, axis), 0.9);
}
END_TEST

START_TEST(bad_arms)
{
    float loop[SYNTH_WRIST_LOOP][3];
    synth_arm_spec spec = arm_spec(loop, 1);
    synth_arm arm;

    spec.length = NAN;
    ck_assert_int_eq(synth_arm_new(arena, &spec, &arm), LT_EINVAL);
    spec = arm_spec(loop, 1);
    memset(spec.elbow, 0, sizeof(spec.elbow));
    ck_assert_int_eq(synth_arm_new(arena, &spec, &arm), LT_EINVAL);
    spec = arm_spec(loop, 1);
    memset(loop, 0, sizeof(loop));
    ck_assert_int_eq(synth_arm_new(arena, &spec, &arm), LT_EINVAL);
    spec = arm_spec(loop, 1);
    loop[3][1] = NAN;
    ck_assert_int_eq(synth_arm_new(arena, &spec, &arm), LT_EINVAL);
}
END_TEST

/* ---- drawing --------------------------------------------------------------------------------- */

static long ink(const draw_canvas *c)
{
    long sum = 0;

    for (int i = 0; i < c->width * c->height; i++)
        sum += c->rgb[i][0];
    return sum;
}

START_TEST(drawing_is_cut)
{
    static const float far[7][2] = {
        { -1e9f, 5 }, { 1e9f, 6 }, { NAN, 0 }, { 5, INFINITY }, { 1e30f, -1e30f }, { 30, -40 }, { -3, -3 },
    };
    const draw_color white = { 255, 255, 255 }, black = { 0, 0, 0 };
    draw_canvas c = draw_canvas_new(arena, 40, 30, black);

    for (int i = 0; i < 7; i++)
        for (int j = 0; j < 7; j++) {
            draw_line(&c, far[i], far[j], 2, white, 1);
            draw_disc(&c, far[i], 3, white, 1);
        }
    draw_text(&c, -9, -4, 2, white, "clip\xff~");
    draw_text(&c, 35, 27, 3, white, "clip");
    draw_rect(&c, -5, 20, 100, 21, white, 1);
    draw_picture(&c, -10, -10, 200, 200, &c);
    ck_assert_int_gt(ink(&c), 0);
}
END_TEST

START_TEST(lines_have_their_width)
{
    const draw_color white = { 255, 255, 255 }, black = { 0, 0, 0 };
    const float ends[3][2][2] = { { { 10, 10 }, { 30, 10 } }, { { 10, 5 }, { 10, 25 } }, { { 10, 10 }, { 22, 26 } } };
    const float center[2] = { 20, 15 };
    draw_canvas c = draw_canvas_new(arena, 40, 30, black);

    draw_line(&c, ends[_i][0], ends[_i][1], 3, white, 1);
    ck_assert_double_eq_tol((double)ink(&c) / 255, 20 * 3 + M_PI * 1.5 * 1.5, 2);
    draw_rect(&c, 0, 0, 40, 30, black, 1);
    draw_disc(&c, center, 8, white, 1);
    ck_assert_double_eq_tol((double)ink(&c) / 255, M_PI * 64, 2);
}
END_TEST

START_TEST(sheet_holds_pictures)
{
    const draw_color red = { 200, 0, 0 };
    const draw_canvas one = draw_canvas_new(arena, 10, 8, red), three[3] = { one, one, one };
    const char *const titles[3] = { "first", NULL, "third" };
    const draw_canvas c = draw_sheet(arena, three, titles, 3, 2, 20, 16);

    ck_assert_int_eq(c.width, 4 + 2 * 24);
    ck_assert_int_eq(c.height, 4 + 2 * (16 + 13 + 4));
    ck_assert_int_eq(c.rgb[(4 + 13 + 5) * c.width + 10][1], 0);
    ck_assert_ptr_null(draw_sheet(arena, three, titles, 0, 2, 20, 16).rgb);
}
END_TEST

START_TEST(outline_is_inside)
{
    const draw_color black = { 0, 0, 0 }, white = { 255, 255, 255 };
    draw_canvas c = draw_canvas_new(arena, 20, 20, black);
    uint8_t mask[400] = { 0 };

    for (int i = 0; i < 400; i++)
        mask[i] = i % 20 >= 5 && i % 20 < 15 && i / 20 >= 5 && i / 20 < 15;
    draw_outline(&c, mask, 1, white);
    for (int i = 0; i < 400; i++) {
        const bool rim = mask[i] && !(i % 20 > 5 && i % 20 < 14 && i / 20 > 5 && i / 20 < 14);

        ck_assert_int_eq(c.rgb[i][0], rim ? 255 : 0);
    }
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_set_timeout(t, 0);
    tcase_add_test(t, plane_depth);
    tcase_add_test(t, sphere_depth);
    tcase_add_test(t, moved_camera);
    tcase_add_test(t, masks_hold_what_is_seen);
    tcase_add_test(t, mask_is_of_it_alone);
    tcase_add_test(t, no_cracks);
    tcase_add_test(t, shadow_falls);
    tcase_add_test(t, same_bits);
    tcase_add_test(t, depth_camera);
    tcase_add_test(t, empty);
    tcase_add_test(t, degenerate);
    tcase_add_test(t, across_the_camera);
    tcase_add_test(t, outside);
    tcase_add_test(t, bad_scenes);
    tcase_add_test(t, without_memory);
    tcase_add_test(t, far_texture_is_grey);
    tcase_add_test(t, shared_light_is_right);
    tcase_add_test(t, sensor_is_srgb);
    tcase_add_test(t, motion_smears_what_moves);
    tcase_add_test(t, room_leaves_room);
    tcase_add_loop_test(t, paints_what_is_seen, 0, 6);
    tcase_add_loop_test(t, arm_starts_at_the_loop, 0, 2);
    tcase_add_test(t, bad_arms);
    tcase_add_test(t, drawing_is_cut);
    tcase_add_loop_test(t, lines_have_their_width, 0, 3);
    tcase_add_test(t, sheet_holds_pictures);
    tcase_add_test(t, outline_is_inside);
}

int main(void)
{
    return run_suite("render", add_tests);
}
