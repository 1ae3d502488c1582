/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes frames, models and lists as an HO3D v3 tree (or v2: png images), in its axes, orders and keys.
 *
 * Everything handed in is in our convention: OpenCV camera axes, metres; only the files have OpenGL's.
 */
#ifndef DATA_SYNTH_WRITE_HO3D_H
#define DATA_SYNTH_WRITE_HO3D_H

#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/hand_model.h"
#include "libtensor/geometry/mesh.h"
#include "libtensor/io/atomic_file.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_WIDTH = 640, SYNTH_HEIGHT = 480, SYNTH_FRAME_FILES = 4 };

/* How hand vertices meet the object. */
typedef struct {
    bool contact[LT_HAND_VERTICES];             /* within 4 mm of its surface */
    bool inside[LT_HAND_VERTICES];
    float distance[LT_HAND_VERTICES];           /* metres to the surface, also from inside */
    float nearest[LT_HAND_VERTICES][3];         /* the point of the surface, camera axes */
} synth_contact;

/* One picture and all that is known of it. */
typedef struct {
    const char *sequence;                       /* "SYN3MB10": its last digit is the camera */
    int frame;                                  /* 0 .. 9999 */
    bool evaluation;
    lt_camera camera;
    int n_cameras;

    double pose[3 * LT_HAND_JOINTS];            /* axis-angle, flat hand zero, wrist first */
    double trans[3], beta[LT_HAND_BETAS];
    double rest_wrist[3];                       /* lt_hand_rest_wrist for beta */
    double joints[LT_HAND_KEYPOINTS][3];        /* MANO order */
    double vertices[LT_HAND_VERTICES][3];
    synth_contact contact;

    const char *object;                         /* the model's name */
    int object_id;                              /* 1..21 */
    lt_box box;                                 /* of its points */
    double R[9], t[3];                          /* x_cam = R x_model + t */

    const uint8_t *rgb;                         /* (480, 640, 3) */
    const float *depth;                         /* (480, 640) metres, 0 unknown */
    const uint8_t *label;                       /* (480, 640) 255 hand, object_id object */
} synth_picture;

typedef struct {
    char path[128];                             /* within the dataset */
    uint32_t crc;                               /* CRC-32 of the file */
} synth_file;

/**
 * synth_write_picture - rgb, depth, seg and meta of one frame under root
 *
 *   png      the colour image as PNG (version 2) in place of JPEG of the given quality
 *   files    what was written, SYNTH_FRAME_FILES of them
 *
 * The folders must be there: synth_make_sequence. May run on many threads for different frames.
 */
lt_status synth_write_picture(const char *root, const synth_picture *p, bool png, int quality,
                              synth_file *files);

/* synth_make_sequence - root/split/sequence/{rgb,depth,meta,seg} */
lt_status synth_make_sequence(const char *root, const char *sequence, bool evaluation);

/* synth_write_model - root/models/name: the mesh as textured_simple.obj with its texture (top row
 * first, side x side sRGB), and points.xyz; files gets 4 entries */
lt_status synth_write_model(const char *root, const char *name, const lt_mesh *mesh,
                            const uint8_t (*rgb)[3], int side, const float (*points)[3], int n_points,
                            synth_file *files);

/* synth_describe_file - the CRC of root/path into *out */
lt_status synth_describe_file(const char *root, const char *path, synth_file *out);

/* The two files of ground truth of the evaluation split, written frame by frame in its order. */
typedef struct {
    lt_atomic_file xyz, verts;
    bool open;
    int64_t count;
} synth_truth;

lt_status synth_truth_open(synth_truth *t, const char *root);
void synth_truth_add(synth_truth *t, const double joints[LT_HAND_KEYPOINTS][3],
                     const double vertices[LT_HAND_VERTICES][3]);
lt_status synth_truth_commit(synth_truth *t);
void synth_truth_abort(synth_truth *t);         /* leaves nothing; fine after a failed open */

#ifdef __cplusplus
}
#endif
#endif
