/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HOGS: hand and object as two sets of Gaussians, changed and coloured by what an image shows (V-PM), posed, and drawn
 * together; the object's pose refined by another network (G-PM).
 *
 * Files: hogs.c the model as the zoo knows it, hogs_record.c its graph, hogs_loss.c its losses. A set is a hand's
 * subject or an object; hands come first.
 */
#ifndef MODELS_HOGS_HOGS_H
#define MODELS_HOGS_HOGS_H

#include "libtensor/geometry/mesh/mesh.h"
#include "models/backbones/lpips.h"
#include "models/backbones/vit.h"
#include "models/hogs/avatar.h"
#include "models/hogs/contact.h"
#include "models/hogs/occupancy.h"
#include "models/hogs/sizes.h"
#include "models/model.h"
#include "models/splats/gaussians.h"

#define HOGS_NEAR 0.2                           /* metres: nothing nearer to the camera is drawn */

enum {
    HOGS_TARGETS = 12,              /* red, green, blue of both, of the hand, of the object; the three masks */
    HOGS_IMAGES = 3,
    HOGS_NEIGHBOURS = 4,
    HOGS_SKIN_POINTS = 1024, HOGS_CONTACT_POINTS = 1024, HOGS_SURFACE_POINTS = 1024,
    HOGS_CORNERS = 8, HOGS_BATCH = 16,      /* corners of a box; frames in a graph at most */
};

/* A row of Tables 4 to 8 */
typedef struct {
    const char *name;
    bool small;                     /* in a CPU's sizes, whatever model.size says */
    bool F, pixel, G;               /* what V-PM's trunk reads                                           [Table 8] */
    bool colour, geometry;          /* whether it changes colours, and places, sizes, rotations          [Table 7] */
    bool gpm, contact;
    bool random_points;             /* G-PM's point backbone is not pretrained */
    bool avatar;                    /* the baseline 3DGS-Avatar, in the place of V-PM */
} hogs_variant;

typedef enum { HOGS_NR_NONE, HOGS_NR_DEXYCB, HOGS_NR_HO3D } hogs_lambda_nr;

typedef struct {
    int variant;
    int small;                      /* model.size: 0 the paper's, 1 a CPU's */
    int hands, objects, gaussians;  /* sets, and Gaussians of one at first; 0: as many as the data have, as the size */
    int frames;                     /* that the avatar has codes of; 0: as many as the data have */
    int width, height;              /* of the frames; 0: as the data have */
    int one_blob, raw_vit, white, subset, clip_groups;      /* choices, of two each */
    int lambda_nr;
    bool alpha3, metric_radius;
    const char *point_backbone;     /* "": none */
} hogs_config;

typedef struct {
    hogs_config config;
    const hogs_variant *is;
    hogs_sizes sizes;
    gaussians gaussians;
    vit vit;
    vpm hand, object;
    avatar avatar;
    skin_field skin;
    gpm gpm;
    lpips lpips;
    bool takes_seen;                /* hogs_take_seen was called */
    /* what is known of the sets, and never moves */
    lt_param *box[2];               /* (hands, 6), (objects, 6): middle of the canonical box, metres, and 1 / half of
                                     * its extents */
    lt_param *id[2];                /* (hands), (objects): subject, object */
    lt_param *beta;                 /* (hands, 10) */
    const struct hogs_sets *sets;   /* given before init; NULL: balls, to measure with */
} hogs;

extern const model_class hogs_class;

static inline const hogs *hogs_of(const model *m) { return m->self; }
static inline int hogs_n_sets(const hogs *m) { return m->config.hands + m->config.objects; }

/* ---- what sets are, before there is a model -------------------------------------------------------------- */

/* A set's canonical shape. Borrowed. */
typedef struct {
    int id;                         /* subject or object, as the data call it */
    double lo[3], hi[3];            /* its box, metres: a hand's mesh with a tenth of its extents around it */
    const lt_mesh *mesh;            /* a hand's, whose surface Gaussians begin at; NULL: anywhere in the box */
    float beta[LT_HAND_BETAS];      /* a hand's */
} hogs_set;

typedef struct hogs_sets {
    int hands, objects;
    hogs_set *set;                  /* hands + objects */
} hogs_sets;

/* hogs_give_sets - what init places Gaussians in; outlives it. Errors: another number of sets than m has. */
lt_status hogs_give_sets(model *m, const hogs_sets *sets);

/* hogs_find_set - the number of a hand's (object false) or an object's set; -1: none */
int hogs_find_set(const hogs *m, bool object, int id);

/* hogs_beta - the shape of a hand's set */
void hogs_beta(const hogs *m, int hand, float out[LT_HAND_BETAS]);

/* ---- graphs ------------------------------------------------------------------------------------------------- */

/* What a graph is for. B frames are in it; stages that draw take one. */
typedef enum {
    HOGS_SKIN,                      /* stage 0: the skinning field alone */
    HOGS_WARM,                      /* stage 1 while the skinning field's loss counts 10 */
    HOGS_GAUSSIANS,                 /* 1a: all but poses */
    HOGS_JOINT,                     /* 1b: everything */
    HOGS_POSES,                     /* 2: G-PM alone */
    HOGS_RENDER,                    /* no losses: images and refined poses */
    HOGS_STAGES,
} hogs_stage;

/**
 * hogs_record - record r->batch frames for a stage
 *
 * Inputs, by name, N the capacity of a set, of B frames; LT_I32 ones have a number behind their name where B > 1:
 *   "image" (B, 3, S, S) the crop in [0, 1]; or after hogs_take_seen "feature" (B, C), "patches" (B, map^2, C)
 *   "hand_set", "object_set" (1)   the set's number, from 0 among hands, among objects; LT_I32
 *   "hand_row", "object_row" (1)   its first row; LT_I32
 *   "hand_alive", "object_alive" (B, N, 1)   1 for rows in use, else 0
 *   "hand_place", "object_place" (B, N, 2)   where the initial pose puts them, in cells of the map
 *   "camera" (4)   "bones" (16, 3, 4)   "view" (3, 4)   "degree" (1) LT_I32 of spherical harmonics
 *   "rotation" (B, 3, 3), "translation" (B, 3)   the object's initial pose
 * of the avatar, in the place of "image":
 *   "articulation" (16, 13)   "started" (1)   "frame_code" (1) LT_I32, in training
 * of G-PM, P points drawn of N:
 *   "drawn" (1, P) LT_I32 of each frame   "points" (B, P, 3) camera   "rgb" (B, P, 3)   "count", "start" (B) LT_I32
 *   "root" (B, 3)
 * of losses:
 *   "target" (12, H, W)   "lpips_boxes" (3, 4)   "hand_near", "object_near" (N, 4) LT_I32
 *   "skin_points" (1024, 3), "skin_weights" (1024, 16)
 *   "true_rotation" (B, 3, 3), "true_translation" (B, 3), "offset" (B, 3), "corners" (B, 8, 3), "pose_weight" (B)
 *   "hand_points" (B, 1024, 3), "zones" (B, 1024) LT_I32, "surface" (B, 1024, 3), "inside" (B, cells) LT_U8,
 *   "grid" (B, 6)
 *   "hand_offset", "object_offset" (N, 2)   zeros on the screen, whose gradients density control looks at
 * Outputs: "frame" (12, H, W); "pose_rotation" (B, 3, 3), "pose_translation" (B, 3); and the Gaussians as they are
 * drawn, hand first: "centre" (2 N, 3), "axes" (2 N, 3, 3), "alpha" (2 N, 1), "colour" (2 N, 3), "radius" (2 N)
 */
void hogs_record(const model *m, hogs_stage stage, model_record *r);

/* hogs_see - what the ViT sees in crops (B, 3, S, S) in [0, 1]
 * hogs_take_seen - graphs that are recorded to learn from now on take that as inputs: for a ViT that does not learn */
vit_out hogs_see(const hogs *m, lt_tensor *image);
void hogs_take_seen(model *m);

/* ---- between hogs_record.c and hogs_loss.c --------------------------------------------------------------- */

/* A set as it is in one frame */
typedef struct {
    bool object;
    gaussian_rows rows;             /* canonical, as they are stored */
    hogs_box box;
    lt_tensor *set;                 /* (1) LT_I32 among hands, among objects */
    lt_tensor *alive;               /* (N, 1) */
    lt_tensor *place;               /* (1, N, 2) in cells of the map */
    lt_tensor *code;                /* the frame's; NULL: V-PM has none */
    vpm_gaussians read;             /* what V-PM and G-PM read of them */
    vpm_out deltas;                 /* place NULL: V-PM leaves it alone */
    lt_tensor *centre, *log_scale, *quaternion;     /* behind V-PM, canonical */
    lt_tensor *posed, *axes, *colour;               /* in the camera */
} hogs_drawn_set;

typedef struct {
    hogs_drawn_set hand, object;
    lt_tensor *images;              /* (12, H, W) */
    lt_tensor *radius;
} hogs_drawn;

/* hogs_scene_losses - of what was drawn: images, masks, LPIPS, skinning, neighbours, V-PM's changes.
 * hogs_skin_loss - the skinning field alone. hogs_pose_losses - of G-PM, contact and penetration.
 * Each adds its named losses to r, and its weighted sum to r->loss. hogs_skin_weight - what the field's counts */
double hogs_skin_weight(hogs_stage stage);
void hogs_scene_losses(const hogs *m, hogs_stage stage, const hogs_drawn *d, model_record *r);
void hogs_skin_loss(const hogs *m, double weight, lt_tensor *hand_set, model_record *r);
void hogs_pose_losses(const hogs *m, const gpm_out *offsets, const hogs_pose *initial, const hogs_pose *refined,
                      model_record *r);

/* hogs_fill - model_class.fill: a hand before an object, half a metre away */
void hogs_fill(const model *m, const char *input, lt_real *x);

/* hogs_identity - the transform (1, 3, 4) that leaves everything where it is */
lt_tensor *hogs_identity(lt_graph *g);

/* hogs_integers - an input of LT_I32; hogs_set_box - of the set, whose number in all of them is in which (1) */
lt_tensor *hogs_integers(model_record *r, const char *name, lt_shape shape);
hogs_box hogs_set_box(const hogs *m, lt_tensor *which, bool object);

#endif
