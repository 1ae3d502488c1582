/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame as a trained model of Gaussians draws it: what pages, films and files of it are made of.
 */
#ifndef ESTIMATE_POSED_POSED_H
#define ESTIMATE_POSED_POSED_H

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/opacity/opacity.h"
#include "libtensor/io/mesh/ply.h"

enum { POSED_HAND, POSED_OBJECT, POSED_PARTS };

/* The opacity at which a surface is drawn where nobody asks for another: that of HOGS, 4.3, with the mean rule */
#define POSED_ISO 0.6

/* Borrowed while it is shown. Places are in the camera's frame (x right, y down, z forward), metres. */
typedef struct posed_frame posed_frame;
struct posed_frame {
    int64_t number;                     /* among the frames that can be asked for, from 0 */
    const char *name;                   /* as the dataset calls it: "SYN0MB30/0013" */
    const char *part[POSED_PARTS];      /* what the sets are called: "hand-01", "object-05"; scenes are objects */
    int width, height;
    lt_camera camera;                   /* a pixel is sampled at just its column and row */
    double near;                        /* nothing nearer to it is drawn */
    bool white;                         /* the background; else black */
    bool jittered;                      /* the image's colours */
    const lt_splat *splat;              /* those of the hand, then those of the object, of one colour each */
    size_t n[POSED_PARTS];
    const uint8_t *truth, *drawn;       /* (height, width, 3): hand and object cut out of the image, and as drawn */
    double psnr_db;                     /* of the two */
    double R[9], t[3];                  /* the object's refined pose */

    /* The surface of a part, coloured as it is shown; arrays in the arena. Errors: those of lt_opacity_mesh. */
    lt_status (*surface)(const posed_frame *f, int part, lt_opacity_rule rule, double iso, lt_arena *arena,
                         lt_mesh *out);
    const void *ctx;                    /* surface's own */
};

/* posed_surface - f->surface, but a part of which nothing is opaque enough has a mesh without faces. LT_ENOMEM */
lt_status posed_surface(const posed_frame *f, int part, lt_opacity_rule rule, double iso, lt_arena *arena,
                        lt_mesh *out);

/* posed_beside - the truth at the left of what was drawn: out (height, 2 width, 3) */
void posed_beside(const posed_frame *f, uint8_t *out);

#endif
