/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A dataset of hand-object images, whatever its files: HO3D, DexYCB and what `palmar synth` writes
 * all become the samples below. One convention inside: OpenCV camera axes (x right, y down,
 * z forward), metres, radians, pixels, right hands, axis-angle without a mean pose; the readers convert.
 */
#ifndef DATA_DATASET_H
#define DATA_DATASET_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/depth_fit.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* An object that a dataset knows. Everything is in the model's own frame and belongs to the dataset. */
typedef struct {
    const char *name;               /* the folder under models/: "006_mustard_bottle", "syn_006_..." */
    int ycb_id;                     /* 1..21, the DexYCB number; 0 for an object that is none of them */
    lt_mesh mesh;                   /* textured_simple.obj: vertices and faces only */
    float (*point)[3];              /* points.xyz */
    int n_points;
    float control[21][3];           /* box corners, edge middles, centre, of points.xyz (box21.h) */
    float mirrored[21][3];          /* these in the mirror, for samples that are SAMPLE_MIRRORED */
    lt_surface surface, mirrored_surface;
    float diagonal;                 /* of that box: what HO3D tables call the diameter */
    float diameter;                 /* the largest distance between two mesh vertices */
} dataset_object;

/* An object as an estimator is asked for it, borrowed */
typedef struct {
    const float (*control)[3];      /* (21, 3) its control points; NULL: there is no object */
    lt_surface surface;
} object_shape;

/* What a sample holds; a field whose bit is missing is zero (NULL). */
typedef enum {
    SAMPLE_HAND_POSE = 1,           /* rotation, beta */
    SAMPLE_JOINTS = 2,              /* joints, joints2d */
    SAMPLE_ROOT = 4,                /* root */
    SAMPLE_HAND_BOX = 8,            /* hand_box is an annotation, not the extent of joints2d */
    SAMPLE_OBJECT = 16,             /* object, R, t, control2d, silhouette */
    SAMPLE_VERTICES = 32,           /* vertices */
    SAMPLE_DEPTH = 64,              /* depth */
    SAMPLE_MIRRORED = 128,          /* a left hand: everything here was mirrored in x when it was read */
    SAMPLE_SEGMENTS = 256,          /* segments */
} sample_flag;

/* What a cell of segments is of; 0: neither. */
enum { SEGMENT_HAND = 1, SEGMENT_OBJECT = 2 };

/*
 * Depth lies beside the colour image: the same size, the same camera, pixel on pixel; z along the optical
 * axis in metres, 0 where the sensor saw nothing. It is read only when asked for (SAMPLE_DEPTH in want).
 *
 * A left hand comes as a right one (SAMPLE_MIRRORED): image, depth, camera, joints, rotations, root, boxes,
 * silhouette and 2D points are what a mirror shows (mirror.h), and R, t place the mirrored model. Estimates
 * made from it are mirrored back before they are written for others; distances between them and the
 * annotation are the same on either side.
 */
typedef struct {
    const char *name;               /* "ABF10/0123" */
    unsigned flags;                 /* of sample_flag */
    int width, height;
    const uint8_t *rgb;             /* (height, width, 3) */
    const float *depth;             /* (height, width) metres, 0 where unknown; NULL where not asked for */
    lt_camera camera;

    float rotation[LT_HAND_JOINTS][9];          /* row-major; [0] turns the hand into the camera's axes */
    float beta[LT_HAND_BETAS];
    float joints[LT_HAND_KEYPOINTS][3];         /* camera, "simple" order */
    float joints2d[LT_HAND_KEYPOINTS][2];       /* projected, pixels */
    const float (*vertices)[3];                 /* (778, 3) camera; borrowed from the dataset */
    float root[3];                              /* the wrist, camera */
    float hand_box[4];                          /* x0 y0 x1 y1, pixels */

    int object;                                 /* index into the dataset's objects; -1 for none */
    float R[9], t[3];                           /* x_cam = R x_model + t; dataset_model_to_camera */
    float control2d[21][2];                     /* the object's control points projected, pixels */
    const uint8_t *silhouette;                  /* (height, width) 0/1, parts behind the hand included */

    const uint8_t *segments;                    /* (segments_height, segments_width) over the whole image: what is
                                                 * seen there, the hand, the object (in it, of several) or
                                                 * neither; NULL where not asked for */
    int segments_width, segments_height;        /* the image's, or a whole fraction of it */
} dataset_sample;

typedef struct dataset dataset;
typedef struct dataset_kind dataset_kind;      /* kind.h */

/* What a kind of dataset does; each reader fills one of these. */
typedef struct {
    /* one sample into arena memory; may be called from several threads at once */
    lt_status (*read)(const dataset *d, int64_t index, unsigned want, lt_arena *arena,
                      dataset_sample *out);
    /* the annotation of one sample alone: no image is opened, nothing projected */
    lt_status (*annotation)(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *out);
    /* the path, in arena, of the first of the sample's files that is not there; NULL: all are */
    const char *(*missing)(const dataset *d, int64_t index, lt_arena *arena);
    const char *(*name)(const dataset *d, int64_t index);
    void (*free)(dataset *d);
} dataset_ops;

struct dataset {
    const dataset_ops *ops;
    const dataset_kind *kind;       /* HO3D, DexYCB */
    const char *title;              /* "HO3D v2", "HO3D v3", "DexYCB s0", "DexYCB s0 (part)" */
    const char *split;              /* "train", "evaluation" */
    const char *root;               /* the folder it was opened from; where there is none, what lines call it */
    bool synthetic;                 /* written by `palmar synth`: reports must say so */
    const char *partial;            /* what of the split is not there, a sentence to be said; NULL: it is whole */
    int64_t count;
    const dataset_object *objects;
    int n_objects;
    bool opengl;                    /* its files have OpenGL's axes */
    bool any_size;                  /* labels are given out whatever their size, to see what is wrong with them */
    const int *tips;                /* vertices of the finger tips that the annotation uses (5) */
};

/**
 * dataset_read - sample index of d
 *
 *   want    bits of sample_flag that cost time and may be left out: SAMPLE_OBJECT (the silhouette; the
 *           pose is always read), SAMPLE_DEPTH and SAMPLE_SEGMENTS, which a sample without the file does without
 *   arena   owns rgb, depth, silhouette, segments; the name belongs to the dataset
 *
 * Errors: one line naming the file, the field, what was expected and what was found. Thread-safe.
 */
lt_status dataset_read(const dataset *d, int64_t index, unsigned want, lt_arena *arena,
                       dataset_sample *out);

/* dataset_annotation - sample index without rgb, depth, silhouette and what is projected: quick */
lt_status dataset_annotation(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *out);

/**
 * dataset_check_tips - which vertices the annotation of a training split calls finger tips
 *
 * Compares the tips of hand posed with the annotation against the stored joints, over up to 50 right hands,
 * for each of the conventions that occurred, and remembers the best in d->tips. *rms_mm (may be NULL) is its
 * error. Without a right hand to look at, d->tips stays and *rms_mm is 0.
 *
 * Errors: the best is off by more than 3 mm: the hand file is not the one the data were made with; the
 * annotation has no hand poses, as HO3D's evaluation.
 */
lt_status dataset_check_tips(dataset *d, const lt_hand_model *hand, double *rms_mm);

/* dataset_crc32 - of what tells a dataset from others: the generator's manifest.json, else HO3D's train.txt. hash gets
 * eight hexadecimal digits, the answer is the file's name; without either file "" and NULL */
const char *dataset_crc32(lt_arena *scratch, const char *root, char hash[16]);

/* dataset_name - the sample's name, "SEQUENCE/FRAME"; lives as long as d */
const char *dataset_name(const dataset *d, int64_t index);

/* dataset_plain_name - a model's name without the "syn_" of a stand-in */
const char *dataset_plain_name(const char *name);

/* dataset_find_object - the index of the object called name, "syn_" or not on either side; -1: none */
int dataset_find_object(const dataset *d, const char *name);

void dataset_free(dataset *d);

/**
 * dataset_load_objects - the models that dir (models/) has of those named
 *
 *   names   (n) model folder names; the same name with "syn_" before it is taken as well
 *   out     (*n_out) objects that live, with their arrays, in arena
 *
 * Errors: no such folder or none of the models in it (the line says where they are to be had); a model
 * without textured_simple.obj or points.xyz, or with a broken one; one without triangles; one that no hand could hold,
 * with the unit that it may be in.
 */
lt_status dataset_load_objects(lt_arena *arena, const char *dir, const char *const *names, int n,
                               const dataset_object **out, int *n_out);

/* dataset_measure_object - control points, surface, diagonal and diameter of an object that has mesh and points; obj
 * and xyz are what lines call these. Errors: LT_ENOMEM; a thing that no hand could hold, with the unit that it may be
 * in. */
lt_status dataset_measure_object(lt_arena *arena, dataset_object *o, const char *obj, const char *xyz);

/* dataset_project - joints2d and control2d from the sample's joints, object pose and camera. Errors: a
 * point behind the camera or absurdly far outside the image; the line says which. */
lt_status dataset_project(const dataset *d, dataset_sample *s);

/* dataset_model_to_camera - A so that x_cam = A x_model + s->t for the model as the dataset has it: R, or R
 * times diag(-1, 1, 1) where the sample is mirrored */
void dataset_model_to_camera(const dataset_sample *s, float A[9]);

/* dataset_shape - what s->R and s->t place: the object, or its mirror image */
object_shape dataset_shape(const dataset_object *o, unsigned flags);

/* dataset_draw_silhouette - fills in the sample's silhouette, in arena memory */
lt_status dataset_draw_silhouette(const dataset *d, lt_arena *arena, dataset_sample *s);

#ifdef __cplusplus
}
#endif
#endif
