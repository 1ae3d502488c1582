/* SPDX-License-Identifier: Apache-2.0 */
/* What is fuzzed: each reader with the code behind it that trusts it. */
#define _GNU_SOURCE                     /* memfd_create */
#include "tests/fuzz/fuzz.h"

#include "assets/hand_file.h"
#include "data/action/action.h"
#include "data/body/rows.h"
#include "data/detection/internal.h"
#include "data/ho3d/points.h"
#include "data/mot/mot.h"
#include "data/poses/pose_file.h"
#include "data/recording/line.h"
#include "data/recording/recording.h"
#include "estimate/detection/class_names.h"
#include "eval/scorers/bop_file.h"
#include "eval/scorers/hpe_file.h"
#include "eval/scorers/models_info.h"
#include "libtensor/io/array/npy.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/image/exif.h"
#include "libtensor/io/image/film_head.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/ply.h"
#include "libtensor/io/onnx/onnx.h"
#include "libtensor/io/pickle/dense.h"
#include "libtensor/io/pickle/pickle.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/yaml.h"
#include "libtensor/io/torch/torch.h"
#include "pipeline/boxes.h"
#include "pipeline/calibration/calibration.h"
#include "tasks/detect/results.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* Whatever a reader gives out is looked at, so that the sanitizers see it all. */
static volatile double sink;

static void look_at(const lt_array *a)
{
    const size_t n = lt_array_count(a);

    for (size_t i = 0; i < n; i++) {
        if (a->type == LT_ELEM_TEXT)
            sink = (double)strlen(lt_array_text(a, i));
        else
            sink = lt_array_get(a, i) + (double)lt_array_int(a, i);
    }
}

static void look_at_all(const lt_named_array *entry, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        sink = (double)strlen(entry[i].name);
        look_at(&entry[i].array);
    }
}

static void look_at_refused(const lt_refused_array *list, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        sink = (double)(strlen(list[i].name) + strlen(list[i].reason));
        for (size_t k = 0; list[i].pickle && k < list[i].n; k++)
            sink = list[i].pickle[k];
    }
}

/* For readers that want a file: one in memory, with a path. */
typedef struct {
    int fd;
    char path[32];
} memory_file;

static memory_file memory_file_of(const void *bytes, size_t n)
{
    memory_file f = { .fd = memfd_create("fuzz", MFD_CLOEXEC) };

    if (f.fd < 0 || write(f.fd, bytes, n) != (ssize_t)n)
        abort();
    snprintf(f.path, sizeof(f.path), "/proc/self/fd/%d", f.fd);
    return f;
}

/* ---- the readers ---------------------------------------------------------------------------------- */

static void run_pickle(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const lt_pvalue *v;
    float numbers[48];

    if (lt_pickle_parse(arena, "x.pkl", bytes, n, &v) == LT_OK) {
        lt_pfloats(v, "x", numbers, 48);
        for (size_t i = 0; v->kind == LT_PDICT && i < v->n; i++) {
            lt_array a;

            sink = lt_pstr(v->u.item[2 * i]) ? 1 : 0;
            if (lt_pickle_dense(arena, v->u.item[2 * i + 1], &a) == LT_OK)
                look_at(&a);
        }
    }
}

static void run_torch(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const char *names;
    lt_torch_file f;

    if (lt_torch_parse(arena, "x.pth", bytes, n, &f) == LT_OK) {
        class_names_in(arena, &f, &names);
        look_at_all(f.entry, f.n);
        for (size_t i = 0; i < f.n; i++)
            if (f.within[i] > strlen(f.entry[i].name))
                abort();
        look_at_refused(f.refused, f.n_refused);
    }
}

static void run_npy(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_array a;

    if (lt_npy_parse(arena, "x.npy", bytes, n, &a) == LT_OK)
        look_at(&a);
}

static void run_npz(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_npz z;

    if (lt_npz_parse(arena, "x.npz", bytes, n, &z) == LT_OK) {
        look_at_all(z.entry, z.n);
        look_at_refused(z.refused, z.n_refused);
        if (lt_npz_parse_list(arena, "x.npz", bytes, n, &z) != LT_OK && lt_last_status() != LT_ENOMEM)
            abort();                                /* it asks for less */
    }
}

static void run_safetensors(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_safetensors s;

    if (lt_safetensors_parse(arena, "x.safetensors", bytes, n, &s) == LT_OK) {
        look_at_all(s.entry, s.n);
        look_at_refused(s.refused, s.n_refused);
        sink = lt_safetensors_meta(&s, "format") ? 1 : 0;
    }
}

/* What is read, not what is recorded of it: that is the graph's, and its ops' shape rules. */
static void run_onnx(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_onnx_model m;

    sink = lt_onnx_parse(arena, "x.onnx", bytes, n, &m);
}

static void run_json(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    cJSON *root;

    (void)arena;
    if (lt_json_parse("x.json", (const char *)bytes, n, &root) == LT_OK) {
        FILE *null = fopen("/dev/null", "w");

        lt_json_print(null, root);
        fclose(null);
        cJSON_Delete(root);
    }
}

static void run_yaml(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const lt_yaml *v, *inner;
    double x[12];

    if (lt_yaml_parse(arena, "x.yml", bytes, n, &v) == LT_OK)
        for (v = v->first; v; v = v->next)
            if (lt_yaml_numbers(v, x, 12) && lt_yaml_get(v, "color", &inner) == LT_OK)
                lt_yaml_list(inner, -1);
}

static void run_image(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_image img, rgb;

    if (lt_image_decode(arena, "x", bytes, n, &img) == LT_OK && lt_image_to_rgb8(arena, &img, &rgb) == LT_OK)
        for (size_t i = 0; i < lt_image_bytes(&rgb); i += 61)
            sink = rgb.data[i];
}

static bool starts(const uint8_t *bytes, size_t n, const char *magic)
{
    return n >= strlen(magic) && memcmp(bytes, magic, strlen(magic)) == 0;
}

/* OpenCV's formats are not ours: only what begins as PNG and JPEG do. */
static void run_png(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    if (starts(bytes, n, "\x89PNG"))
        run_image(arena, bytes, n);
}

static void run_jpeg(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    if (starts(bytes, n, "\xff\xd8\xff"))
        run_image(arena, bytes, n);
}

static void run_exif(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const lt_exif e = lt_exif_read(bytes, n);

    (void)arena;
    if (e.orientation < 1 || e.orientation > 8)
        abort();
    sink = lt_exif_focal_px(&e, 640, 480);
}

static void run_film_head(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    const lt_film_head head = lt_film_head_read(f.path);

    (void)arena;
    if (head.orientation < 1 || head.orientation > 8 || (head.want_bytes && head.want_bytes <= (int64_t)n))
        abort();
    close(f.fd);
}

static void look_at_mesh(const lt_mesh *m)
{
    for (int i = 0; i < m->n_faces; i++)
        for (int k = 0; k < 3; k++)
            sink = m->vertex[m->face[i][k]][k];
    for (int i = 0; i < m->n_vertices; i++)
        sink = (m->uv ? m->uv[i][1] : 0) + (m->normal ? m->normal[i][2] : 0) + (m->color ? m->color[i][2] : 0);
}

static void run_obj(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    lt_mesh mesh;

    if (lt_obj_read(arena, f.path, &mesh, NULL) == LT_OK)
        look_at_mesh(&mesh);
    close(f.fd);
}

static void run_ply(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_splat *splat;
    lt_mesh mesh;
    size_t count;
    lt_ply p;

    if (lt_ply_parse(arena, "x.ply", bytes, n, &p) == LT_OK) {
        if (lt_ply_mesh(arena, &p, &mesh) == LT_OK)
            look_at_mesh(&mesh);
        if (lt_ply_splats(arena, &p, &splat, &count) == LT_OK)
            for (size_t i = 0; i < count; i++)
                sink = splat[i].rotation[3];
    }
}

static void run_rle(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    uint8_t mask[40 * 50];
    char text[1025];

    (void)arena;
    n = n < sizeof(text) ? n : sizeof(text) - 1;
    memcpy(text, bytes, n);
    text[n] = '\0';
    if (lt_rle_decode(text, 40, 50, mask) == LT_OK)
        sink = mask[1999];
}

/* A mesh whose material library is the input: both are in the folder of open files. */
static void run_mtl(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file library = memory_file_of(bytes, n);
    char text[128];
    const char *texture;
    memory_file f;
    lt_mesh mesh;
    lt_status st;

    snprintf(text, sizeof(text), "mtllib %d\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", library.fd);
    f = memory_file_of(text, strlen(text));
    st = lt_obj_read(arena, f.path, &mesh, &texture);
    if (st && st != LT_ENOMEM)
        abort();                                    /* the library may be wrong, the mesh is not */
    sink = !st && texture ? (double)strlen(texture) : 0;
    close(f.fd);
    close(library.fd);
}

static void run_xyz(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    float (*points)[3];
    size_t count;

    if (lt_xyz_read(arena, f.path, &points, &count) == LT_OK)
        for (size_t i = 0; i < count; i++)
            sink = points[i][2];
    close(f.fd);
}

static void run_hand_file(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    lt_hand_model *hand;

    if (hand_file_read(arena, f.path, &hand) == LT_OK)
        sink = hand->v_template[0][0];
    close(f.fd);
}

/* ---- what is scored ------------------------------------------------------------------------------- */

static void run_bop(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    bop_file file;

    if (bop_file_read(arena, f.path, &file) == LT_OK)
        for (int64_t i = 0; i < file.n; i++) {
            const bop_estimate *e = &file.estimate[i];
            if (!bop_file_find(&file, e->scene, e->image, e->object))
                abort();                            /* what is in the file is found */
            sink = e->pose.t[2];
        }
    close(f.fd);
}

static void run_hpe(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    hpe_file file;

    if (hpe_file_read(arena, f.path, &file) == LT_OK)
        for (int64_t i = 0; i < file.n; i++) {
            if (!hpe_file_find(&file, file.line[i].index))
                abort();
            sink = file.line[i].joints[20][2];
        }
    close(f.fd);
}

/* Frames of two points and of one, in place of 21 and 778: few bytes make many. */
static void read_points(const char *path, bool any)
{
    static const int points[2] = { 2, 1 };
    static float out[HO3D_MOST_POINTS][3];
    ho3d_points *file;

    if (ho3d_points_open(path, points, 2, &file) != LT_OK)
        return;
    if (any)
        ho3d_points_any(file);
    for (int list = 0; list < 2; list++) {
        bool more = true;
        while (more && ho3d_points_next(file, &out[0][0], &more) == LT_OK)
            for (int i = 0; more && i < ho3d_points_of(file, list); i++)
                sink = out[i][2];
    }
    ho3d_points_close(file);
}

static void run_points(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);

    (void)arena;
    read_points(f.path, false);
    read_points(f.path, true);
    close(f.fd);
}

/* ---- pictures with objects ------------------------------------------------------------------------------- */

enum { SMALL = 1 << 16 };

static void look_at_mask(lt_arena *arena, const detection_object *o, int width, int height)
{
    uint8_t *mask = (int64_t)width * height <= SMALL ? lt_arena_array(arena, (size_t)width * (size_t)height, 1) : NULL;

    if (mask && detection_mask(o, width, height, mask) == LT_OK)
        for (int i = 0; i < width * height; i++)
            if (mask[i] > 1)
                abort();
}

static void run_coco(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    detection_set set = { .root = "", .split = "train" };

    if (detection_parse_coco(arena, f.path, "images", &set) == LT_OK)
        for (int64_t i = 0; i < set.count; i++)
            for (int k = 0; k < set.image[i].n; k++) {
                const detection_object *o = &set.image[i].object[k];

                if (o->cls < 0 || o->cls >= set.classes || !(o->box[2] > o->box[0] && o->box[3] > o->box[1]))
                    abort();
                look_at_mask(arena, o, set.image[i].width, set.image[i].height);
            }
    close(f.fd);
}

static void run_labels(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    char *copy = malloc(n + 1);             /* a file's bytes have a NUL behind them */
    object_list objects = { NULL };
    int64_t twice = 0;

    memcpy(copy, bytes, n);
    copy[n] = 0;
    if (detection_parse_labels(arena, "x.txt", copy, n, 3, &objects, &twice) == LT_OK)
        for (size_t i = 0; i < objects.n; i++) {
            if (objects.list[i].cls < 0 || objects.list[i].cls >= 3)
                abort();
            look_at_mask(arena, &objects.list[i], 7, 5);
        }
    free(copy);
}

static void run_results(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    static const detection_image image[] = {
        { .id = 7, .name = "a", .width = 4, .height = 3 }, { .id = 9, .name = "b" },
    };
    static const int64_t class_id[] = { 1, 5 };
    const detection_set set = { .list = "x", .image = image, .count = 2, .classes = 2, .class_id = class_id };
    const memory_file f = memory_file_of(bytes, n);
    detect_result *r;

    if (detect_results_read(arena, f.path, &set, &r) == LT_OK)
        for (int i = 0; i < 2; i++)
            for (size_t k = 0; k < r[i].n; k++)
                sink = r[i].found[k].score;
    close(f.fd);
}

static void run_models_info(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    bop_model model[YCB_COUNT + 1];

    if (models_info_read(arena, f.path, model) == LT_OK)
        for (int id = 1; id <= YCB_COUNT; id++)
            for (int i = 0; i < model[id].n_symmetries; i++)
                sink = model[id].symmetry[i].t[2];
    close(f.fd);
}

static lt_status look_at_pose(void *ctx, const pose_record *r)
{
    (void)ctx;
    if (r->has_hand)
        for (int i = 0; i < 48; i++)
            sink = r->pose[i] + r->beta[i % 10] + r->trans[i % 3] + r->wrist[i % 3];
    if (r->has_object)
        for (int i = 0; i < 9; i++)
            if (!(r->R[i] >= -1.001 && r->R[i] <= 1.001))
                abort();                            /* whatever the form, it comes out as a rotation */
    sink = (double)strlen(r->frame) + (r->object_name ? (double)strlen(r->object_name) : 0) + r->t[2];
    return LT_OK;
}

static void run_poses(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    char *copy = malloc(n + 1);             /* a file's bytes have a NUL behind them */
    const char *format;

    (void)arena;
    memcpy(copy, bytes, n);
    copy[n] = 0;
    pose_file_parse((pose_text){ "x.json", copy, n }, (pose_text){ "x.json", copy, n }, look_at_pose, NULL, &format);
    free(copy);
}

/* The kind is not in the file: each of them takes it, or says why not. */
static void run_mot(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    enum { FRAMES = 20 };

    for (mot_kind kind = MOT_TRUTH; kind <= MOT_RESULTS; kind++) {
        char *text = lt_arena_alloc(arena, n + 1);
        mot_frame *frame;

        if (!text)
            return;
        memcpy(text, bytes, n);
        if (mot_parse(arena, "x.txt", text, n, kind, FRAMES, &frame))
            continue;
        for (int k = 0; k < FRAMES; k++)
            for (int i = 0; i < frame[k].n; i++) {
                sink = frame[k].box[i].box[2] + frame[k].box[i].score + (double)frame[k].box[i].id;
                if (frame[k].box[i].cls < 1 || frame[k].box[i].cls > MOT_CLASSES)
                    abort();
            }
    }
}

static void run_looks(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    char *text = lt_arena_alloc(arena, n + 1);
    mot_looks looks;

    if (!text)
        return;
    memcpy(text, bytes, n);
    if (mot_parse_looks(arena, "identities.csv", text, n, &looks))
        return;
    for (int i = 0; i < looks.n; i++)
        if (mot_look(&looks, "a_person", looks.person[i].id) < 1)
            abort();
}

static void run_seqinfo(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    char *text = lt_arena_alloc(arena, n + 1);
    mot_sequence s = { .name = "" };

    if (!text)
        return;
    memcpy(text, bytes, n);
    if (mot_parse_info(arena, "seqinfo.ini", text, n, &s))
        return;
    sink = (double)(strlen(s.images) + strlen(s.extension));
    if (s.frames < 1 || s.frames > MOT_MAX_FRAMES || s.width < 0 || s.height < 0 || !(s.fps > 0))
        abort();
}

static void run_action_labels(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    enum { CLIPS = 3, LENGTH = 90 };
    const action_clip *clip;

    if (action_parse_labels(arena, "label.json", (const char *)bytes, n, CLIPS, LENGTH, &clip))
        return;
    for (int i = 0; i < CLIPS; i++) {
        sink = (double)strlen(clip[i].name);
        if (clip[i].cls < 0 || clip[i].cls >= ACTION_CLASSES || clip[i].frames < 1 || clip[i].frames > LENGTH
            || clip[i].subject < 0 || clip[i].onset > LENGTH)
            abort();
    }
}

static void run_body_rows(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    body_row *row;
    int64_t rows;

    if (body_rows_parse(arena, "train.npz", bytes, n, &row, &rows))
        return;
    for (int64_t i = 0; i < rows; i++) {
        sink = (double)row[i].pose[54][2] + row[i].sits;
        if (!(row[i].nodes_3d[0][2] > 0 && row[i].K[0][0] > 0))
            abort();
    }
}

/* All of a recording's files are tried with the cameras of a sound one. */
static void run_recording(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    recording r = { .rig = { .n = 2, .camera = { { .depth_scale = 1 } } } };
    const char *text = (const char *)bytes;
    uint16_t depth[16];
    recording_rig rig;

    recording_rig_parse(arena, "recording.json", text, n, &rig);
    recording_depth_unpack(arena, "a.z16", bytes, n, 4, 4, depth);
    if (recording_parse_frames(arena, "frames.jsonl", text, n, &r))
        r.n_frames = 0;
    if (recording_parse_sets(arena, "sets.jsonl", text, n, &r))
        return;
    for (int64_t i = 0; i < r.n_sets; i++)
        for (int c = 0; c < 2; c++)
            if (r.set[i].frame[c] >= r.n_frames)
                abort();
}

static void run_session(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    session_line l;

    session_line_parse(arena, "truth.ndjson", 1, (const char *)bytes, n, true, &l);
    if (session_line_parse(arena, "session.ndjson", 1, (const char *)bytes, n, false, &l))
        return;
    for (int i = 0; i < l.n_tracks; i++)
        if (l.track[i].camera < 0 || l.track[i].camera >= RECORDING_CAMERAS || !l.track[i].cls)
            abort();
    for (int i = 0; i < l.n_actions; i++)
        sink = (double)strlen(l.action[i].what);
}

static void run_boxes(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const memory_file f = memory_file_of(bytes, n);
    predict_boxes boxes;

    if (predict_boxes_read(arena, f.path, &boxes) == LT_OK)
        for (size_t i = 0; i < boxes.n; i++) {
            const predict_boxes_row *row = &boxes.row[i];
            if (row->has_hand && !(row->hand.x0 < row->hand.x1 && row->hand.y0 < row->hand.y1))
                abort();
            sink = (double)strlen(row->image) + (double)row->object.y1;
        }
    close(f.fd);
}

static void run_calibration(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    uint8_t *copy = malloc(n + 1);          /* a file's bytes have a NUL behind them */
    calibration c;

    memcpy(copy, bytes, n);
    copy[n] = 0;
    if (calibration_parse(arena, "K.yml", copy, n, &c) == LT_OK && !(c.camera.fx >= 1 && c.camera.fy >= 1))
        abort();
    free(copy);
}

const fuzz_target fuzz_targets[] = {
    { "pickle", run_pickle, fuzz_pickle, 16384 },
    { "torch", run_torch, fuzz_torch, 8192 },
    { "npy", run_npy, NULL, 4096 },
    { "npz", run_npz, fuzz_zip, 4096 },
    { "safetensors", run_safetensors, NULL, 4096 },
    { "onnx", run_onnx, NULL, 4096 },
    { "json", run_json, NULL, 4096 },
    { "yaml", run_yaml, NULL, 4096 },
    { "png", run_png, fuzz_png, 4096 },
    { "jpeg", run_jpeg, NULL, 4096 },
    { "exif", run_exif, NULL, 4096 },
    { "film_head", run_film_head, NULL, 8192 },
    { "obj", run_obj, NULL, 4096 },
    { "mtl", run_mtl, NULL, 4096 },
    { "ply", run_ply, NULL, 4096 },
    { "rle", run_rle, NULL, 1024 },
    { "xyz", run_xyz, NULL, 4096 },
    { "hand_file", run_hand_file, fuzz_torch, 32768 },
    { "bop", run_bop, NULL, 4096 },
    { "hpe", run_hpe, NULL, 4096 },
    { "points", run_points, NULL, 4096 },
    { "models_info", run_models_info, NULL, 4096 },
    { "poses", run_poses, NULL, 4096 },
    { "coco", run_coco, NULL, 4096 },
    { "labels", run_labels, NULL, 4096 },
    { "results", run_results, NULL, 4096 },
    { "mot", run_mot, NULL, 4096 },
    { "looks", run_looks, NULL, 4096 },
    { "seqinfo", run_seqinfo, NULL, 1024 },
    { "action_labels", run_action_labels, NULL, 4096 },
    { "body_rows", run_body_rows, fuzz_zip, 8192 },
    { "recording", run_recording, NULL, 4096 },
    { "session", run_session, NULL, 8192 },
    { "boxes", run_boxes, NULL, 4096 },
    { "calibration", run_calibration, NULL, 4096 },
    { 0 },
};

const fuzz_target *fuzz_find(const char *name)
{
    for (const fuzz_target *t = fuzz_targets; t->name; t++)
        if (strcmp(t->name, name) == 0)
            return t;
    return NULL;
}

void fuzz_run(const fuzz_target *t, const uint8_t *bytes, size_t n, long fail_at)
{
    lt_arena *arena = lt_arena_new();

    if (!arena)
        abort();
    lt_alloc_fail_at(fail_at);
    t->run(arena, bytes, n);
    lt_alloc_fail_at(0);
    lt_arena_free(arena);
}
