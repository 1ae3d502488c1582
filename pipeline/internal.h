/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: what the stages are made of, one file each.
 */
#ifndef PIPELINE_INTERNAL_H
#define PIPELINE_INTERNAL_H

#include "libtensor/geometry/kalman/kalman.h"
#include "libtensor/io/image/exif.h"
#include "pipeline/frame.h"
#include "vision/drawing/draw.h"

/* ---- notes.c: what is told of an image ------------------------------------------------------------------ */

/* predict_say - one line to o->messages, bytes that would bend the line replaced by '?' */
void predict_say(const predict_options *o, const char *fmt, ...) LT_PRINTF(2, 3);

/* predict_note_add - v: which hand it is about, where there are several; NULL: the image */
void predict_note_add(predict_notes *notes, const predict_view *v, predict_note_code code, const char *fmt, ...)
    LT_PRINTF(4, 5);

/* predict_note_name - "low-trust" */
const char *predict_note_name(predict_note_code code);

enum { PREDICT_SAID = 512 };

/* What was told of the last image that was told of; zeroed at first. */
typedef struct {
    bool explained;
    char last[PREDICT_NOTES][PREDICT_SAID];
} predict_said;

/* predict_say_notes - to o->messages; what was assumed only where it is not what was told of the image before, and of a
 * film's frames also what was not found */
void predict_say_notes(const predict_options *o, const char *path, bool among_many, bool film,
                       const predict_notes *notes, predict_said *said);

/* ---- inputs.c: which images, and what their results are called ----------------------------------------- */

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

/* ---- pair.c: hands that a detector sees, each with an object -------------------------------------------- */

/* Models by a detector's classes, loaded when they are first seen. o, arena and of are set. */
typedef struct {
    const predict_options *o;
    lt_arena *arena;
    struct { bool tried; const predict_object *object; } *of;          /* by class */
} predict_models;

/* predict_views_detected - f->view: every hand among f's detections, the surest first, with what it holds */
lt_status predict_views_detected(predict_frame *f, predict_models *models);

/* predict_partner - which detection a hand goes with, NULL for none: the object whose box overlaps its own most (IoU),
 * else the nearest, if the gap is at most a quarter of the hand's longer side; of equals the surer one */
const predict_detection *predict_partner(const predict_detection *hand, const predict_detection *all, int n);

/* ---- view.c: the image, upright, with a camera and the boxes of each hand -------------------------------- */

const char *predict_source_name(predict_source s);

/* predict_scene_open - f->scene: the picture, upright, with a camera */
lt_status predict_scene_open(predict_frame *f);

/* predict_views_new - f->view: n hands that have the scene in common. LT_ENOMEM */
lt_status predict_views_new(predict_frame *f, int n);

/* predict_views_listed - f->view: the hands of the image's lines in --boxes, or the one of the options */
lt_status predict_views_listed(predict_frame *f);

/* predict_choose_side - v->left and v->any_side, from what a line of --boxes or a detector says */
void predict_choose_side(const predict_options *o, predict_side said, predict_view *v);

/* predict_default_hand_box - the middle of the image; predict_default_object_box - around the hand's box */
crop_box predict_default_hand_box(int width, int height);
crop_box predict_default_object_box(crop_box hand);

/* predict_check_inside - LT_EINVAL where a box of the view's is empty or outside its picture; what: "hand" */
lt_status predict_check_inside(const predict_view *v, const char *what, crop_box b);

/* predict_view_mirror - the same seen in a mirror, x -> width - 1 - x */
lt_status predict_view_mirror(lt_arena *arena, const predict_view *v, predict_view *out);

/* ---- turn.c: hands that stand another way up ------------------------------------------------------------- */

/* predict_view_turn - what is around the hand, turned clockwise by 1 to 3 quarters. LT_ENOMEM */
lt_status predict_view_turn(lt_arena *arena, const predict_view *v, int quarters, predict_view *out,
                            predict_turn *turn);

/* predict_turn_back - a result of that view as one of the view that was turned; theta and joints2d are not touched */
void predict_turn_back(const predict_turn *turn, predict_result *r);

/* ---- depth.c -------------------------------------------------------------------------------------------- */

/* predict_read_depth - v->depth, upright. LT_EFORMAT: no depth, or of another size; those of reading */
lt_status predict_read_depth(lt_arena *arena, const predict_options *o, const char *path, predict_view *v,
                             predict_notes *notes);

/* predict_note_depth - where what is measured has nothing to do with the hand's size */
void predict_note_depth(const predict_view *v, const predict_result *r, predict_notes *notes);

/* ---- camera.c ------------------------------------------------------------------------------------------- */

/* predict_choose_camera - v->camera for a picture of its size */
void predict_choose_camera(const predict_options *o, const lt_exif *exif, predict_view *v, predict_notes *notes);

/* predict_assumed_camera - of a focal length in pixels; 0: 1.2 times the longer side */
lt_camera predict_assumed_camera(double focal, int width, int height);

/* predict_undistort - picture and depth without o->lens. LT_EINVAL: no lens makes such a picture; LT_ENOMEM */
lt_status predict_undistort(lt_arena *arena, const predict_options *o, predict_view *v, predict_notes *notes);

/* predict_undistort_box - of the distorted picture, in the one without distortion */
crop_box predict_undistort_box(const predict_view *v, crop_box b);

/* ---- assumed.c: what was not given --------------------------------------------------------------------- */

/* predict_note_assumed - of a frame and its views */
void predict_note_assumed(predict_frame *f);

/* ---- place.c: where the hand is, and how far that is to be believed -------------------------------------- */

static const double PREDICT_NEAREST = 0.05, PREDICT_FARTHEST = 10;      /* metres that are believed */

/* predict_place_hand - joints and vertices from the wrist to the camera's axes; r->placed
 * Source: Bandi and Thomas 2025 name none; weighted least squares over the joints, and the depth image's word on how
 * far away they are. */
void predict_place_hand(const predict_view *v, predict_result *r);

/* predict_reproject - joints2d and agreement_px from the joints */
void predict_reproject(const predict_view *v, predict_result *r);

/* predict_trusted - whether 2D and 3D joints agree to a tenth of the hand's box */
bool predict_trusted(const predict_view *v, const predict_result *r);

/* predict_object_apart - metres from the joints to the box of the object, 0 in it; infinite where none was found.
 * predict_object_trusted - whether it is in reach of a hand that can be trusted itself */
double predict_object_apart(const predict_view *v, const predict_result *r);
bool predict_object_trusted(const predict_view *v, const predict_result *r);

/* predict_hand_alone - whether the model was never taught where objects are, so that none is asked for */
static inline bool predict_hand_alone(const predict_options *o)
{
    return o->m && o->m->hand_alone;
}

/* ---- smooth.c: a hand in a film, frame after frame ------------------------------------------------------- */

typedef struct {
    double dt;                      /* seconds between frames; the rest is zeroed at first */
    lt_point_filter joint[LT_HAND_KEYPOINTS];
    lt_pose_filter object;
    const predict_object *held;     /* the one that `object` follows */
    int64_t track;                  /* of the hand; 0: not known */
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

/* The hands that are followed; the arena, dt and which are set, the rest zeroed at first. */
struct predict_followed {
    lt_arena *arena;                /* the film's */
    int which;                      /* film, each has another number */
    double dt;                      /* seconds between frames */
    double time;                    /* seconds, of the frame at hand */
    predict_smoother *smoother;
    size_t n, room;
};

/* predict_follow - the next frame, in which n hands are seen: each is smoothed as the one of its track, else as the one
 * of its side that was last nearest by. A hand without a box is predicted for 15 frames, in case it comes back. */
lt_status predict_follow(predict_followed *f, lt_arena *scratch, const predict_view *v, predict_result *r, int n);

/* predict_follow_sides - of hands in the next frame whose side nobody says: as the hand that each is followed as, where
 * there is one; known: (n) whether there is. LT_ENOMEM */
lt_status predict_follow_sides(const predict_followed *f, lt_arena *scratch, predict_view *v, int n, bool *known);

/* predict_follow_missed - the next frame could not be read: as one in which nothing was seen */
void predict_follow_missed(predict_followed *f);

/* ---- marks.c, overlay.c, meshes.c, json.c: what is written --------------------------------------------- */

/* predict_draw_detections - masks, boxes, and what each is called; width: of lines, pixels */
void predict_draw_detections(draw_canvas *c, const predict_frame *f, float width);

/* predict_hand_mesh - hand i posed, its triangles looking outwards; in the frame's arena */
lt_status predict_hand_mesh(const predict_frame *f, int i, lt_mesh *out);

lt_status predict_draw_overlay(const predict_frame *f, lt_image *out);

/* predict_write_meshes - f->hand and the objects in the format that was asked for; f->files */
lt_status predict_write_meshes(const predict_frame *f);

/* predict_file_name - the image's name with an ending, and where that is */
lt_status predict_file_name(const predict_frame *f, const char *ending, const char **name, const char **path);

/* predict_write_json - into a file; predict_print_json - as one line, at once */
lt_status predict_write_json(const predict_frame *f, const char *path);
lt_status predict_print_json(const predict_frame *f, FILE *to);

#endif
