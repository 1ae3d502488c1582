/* SPDX-License-Identifier: Apache-2.0 */
/* palmar export --int8 */
#ifndef CLI_EXPORT_INT8_H
#define CLI_EXPORT_INT8_H

#include "cli/cli.h"

typedef struct {
    bool wanted;
    const char *data;               /* --calibration */
    int samples;
} cli_int8;

/* cli_export_int8 - calibrate the checkpoint's model, write it to path, and print which layers read integers, what
 * that costs and what it gains, as text or one JSON object */
lt_status cli_export_int8(const cli_int8 *o, cli_checkpoint *c, const char *path, bool json);

#endif
