/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HOGS whole, in double: from images and poses to the parameters of each of its parts, along a random direction
 * that leans along the gradient.
 *
 * What is held still on purpose (the numbers of Gaussians that V-PM and G-PM read, directions' transforms) would show
 * in differences and not in gradients: so Gaussians are looked at without V-PM, V-PM without G-PM, G-PM with all of it,
 * and colours by degree 0 alone.
 */
#ifndef TESTS_MODELS_MODEL_GRADIENT_H
#define TESTS_MODELS_MODEL_GRADIENT_H

enum { MODEL_GRADIENT_CHAINS = 3, MODEL_GRADIENT_PARTS = 8 };

typedef struct {
    const char *through;            /* "G-PM to images, poses, contact" */
    const char *block;              /* of parameters: "gpm" */
    double error;                   /* of the slope, relative */
} model_gradient;

/* model_gradients - of a chain's parts; how many, at most MODEL_GRADIENT_PARTS; 0 with a line in lt_last_error(). The
 * first chain takes seconds, each other one half a minute. */
int model_gradients(int chain, model_gradient out[MODEL_GRADIENT_PARTS]);

#endif
