/* SPDX-License-Identifier: Apache-2.0 */
/*
 * `palmar info FILE`: what a file has.
 */
#ifndef CLI_INFO_FILE_H
#define CLI_INFO_FILE_H

#include "libtensor/base/status.h"

struct cJSON;

/**
 * info_file - add to root: arrays with shape and type, metadata; of hands and bodies, whether they are complete
 *
 *   name   safetensors and their index, an .npz, a .npy, a pickle, or PyTorch's, told apart by their first bytes; a
 *          run's folder stands for its last checkpoint
 *
 * "notes" is a list of { code, text }; docs/formats.md has the codes.
 * Errors: no such file, one of another kind, a broken one.
 */
lt_status info_file(const char *name, struct cJSON *root);

#endif
