/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What published checkpoints call the weights of the networks that we have, in our words, which are
 * torchvision's.
 *
 * Source: torchvision models/resnet.py, models/efficientnet.py; lukemelas/EfficientNet-PyTorch model.py;
 * timm models/efficientnet.py; lzfff12/HFL-Net and stevenlsw/Semi-Hand-Object networks/backbone.
 */
#ifndef ESTIMATE_WEIGHT_NAMES_H
#define ESTIMATE_WEIGHT_NAMES_H

#include "libtensor/io/array/array.h"

typedef struct {
    const char *name;               /* whose words they are: "torchvision and palmar", "timm" ... */
    const char *note;               /* what its numbers were made with that ours are not; or NULL */

    /* Our name for one of theirs, which has no prefix any more, into out of WEIGHT_NAME bytes; false when
     * there is none. */
    bool (*ours)(const char *theirs, char *out);
    const char *mark;               /* a name that only this family's files have; NULL: any file's */
} weight_family;

enum { WEIGHT_NAME = 256 };

/* weight_family_of - the family of a file with these n names; never NULL */
const weight_family *weight_family_of(const lt_named_array *entry, size_t n);

/* weight_name - our name for one of a family's: wrappers such as "module." taken off, then translated */
bool weight_name(const weight_family *f, const char *theirs, char out[WEIGHT_NAME]);

#endif
