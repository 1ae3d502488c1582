/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libpalmar: hand and object in pictures that are in memory already.
 *
 * What `palmar predict` finds, with the same numbers, without files and without messages:
 *
 *     palmar *p;
 *     if (palmar_open("runs/tiny", NULL, &p))
 *         return puts(palmar_last_error());
 *     palmar_estimate(p, &(palmar_image){ .rgb = rgb, .width = 640, .height = 480 }, 1, &(palmar_query){ 0 }, &hand);
 *
 * Metres, radians and pixels; the camera's axes are x right, y down, z forward; centres of pixels are at whole numbers.
 * A handle belongs to one thread at a time; several threads take one each. After the first frames of a size nothing is
 * allocated: memory is taken in palmar_open, in palmar_load_object, and when a picture is larger, or has more hands,
 * than any before.
 *
 * A call that fails returns a status, leaves what it was to fill as it was, and one line in palmar_last_error().
 */
#ifndef PALMAR_H
#define PALMAR_H

#include <stddef.h>
#include <stdint.h>

#define PALMAR_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    PALMAR_OK = 0,
    PALMAR_EINVAL,                  /* an argument that cannot be: NULL, an empty picture, a camera of NaN */
    PALMAR_EIO,                     /* the system refused to read */
    PALMAR_EFORMAT,                 /* a file is not what it should be */
    PALMAR_ENOMEM,                  /* no memory */
    PALMAR_ENUMERIC,                /* what the network gives is not finite: its weights are damaged */
} palmar_status;

enum {
    PALMAR_JOINTS = 21,             /* wrist, then thumb to little finger from knuckle to tip */
    PALMAR_VERTICES = 778, PALMAR_FACES = 1538,             /* of MANO's mesh */
    PALMAR_ROTATIONS = 16, PALMAR_SHAPE = 10,
    PALMAR_MOST_HANDS = 64,         /* in a picture */
};

typedef struct palmar palmar;

/**
 * palmar_open - a run's folder, of which the last checkpoint is read, or a checkpoint file
 *
 *   hand   MANO_RIGHT.pkl, or what else palmar's --hand takes; NULL: the hand of the training
 *
 * Errors: PALMAR_EIO, PALMAR_EFORMAT, PALMAR_ENOMEM; PALMAR_EINVAL for a model of another task.
 */
PALMAR_API palmar_status palmar_open(const char *path, const char *hand, palmar **out);
PALMAR_API void palmar_close(palmar *p);

/**
 * palmar_load_object - an object whose pose is to be found
 *
 *   name     "006_mustard_bottle", or a folder of `models`
 *   models   a folder with a folder for each object, with a mesh in metres in it; NULL: the embedded stand-ins for
 *            YCB's
 *   out      what palmar_query.object takes; 1 and up
 */
PALMAR_API palmar_status palmar_load_object(palmar *p, const char *name, const char *models, int *out);

/**
 * palmar_film - the pictures from here on are a film's, fps a second: joints and object poses go through filters
 *
 * Each hand is followed by its side and place, and predicted for 15 frames in which it cannot be trusted. Called again,
 * another film begins; 0: pictures have nothing to do with each other, as in the beginning. PALMAR_EINVAL: fps is
 * negative or not finite; PALMAR_ENOMEM.
 */
PALMAR_API palmar_status palmar_film(palmar *p, double fps);

/* All of it is borrowed for the call alone. */
typedef struct {
    const uint8_t *rgb;             /* (height, width, 3), the upper row first */
    int width, height;              /* at most 16384 */
    ptrdiff_t stride;               /* bytes from row to row; 0: 3 * width */
    const float *depth;             /* (height, width) metres along z, 0 or NaN unknown, pixel on pixel; NULL: none */
    ptrdiff_t depth_stride;         /* bytes from row to row; 0: 4 * width */
    double fx, fy, cx, cy;          /* the camera; all 0: 1.2 times the longer side, and the middle */
} palmar_image;

/* Where to look; zeroed: one right hand in the middle, without an object. */
typedef struct {
    float hand_box[4];              /* x0 y0 x1 y1; all 0: the middle of the picture */
    float object_box[4];            /* all 0: around the hand's */
    int left;                       /* 1: a left hand */
    int object;                     /* of palmar_load_object; 0: none */
} palmar_query;

/* A hand and what it holds. */
typedef struct {
    float joints[PALMAR_JOINTS][3], vertices[PALMAR_VERTICES][3];           /* in the camera's axes */
    float joints2d[PALMAR_JOINTS][2];           /* the joints as the camera sees them */
    double rotations[PALMAR_ROTATIONS][3];      /* MANO's axis-angles, the wrist's first; 0 is a flat hand */
    float shape[PALMAR_SHAPE];
    float translation[3];           /* the wrist's place, joints[0] */
    int placed;                     /* 1; 0: the place is a guess, 0.6 m away in the box */
    int trusted;                    /* 1: placed, and 2D and 3D joints agree to a tenth of the hand's box */
    double agreement_px;            /* how far they are apart */
    int object_found;               /* 1: the pose below was found, 0.05 to 10 m away */
    int object_trusted;             /* 1: and in reach of the hand, which is trusted */
    double object_rotation[9], object_translation[3];       /* x_camera = R x_object + t; R by rows */
    int object_inliers;             /* votes for the pose */
    float object_confidence;        /* in [0, 1], of the network in where it sees the object */
} palmar_hand;

/**
 * palmar_estimate - n hands in a picture
 *
 *   query   (n)
 *   out     (n)
 *
 * Where 2D and 3D joints of a hand differ by more than 4 % of its box it is looked at turned by quarters too, and takes
 * four times as long.
 *
 * Errors: PALMAR_EINVAL says which argument; depth for a model without; a box outside of the picture. PALMAR_ENOMEM,
 * PALMAR_ENUMERIC.
 */
PALMAR_API palmar_status palmar_estimate(palmar *p, const palmar_image *image, int n, const palmar_query *query,
                                         palmar_hand *out);

/* palmar_faces - (1538, 3) triangles of the vertices of a right hand, seen from outside counter-clockwise; for a left
 * one swap two corners of each. As long as the handle. */
PALMAR_API const int32_t *palmar_faces(const palmar *p);

/* palmar_set_threads - for all handles; below 1, as in the beginning: the CPUs this process may use. The numbers do not
 * depend on it. */
PALMAR_API void palmar_set_threads(int n);

/* palmar_last_error - the line of the last call on this thread that failed; "" before. Until the next call */
PALMAR_API const char *palmar_last_error(void);

/* palmar_version - "0.1.0" */
PALMAR_API const char *palmar_version(void);

#ifdef __cplusplus
}
#endif
#endif
