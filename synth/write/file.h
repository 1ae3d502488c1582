/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The files of a dataset, as its manifest lists them.
 */
#ifndef SYNTH_WRITE_FILE_H
#define SYNTH_WRITE_FILE_H

#include "libtensor/base/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_FRAME_FILES = 4 };                 /* of one frame, in the layout that has most */

typedef struct {
    char path[128];                             /* within the dataset */
    uint32_t crc;                               /* CRC-32 of the file */
} synth_file;

/* synth_describe_file - the CRC of root/path into *out */
lt_status synth_describe_file(const char *root, const char *path, synth_file *out);

#ifdef __cplusplus
}
#endif
#endif
