/* SPDX-License-Identifier: Apache-2.0 */
/* `palmar info --data` of pictures with objects: what each split has, and what was left out. */
#ifndef CLI_INFO_DETECTION_H
#define CLI_INFO_DETECTION_H

#include "libtensor/base/status.h"

struct cJSON;

/* info_detection - add to root the dataset's kind, and for each split that is there counts of images and objects, by
 * class too. Errors: those of detection_open, where no split can be opened. */
lt_status info_detection(const char *data, struct cJSON *root);

#endif
