/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Slips that people make with numbers in space: another unit, other axes, joints in another order, places counted from
 * the wrist, intrinsics of another image. They are found by size and by what would make the numbers fit, and said in
 * one half-sentence, "the joints are in millimetres, not metres". Of labels and of result files alike.
 */
#ifndef DATA_SLIP_H
#define DATA_SLIP_H

#include "libtensor/base/common.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SLIP_TEXT = 320, SLIP_UNIT = 64 };

typedef struct {
    const char *code;               /* "unit", "axes", "order", "place", "size", "camera"; NULL: nothing is found */
    char text[SLIP_TEXT];
    double before, after;           /* metres from where they ought to be: as they are, and without the slip */
} slip;

/* What a file ought to have, in whose words a slip is said. */
typedef struct {
    bool opengl;                    /* OpenGL's axes (y up, z backward), not OpenCV's */
    bool millimetres;               /* that unit, not metres */
} slip_file;

/* Joints or vertices of n samples, in metres, OpenCV's axes and simple order after they were read. */
typedef struct {
    const char *what;               /* "the joints" */
    slip_file file;
    int64_t n;
    int points;                     /* 21 are joints, whose order is tried too */
    const float *found, *wanted;    /* (n, points, 3) */
    int skip;                       /* a point that is not compared; -1: none */
    bool places;                    /* where the hands are is compared too, not their shape alone */
} slip_points;

/**
 * slip_in_points - why points are not where they ought to be
 *
 * Tried are units, each way to name and turn the axes, the orders of MANO, InterHand, RHD, F-PHAB and of fingers from
 * the little one, and all of these together; each has to halve the distance to count. Hands are compared about their
 * own middle, so that a wrong place does not hide a wrong shape, and then their places. Samples that are not finite or
 * of a size unlike most are passed over. out->code is NULL when nothing explains anything, or memory is short.
 */
void slip_in_points(const slip_points *p, slip *out);

/* A pose of an object, estimated and true, and the corners of its box in its own frame. */
typedef struct {
    lt_pose found, wanted;
    double corner[8][3], centre[3];
} slip_pose;

/* slip_in_poses - the same of n poses: the translation's unit, axes, a rotation that is transposed, a pose of the
 * camera in the object's frame, BOP's frame whose origin is the box's centre. By the median over poses. */
void slip_in_poses(const slip_pose *pose, int64_t n, slip_file file, slip *out);

/**
 * slip_in_camera - whether intrinsics are those of another image than one of width x height
 *
 * The principal point ought to be within a fifth of the image of its middle, and the focal length between a third and
 * ten times the longer side. Named are another size of image, exchanged cx and cy, units of the image's size, and
 * focal lengths in millimetres.
 */
void slip_in_camera(const lt_camera *camera, int width, int height, slip *out);

/* slip_unit - the power of ten from -6 to 6, 0 for none, that brings a size into [lo, hi], nearest to the middle; 0 too
 * where none does. slip_unit_words - what that power, not 0, tells of a file that ought to be in metres or millimetres:
 * "in millimetres, not metres", "1000 times too small"; returns out */
int slip_unit(double size, double lo, double hi);
const char *slip_unit_words(int power, bool millimetres, char out[SLIP_UNIT]);

#ifdef __cplusplus
}
#endif
#endif
