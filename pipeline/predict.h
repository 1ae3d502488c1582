/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A trained model on a user's own photographs: overlays, numbers, meshes.
 */
#ifndef PIPELINE_PREDICT_H
#define PIPELINE_PREDICT_H

#include "assets/ycb/ycb.h"
#include "estimate/body/estimator.h"
#include "estimate/detection/detector.h"
#include "estimate/embedder.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/lens.h"
#include "models/model.h"
#include "vision/crop.h"
#include "vision/track/tracker.h"

#include <stdio.h>

typedef enum { PREDICT_OBJ, PREDICT_PLY, PREDICT_GLB } predict_format;

typedef struct {
    const model *m;                 /* NULL: no hands, but what the detector sees and the bodies of people */
    detector *detector;             /* finds hands and objects where no line of `boxes` says where they are, or NULL */
    body_estimator *body;           /* whole bodies of the people that the detector finds, or NULL */
    track_method track;             /* how a film's detections get their numbers */
    embedder *embedder;             /* how they look, which TRACK_DEEPSORT goes by; NULL: by overlap alone */
    int most_looks;                 /* of a frame that are in doubt, the surest; 0: all are looked at */
    bool bilinear;                  /* crops are sampled between pixels: data.bilinear */
    const lt_hand_model *hand;      /* the one that the model was made with: its triangles are written */
    const char *checkpoint;         /* its path, for the JSON */
    const char *trained_on;         /* "HO3D v2 train", "synthetic, HO3D layout"; NULL: not known */

    const char *const *inputs;      /* n_inputs images, films, and folders of images */
    int n_inputs;
    bool pipe;                      /* frames come through standard input, and inputs are nothing to it */
    const char *out;                /* folder, made when it is missing; NULL: no files */
    FILE *lines;                    /* the numbers of each frame go here as a line; NULL: nowhere */

    const crop_box *hand_box;       /* pixels of the upright image, for every image; NULL: default */
    const crop_box *object_box;
    const crop_box *person_box;     /* of the one person, where there is no detector; NULL: the whole image */
    const char *boxes;              /* CSV of boxes for single hands (pipeline/boxes.h), which go before the two;
                                     * NULL: none */
    const char *depth;              /* of the image, or a folder with NAME.png for each NAME.jpg, NAME-000001.png for a
                                     * film's first frame; NULL: not known */
    double depth_scale;             /* metres of a step of 16 bits; 0: a millimetre */
    const lt_camera *camera;        /* NULL: from EXIF, or a default */
    int camera_width, camera_height;        /* of the pictures it is for, others are scaled to; 0: these */
    double camera_skew;             /* pixels; said, and left out */
    const lt_lens *lens;            /* which the camera's pictures are taken out of before all else; NULL: none */
    const char *object;             /* "003_cracker_box", a folder of models; NULL: the hand alone */
    const char *models;             /* a folder with a folder for each object (pipeline/objects/mesh.h); NULL: the
                                     * embedded stand-ins */
    predict_format format;          /* of the meshes */
    bool numbers;                   /* of files NAME.json alone: no overlay, no meshes; those of an earlier call stay */
    double fps;                     /* the images are frames of a film: filtered; 0: they are unrelated, and a film
                                     * says by itself */
    bool left;                      /* a left hand: the image is mirrored, and the result mirrored back; `boxes` may
                                     * know better */
    bool any_side;                  /* where neither `boxes` nor the detector says: what it looks most like instead; in
                                     * a film, what it did in the first frame that has it */
    bool any_way_up;                /* hands may stand any way up: where a look leaves a doubt they are turned */
    bool alone;                     /* nothing else uses the model's weights, now or later: less memory */
    bool (*stop)(void);             /* asked behind each image, whose files are whole by then; NULL: never */
    bool quiet;                     /* notes are in the JSON alone; what was skipped is told */
    FILE *messages;                 /* what was assumed, skipped or not found; NULL: nobody is told */
} predict_options;

typedef struct {
    int written, skipped;           /* images */
} predict_summary;

/**
 * predict_images - estimate hand and object in every image, and write what was found
 *
 * In `out`, for an image NAME.jpg:
 *   NAME.overlay.png   the image with boxes, skeleton, hand mesh, object box and confidences
 *   NAME.json          all numbers, with units, conventions, where boxes and camera came from, and notes
 *   NAME.hand.obj, NAME.object.obj   the posed meshes in camera axes, metres; the latter when found. Or .ply,
 *                      or both in NAME.glb, whose axes are glTF's: y up, z backward
 *
 * The second image of a name becomes NAME-2, and so on. Folders give their images (by extension; not
 * hidden ones, nor overlays) in the order of their names, numbers as numbers, and are not descended. Images are turned
 * upright as their EXIF orientation says. An image with several lines in `boxes` has several hands: NAME.hand-2.obj and
 * so on. What is not given is assumed, and said on `messages`, of the first image and where it changes:
 *   hand box     the central square of 60 % of the shorter side
 *   object box   the hand box grown 1.3 times about its centre
 *   camera       focal length of the EXIF tag, else 1.2 times the longer side; centre of the image
 *   object       none: no object pose
 *
 * With a detector hands and objects are where it sees them, any number of them: each hand goes with the object that it
 * touches or that is near (pipeline/README.md), whose model is the one of its class's name. Nothing found is said, and
 * no error. Detections alone, without a model, are numbers and an overlay. In a film they have track ids.
 *
 * With a body estimator each person that the detector finds, or the one in person_box, has a body: its joints in the
 * JSON and its skeleton in the overlay.
 *
 * Depth lies pixel on pixel beside the image, as that is stored or as it is upright, in steps of depth_scale or as HO3D
 * packs it; a model that does not take it refuses it, and to one that does, no depth is depth known nowhere.
 *
 * A film (.mp4, .avi, .mov, .mkv, .webm) leaves results for each frame, NAME-000001 and so on; OpenCV reads it. With
 * fps images are frames in the order given. Of frames that follow each other joints and object pose go through the
 * filters of libtensor/geometry/kalman/kalman.h, which bridge up to 15 frames in which the hand or the object is lost.
 *
 * The hand's position solves weighted least squares (libtensor/geometry/translation.h) with the 2D
 * joints of the heat maps; without a solution between 0.05 and 10 m the hand is put 0.6 m away in its box.
 *
 * Errors: an unreadable image is named, skipped and counted, and when all are done the call returns
 * LT_EFORMAT. At once: LT_ESTOPPED by o->stop, LT_EUSAGE (unknown object, depth that does not go with the images or the
 * model), LT_EINVAL (nothing to do, boxes of other images), LT_EFORMAT (o->boxes cannot be read), LT_ENUMERIC
 * (damaged weights), LT_EIO, LT_ENOSPC, LT_ENOMEM.
 * sum may be NULL.
 */
lt_status predict_images(const predict_options *o, predict_summary *sum);

/* ---- options as text ------------------------------------------------------------------------------- */

/* predict_parse_box - "x0,y0,x1,y1" in pixels, x0 < x1 and y0 < y1. LT_EUSAGE; name is for the line:
 * "--hand-box". */
lt_status predict_parse_box(const char *name, const char *text, crop_box *out);

/* predict_parse_format - "obj", "ply" or "glb" */
lt_status predict_parse_format(const char *name, const char *text, predict_format *out);

/* predict_find_object - "006_mustard_bottle", "syn_006_mustard_bottle" or "mustard_bottle". LT_EUSAGE
 * names the nearest, or else all of them. */
lt_status predict_find_object(const char *text, const ycb_object **out);

#endif
