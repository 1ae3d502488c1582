/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The vision transformer in the layout of CLIP's image tower: no bias in the patches' projection, a norm before the
 * blocks, QuickGELU.
 *
 * Source: Dosovitskiy et al. 2021, "An image is worth 16 x 16 words", section 3.1; Radford et al. 2021, "Learning
 * transferable visual models from natural language supervision"; openai/CLIP clip/model.py.
 */
#ifndef MODELS_BACKBONES_VIT_H
#define MODELS_BACKBONES_VIT_H

#include "libtensor/nn/layers.h"

enum { VIT_MAX_LAYERS = 48 };

typedef struct {
    int image_size, patch;          /* pixels: the image's side, a multiple of the patch's */
    int width, layers, heads;       /* heads divide the width; hidden units are four times as many */
} vit_opts;

typedef enum { VIT_B32, VIT_S16, VIT_TINY } vit_variant;

/* vit_variants - "b32", CLIP's ViT-B/32; "s16"; "tiny", for a CPU: 6 layers of 192 on 112 x 112 pixels; then NULL */
extern const char *const vit_variants[];
extern const vit_opts vit_sizes[];

/* Attention, then a perceptron, each behind a norm and beside what it changes. CLIP's has QuickGELU and leaves nothing
 * out; whoever wants another one sets these fields. */
typedef struct {
    lt_layer_norm_layer norm1, norm2;
    lt_attention_layer attention;
    lt_linear_layer fc1, fc2;
    bool exact_gelu;
    double stochastic_depth;        /* chance that training leaves out what a half adds, in a sample */
} vit_block;

/* vit_block_new - tokens of so many channels; vit_block_forward - x (B, T, C) */
vit_block vit_block_new(lt_params *set, const char *prefix, int width, int heads);
void vit_block_init(const vit_block *b, uint64_t seed);
lt_tensor *vit_block_forward(const vit_block *b, lt_tensor *x);

typedef struct {
    vit_opts opts;
    lt_conv_layer patch;
    lt_param *class_token, *position;           /* (C), (1 + cells^2, C) */
    lt_layer_norm_layer norm_pre, norm;
    vit_block block[VIT_MAX_LAYERS];
} vit;

/* vit_new - registers the parameters; a prefix may be "" */
void vit_new(vit *m, lt_params *set, const char *prefix, const vit_opts *opts);

/* vit_init - as trained from scratch, after lt_init_default: weights normal with deviation 0.02, biases 0 */
void vit_init(const vit *m, uint64_t seed);

typedef struct {
    lt_tensor *feature;             /* (B, C): the class token behind the last norm */
    lt_tensor *patches;             /* (B, cells^2, C): what the last block makes of the patches, row by row; no norm */
} vit_out;

/* vit_forward - image (B, 3, S, S), normalised as its weights want it: vit_normalise */
vit_out vit_forward(const vit *m, lt_tensor *image);

/* vit_mean, vit_deviation - by which CLIP's weights want red, green and blue in [0, 1];  vit_normalise - does it */
extern const double vit_mean[3], vit_deviation[3];
lt_tensor *vit_normalise(lt_tensor *image);

#endif
