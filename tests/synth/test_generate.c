/* SPDX-License-Identifier: Apache-2.0 */
/* A very small synthetic dataset, through the doors that the real one comes by. */
#include "assets/ycb/objects.h"
#include "data/dexycb/dexycb.h"
#include "data/hand_object.h"
#include "data/ho3d/ho3d.h"
#include "eval/scorers/ho3d/score.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/pickle/pickle.h"
#include "libtensor/io/text/json.h"
#include "synth/generate.h"
#include "synth/take/annotate.h"
#include "synth/take/rig.h"
#include "synth/write/dexycb.h"
#include "synth/write/ho3d.h"
#include "synth/write/model.h"
#include "tests/synth/made.h"
#include "vision/picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { W = SYNTH_WIDTH, H = SYNTH_HEIGHT };

static lt_hand_model *hand;

static synth_options tiny(const char *folder)
{
    return (synth_options){ .preset = SYNTH_TINY, .out = at(folder), .seed = 11, .frames = 6 };
}

/* One dataset for all tests: a frame of each of the six sequences. */
static void setup(void)
{
    synth_options o;

    open_scratch();
    o = tiny("data");
    check_ok(synth_generate(&o, NULL, NULL));
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
}

static dataset *open_split(const char *split)
{
    const ho3d_options o = { .root = at("data"), .split = split, .vertices = true };
    dataset *d = NULL;

    check_ok(ho3d_open(&o, &d));
    return d;
}

/* ---- the files ---- */

START_TEST(manifest)
{
    ck_assert_int_eq(check_manifest("tiny", "11"), 6 * SYNTH_FRAME_FILES + 3 * 4 + 5);
}
END_TEST

/* The keys of a meta file, as many as wanted and no more. */
static void keys_are(const char *path, const char *const *want, size_t n)
{
    const lt_pvalue *v;

    check_ok(lt_pickle_read(arena, path, &v));
    ck_assert_int_eq(v->kind, LT_PDICT);
    ck_assert_uint_eq(v->n, n);
    for (size_t i = 0; i < n; i++)
        ck_assert_msg(lt_pdict_get(v, want[i]) != NULL, "%s: no %s", path, want[i]);
}

START_TEST(annotation_keys)
{
    static const char *const train[] = {
        "camMat", "objName", "objLabel", "objRot", "objTrans", "objCorners3DRest", "objCorners3D",
        "camIDList", "handPose", "handTrans", "handBeta", "handJoints3D", "handVertContact", "handVertDist",
        "handVertIntersec", "handVertObjSurfProj",
    };
    static const char *const evaluation[] = {
        "camMat", "objName", "objLabel", "objRot", "objTrans", "objCorners3DRest", "objCorners3D",
        "camIDList", "handJoints3D", "handBoundingBox",
    };
    static const struct { const char *split; const char *const *keys; size_t n; } cases[] = {
        { "train", train, LT_COUNT(train) }, { "evaluation", evaluation, LT_COUNT(evaluation) },
    };

    for (int i = 0; i < 2; i++) {
        dataset *d = open_split(cases[i].split);
        const char *name = dataset_name(d, 0), *slash = strchr(name, '/');
        keys_are(lt_arena_printf(arena, "%s/data/%s/%.*s/meta%s.pkl", scratch_folder, cases[i].split,
                                 (int)(slash - name), name, slash), cases[i].keys, cases[i].n);
        dataset_free(d);
    }
}
END_TEST

START_TEST(same_seed_same_bytes)
{
    synth_options o = tiny("again");

    lt_set_threads(1);
    check_ok(synth_generate(&o, NULL, NULL));
    lt_set_threads(0);
    same_files(at("data/manifest.json"), at("again/manifest.json"));
}
END_TEST

START_TEST(a_full_folder_is_left_alone)
{
    const synth_options o = tiny("data");

    ck_assert_int_eq(synth_generate(&o, NULL, NULL), LT_EINVAL);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "/data: is not empty (it holds "));
}
END_TEST

static bool never(void *ctx, const char *step, int64_t done, int64_t total)
{
    (void)ctx;
    (void)step;
    return done < total / 2;
}

START_TEST(stopping)
{
    synth_options o = tiny("stopped");
    struct stat info;

    o.progress = never;
    ck_assert_int_eq(synth_generate(&o, NULL, NULL), LT_ESTOPPED);
    ck_assert_str_eq(lt_last_error(), lt_arena_printf(arena, "%s: stopped after 3 of 6 frames; it is not "
                                                      "complete", o.out));
    ck_assert_int_ne(stat(at("stopped/train.txt"), &info), 0);
    ck_assert_int_ne(stat(at("stopped/manifest.json"), &info), 0);
    ck_assert_int_eq(synth_generate(&o, NULL, NULL), LT_EINVAL);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "/stopped: holds a dataset that was not finished; remove it"));
}
END_TEST

/* ---- read back ---- */

START_TEST(reads_as_ho3d)
{
    dataset *d = open_split("train");
    double rms;

    ck_assert_str_eq(d->title, "HO3D v3");
    ck_assert(d->synthetic);
    ck_assert_int_eq(d->count, 4);
    ck_assert_int_eq(d->n_objects, 3);
    check_ok(dataset_check_tips(d, hand, &rms));
    ck_assert_double_lt(rms, 0.01);
    ck_assert_int_eq(d->tips[0], 728);
    for (int64_t i = 0; i < d->count; i++) {
        dataset_sample s;
        check_ok(dataset_read(d, i, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s));
        ck_assert_int_ge(s.object, 0);
        ck_assert_ptr_nonnull(strstr(d->objects[s.object].name, "syn_"));
    }
    dataset_free(d);
}
END_TEST

/* The truth scores as the truth, and nothing at all as bad as hands are large. */
START_TEST(truth_is_perfect)
{
    dataset *d = open_split("evaluation");
    ho3d_scorer *perfect = ho3d_scorer_new(), *zero = ho3d_scorer_new();
    static const float none[LT_HAND_VERTICES * 3];
    double score[HO3D_SCORES];

    ck_assert_int_eq(d->count, 2);
    for (int64_t i = 0; i < d->count; i++) {
        float joints[21 * 3], verts[LT_HAND_VERTICES * 3];
        dataset_sample s;
        check_ok(dataset_read(d, i, 0, arena, &s));
        ho3d_joints_from_camera(&s.joints[0][0], joints);
        ho3d_vertices_from_camera(&s.vertices[0][0], verts);
        for (int k = 0; k < 3; k++)
            ck_assert_float_eq_tol(s.root[k], s.joints[0][k], 1e-6);
        check_ok(ho3d_scorer_add(perfect, 1, joints, verts, joints, verts, NULL));
        check_ok(ho3d_scorer_add(zero, 1, none, none, joints, verts, NULL));
    }
    ho3d_scorer_scores(perfect, score);
    ck_assert_double_eq(score[HO3D_XYZ_MEAN], 0);
    ck_assert_double_lt(score[HO3D_XYZ_PA_MEAN], 1e-4);
    ck_assert_double_eq(score[HO3D_F_5], 1);
    ck_assert_double_eq(score[HO3D_F_AL_5], 1);
    ck_assert_double_eq(score[HO3D_XYZ_AUC], 1);
    ho3d_scorer_scores(zero, score);
    ck_assert(score[HO3D_XYZ_PA_MEAN] > 4 && score[HO3D_XYZ_PA_MEAN] < 6.5);
    ho3d_scorer_free(perfect);
    ho3d_scorer_free(zero);
    dataset_free(d);
}
END_TEST

START_TEST(makes_batches)
{
    const hand_object_feed feed = { .data = open_split("train"), .options = hand_object_defaults(true, 5) };
    const loader_source source = hand_object_source(&feed);
    const loader_options o = { .batch = 3, .threads = 2, .ahead = 2, .shuffle = true, .seed = 5 };
    float first[42];
    loader *l;
    void *batch;

    for (int run = 0; run < 2; run++) {
        hand_object_batch *b;
        check_ok(loader_new(&source, &o, (loader_position){ 0 }, &l));
        check_ok(loader_next(l, &batch));
        b = batch;
        ck_assert_int_eq(b->count, 3);
        for (int i = 0; i < b->count; i++) {
            double covered = 0;
            for (int k = 0; k < 32 * 32; k++)
                covered += b->mask[1024 * i + k] / 1024;
            ck_assert_double_gt(covered, 0.1);
            ck_assert_double_lt(covered, 1);
            ck_assert_float_eq(b->weight[i], 1);
        }
        if (run)
            ck_assert_mem_eq(first, b->joints2d, sizeof(first));
        memcpy(first, b->joints2d, sizeof(first));
        loader_free(l);
    }
    dataset_free((dataset *)feed.data);
}
END_TEST

/* ---- one frame, filmed here, against what its files say ---- */

typedef struct {
    synth_prop prop;
    synth_subject subject;
    synth_stage stage;
    synth_frame *frame;
    float *depth;
    synth_picture picture;
    synth_visibility visibility;
    dataset *d;
    dataset_sample sample;
} shot;

/* A frame in the middle of handling a can, written into a training split of its own and read back. */
static void film(shot *s)
{
    enum { FRAMES = 9, K = 5 };
    synth_grasp_ctx *ctx;
    synth_grasp grasp;
    synth_posed_hand posed;
    synth_file file[4];
    uint8_t part[LT_HAND_VERTICES];
    const ho3d_options o = { .root = at("one"), .split = "train" };

    synth_subject_draw(hand, 3, 1, &s->subject);
    check_ok(synth_prop_new(arena, 9, false, &s->prop));
    check_ok(synth_grasp_ctx_new(arena, 9, &s->prop.mesh, NULL, hand, s->subject.beta, &ctx));
    check_ok(synth_grasp_sample(ctx, 5, NULL, &grasp));
    check_ok(synth_stage_new(arena, &(synth_stage_spec){
        .hand = hand, .subject = &s->subject, .prop = &s->prop, .grasp = &grasp, .n_grasps = 1, .n_frames = FRAMES,
        .n_cameras = 1, .setting.depth_unit = HO3D_DEPTH_UNIT, .seed = 3, .stream = 4 }, &s->stage));
    s->frame = synth_frame_new(W, H);
    s->depth = lt_arena_array(arena, (size_t)W * H, sizeof(float));
    synth_stage_pose(&s->stage, &s->stage.sequence.moment[s->stage.kept[K]], &posed);
    check_ok(synth_stage_film(&s->stage, 0, K, &posed, s->frame, s->depth));
    s->picture = (synth_picture){ .sequence = "SYN1PM00", .frame = 77, .rgb = &s->frame->rgb[0][0],
                                  .depth = s->depth, .label = s->frame->label };
    synth_annotate(&s->stage, 0, K, &posed, &s->picture);
    synth_annotate_contact(&s->stage, &s->picture);
    synth_hand_parts(hand, part);
    synth_look(&s->picture, s->frame, SYNTH_MANIPULATE, part, &s->visibility);
    check_ok(synth_make_sequence(at("one"), "SYN1PM00", false));
    check_ok(synth_write_model(at("one"), s->prop.name, &s->prop.mesh, (const uint8_t (*)[3])s->prop.rgb,
                         SYNTH_TEXTURE, s->prop.points, SYNTH_POINTS, file));
    check_ok(synth_write_picture(at("one"), &s->picture, true, 0, file));
    check_ok(lt_write_file(at("one/train.txt"), "SYN1PM00/0077\n", 14));
    check_ok(ho3d_open(&o, &s->d));
    check_ok(dataset_read(s->d, 0, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s->sample));
}

static void vertices_return(const shot *s)
{
    double R[16 * 9], beta[10], v[LT_HAND_VERTICES][3], joints[LT_HAND_JOINTS][3];

    for (int i = 0; i < 16 * 9; i++)
        R[i] = s->sample.rotation[i / 9][i % 9];
    for (int i = 0; i < 10; i++)
        beta[i] = s->sample.beta[i];
    lt_hand_pose(hand, R, beta, NULL, &v[0][0], &joints[0][0]);
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(v[i][k] - joints[0][k] + s->sample.root[k], s->picture.vertices[i][k], 1e-5);
}

static void joints_return(const shot *s)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const double *p = s->picture.joints[lt_mano_to_simple[i]];
        double uv[2];
        lt_camera_project(&s->picture.camera, p, uv);
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(s->sample.joints[i][k], p[k], 1e-6);
        for (int k = 0; k < 2; k++)
            ck_assert_double_eq_tol(s->sample.joints2d[i][k], uv[k], 0.01);
    }
}

static void object_returns(const shot *s)
{
    for (int i = 0; i < 9; i++)
        ck_assert_double_eq_tol(s->sample.R[i], s->picture.R[i], 1e-6);
    for (int i = 0; i < 3; i++)
        ck_assert_double_eq_tol(s->sample.t[i], s->picture.t[i], 1e-6);
}

/* The silhouette drawn by the reader is the amodal mask of the renderer, but for its edge. */
static void silhouettes_agree(const shot *s)
{
    int either = 0, differ = 0;

    for (int i = 0; i < W * H; i++) {
        const bool a = s->sample.silhouette[i], b = s->frame->object_mask[i];
        either += a || b;
        differ += a != b;
    }
    ck_assert_int_gt(either, 2000);
    ck_assert_int_lt(differ, either / 25);
}

static void pixels_return(const shot *s)
{
    ck_assert_mem_eq(s->sample.rgb, s->frame->rgb, (size_t)W * H * 3);
    for (int i = 0; i < W * H; i++)
        ck_assert_float_eq_tol(s->sample.depth[i], s->depth[i], 7e-5);
}

/* In the version's container and colours. */
static void mask_returns(const shot *s, const char *path, int hand_channel, int object_channel)
{
    const int other = 3 - hand_channel - object_channel;
    lt_image seg;
    int hands = 0, objects = 0;

    check_ok(lt_image_read(arena, path, &seg));
    ck_assert_int_eq(seg.width, W / 4);
    ck_assert_int_eq(seg.height, H / 4);
    for (int y = 0; y < H / 4; y++)
        for (int x = 0; x < W / 4; x++) {
            const uint8_t *p = seg.data + 3 * (y * W / 4 + x);
            const uint8_t label = s->frame->label[(4 * y + 2) * W + 4 * x + 2];
            ck_assert_int_eq(p[hand_channel] > 200, label == SYNTH_LABEL_HAND);
            ck_assert_int_eq(p[object_channel] > 200, label == 9);
            ck_assert_int_le(p[other], 100);                /* a JPEG's edges ring */
            hands += p[hand_channel] > 200;
            objects += p[object_channel] > 200;
        }
    ck_assert_int_gt(hands, 100);
    ck_assert_int_gt(objects, 20);
}

/* What the reader makes of the mask that is there. */
static void segments_return(const shot *s)
{
    const ho3d_options o = { .root = at("one"), .split = "train" };
    dataset_sample again;
    dataset *d;

    check_ok(ho3d_open(&o, &d));
    check_ok(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &again));
    for (int y = 0; y < H / 4; y++)
        for (int x = 0; x < W / 4; x++) {
            const uint8_t label = s->frame->label[(4 * y + 2) * W + 4 * x + 2];
            const int want = label == SYNTH_LABEL_HAND ? SEGMENT_HAND : label == 9 ? SEGMENT_OBJECT : 0;
            ck_assert_int_eq(again.segments[y * W / 4 + x], want);
        }
    dataset_free(d);
}

static void masks_return(const shot *s)
{
    const char *jpg = at("one/train/SYN1PM00/seg/0077.jpg");
    synth_file file[SYNTH_FRAME_FILES];

    mask_returns(s, jpg, 0, 2);
    segments_return(s);
    unlink(jpg);
    check_ok(synth_write_picture(at("one"), &s->picture, false, 95, file));
    mask_returns(s, at("one/train/SYN1PM00/seg/0077.png"), 2, 1);
    segments_return(s);
}

/* Seen hand pixels, taken back into space by the clean depth, lie on the hand. */
static void depth_lies_on_the_hand(const shot *s)
{
    lt_mesh mesh = { .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES,
                     .vertex = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*mesh.vertex)),
                     .face = hand->faces };
    lt_mesh_index *index;
    int off = 0, all = 0;

    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            mesh.vertex[i][k] = (float)s->picture.vertices[i][k];
    check_ok(lt_mesh_index_new(arena, &mesh, &index));
    for (int i = 0; i < W * H; i += 7) {
        const double uv[2] = { i % W, i / W };
        double p[3];
        if (s->frame->label[i] != SYNTH_LABEL_HAND || s->frame->depth[i] <= 0)
            continue;
        lt_camera_backproject(&s->picture.camera, uv, s->frame->depth[i], p);
        off += lt_mesh_closest(index, p).distance > 0.002;
        all++;
    }
    ck_assert_int_gt(all, 300);
    ck_assert_int_le(off, all / 50);        /* at the edge the label is the hand's, the depth what is behind */
}

/* Every triangle of the object for every vertex of the hand. */
static void contact_is_the_slow_way(const shot *s)
{
    const lt_mesh *o = &s->prop.mesh;
    int touching = 0;

    for (int i = 0; i < LT_HAND_VERTICES; i += 3) {
        double d[3], back[9], p[3], best = INFINITY;
        lt_vec3_sub(s->picture.vertices[i], s->picture.t, d);
        lt_mat3_transpose(s->picture.R, back);
        lt_mat3_mulvec(back, d, p);
        for (int f = 0; f < o->n_faces; f++) {
            double c[3][3], q[3];
            for (int k = 0; k < 9; k++)
                c[k / 3][k % 3] = o->vertex[o->face[f][k / 3]][k % 3];
            lt_closest_on_triangle(p, c[0], c[1], c[2], q);
            best = fmin(best, lt_vec3_distance(p, q));
        }
        ck_assert_double_eq_tol(s->picture.contact.distance[i], best, 1e-4);
        if (fabs(best - 0.004) > 1e-6)
            ck_assert_int_eq(s->picture.contact.contact[i], best < 0.004);
        touching += s->picture.contact.contact[i];
    }
    ck_assert_int_gt(touching, 3);
}

/* ---- the same scene in DexYCB's layout ---- */

static dataset *dexycb_of(const shot *s)
{
    const char *dir = at("dexycb");
    synth_picture *p = lt_arena_alloc(arena, sizeof(*p));
    synth_manifest files = { .arena = arena };
    synth_dexycb_sequence q = { .frames = 1, .cameras = 2, .n_objects = 1, .id = { 9 }, .extrinsics = "e",
                                .mano = "m" };
    synth_dexycb_frame f = { .sequence = &q, .hand = hand, .picture = p };
    synth_camera camera[2] = { s->stage.camera[0], s->stage.camera[0] };
    uint8_t *rgb = lt_arena_alloc(arena, 3 * W * H), *label = lt_arena_alloc(arena, W * H);
    float *depth = lt_arena_array(arena, W * H, sizeof(*depth)), pose_m[51] = { 0 }, pose_y[7] = { 0 };
    synth_file file[4];
    dataset *d;

    synth_rig_mirror(&camera[1], 1);                    /* the second camera sees the mirrored scene */
    check_ok(synth_dexycb_write_intrinsics(dir, camera, 2, &files));
    check_ok(synth_dexycb_write_extrinsics(dir, "e", camera, 2, &files));
    check_ok(synth_dexycb_write_mano(dir, "m", s->picture.beta, &files));
    check_ok(synth_write_model(dir, s->prop.name, &s->prop.mesh, (const uint8_t (*)[3])s->prop.rgb, SYNTH_TEXTURE,
                         s->prop.points, SYNTH_POINTS, file));
    for (int i = 0; i < 5; i++) {
        q.folder = lt_arena_printf(arena, "20260101-subject-01/20260101_10000%d", i);
        q.left = i == 1;
        check_ok(synth_dexycb_make_folders(dir, &q));
        check_ok(synth_dexycb_write_sequence(dir, &q, pose_m, pose_y, &files));
        if (i > 1)
            continue;
        *p = s->picture;
        p->frame = 0;
        p->rgb = memcpy(rgb, s->picture.rgb, 3 * W * H);
        p->label = memcpy(label, s->picture.label, W * H);
        p->depth = memcpy(depth, s->picture.depth, W * H * sizeof(*depth));
        if (q.left)
            synth_dexycb_mirror(p, rgb, depth, label);
        memcpy(f.R[0], p->R, sizeof(p->R));
        memcpy(f.t[0], p->t, sizeof(p->t));
        f.camera = i;
        check_ok(synth_dexycb_write_frame(dir, &f, 95, file));
    }
    check_ok(synth_manifest_text(&files, dir, "synthetic.json", "{\"subjects\": 1, \"sequences\": 5}"));
    check_ok(dexycb_open(&(dexycb_options){ .root = dir, .setup = "s0", .split = "train", .filter = DEXYCB_EVERY,
                                            .hand = hand }, &d));
    return d;
}

static void same(const float *a, const float *b, int n, float tolerance)
{
    for (int i = 0; i < n; i++)
        ck_assert_float_eq_tol(a[i], b[i], tolerance);
}

/* The mesh that a sample's pose makes of the hand, at its root. */
static void mesh_of(const dataset_sample *s, float out[LT_HAND_VERTICES][3])
{
    double R[16 * 9], beta[10], v[LT_HAND_VERTICES][3], j[16][3];

    for (int i = 0; i < 16 * 9; i++)
        R[i] = s->rotation[i / 9][i % 9];
    for (int i = 0; i < 10; i++)
        beta[i] = s->beta[i];
    lt_hand_pose(hand, R, beta, NULL, v[0], j[0]);
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            out[i][k] = (float)(v[i][k] - j[0][k] + s->root[k]);
}

/* HO3D's file and DexYCB's say the same, in the camera's axes, of a right hand; and of the left hand that it is
 * in the mirror, which is read as the right one again. */
static void layouts_agree(const shot *s)
{
    static const int numbers[2] = { 0, 3 };
    dataset *d = dexycb_of(s);
    const dataset_sample *a = &s->sample;
    float va[LT_HAND_VERTICES][3], vb[LT_HAND_VERTICES][3];

    mesh_of(a, va);
    for (int i = 0; i < 2; i++) {
        dataset_sample b;
        check_ok(dataset_read(d, numbers[i], SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &b));
        ck_assert_int_eq(!!(b.flags & SAMPLE_MIRRORED), i == 1);
        same(a->joints[0], b.joints[0], 3, 1e-6f);
        for (int j = 0; j < LT_HAND_KEYPOINTS; j++)
            if (j == 0 || j % 4)                        /* tips are other vertices */
                same(a->joints[j], b.joints[j], 3, 1e-6f);
        same(a->root, b.root, 3, 1e-6f);
        same(a->R, b.R, 9, 1e-6f);
        same(a->t, b.t, 3, 1e-6f);
        same(a->rotation[0], b.rotation[0], 16 * 9, 2e-6f);
        mesh_of(&b, vb);
        same(va[0], vb[0], 3 * LT_HAND_VERTICES, 1e-6f);
        if (i == 0) {                                   /* in the mirror, models/ would have to hold another object */
            same(a->control2d[0], b.control2d[0], 42, 2e-3f);
            ck_assert_mem_eq(a->silhouette, b.silhouette, W * H);
        }
        for (int k = 0; k < W * H; k++)
            ck_assert_float_eq_tol(a->depth[k], b.depth[k], 6e-4f);
        ck_assert_double_eq_tol(a->camera.cx, b.camera.cx, 1e-4);
    }
    dataset_free(d);
}

START_TEST(a_frame_returns)
{
    shot *s = lt_arena_alloc(arena, sizeof(*s));

    film(s);
    vertices_return(s);
    joints_return(s);
    object_returns(s);
    silhouettes_agree(s);
    pixels_return(s);
    masks_return(s);
    depth_lies_on_the_hand(s);
    contact_is_the_slow_way(s);
    layouts_agree(s);
    ck_assert(s->visibility.contact);
    ck_assert_int_eq(s->visibility.inside, LT_HAND_KEYPOINTS);
    dataset_free(s->d);
    synth_frame_free(s->frame);
}
END_TEST

/* Where frame k is in its round: 0 where the hand begins to reach, 1 where it has let go. */
static double part_of_round(const synth_stage *stage, int k)
{
    const synth_moment *m = stage->sequence.moment;
    const int at = stage->kept[k];
    int from = at, to = at;

    while (from > 0 && m[from - 1].round == k)
        from--;
    while (to < stage->sequence.n && m[to].round == k)
        to++;
    ck_assert_int_eq(m[at].round, k);
    return (double)(at - from) / (to - from);
}

/* Of each grasp as many frames, where that is possible; else evenly spread over all. A single one shows another part
 * of the motion each time. */
START_TEST(rounds_have_their_frames)
{
    shot *s = lt_arena_alloc(arena, sizeof(*s));
    synth_grasp_ctx *ctx;
    synth_grasp grasp[3];
    synth_stage stage;

    synth_subject_draw(hand, 3, 1, &s->subject);
    check_ok(synth_prop_new(arena, 9, false, &s->prop));
    check_ok(synth_grasp_ctx_new(arena, 9, &s->prop.mesh, NULL, hand, s->subject.beta, &ctx));
    for (int i = 0; i < 3; i++)
        check_ok(synth_grasp_sample(ctx, (uint64_t)(5 + i), NULL, &grasp[i]));
    for (int n = 3; n <= 6; n++) {
        check_ok(synth_stage_new(arena, &(synth_stage_spec){
            .hand = hand, .subject = &s->subject, .prop = &s->prop, .grasp = grasp, .n_grasps = 3, .n_frames = n,
            .n_cameras = 1, .number = 7, .setting.depth_unit = HO3D_DEPTH_UNIT, .seed = 3, .stream = 4 }, &stage));
        for (int k = 1; k < n; k++)
            ck_assert_int_gt(stage.kept[k], stage.kept[k - 1]);
        for (int k = 0; n == 3 && k < n; k++)
            ck_assert_double_eq_tol(part_of_round(&stage, k), fmod((7 * 3 + k + 0.5) * 0.61803, 1), 0.02);
    }
    for (int k = 0; k < 6; k++)
        ck_assert_int_eq(stage.sequence.moment[stage.kept[k]].round, k / 2);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_unchecked_fixture(c, setup, close_scratch);
    tcase_set_timeout(c, 600);
    tcase_add_test(c, manifest);
    tcase_add_test(c, annotation_keys);
    tcase_add_test(c, same_seed_same_bytes);
    tcase_add_test(c, a_full_folder_is_left_alone);
    tcase_add_test(c, stopping);
    tcase_add_test(c, reads_as_ho3d);
    tcase_add_test(c, truth_is_perfect);
    tcase_add_test(c, makes_batches);
    tcase_add_test(c, a_frame_returns);
    tcase_add_test(c, rounds_have_their_frames);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads of setup do not survive a fork */
    return run_suite("generate", add_tests);
}
