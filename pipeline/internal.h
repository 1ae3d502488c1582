/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: the steps of predict_images, one file each.
 */
#ifndef PIPELINE_INTERNAL_H
#define PIPELINE_INTERNAL_H

#include "assets/ycb/symmetry.h"
#include "estimate/estimator.h"
#include "libtensor/geometry/kalman/kalman.h"
#include "libtensor/geometry/mesh/mesh.h"
#include "libtensor/io/image/image.h"
#include "pipeline/boxes.h"
#include "pipeline/predict.h"

/* predict_say - one line to o->messages, bytes that would bend the line replaced by '?' */
void predict_say(const predict_options *o, const char *fmt, ...) LT_PRINTF(2, 3);

/* ---- inputs.c: which images, and what their results are called ----------------------------------------- */

typedef struct {
    const char *path, *name;        /* name: of the results, without extension; unique in a list */
    const char *depth;              /* the depth image, of a film the folder of them, or NULL */
    bool film;
    int frame;                      /* of a film, from 1; 0: an image */
    int orientation;                /* of a frame as the film stores it, as EXIF has it */
    const predict_boxes_row *boxes; /* the image's line in --boxes, or NULL; of a film all of its frames', in order */
    size_t n_boxes;
} predict_input;

typedef struct {
    predict_input *input;
    int n, skipped;                 /* skipped: inputs that are no file and no folder with images */
} predict_list;

/* A frame's results are called FILM-000001 and so on. */
enum { PREDICT_FRAME_DIGITS = 6 };

lt_status predict_list_inputs(lt_arena *arena, const predict_options *o, predict_list *out);

/* ---- match.c: whose the lines of --boxes are ----------------------------------------------------------- */

/**
 * predict_match_boxes - give every input the lines of b that name it, by its file's name or that without the ending
 *
 * The rows are ordered anew. Lines for other images are said.
 * Errors: LT_EINVAL with file and line: no line is for any input, a name that two inputs have, two lines for one, a
 * film's frame 0. LT_ENOMEM.
 */
lt_status predict_match_boxes(lt_arena *arena, const predict_options *o, predict_boxes *b, predict_list *list);

/* predict_frame_boxes - a film's line for frame k, or NULL */
const predict_boxes_row *predict_frame_boxes(const predict_input *film, int k);

/* ---- view.c: the image, upright, with boxes and a camera ----------------------------------------------- */

/* PREDICT_LISTED: in --boxes */
typedef enum { PREDICT_GIVEN, PREDICT_LISTED, PREDICT_EXIF, PREDICT_DEFAULT } predict_source;

typedef struct {
    const char *path, *name, *depth_path;
    const uint8_t *rgb;             /* (height, width, 3) */
    const float *depth;             /* (height, width) metres, or NULL */
    int width, height, orientation; /* as the file stores it, as EXIF has it; rgb and depth are upright */
    crop_box hand_box, object_box;
    lt_camera camera;
    predict_source hand_from, object_from, camera_from;
    bool left;                      /* the hand */
} predict_view;

const char *predict_source_name(predict_source s);
/* predict_view_open - frame: the picture of a film; NULL: it is read */
lt_status predict_view_open(lt_arena *arena, const predict_options *o, const predict_input *in, const lt_image *frame,
                            predict_view *out);

/* predict_view_mirror - the same seen in a mirror, x -> width - 1 - x */
lt_status predict_view_mirror(lt_arena *arena, const predict_view *v, predict_view *out);

/* ---- assumed.c: what was not given --------------------------------------------------------------------- */

enum { PREDICT_ASSUMPTIONS = 4, PREDICT_ASSUMPTION_TEXT = 512 };

/* What was said last of each kind of assumption; zeroed at first. */
typedef struct {
    bool many, explained;           /* many: of images */
    char last[PREDICT_ASSUMPTIONS][PREDICT_ASSUMPTION_TEXT];
} predict_assumed;

/* predict_say_assumed - everything that was not given, in one line each, but for what was said of the image before */
void predict_say_assumed(const predict_options *o, const predict_view *v, predict_assumed *said);

/* ---- solve.c: from the view to a hand and an object in camera coordinates ------------------------------ */

typedef struct {
    const char *name, *origin;      /* origin: where the mesh is from, for the JSON */
    lt_mesh mesh;
    float control[21][3], mirrored[21][3];
    double symmetry[YCB_TURNS][4]; /* turns that leave it as it is, about the middle of its box */
    int n_symmetries;
} predict_object;

lt_status predict_object_load(lt_arena *arena, const predict_options *o, predict_object *out);

typedef struct {
    estimate e;                     /* of the hand as it is, left or right */
    double theta[3 * LT_HAND_JOINTS];
    float heatmap2d[LT_HAND_KEYPOINTS][2], joints2d[LT_HAND_KEYPOINTS][2];      /* image pixels */
    double agreement_px;            /* mean distance of the two */
    float control2d[LT_BOX_POINTS][2];          /* of the object's box, image pixels; NaN: not seen */
    bool placed;                    /* else the hand's position is a guess */
    bool object_found;
} predict_result;

typedef struct predict_solver predict_solver;

lt_status predict_solver_new(const predict_options *o, predict_solver **out);
void predict_solver_free(predict_solver *s);

/* predict_solve - object may be NULL */
lt_status predict_solve(predict_solver *s, lt_arena *arena, const predict_view *v, const predict_object *object,
                        predict_result *out);

/* predict_trusted - whether 2D and 3D joints agree to a tenth of the hand's box */
bool predict_trusted(const predict_view *v, const predict_result *r);

/* predict_reproject - joints2d and agreement_px from the joints */
void predict_reproject(const predict_view *v, predict_result *r);

/* ---- place.c ------------------------------------------------------------------------------------------- */

/* predict_place_hand - joints and vertices from the wrist to the camera's axes; r->placed
 * Source: Bandi and Thomas 2025 name none; weighted least squares over the joints, and the depth image's word on how
 * far away they are. */
void predict_place_hand(const predict_view *v, predict_result *r);

/* ---- smooth.c: a film, frame after frame --------------------------------------------------------------- */

typedef struct {
    double dt;                      /* seconds between frames; the rest is zeroed at first */
    lt_point_filter joint[LT_HAND_KEYPOINTS];
    lt_pose_filter object;
    int missed;                     /* frames in a row without a hand that can be trusted */
    bool left;                      /* the hand that joint[] follows */
} predict_smoother;

/* predict_smooth - the next frame: joints, mesh and object pose move to where the filters have them. A hand that
 * cannot be trusted, or an object that was not found, is predicted for 15 frames. object: NULL: none was asked for. */
void predict_smooth(predict_smoother *s, const predict_view *v, const predict_object *object, predict_result *r);

/* predict_smooth_missed - the next frame could not be read: as one in which nothing was seen */
void predict_smooth_missed(predict_smoother *s);

/* ---- overlay.c, meshes.c, files.c: what is written ----------------------------------------------------- */

/* All that is known about one image; object NULL when none was asked for. */
typedef struct {
    const predict_options *o;
    const predict_view *v;
    const predict_object *object;
    const predict_result *r;
} predict_case;

/* predict_hand_mesh - the posed hand, its triangles looking outwards; in the arena */
lt_status predict_hand_mesh(lt_arena *arena, const predict_case *s, lt_mesh *out);

/* Their names in the folder of results, the same twice where one file has both; object NULL: not found. */
typedef struct { const char *hand, *object; } predict_mesh_files;

/* predict_write_meshes - in the format that was asked for */
lt_status predict_write_meshes(lt_arena *arena, const predict_case *s, const lt_mesh *hand, predict_mesh_files *out);

/* predict_file_name - the image's name with an ending, and where that is */
lt_status predict_file_name(lt_arena *arena, const predict_case *s, const char *ending, const char **name,
                            const char **path);

lt_status predict_write_overlay(lt_arena *arena, const predict_case *s, const lt_mesh *hand, const char *path);
lt_status predict_write_files(lt_arena *arena, const predict_case *s);

#endif
