/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The checkpoints/ folder of a run: step-000412.safetensors and so on, of which the newest few stay, and
 * last.safetensors and best.safetensors, which are further names of files that were written as a step.
 */
#ifndef ESTIMATE_CHECKPOINT_FOLDER_H
#define ESTIMATE_CHECKPOINT_FOLDER_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"

/* checkpoint_name - "folder/step-000412.safetensors" in the arena; NULL without memory */
const char *checkpoint_name(lt_arena *arena, const char *folder, int64_t step);

/* checkpoint_step - that a path ends with, -1 where it names none */
int64_t checkpoint_step(const char *path);

/* checkpoint_list - the step files of a folder, newest first; *n is 0 when there is no such folder */
lt_status checkpoint_list(lt_arena *arena, const char *folder, const char *const **paths, int *n);

/* checkpoint_last - of a run's folder its last checkpoint, in the arena; any other path as it is; NULL without
 * memory */
const char *checkpoint_last(lt_arena *arena, const char *path);

/**
 * checkpoint_alias - let folder/name be the file at path too
 *
 * A hard link, put in place by a rename; a copy where the file system has no links. What had the name stays
 * until then. Errors: LT_EIO, LT_ENOSPC.
 */
lt_status checkpoint_alias(const char *folder, const char *name, const char *path);

/* checkpoint_prune - of the files up to a step remove all but the newest keep, and what a killed run left half written;
 * later ones are no more than what the run could not go on from */
lt_status checkpoint_prune(const char *folder, int64_t step, int keep);

#endif
