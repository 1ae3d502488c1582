/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One picture on its way through the stages (pipeline/stage.h), and all that is known of it by then: the record that
 * palmar.frame/1 is written from (docs/formats.md).
 */
#ifndef PIPELINE_FRAME_H
#define PIPELINE_FRAME_H

#include "assets/ycb/symmetry.h"
#include "estimate/body/estimator.h"
#include "estimate/detection/detector.h"
#include "estimate/estimator.h"
#include "libtensor/io/image/pixels.h"
#include "pipeline/boxes.h"
#include "pipeline/predict.h"

/* ---- where it is from -------------------------------------------------------------------------------------- */

typedef struct {
    const char *path, *name;        /* name: of the results, without extension; unique in a list */
    const char *depth;              /* the depth image, of a film the folder of them, or NULL */
    bool film, pipe;                /* pipe: a film that comes through standard input */
    int frame;                      /* of a film, from 1; 0: an image */
    int orientation;                /* of a frame as the film stores it, as EXIF has it */
    const predict_boxes_row *boxes; /* the image's lines in --boxes, or NULL; of a film all of its frames', in order */
    size_t n_boxes;
} predict_input;

/* ---- what is to be said of it ------------------------------------------------------------------------------ */

/* docs/formats.md has the list of their names in the JSON */
typedef enum {
    NOTE_TURNED, NOTE_HAND_BOX, NOTE_OBJECT_BOX, NOTE_CAMERA, NOTE_CAMERA_SCALED, NOTE_CAMERA_DOUBTFUL,
    NOTE_UNDISTORTED, NOTE_NO_OBJECT, NOTE_NO_DEPTH, NOTE_DEPTH_TURNED, NOTE_NOT_SMOOTHED,
    NOTE_OBJECT_UNIT, NOTE_OBJECT_AXES, NOTE_HAND_GUESSED, NOTE_LOW_TRUST, NOTE_DEPTH_DOUBTFUL, NOTE_NO_POSE,
    NOTE_POSE_FAR, NOTE_OBJECT_APART, NOTE_NOTHING, NOTE_NO_HAND, NOTE_LOW_SCORE, NOTE_SIDE, NOTE_OBJECT_UNKNOWN,
    NOTE_PERSON_BOX, NOTE_NO_PERSON,
    PREDICT_NOTES
} predict_note_code;

typedef struct {
    predict_note_code code;
    const char *text;
} predict_note;

/* Of one image. The arena is set, the rest zeroed at first. */
typedef struct {
    lt_arena *arena;
    predict_note *note;
    size_t n, room;
    bool lost;                      /* there was no memory for one */
} predict_notes;

/* ---- the picture, and each hand in it ---------------------------------------------------------------------- */

typedef struct predict_object {
    const char *name, *origin;      /* origin: where the mesh is from, for the JSON */
    lt_mesh mesh;
    float control[LT_BOX_POINTS][3], mirrored[LT_BOX_POINTS][3];
    lt_surface surface, mirrored_surface;
    double symmetry[YCB_TURNS][4];  /* turns that leave it as it is, about the middle of its box */
    int n_symmetries;
    const char *unit_note, *axes_note;          /* what of its model is not as it should be, or NULL */
} predict_object;

/* PREDICT_LISTED: in --boxes; PREDICT_DETECTED: by --detector */
typedef enum { PREDICT_GIVEN, PREDICT_LISTED, PREDICT_DETECTED, PREDICT_EXIF, PREDICT_DEFAULT } predict_source;

typedef enum { DETECTED_OBJECT, DETECTED_HAND, DETECTED_PERSON } predict_kind;

/* What a detector sees somewhere in the picture */
typedef struct {
    predict_kind kind;
    int cls;
    const char *name;               /* of the class */
    double score;
    crop_box box;
    detection_pixels window;
    predict_side side;              /* of a hand whose class says it */
    int64_t track;                  /* in a film: whose number it is among all frames, from 1; 0: not known */
} predict_detection;

/* An image as one of its hands is looked at. */
typedef struct predict_view {
    const char *path, *name, *depth_path;
    const uint8_t *rgb;             /* (height, width, 3) */
    const float *depth;             /* (height, width) metres, or NULL */
    double depth_scale;             /* metres that a step of its file was taken for */
    int width, height, orientation; /* as the file stores it, as EXIF has it; rgb and depth are upright */
    lt_camera camera;
    predict_source camera_from;
    const lt_lens *lens;            /* what was taken out of the picture; NULL: nothing */

    /* of this hand alone */
    int hand, n_hands;              /* from 0; of the image */
    crop_box hand_box, object_box;
    predict_source hand_from, object_from;
    const predict_detection *hand_seen, *object_seen;       /* whose boxes they are; NULL: not by a detector */
    bool left, any_side;            /* any_side: nobody says which; `left` is then what it looks most like */
    const predict_object *object;   /* NULL: none was named */
} predict_view;

/* A view that was turned: its part at (x0, y0), `width` x `height`, clockwise by quarters; zeroed: it was not. */
typedef struct { int quarters, x0, y0, width, height; } predict_turn;

/* ---- what was found ---------------------------------------------------------------------------------------- */

typedef struct {
    estimate e;                     /* of the hand as it is, left or right */
    double theta[3 * LT_HAND_JOINTS];
    float heatmap2d[LT_HAND_KEYPOINTS][2], joints2d[LT_HAND_KEYPOINTS][2];      /* image pixels */
    double agreement_px;            /* mean distance of the two */
    float control2d[LT_BOX_POINTS][2];          /* of the object's box, image pixels; NaN: not seen */
    bool placed;                    /* else the hand's position is a guess */
    double measured_m, solved_m;    /* the wrist's depth: as depth has it, or NaN; as joints' size has it */
    bool object_found;
    bool object_far;                /* a pose was found, too near or too far to be believed */
} predict_result;

/* A person, and the body that was found */
typedef struct {
    crop_box box;
    predict_source from;
    const predict_detection *seen;  /* whose box it is; NULL: not by a detector */
    body_estimate body;
} predict_person;

/* Of a hand, names in the folder of results, the same twice where one file has both; NULL: there is none. */
typedef struct { const char *hand, *object; } predict_mesh_files;

/* ---- the frame --------------------------------------------------------------------------------------------- */

typedef struct predict_followed predict_followed;

/* What is known of a frame; stages say in these what they need and what they give. */
typedef enum {
    FRAME_SCENE = 1,                /* scene */
    FRAME_DETECTIONS = 2,           /* detection, unless the boxes are listed; those too that are sure enough only for
                                     * a track to go on */
    FRAME_VIEWS = 4,                /* view */
    FRAME_ESTIMATES = 8,            /* seen, turn; of result e, as the network has it, and 2D points in pixels of
                                     * seen */
    FRAME_POSES = 16,               /* result, in the camera's axes */
    FRAME_VERDICT = 32,             /* notes on what was found */
    FRAME_DRAWING = 64,             /* hand, overlay */
    FRAME_BODIES = 128,             /* person */
} frame_part;

/* The source of the frame sets the first five; stages the others, each as it says that it gives them. */
typedef struct {
    const predict_options *o;
    lt_arena *arena;                /* of this frame */
    predict_input input;
    const lt_image *picture;        /* upright, where it was decoded already; NULL: it is in the input's file */
    const predict_object *object;   /* where the boxes name none; may be NULL */
    predict_followed *film;         /* whose next frame it is; NULL: it has nothing to do with the last one */
    bool among_many;                /* other frames are likely to come */

    unsigned has;                   /* of frame_part */
    predict_notes notes;
    predict_view scene;             /* the picture as every hand has it, without any hand's own */
    bool detected;                  /* hands are where a detector sees them */
    predict_detection *detection;   /* n_detections of them, the surest first */
    int n_detections;
    int n;                          /* hands */
    predict_view *view;             /* (n) */
    predict_view *seen;             /* (n) as the network looks at it: a left hand in the mirror, then turned by */
    predict_turn *turn;             /* (n) */
    predict_result *result;         /* (n) */
    int n_people;
    predict_person *person;         /* (n_people) */
    lt_mesh *hand;                  /* (n) posed, triangles looking outwards */
    predict_mesh_files *files;      /* (n) where they are written; else NULL */
    lt_image overlay;

    bool forgiven;                  /* what went wrong is this frame's alone, so that the next may do better */
} predict_frame;

#endif
