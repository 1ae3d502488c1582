/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A re-identification model at work: boxes of a picture in, embeddings out.
 */
#ifndef ESTIMATE_EMBEDDER_H
#define ESTIMATE_EMBEDDER_H

#include "libtensor/io/image/image.h"
#include "models/reid/reid.h"

typedef struct embedder embedder;

/* embedder_new - of a model reid, which must outlive it. LT_ENOMEM. */
lt_status embedder_new(const model *m, embedder **out);

/* embedder_open - of a checkpoint file, or the last one of a run's folder. Errors: those of reading; a model that is
 * trained for something else; LT_ENOMEM. */
lt_status embedder_open(const char *path, embedder **out);

/* embedder_free - NULL is fine */
void embedder_free(embedder *e);

/* embedder_run - the embedding (REID_EMBEDDING) of what lies in box x0 y0 x1 y1 of a picture of 8 bits; a person's box
 * is first made half as wide as high. False: nothing of the box is in the picture, and out is as it was. */
bool embedder_run(embedder *e, const lt_image *rgb, const float box[4], bool person, float *out);

#endif
