/* SPDX-License-Identifier: Apache-2.0 */
/* A small HO3D tree of noise with true annotations, and a model of a few thousand weights to train on it. */
#ifndef TESTS_TRAIN_TREE_H
#define TESTS_TRAIN_TREE_H

#include "assets/hand/hand.h"
#include "assets/ycb/objects.h"
#include "libtensor/base/arena.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/atomic_file.h"
#include "synth/write/ho3d.h"
#include "synth/write/model.h"
#include "synth/write/truth.h"
#include "tests/suite.h"

enum { TREE_TRAIN = 14, TREE_EVALUATION = 5 };

static lt_arena *tree_arena;

static inline const char *tree_at(const char *path)
{
    return lt_arena_printf(tree_arena, "%s/%s", scratch_folder, path);
}

static inline void tree_pose(const lt_hand_model *hand, synth_picture *p, lt_rng *rng)
{
    double R[LT_HAND_JOINTS * 9], joints[LT_HAND_JOINTS * 3], keypoints[LT_HAND_KEYPOINTS * 3];

    for (int i = 0; i < 48; i++)
        p->pose[i] = lt_rng_range(rng, -0.3, 0.3);
    for (int i = 0; i < LT_HAND_BETAS; i++)
        p->beta[i] = lt_rng_range(rng, -1, 1);
    p->trans[0] = lt_rng_range(rng, -0.05, 0.05);
    p->trans[1] = lt_rng_range(rng, -0.05, 0.05);
    p->trans[2] = 0.6;
    for (int i = 0; i < LT_HAND_JOINTS; i++)
        lt_rot_from_axis_angle(p->pose + 3 * i, R + 9 * i);
    lt_hand_pose(hand, R, p->beta, p->trans, p->vertices[0], joints);
    lt_hand_keypoints(p->vertices[0], joints, lt_hand_tips_ho3d, LT_HAND_MANO_ORDER, keypoints);
    memcpy(p->joints, keypoints, sizeof(keypoints));
    lt_hand_rest_wrist(hand, p->beta, p->rest_wrist);
}

static inline void tree_picture(const lt_hand_model *hand, synth_picture *p, int frame, bool evaluation)
{
    lt_rng rng = lt_rng_make(7, (uint64_t)(frame + (evaluation ? 1000 : 0)));
    uint8_t *rgb = lt_arena_alloc(tree_arena, 3 * SYNTH_WIDTH * SYNTH_HEIGHT);
    synth_file files[SYNTH_FRAME_FILES];

    for (int i = 0; i < 3 * SYNTH_WIDTH * SYNTH_HEIGHT; i++)
        rgb[i] = (uint8_t)(i / 5 * (frame + 3) % 251);
    p->rgb = rgb;
    p->frame = frame;
    p->evaluation = evaluation;
    p->sequence = evaluation ? "SYN2MB11" : "SYN1MB10";
    tree_pose(hand, p, &rng);
    check_ok(synth_write_picture(scratch_folder, p, false, 90, files));
}

static inline void tree_list(const char *split, const char *sequence, int n)
{
    char text[512] = "";

    for (int i = 0; i < n; i++)
        sprintf(text + strlen(text), "%s/%04d\n", sequence, i);
    check_ok(lt_write_file(tree_at(lt_arena_printf(tree_arena, "%s.txt", split)), text, strlen(text)));
}

static inline void tree_model(const char *name, lt_box *box)
{
    static uint8_t texture[4][3] = { { 200, 200, 0 } };
    synth_file files[4];
    lt_mesh mesh;

    check_ok(synth_object_new(tree_arena, 5, &mesh));
    check_ok(lt_box_from_points(mesh.n_vertices, mesh.vertex[0], box));
    check_ok(synth_write_model(scratch_folder, name, &mesh, (const uint8_t (*)[3])texture, 2,
                              (const float (*)[3])mesh.vertex, mesh.n_vertices, files));
}

static inline void tree_splits(const lt_hand_model *hand, synth_picture *p, bool truth)
{
    synth_truth t;

    check_ok(synth_make_sequence(scratch_folder, "SYN1MB10", false));
    check_ok(synth_make_sequence(scratch_folder, "SYN2MB11", true));
    for (int i = 0; i < TREE_TRAIN; i++)
        tree_picture(hand, p, i, false);
    if (truth)
        check_ok(synth_truth_open(&t, scratch_folder));
    for (int i = 0; i < TREE_EVALUATION; i++) {
        tree_picture(hand, p, i, true);
        if (truth)
            synth_truth_add(&t, (const double (*)[3])p->joints, (const double (*)[3])p->vertices);
    }
    if (truth)
        check_ok(synth_truth_commit(&t));
    tree_list("train", "SYN1MB10", TREE_TRAIN);
    tree_list("evaluation", "SYN2MB11", TREE_EVALUATION);
}

static const char tree_config[] =
    "{ \"model\": { \"name\": \"hocat\", \"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8,\n"
    "              \"depth\": 1, \"heads\": 2 },\n"
    "  \"optim\": { \"batch\": 4, \"epochs\": 1000, \"lr\": 1e-3 },\n"
    "  \"train\": { \"seed\": 3, \"checkpoint_minutes\": 0, \"validate_every\": 0 } }\n";

static const char tree_unified[] =
    "{ \"model\": { \"name\": \"unified\", \"image_size\": 64, \"width\": 8, \"layers\": 1,\n"
    "              \"heads\": 2, \"points\": 2 },\n"
    "  \"optim\": { \"batch\": 4, \"epochs\": 1000, \"lr\": 1e-3 },\n"
    "  \"train\": { \"seed\": 3, \"checkpoint_minutes\": 0, \"validate_every\": 0 } }\n";

/* The tree under /tmp, made once for all tests of a program. */
static inline void tree_make(bool truth)
{
    synth_picture *p;
    lt_hand_model *hand;

    make_scratch_folder();
    tree_arena = lt_arena_new();
    p = lt_arena_alloc(tree_arena, sizeof(*p));
    *p = (synth_picture){
        .width = SYNTH_WIDTH, .height = SYNTH_HEIGHT,
        .camera = { 614, 614, 320, 238 }, .n_cameras = 1, .object = "syn_006_mustard_bottle", .object_id = 5,
        .R = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .t = { 0.02, 0.01, 0.6 },
        .depth = lt_arena_array(tree_arena, SYNTH_WIDTH * SYNTH_HEIGHT, sizeof(float)),
        .label = lt_arena_alloc(tree_arena, SYNTH_WIDTH * SYNTH_HEIGHT),
    };
    check_ok(synth_hand_new(tree_arena, SYNTH_HAND_MANO_LIKE, &hand));
    tree_model(p->object, &p->box);
    tree_splits(hand, p, truth);
    check_ok(lt_write_file(tree_at("tiny.json"), tree_config, sizeof(tree_config) - 1));
    check_ok(lt_write_file(tree_at("unified.json"), tree_unified, sizeof(tree_unified) - 1));
}

static inline void tree_remove(void)
{
    remove_scratch_folder();
    lt_arena_free(tree_arena);
}

#endif
