/* SPDX-License-Identifier: Apache-2.0 */
/* What the classes of a detector are called. */
#ifndef ESTIMATE_DETECTION_CLASS_NAMES_H
#define ESTIMATE_DETECTION_CLASS_NAMES_H

#include "libtensor/io/torch/torch.h"

/**
 * class_names_of - n names, in the arena; NULL without memory
 *
 *   listed   with commas between; not n of them, or NULL: unknown
 *
 * Where they are unknown 23 classes are those of `palmar synth --preset detect`, and 80 COCO's; any others are called
 * "class 0" and so on.
 */
const char **class_names_of(lt_arena *arena, const char *listed, int n);

/**
 * class_names_saved - the names in a checkpoint of PyTorch, with commas between, *out NULL where it has none
 *
 * As ultralytics leaves them: names of a module under "model" or "ema", by number or in order. Nothing in the file is
 * run. Errors: those of lt_torch_read.
 */
lt_status class_names_saved(lt_arena *arena, const char *path, const char **out);

/* class_names_in - likewise of one that was read. LT_ENOMEM. */
lt_status class_names_in(lt_arena *arena, const lt_torch_file *file, const char **out);

/* class_names_join - n of them with commas between, as class_names_of reads them; NULL without memory */
const char *class_names_join(lt_arena *arena, const char *const *name, int n);

#endif
