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
#include "libtensor/io/image/exif.h"
#include "libtensor/io/image/image.h"
#include "pipeline/boxes.h"
#include "pipeline/predict.h"

/* ---- notes.c: what is told of an image ------------------------------------------------------------------ */

/* predict_say - one line to o->messages, bytes that would bend the line replaced by '?' */
void predict_say(const predict_options *o, const char *fmt, ...) LT_PRINTF(2, 3);

/* docs/formats.md has the list of their names in the JSON */
typedef enum {
    NOTE_TURNED, NOTE_HAND_BOX, NOTE_OBJECT_BOX, NOTE_CAMERA, NOTE_CAMERA_SCALED, NOTE_CAMERA_DOUBTFUL,
    NOTE_UNDISTORTED, NOTE_NO_OBJECT, NOTE_NO_DEPTH, NOTE_DEPTH_TURNED, NOTE_NOT_SMOOTHED,
    NOTE_OBJECT_UNIT, NOTE_OBJECT_AXES, NOTE_HAND_GUESSED, NOTE_LOW_TRUST, NOTE_DEPTH_DOUBTFUL, NOTE_NO_POSE,
    NOTE_POSE_FAR,
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

struct predict_view;

/* predict_note_add - v: which hand it is about, where there are several; NULL: the image */
void predict_note_add(predict_notes *notes, const struct predict_view *v, predict_note_code code, const char *fmt, ...)
    LT_PRINTF(4, 5);

/* predict_note_name - "low-trust" */
const char *predict_note_name(predict_note_code code);

enum { PREDICT_SAID = 512 };

/* What was told of the last image that was told of; zeroed at first. */
typedef struct {
    bool many, explained;           /* many: of images */
    char last[PREDICT_NOTES][PREDICT_SAID];
} predict_said;

/* predict_say_notes - to o->messages; what was assumed only where it is not what was told of the image before */
void predict_say_notes(const predict_options *o, const char *path, const predict_notes *notes, predict_said *said);

/* ---- inputs.c: which images, and what their results are called ----------------------------------------- */

typedef struct {
    const char *path, *name;        /* name: of the results, without extension; unique in a list */
    const char *depth;              /* the depth image, of a film the folder of them, or NULL */
    bool film;
    int frame;                      /* of a film, from 1; 0: an image */
    int orientation;                /* of a frame as the film stores it, as EXIF has it */
    const predict_boxes_row *boxes; /* the image's lines in --boxes, or NULL; of a film all of its frames', in order */
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
 * Errors: LT_EINVAL with file and line: no line is for any input, a name that two inputs have, two lines for one
 * hand, more than 64 for an image, a film's frame 0. LT_ENOMEM.
 */
lt_status predict_match_boxes(lt_arena *arena, const predict_options *o, predict_boxes *b, predict_list *list);

/* predict_frame_boxes - a film's lines for frame k, *n of them */
const predict_boxes_row *predict_frame_boxes(const predict_input *film, int k, size_t *n);

/* ---- objects.c: the models of what may be in a hand ------------------------------------------------------ */

typedef struct predict_object {
    const char *name, *origin;      /* origin: where the mesh is from, for the JSON */
    lt_mesh mesh;
    float control[21][3], mirrored[21][3];
    double symmetry[YCB_TURNS][4];  /* turns that leave it as it is, about the middle of its box */
    int n_symmetries;
    const char *unit_note, *axes_note;          /* what of its model is not as it should be, or NULL */
} predict_object;

/* predict_load_objects - those that the lines of b name, which point to them then, and *given of --object, or NULL */
lt_status predict_load_objects(lt_arena *arena, const predict_options *o, predict_boxes *b,
                               const predict_object **given);

/* ---- view.c: the image, upright, with a camera and the boxes of each hand -------------------------------- */

/* PREDICT_LISTED: in --boxes */
typedef enum { PREDICT_GIVEN, PREDICT_LISTED, PREDICT_EXIF, PREDICT_DEFAULT } predict_source;

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
    bool left;
    const predict_object *object;   /* NULL: none was named */
} predict_view;

const char *predict_source_name(predict_source s);

/**
 * predict_view_open - all hands of an image: as many views, at least one, that have its pixels in common
 *
 *   frame    the picture of a film; NULL: it is read
 *   given    the object where the boxes name none
 */
lt_status predict_view_open(lt_arena *arena, const predict_options *o, const predict_input *in, const lt_image *frame,
                            const predict_object *given, predict_notes *notes, predict_view **out, int *n);

/* predict_view_mirror - the same seen in a mirror, x -> width - 1 - x */
lt_status predict_view_mirror(lt_arena *arena, const predict_view *v, predict_view *out);

/* ---- depth.c -------------------------------------------------------------------------------------------- */

/* predict_read_depth - v->depth, upright. LT_EFORMAT: no depth, or of another size; those of reading */
lt_status predict_read_depth(lt_arena *arena, const predict_options *o, const char *path, predict_view *v,
                             predict_notes *notes);

/* ---- camera.c ------------------------------------------------------------------------------------------- */

/* predict_choose_camera - v->camera for a picture of its size */
void predict_choose_camera(const predict_options *o, const lt_exif *exif, predict_view *v, predict_notes *notes);

/* predict_undistort - picture and depth without o->lens. LT_EINVAL: no lens makes such a picture; LT_ENOMEM */
lt_status predict_undistort(lt_arena *arena, const predict_options *o, predict_view *v, predict_notes *notes);

/* predict_undistort_box - of the distorted picture, in the one without distortion */
crop_box predict_undistort_box(const predict_view *v, crop_box b);

/* ---- assumed.c: what was not given --------------------------------------------------------------------- */

/* predict_note_assumed - of an image's n views */
void predict_note_assumed(const predict_options *o, const predict_view *v, int n, predict_notes *notes);

/* ---- solve.c: from the view to a hand and an object in camera coordinates ------------------------------ */

static const double PREDICT_NEAREST = 0.05, PREDICT_FARTHEST = 10;      /* metres that are believed */

typedef struct {
    estimate e;                     /* of the hand as it is, left or right */
    double theta[3 * LT_HAND_JOINTS];
    float heatmap2d[LT_HAND_KEYPOINTS][2], joints2d[LT_HAND_KEYPOINTS][2];      /* image pixels */
    double agreement_px;            /* mean distance of the two */
    float control2d[LT_BOX_POINTS][2];          /* of the object's box, image pixels; NaN: not seen */
    bool placed;                    /* else the hand's position is a guess */
    double measured_m, solved_m;    /* the wrist's depth: as depth has it, NaN where it does not; as joints' size has it */
    bool object_found;
    bool object_far;                /* a pose was found, too near or too far to be believed */
} predict_result;

typedef struct predict_solver predict_solver;

lt_status predict_solver_new(const predict_options *o, predict_solver **out);
void predict_solver_free(predict_solver *s);

lt_status predict_solve(predict_solver *s, lt_arena *arena, const predict_view *v, predict_result *out);

/* predict_trusted - whether 2D and 3D joints agree to a tenth of the hand's box */
bool predict_trusted(const predict_view *v, const predict_result *r);

/* predict_reproject - joints2d and agreement_px from the joints */
void predict_reproject(const predict_view *v, predict_result *r);

/* ---- place.c ------------------------------------------------------------------------------------------- */

/* predict_place_hand - joints and vertices from the wrist to the camera's axes; r->placed
 * Source: Bandi and Thomas 2025 name none; weighted least squares over the joints, and the depth image's word on how
 * far away they are. */
void predict_place_hand(const predict_view *v, predict_result *r);

/* depth.c: predict_note_depth - where what is measured has nothing to do with the hand's size */
void predict_note_depth(const predict_view *v, const predict_result *r, predict_notes *notes);

/* ---- smooth.c: a hand in a film, frame after frame ------------------------------------------------------- */

typedef struct {
    double dt;                      /* seconds between frames; the rest is zeroed at first */
    lt_point_filter joint[LT_HAND_KEYPOINTS];
    lt_pose_filter object;
    int missed;                     /* frames in a row without a hand that can be trusted */
    bool left;                      /* the hand that joint[] follows */
    crop_box box;                   /* where it was last */
    int unseen;                     /* frames in a row that have no box for it */
} predict_smoother;

enum { PREDICT_COAST = 15 };        /* frames that a hand is predicted without being seen */

/* predict_smooth - the next frame: joints, mesh and object pose move to where the filters have them. A hand that
 * cannot be trusted, or an object that was not found, is predicted for 15 frames. object: NULL: none was asked for. */
void predict_smooth(predict_smoother *s, const predict_view *v, const predict_object *object, predict_result *r);

/* predict_smooth_missed - the next frame could not be read: as one in which nothing was seen */
void predict_smooth_missed(predict_smoother *s);

/* ---- follow.c: the hands of a film ----------------------------------------------------------------------- */

/* The hands that are followed; the arena and dt are set, the rest zeroed at first. */
typedef struct {
    lt_arena *arena;                /* the film's */
    double dt;                      /* seconds between frames */
    predict_smoother *smoother;
    size_t n, room;
} predict_followed;

/* predict_follow - the next frame, in which n hands are seen: each is smoothed as the one of its side that was last
 * nearest by. A hand without a box is predicted for 15 frames, in case it comes back. */
lt_status predict_follow(predict_followed *f, const predict_view *v, predict_result *r, int n);

/* predict_follow_missed - the next frame could not be read: as one in which nothing was seen */
void predict_follow_missed(predict_followed *f);

/* ---- found.c: what was found, and how far to believe it -------------------------------------------------- */

void predict_note_found(const predict_view *v, const predict_result *r, predict_notes *notes);

/* ---- overlay.c, meshes.c, files.c: what is written ----------------------------------------------------- */

/* All that is known about one image. */
typedef struct {
    const predict_options *o;
    const predict_view *view;       /* (n), of each hand */
    const predict_result *result;   /* (n) */
    int n;
    const predict_notes *notes;
} predict_case;

/* predict_hand_mesh - hand i posed, its triangles looking outwards; in the arena */
lt_status predict_hand_mesh(lt_arena *arena, const predict_case *s, int i, lt_mesh *out);

/* Of a hand, names in the folder of results, the same twice where one file has both; object NULL: not found. */
typedef struct { const char *hand, *object; } predict_mesh_files;

/* predict_write_meshes - (n) hands and their objects in the format that was asked for; out: (n) */
lt_status predict_write_meshes(lt_arena *arena, const predict_case *s, const lt_mesh *hand, predict_mesh_files *out);

/* predict_file_name - the image's name with an ending, and where that is */
lt_status predict_file_name(lt_arena *arena, const predict_case *s, const char *ending, const char **name,
                            const char **path);

lt_status predict_write_overlay(lt_arena *arena, const predict_case *s, const lt_mesh *hand, const char *path);
lt_status predict_write_json(const predict_case *s, const predict_mesh_files *files, const char *path);
lt_status predict_write_files(lt_arena *arena, const predict_case *s);

#endif
