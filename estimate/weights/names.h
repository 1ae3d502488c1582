/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What published checkpoints call the weights of the networks that we have, in our words, which are
 * torchvision's.
 *
 * Source: torchvision models/resnet.py, models/efficientnet.py; lukemelas/EfficientNet-PyTorch model.py;
 * timm models/efficientnet.py, models/vision_transformer.py; openai/CLIP clip/model.py; huggingface/transformers CLIP;
 * richzhang/PerceptualSimilarity; the files of ultralytics' YOLOv8; lzfff12/HFL-Net and stevenlsw/Semi-Hand-Object
 * networks/backbone.
 */
#ifndef ESTIMATE_WEIGHT_NAMES_H
#define ESTIMATE_WEIGHT_NAMES_H

#include <stdbool.h>

typedef struct {
    const char *name;               /* whose words they are: "torchvision and palmar", "timm" ... */
    const char *note;               /* what its numbers were made with that ours are not; or NULL */

    /* Our name for one of theirs, which has nothing of a wrapper's before it, into out of WEIGHT_NAME bytes; false when
     * there is none. */
    bool (*ours)(const char *theirs, char *out);
} weight_family;

enum { WEIGHT_NAME = 256 };

/* weight_families - all of them; ends with a NULL name */
extern const weight_family weight_families[];

#endif
