/* SPDX-License-Identifier: Apache-2.0 */
/* What is true of worlds as COCO and BOP have it: text against values made by hand, files against each other. */
#include "assets/ycb/objects.h"
#include "assets/ycb/symmetry.h"
#include "data/detection/detection.h"
#include "eval/scorers/models_info.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/mesh/ply.h"
#include "libtensor/io/text/json.h"
#include "synth/workplace/export.h"
#include "synth/workplace/workplace.h"
#include "tests/scratch.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <unistd.h>

enum { SEED = 3, SHRINK = 4, CAN = 4, MOMENTS = 2, WIDTH = WORKPLACE_WIDTH / SHRINK, HEIGHT = WORKPLACE_HEIGHT / SHRINK,
       PIXELS = WIDTH * HEIGHT };

static lt_hand_model *hand;
static synth_body body;
static synth_prop_pair prop[YCB_COUNT];         /* all of them the same can: others take seconds to make */
static workplace_means means;

static void film(const char *out, bool coco, bool bop, int threads)
{
    const synth_options o = { .preset = SYNTH_WORLD, .out = at(out), .seed = SEED, .frames = MOMENTS, .cameras = 4,
                              .difficulty = 0.2, .coco = coco, .bop = bop };
    synth_figure figures[SYNTH_FIGURES];
    int n;

    lt_set_threads(threads);
    check_ok(workplace_film(&o, &means, SHRINK, figures, &n));
    lt_set_threads(1);
}

/* One world for all tests. */
static void setup(void)
{
    open_scratch();
    lt_set_threads(1);
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(synth_body_new(arena, hand, &body));
    check_ok(synth_prop_new_bare(arena, CAN, &prop[0].right));
    check_ok(synth_prop_mirror(arena, &prop[0].right, &prop[0].left));
    for (int i = 1; i < YCB_COUNT; i++)
        prop[i] = prop[0];
    means = (workplace_means){ &body, hand, prop };
    film("world", true, true, 1);
}

static const char *text_of(const char *path)
{
    uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, at(path), LT_FILE_MAX, &bytes, &n));
    return (const char *)bytes;
}

static cJSON *json_of(const char *path)
{
    cJSON *j;

    check_ok(lt_json_read(at(path), &j));
    return j;
}

static void numbers_of(const cJSON *in, const char *key, int n, double *out)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(in, key);

    ck_assert_int_eq(cJSON_GetArraySize(list), n);
    for (int i = 0; i < n; i++)
        out[i] = cJSON_GetArrayItem(list, i)->valuedouble;
}

static double number_of(const cJSON *in, const char *key)
{
    return cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(in, key));
}

/* Whether the key has the box x y width height around the pixels of a mask; their number */
static int64_t check_box(const cJSON *in, const char *key, const uint8_t *mask)
{
    double box[4];
    int64_t n;
    const synth_pixels b = synth_pixels_of(mask, WIDTH, HEIGHT, &n);

    numbers_of(in, key, 4, box);
    ck_assert(box[0] == b.x0 && box[1] == b.y0 && box[2] == b.x1 - b.x0 && box[3] == b.y1 - b.y0);
    return n;
}

/* ---- by hand ------------------------------------------------------------------------------------------------- */

START_TEST(coco_is_as_written_by_hand)
{
    static const uint8_t seen[12] = { 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0 };     /* rows of 4 */
    static const uint8_t whole[12] = { 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0 };
    const synth_thing thing = { .kind = SYNTH_HAND_THING, .owner = -1, .left = true, .identity = 11 };
    const synth_seen s = { .mask = seen, .visible = 3, .whole = 4, .box = { 1, 0, 3, 3 }, .whole_box = { 1, 0, 3, 3 } };
    synth_coco_image image = { .file = "front_000007.jpg", .width = 4, .height = 3, .camera = "front", .frame = 7 };
    synth_manifest manifest = { .arena = arena };
    synth_coco c;

    ck_assert(!synth_coco_counts(&s));                                          /* fewer than 16 pixels */
    check_ok(synth_coco_open(&c, "hand.json"));
    check_ok(synth_coco_see(arena, &thing, &s, whole, &image));
    synth_coco_add(&c, &image);
    check_ok(synth_coco_close(&c, scratch_folder, &manifest));
    synth_coco_fini(&c);
    ck_assert_ptr_nonnull(strstr(text_of("hand.json"),
        "{\"id\": 1, \"file_name\": \"front_000007.jpg\", \"width\": 4, \"height\": 3, \"camera\": \"front\", "
        "\"frame\": 7}"));
    ck_assert_ptr_nonnull(strstr(text_of("hand.json"),
        "{\"id\": 1, \"image_id\": 1, \"category_id\": 2, \"bbox\": [1, 0, 2, 3], \"area\": 3, \"iscrowd\": 0, "
        "\"side\": \"left\", \"track_id\": 11, \"visible\": 0.7500, "
        "\"segmentation\": {\"size\": [3, 4], \"counts\": \"435\"}, "
        "\"amodal\": {\"bbox\": [1, 0, 2, 3], \"area\": 4, "
        "\"segmentation\": {\"size\": [3, 4], \"counts\": \"345\"}}}"));
}
END_TEST

/* A can a metre away that lies across: the middle of its box is at (0.024, 1.527, -8.4035) mm of its own frame. */
START_TEST(bop_is_as_written_by_hand)
{
    const synth_bop_image image = {
        .number = 7, .depth_step = 0.0005, .n = 2,
        .camera = { .fx = 500, .fy = 501, .cx = 319.5, .cy = 239.5, .width = 640, .height = 480,
                    .R_cam_world = { 1, 0, 0, 0, 0, -1, 0, 1, 0 }, .t_cam_world = { 0, 0.25, 2 } },
        .object = { { .id = CAN, .R = { 0, -1, 0, 1, 0, 0, 0, 0, 1 }, .t = { 0.1, 0.2, 1 }, .whole = 8, .measured = 5,
                      .visible = 2, .whole_box = { -2, 3, 2, 5 }, .box = { 0, 3, 2, 4 } },
                    { .id = 3, .R = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .t = { 0, 0, -1 } } },
    };
    synth_manifest manifest = { .arena = arena };
    synth_bop_scene s;

    check_ok(lt_make_dirs(at("scene")));
    check_ok(synth_bop_open(&s));
    synth_bop_add(&s, &image);
    check_ok(synth_bop_close(&s, scratch_folder, "scene", &manifest));
    synth_bop_fini(&s);
    ck_assert_str_eq(text_of("scene/scene_camera.json"),
        "{\n\"7\": {\"cam_K\": [500, 0, 319.5, 0, 501, 239.5, 0, 0, 1], \"cam_R_w2c\": [1, 0, 0, 0, 0, -1, 0, 1, 0], "
        "\"cam_t_w2c\": [0, 250, 2000], \"depth_scale\": 0.5}\n}\n");
    ck_assert_str_eq(text_of("scene/scene_gt.json"),
        "{\n\"7\": [{\"cam_R_m2c\": [0, -1, 0, 1, 0, 0, 0, 0, 1], \"cam_t_m2c\": [98.473, 200.024, 991.5965], "
        "\"obj_id\": 4}, {\"cam_R_m2c\": [1, 0, 0, 0, 1, 0, 0, 0, 1], \"cam_t_m2c\": [0.952, -1.467, -1004.3645], "
        "\"obj_id\": 3}]\n}\n");
    ck_assert_str_eq(text_of("scene/scene_gt_info.json"),
        "{\n\"7\": [{\"bbox_obj\": [-2, 3, 4, 2], \"bbox_visib\": [0, 3, 2, 1], \"px_count_all\": 8, "
        "\"px_count_valid\": 5, \"px_count_visib\": 2, \"visib_fract\": 0.250000}, "
        "{\"bbox_obj\": [-1, -1, -1, -1], \"bbox_visib\": [-1, -1, -1, -1], \"px_count_all\": 0, "
        "\"px_count_valid\": 0, \"px_count_visib\": 0, \"visib_fract\": 0.000000}]\n}\n");
}
END_TEST

/* A block of 20 x 40 x 60 mm; models with all kinds of symmetry, one of them twice. */
START_TEST(models_are_read_back)
{
    static const int id[] = { 1, 3, 13, 16, 18, 21, 13 };
    float vertex[8][3], uv[8][2] = { { 0, 0 } };
    int32_t face[1][3] = { { 0, 1, 2 } };
    const lt_mesh mesh = { .n_vertices = 8, .n_faces = 1, .vertex = vertex, .face = face, .uv = uv };
    uint8_t (*rgb)[3] = lt_arena_array(arena, SYNTH_TEXTURE * SYNTH_TEXTURE, sizeof(*rgb));
    synth_bop_model model[LT_COUNT(id)];
    synth_manifest manifest = { .arena = arena };
    bop_model *back = lt_arena_array(arena, YCB_COUNT + 1, sizeof(*back));
    lt_mesh m;
    lt_ply file;

    for (int i = 0; i < 8; i++) {
        vertex[i][0] = i & 1 ? 0.02f : 0;
        vertex[i][1] = i & 2 ? 0.04f : 0;
        vertex[i][2] = i & 4 ? 0.06f : 0;
    }
    rgb[SYNTH_TEXTURE * (SYNTH_TEXTURE - 1)][0] = 51;                           /* the lower left: u = v = 0 */
    for (size_t i = 0; i < LT_COUNT(id); i++)
        model[i] = (synth_bop_model){ id[i], &mesh, (const uint8_t (*)[3])rgb };
    check_ok(lt_make_dirs(at("models")));
    check_ok(synth_bop_models(model, LT_COUNT(id), scratch_folder, "models", &manifest));
    ck_assert_int_eq(manifest.n, 7);

    check_ok(models_info_read(arena, at("models/models_info.json"), back));
    for (int i = 1; i <= YCB_COUNT; i++) {
        static lt_pose want[YCB_TURNS];
        const int n = ycb_symmetries(ycb_find(i), want);

        if (back[i].diameter == 0)
            continue;
        ck_assert_double_eq_tol(back[i].diameter, sqrt(0.0056), 1e-8);
        ck_assert_int_eq(back[i].n_symmetries, n);
        for (int k = 0; k < n; k++) {
            for (int e = 0; e < 9; e++)
                ck_assert_double_eq_tol(back[i].symmetry[k].R[e], want[k].R[e], 1e-8);
            ck_assert_double_lt(lt_vec3_distance(back[i].symmetry[k].t, want[k].t), 1e-9);
        }
    }
    check_ok(lt_ply_read(arena, at("models/obj_000003.ply"), &file));
    check_ok(lt_ply_mesh(arena, &file, &m));
    ck_assert_double_eq_tol(m.vertex[7][0], 20 - 0.952, 1e-4);
    ck_assert_double_eq_tol(m.vertex[7][1], 40 + 1.467, 1e-4);
    ck_assert_double_eq_tol(m.vertex[7][2], 60 + 4.3645, 1e-4);
    ck_assert(m.color[0][0] == 51 / 255.0f && m.color[0][1] == 0);
}
END_TEST

/* ---- a world ------------------------------------------------------------------------------------------------- */

/* The same bits on three threads; and what is exported changes nothing of the recording. */
START_TEST(same_bytes)
{
    cJSON *with, *without, *file;
    int shared = 0;

    film("threads", true, true, 3);
    same_files(at("world/manifest.json"), at("threads/manifest.json"));
    film("alone", false, false, 1);
    ck_assert_int_ne(access(at("alone/coco"), F_OK), 0);
    ck_assert_int_ne(access(at("alone/bop"), F_OK), 0);
    with = json_of("world/manifest.json");
    without = json_of("alone/manifest.json");
    ck_assert_str_eq(cJSON_GetObjectItem(with, "export")->valuestring, "coco,bop");
    ck_assert_ptr_null(cJSON_GetObjectItem(without, "export"));
    cJSON_ArrayForEach(file, cJSON_GetObjectItem(without, "files_crc32")) {
        const cJSON *other = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItem(with, "files_crc32"), file->string);

        ck_assert_msg(other && strcmp(other->valuestring, file->valuestring) == 0, "%s", file->string);
        shared++;
    }
    ck_assert_int_gt(shared, 3 * MOMENTS);
    cJSON_Delete(with);
    cJSON_Delete(without);
}
END_TEST

START_TEST(the_detector_s_reader_reads_it)
{
    detection_set *s;
    int objects = 0;

    check_ok(detection_open(arena, at("world/coco"), "train", &s));
    ck_assert(s->synthetic && s->seed == -1 && s->missing == 0 && s->dropped == 0);
    ck_assert_int_eq(s->classes, SYNTH_CLASSES);
    ck_assert_int_ge(s->count, 4 * MOMENTS - 2);
    for (int64_t i = 0; i < s->count; i++) {
        detection_sample sample;

        check_ok(detection_read(s, i, arena, &sample));
        ck_assert(sample.rgb.width == WIDTH && sample.rgb.height == HEIGHT);
        for (int k = 0; k < sample.n; k++, objects++) {
            const detection_object *o = &sample.object[k];
            uint8_t mask[PIXELS];
            int64_t n;
            synth_pixels b;

            check_ok(detection_mask(o, WIDTH, HEIGHT, mask));
            b = synth_pixels_of(mask, WIDTH, HEIGHT, &n);
            ck_assert(o->area == (double)n);
            ck_assert(o->box[0] == b.x0 && o->box[1] == b.y0 && o->box[2] == b.x1 && o->box[3] == b.y1);
        }
    }
    ck_assert_int_gt(objects, 2 * MOMENTS);
}
END_TEST

static int64_t decode(const cJSON *of, uint8_t mask[PIXELS])
{
    const cJSON *s = cJSON_GetObjectItem(of, "segmentation");

    check_ok(lt_rle_decode(cJSON_GetObjectItem(s, "counts")->valuestring, HEIGHT, WIDTH, mask));
    return check_box(of, "bbox", mask);
}

START_TEST(what_is_seen_is_a_part_of_the_whole)
{
    cJSON *j = json_of("world/coco/annotations/instances_train.json"), *a;
    int hidden = 0;

    cJSON_ArrayForEach(a, cJSON_GetObjectItem(j, "annotations")) {
        const cJSON *amodal = cJSON_GetObjectItem(a, "amodal");
        uint8_t seen[PIXELS], whole[PIXELS];
        const int64_t n = decode(a, seen), all = decode(amodal, whole);

        ck_assert(number_of(a, "area") == (double)n && number_of(amodal, "area") == (double)all);
        ck_assert_double_eq_tol(number_of(a, "visible"), (double)n / (double)all, 1e-4);
        for (int i = 0; i < PIXELS; i++)
            ck_assert(!seen[i] || whole[i]);
        hidden += all > n;
    }
    ck_assert_int_gt(hidden, 0);
    cJSON_Delete(j);
}
END_TEST

static int64_t read_mask(const char *kind, int scene, int image, int object, uint8_t mask[PIXELS])
{
    lt_image img;
    int64_t n = 0;

    check_ok(lt_image_read(arena, at(lt_arena_printf(arena, "world/bop/train_synt/%06d/%s/%06d_%06d.png", scene, kind,
                                                     image, object)), &img));
    ck_assert(img.width == WIDTH && img.height == HEIGHT && img.channels == 1 && img.bits == 8);
    for (int i = 0; i < PIXELS; i++) {
        ck_assert(img.data[i] == 0 || img.data[i] == 255);
        n += img.data[i] == 255;
    }
    memcpy(mask, img.data, PIXELS);
    return n;
}

/* The corners of the model at its pose reach as far as the box does: a pixel belongs to it by its centre, so that half
 * a pixel at either side is open, and where the outline is a point, a whole one. */
static void check_pose(const lt_mesh *m, const cJSON *pose, const cJSON *camera, const cJSON *counts)
{
    double K[9], R[9], t[3], box[4], lo[2] = { INFINITY, INFINITY }, hi[2] = { -INFINITY, -INFINITY };

    numbers_of(camera, "cam_K", 9, K);
    numbers_of(pose, "cam_R_m2c", 9, R);
    numbers_of(pose, "cam_t_m2c", 3, t);
    numbers_of(counts, "bbox_obj", 4, box);
    for (int i = 0; i < m->n_vertices; i++) {
        const double x[3] = { m->vertex[i][0], m->vertex[i][1], m->vertex[i][2] };
        double p[3];

        lt_rigid_apply(R, t, x, p);
        for (int k = 0; k < 2; k++) {
            const double u = K[4 * k] * p[k] / p[2] + K[3 * k + 2];

            lo[k] = fmin(lo[k], u);
            hi[k] = fmax(hi[k], u);
        }
    }
    for (int k = 0; k < 2; k++) {
        ck_assert_double_le(fabs(box[k] - lo[k]), 1);
        ck_assert_double_le(fabs(box[k] + box[2 + k] - 1 - hi[k]), 1);
    }
}

/* Masks, counts, boxes and poses of one image */
static int check_image(const lt_mesh *m, int scene, const cJSON *poses, const cJSON *counts, const cJSON *camera)
{
    const int image = atoi(poses->string);
    lt_image depth;
    int n = 0;

    check_ok(lt_image_read(arena, at(lt_arena_printf(arena, "world/bop/train_synt/%06d/depth/%06d.png", scene, image)),
                           &depth));
    ck_assert(depth.bits == 16 && depth.channels == 1 && number_of(camera, "depth_scale") == 1);
    for (int o = 0; o < cJSON_GetArraySize(poses); o++) {
        const cJSON *pose = cJSON_GetArrayItem(poses, o), *count = cJSON_GetArrayItem(counts, o);
        uint8_t whole[PIXELS], seen[PIXELS];
        const int64_t all = read_mask("mask", scene, image, o, whole);
        const int64_t visible = read_mask("mask_visib", scene, image, o, seen);
        int64_t valid = 0;

        ck_assert_int_eq((int)number_of(pose, "obj_id"), CAN);
        for (int i = 0; i < PIXELS; i++) {
            ck_assert(!seen[i] || whole[i]);
            valid += whole[i] && ((const uint16_t *)(const void *)depth.data)[i];
        }
        ck_assert(number_of(count, "px_count_valid") == (double)valid);
        ck_assert(number_of(count, "px_count_visib") == (double)visible);
        if (!visible || number_of(count, "px_count_all") != (double)all)
            continue;
        n++;
        check_box(count, "bbox_visib", seen);
        check_box(count, "bbox_obj", whole);
        check_pose(m, pose, camera, count);
    }
    return n;
}

START_TEST(poses_masks_and_counts_agree)
{
    lt_ply file;
    lt_mesh m;
    int n = 0;

    check_ok(lt_ply_read(arena, at("world/bop/models/obj_000004.ply"), &file));
    check_ok(lt_ply_mesh(arena, &file, &m));
    for (int scene = 1; scene <= 4; scene++) {
        const char *folder = lt_arena_printf(arena, "world/bop/train_synt/%06d", scene);
        cJSON *camera = json_of(lt_arena_printf(arena, "%s/scene_camera.json", folder)), *poses;
        cJSON *gt = json_of(lt_arena_printf(arena, "%s/scene_gt.json", folder));
        cJSON *info = json_of(lt_arena_printf(arena, "%s/scene_gt_info.json", folder));

        ck_assert_int_eq(cJSON_GetArraySize(gt), cJSON_GetArraySize(camera));
        cJSON_ArrayForEach(poses, gt)
            n += check_image(&m, scene, poses, cJSON_GetObjectItem(info, poses->string),
                             cJSON_GetObjectItem(camera, poses->string));
        cJSON_Delete(camera);
        cJSON_Delete(gt);
        cJSON_Delete(info);
    }
    ck_assert_int_ge(n, 4);
}
END_TEST

static void shoot(const workplace_scene *scene, const synth_room *room, const recording_rig *rig, synth_seen **seen,
                  export_view *view)
{
    static const uint16_t depth[PIXELS];
    const synth_options o = { .out = at("border"), .bop = true };
    const synth_camera camera = workplace_camera(&rig->camera[0]);
    synth_frame *f = synth_frame_new(WIDTH, HEIGHT);
    workplace_export e;

    check_ok(workplace_scene_draw(scene, room, &camera, f));
    check_ok(synth_world_look(arena, &scene->world, &camera, f, NULL, seen));
    check_ok(export_open(&e, &o, rig));
    check_ok(lt_make_dirs(at("border/front")));
    put_file(at("border/front/000001.jpg"), "", 0);
    check_ok(export_shoot(&e, arena, arena, scene, 0, *seen, depth, view));
    export_fini(&e);
    synth_frame_free(f);
}

/* An object that the border cuts has the pixels that it has where all of it is in the picture, half its width to the
 * right. */
START_TEST(an_object_at_the_border)
{
    workplace_script s = { .body = &body, .hand = hand, .prop = prop, .seed = SEED, .frames = 1, .difficulty = 0.2 };
    static export_view view;
    static uint8_t whole[PIXELS];
    const synth_bop_object *o = &view.poses.object[0];
    workplace_scene *scene;
    recording_rig rig;
    synth_room *room;
    synth_seen *seen;
    synth_pixels b;
    synth_camera camera;
    bool cut = false;
    int64_t n;

    check_ok(workplace_script_new(arena, &s));
    check_ok(workplace_room(arena, &s, &room));
    check_ok(workplace_scene_at(arena, &s, room, 0, &scene));
    workplace_rig(&s, 1, SHRINK, &rig);
    const int thing = 3 * s.n_people;

    camera = workplace_camera(&rig.camera[0]);
    check_ok(synth_world_cover(arena, &scene->world, &camera, thing, whole, &cut));
    ck_assert(!cut);
    b = synth_pixels_of(whole, WIDTH, HEIGHT, &n);
    const int shift = (b.x0 + b.x1) / 2;

    rig.camera[0].K.cx -= shift;
    shoot(scene, room, &rig, &seen, &view);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH - shift; x++)
            whole[y * WIDTH + x + shift] |= seen[thing].mask[y * WIDTH + x];
    b = synth_pixels_of(whole, WIDTH, HEIGHT, &n);
    ck_assert(o->visible > 0 && o->visible < n && o->box.x0 == 0 && o->measured == 0);
    ck_assert_int_eq(o->whole, n);
    ck_assert(o->whole_box.x0 == b.x0 - shift && o->whole_box.x1 == b.x1 - shift);
    ck_assert(o->whole_box.y0 == b.y0 && o->whole_box.y1 == b.y1);
}
END_TEST

static bool stop_after_frames(void *ctx, const char *step, int64_t done, int64_t total)
{
    (void)ctx;
    (void)total;
    return strcmp(step, "moments") != 0 || done == 0;
}

START_TEST(stopped_it_leaves_no_lists)
{
    const synth_options o = { .preset = SYNTH_WORLD, .out = at("stopped"), .seed = SEED, .frames = 1, .cameras = 1,
                              .coco = true, .bop = true, .progress = stop_after_frames };
    synth_figure figures[SYNTH_FIGURES];
    int n;

    check_error(workplace_film(&o, &means, SHRINK, figures, &n), LT_ESTOPPED, "it is not complete");
    ck_assert_int_eq(access(at("stopped/coco/train/front_000001.jpg"), F_OK), 0);
    ck_assert_int_eq(access(at("stopped/bop/train_synt/000001/rgb/000001.jpg"), F_OK), 0);
    ck_assert_int_ne(access(at("stopped/coco/annotations/instances_train.json"), F_OK), 0);
    ck_assert_int_ne(access(at("stopped/bop/train_synt/000001/scene_gt.json"), F_OK), 0);
    ck_assert_int_ne(access(at("stopped/manifest.json"), F_OK), 0);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 0);
    tcase_add_unchecked_fixture(t, setup, close_scratch);
    tcase_add_test(t, coco_is_as_written_by_hand);
    tcase_add_test(t, bop_is_as_written_by_hand);
    tcase_add_test(t, models_are_read_back);
    tcase_add_test(t, same_bytes);
    tcase_add_test(t, the_detector_s_reader_reads_it);
    tcase_add_test(t, what_is_seen_is_a_part_of_the_whole);
    tcase_add_test(t, poses_masks_and_counts_agree);
    tcase_add_test(t, an_object_at_the_border);
    tcase_add_test(t, stopped_it_leaves_no_lists);
}

int main(void)
{
    return run_suite("export", add_tests);
}
