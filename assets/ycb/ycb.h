/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The 21 YCB objects of YCB-Video, HO3D and DexYCB as a table: names, sizes and symmetries, in the model
 * frame of PoseCNN, which DexYCB and HO3D share.
 *
 * Source: the public model info of BOP's YCB-V; its frame is shifted, p_bop = p + b, so that the centre of
 * a model's bounding box is -b here.
 */
#ifndef ASSETS_YCB_YCB_H
#define ASSETS_YCB_YCB_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { YCB_COUNT = 21 };

typedef enum {
    YCB_SYM_NONE,
    YCB_SYM_CYLINDER_Z,             /* any turn about z; a label may break it */
    YCB_SYM_CYLINDER_Y,             /* any turn about y; a label may break it */
    YCB_SYM_CONTINUOUS_Z,           /* any turn about z, the texture as well */
    YCB_SYM_BOX,                    /* half turns about the three box axes, broken by the print */
    YCB_SYM_C2,                     /* half turn about the long axis */
    YCB_SYM_C2_Z,                   /* half turn about z, broken by the print */
    YCB_SYM_C4_Z,                   /* quarter turns about z, and flips */
} ycb_symmetry;

/* The lists of objects that papers score with ADD-S in place of ADD. */
typedef enum {
    YCB_ADDS_POSECNN = 1,           /* 13 16 19 20 21 */
    YCB_ADDS_BOP = 2,               /* 1 13 14 16 18 19 20 21 */
    YCB_ADDS_HFL = 4,               /* 13 16 20 21: HFL-Net's DexYCB tables */
} ycb_adds_set;

/* Metres and radians. */
typedef struct {
    int id;                         /* 1 .. 21 */
    const char *name;               /* "003_cracker_box": the folder's name */
    double size[3];                 /* of the axis-aligned box of the vertices */
    double centre[3];               /* of that box */
    double diameter;                /* the largest distance of two vertices (BOP) */
    double diagonal;                /* of the box of points.xyz, "diameter" in HFL-Net and its parents */
    ycb_symmetry symmetry;
    unsigned adds;                  /* ycb_adds_set bits */
    double yaw;                     /* of the smallest rectangle around the model seen along z */
    double rect[2];                 /* that rectangle: its width along the turned x, depth along the turned y */
} ycb_object;

/* ycb_find - the row of an id, or NULL outside 1 .. 21 */
const ycb_object *ycb_find(int id);

/* ycb_find_name - the row of a folder's name ("021_bleach_cleanser"), or NULL */
const ycb_object *ycb_find_name(const char *name);

#ifdef __cplusplus
}
#endif
#endif
