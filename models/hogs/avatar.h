/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The baseline "3DGS-Avatar, adapted": Gaussians that see no image. A hand's are changed by its pose alone, an
 * object's are rigid; colours come from an MLP on what each Gaussian has learnt, where it is seen from, and a code of
 * the frame.
 *
 * Source: Qian et al. 2024, "3DGS-Avatar: animatable avatars via deformable 3D Gaussian splatting"; the pose encoder
 * is Mihajlovic et al. 2021, "LEAP", its hierarchical one.
 */
#ifndef MODELS_HOGS_AVATAR_H
#define MODELS_HOGS_AVATAR_H

#include "models/hogs/vpm.h"

enum {
    AVATAR_JOINTS = SKIN_FIELD_BONES,
    AVATAR_JOINT = 13,              /* of a joint: rotation 9, place 3, length of the bone to its parent */
    AVATAR_LOCAL = 6,               /* what the encoder says of one; of all of them: 96 */
    AVATAR_CODE = 16, AVATAR_SHADE = 16,        /* of a frame; what the pose says of a Gaussian's colour */
};

typedef struct {
    lt_hash_grid_opts grid;
    int deform, look, feature;      /* hidden layers of the non-rigid and the appearance MLP; of a Gaussian */
    int64_t frames;                 /* to train on: a code each */
} avatar_opts;

typedef struct {
    avatar_opts opts;
    lt_param *table;                /* of the hash grid, of the hands */
    set_mlp root, joint[AVATAR_JOINTS];         /* the pose encoder */
    set_mlp deform;                 /* [enc(p), pose] -> dp, ds, dq, shade */
    set_mlp look[2];                /* appearance of hands, of objects */
    lt_param *code;                 /* (frames, AVATAR_CODE) */
} avatar;

/* avatar_new - parameters PREFIX.hash.table, .pose.root .., .deform .., .look_hand .., .look_object .., .code */
void avatar_new(avatar *m, lt_params *set, const char *prefix, int hands, int objects, const avatar_opts *opts);

/* avatar_init - codes N(0, 1), MLPs as linear layers begin, tables +-1e-4 */
void avatar_init(const avatar *m, uint64_t seed);

/* avatar_touch - a hand's, an object's networks and a frame's code take part in the step to come */
lt_status avatar_touch(const avatar *m, int hand, int object, int64_t frame);

/* avatar_deform - the hand `which` (1) LT_I32 in the pose (16, AVATAR_JOINT), its Gaussians at `places` in the box's
 * units (N, 3): changes as V-PM's, appearance being the shade (N, AVATAR_SHADE); all times `started` (1) */
vpm_out avatar_deform(const avatar *m, lt_tensor *places, lt_tensor *pose, lt_tensor *started, lt_tensor *which);

/* avatar_code - of a frame to train on, (1, AVATAR_CODE), its number in (1) LT_I32; NULL: the mean of all,
 * which only a graph without gradients can read */
lt_tensor *avatar_code(const avatar *m, lt_graph *g, lt_tensor *frame);

/* avatar_colour - (N, 3) in 0 .. 1 of features (N, F) seen along `direction` (N, 3), canonical; shade NULL: none */
lt_tensor *avatar_colour(const avatar *m, bool object, lt_tensor *feature, lt_tensor *direction, lt_tensor *shade,
                         lt_tensor *code, lt_tensor *which);

#endif
