/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A camera as people have it: numbers, a text file of them, or what calibration programs write.
 */
#ifndef PIPELINE_CALIBRATION_CALIBRATION_H
#define PIPELINE_CALIBRATION_CALIBRATION_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/lens.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_camera camera;
    lt_lens lens;
    int width, height;              /* of the pictures that it was found with; 0: not said */
    double skew;                    /* pixels; not part of the camera */
} calibration;

/**
 * calibration_read - fx,fy,cx,cy or the nine numbers of a matrix, or the path of a file
 *
 *   name     of the option, for the error line
 *
 * A text file holds four or nine numbers, 3 x 4 or 4 x 4 of which the rest is the identity's, in any brackets; a matrix
 * may be transposed, as MATLAB has it. JSON and YAML, OpenCV's too: a matrix or fx, fy, cx, cy under one of their many
 * names, with distortion and the pictures' size where they stand beside it.
 *
 * Errors: LT_EUSAGE for what is neither numbers nor a file; LT_EFORMAT with the file and the line: no camera, several,
 * numbers that are none, a lens of another model than OpenCV's common one. LT_EIO, LT_ENOMEM.
 */
lt_status calibration_read(const char *name, const char *text, calibration *out);

/* calibration_parse - the contents of such a file, n bytes and a NUL behind them; name is for the error line */
lt_status calibration_parse(lt_arena *scratch, const char *name, const uint8_t *bytes, size_t n, calibration *out);

/* calibration_parse_lens - k1,k2,p1,p2[,k3[,k4,k5,k6]]; LT_EUSAGE, name is for the line: "--distortion" */
lt_status calibration_parse_lens(const char *name, const char *text, lt_lens *out);

/* calibration_set_matrix - of nine numbers by rows, or by columns where they say so; LT_EFORMAT */
lt_status calibration_set_matrix(const char *name, const double m[9], calibration *out);

/* calibration_from_tree - of a file of JSON or YAML */
struct lt_yaml;
lt_status calibration_from_tree(const struct lt_yaml *root, calibration *out);

#ifdef __cplusplus
}
#endif
#endif
