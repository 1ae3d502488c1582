/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of OSX behind its encoder, in the form without decoders: where the joints are, how the body's are turned,
 * where hands and face are, how the hands' joints are turned.
 *
 * Places are in cells, column, row and depth, which count as pixels do: column 1 of the encoder's map is at pixel 16. A
 * body's depth is from its pelvis, a hand's from its wrist, metres: cell 8 (1 + z / OSX_BODY_DEPTH).
 *
 * Source: Lin et al. 2023, sections 3.3 and 3.4; IDEA-Research/OSX common/nets/module_wo_decoder.py.
 */
#ifndef MODELS_BODY_OSX_PARTS_H
#define MODELS_BODY_OSX_PARTS_H

#include "models/body/osx_encoder.h"

enum {
    OSX_DEPTHS = 16,                /* bins of a body joint's depth */
    OSX_BODY_ROTATIONS = 22,        /* the pelvis, which is the whole body's, and 21 joints */
    OSX_HAND_JOINTS = 20, OSX_HAND_ROTATIONS = 15, OSX_HAND_CELLS = 16,
    OSX_BOXES = 3,                  /* left hand, right hand, face */
    OSX_SHAPES = 10, OSX_EXPRESSIONS = 10,
};

static const double OSX_BODY_DEPTH = 1, OSX_HAND_DEPTH = 0.15;      /* metres that half of the depth's cells take in */

/* What is as wide as the encoder (width), as the maps of boxes (box), as what is regressed from (fc) */
typedef struct { int width, box, fc; } osx_sizes;

/* ---- places of joints ---- */

/* A map of cells in space for each joint, and the mean place in it. */
typedef struct {
    lt_conv_layer conv;
    int joints, depth;
} osx_position;

osx_position osx_position_new(lt_params *set, const char *prefix, int width, int joints, int depth);

typedef struct {
    lt_tensor *logits, *heat;       /* (B, joints, depth rows columns): before the softmax; behind it, sums to 1 */
    lt_tensor *place;               /* (B, joints, 3) */
} osx_places;

/* osx_position_forward - map (B, C, rows, columns) */
osx_places osx_position_forward(const osx_position *m, lt_tensor *map);

/* osx_sample - what a map (B, C, rows, columns) has at place (B, N, 2), between its cells: (B, N, C); places are
 * constants */
lt_tensor *osx_sample(lt_tensor *map, lt_tensor *place);

/* osx_of_token - what a layer makes of one of the tokens (B, N, C): (B, n) */
lt_tensor *osx_of_token(const lt_linear_layer *l, lt_tensor *tokens, int i);

/* ---- the body ---- */

typedef struct {
    lt_linear_layer conv, root, pose, shape, camera;
} osx_body;

osx_body osx_body_new(lt_params *set, const char *prefix, osx_sizes size);

typedef struct {
    lt_tensor *rotation;            /* (B, OSX_BODY_ROTATIONS, 3, 3) */
    lt_tensor *shape;               /* (B, OSX_SHAPES) */
    lt_tensor *camera;              /* (B, 3) where the body is, metres, before the virtual camera */
} osx_body_out;

osx_body_out osx_body_forward(const osx_body *m, lt_tensor *tokens, lt_tensor *place);

/* osx_rotations - (B, n * 6) as OSX has them, the two columns' numbers in turns -> (B, n, 3, 3) */
lt_tensor *osx_rotations(lt_tensor *six);

/* osx_rotations_init - of the layer before: every joint at rest, nearly */
void osx_rotations_init(const lt_linear_layer *l, uint64_t seed);

/* ---- boxes ---- */

/* A map twice as large: a transposed convolution, a batch norm, ReLU */
typedef struct {
    lt_param *weight;
    lt_batch_norm_layer bn;
} osx_up;

osx_up osx_up_new(lt_params *set, const char *prefix, int number, int in, int out);
lt_tensor *osx_up_forward(const osx_up *m, lt_tensor *x);

enum { OSX_BOX_UPS = 3, OSX_HAND_UPS = 2 };

typedef struct {
    osx_up up[OSX_BOX_UPS];
    lt_conv_layer centre;
    lt_linear_layer size[OSX_BOXES][2];
} osx_box_net;

osx_box_net osx_box_net_new(lt_params *set, const char *prefix, osx_sizes size);

typedef struct {
    lt_tensor *centre, *size;       /* (B, OSX_BOXES, 2) in cells of the encoder's map */
} osx_boxes;

osx_boxes osx_box_net_forward(const osx_box_net *m, lt_tensor *map, lt_tensor *heat);

/* osx_box_pixels - box number i squared and made larger by `times`, (B, 5): the sample's number, x0 y0 x1 y1 in pixels;
 * no gradient */
lt_tensor *osx_box_pixels(const osx_boxes *b, int i, double times);

/* ---- hands ---- */

typedef struct {
    osx_up up[OSX_HAND_UPS];
    lt_conv_layer widen;
    osx_position position;
    lt_conv_layer conv;
    lt_batch_norm_layer bn;
    lt_linear_layer pose;
} osx_hands;

osx_hands osx_hands_new(lt_params *set, osx_sizes size);

typedef struct {
    lt_tensor *place[2];            /* (B, OSX_HAND_JOINTS, 3) left, right: in OSX_HAND_CELLS cells of the hand's box */
    lt_tensor *rotation[2];         /* (B, OSX_HAND_ROTATIONS, 3, 3) */
} osx_hands_out;

/* osx_hands_forward - box (B, 5) of the left hand and the right one, pixels */
osx_hands_out osx_hands_forward(const osx_hands *m, lt_tensor *map, lt_tensor *const box[2]);

/* osx_hand_in_picture - a hand's places in its box (B, 5), as the encoder's map counts columns and rows; the depth stays
 * as it is */
lt_tensor *osx_hand_in_picture(lt_tensor *place, lt_tensor *box);

#endif
