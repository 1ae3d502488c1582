/* SPDX-License-Identifier: Apache-2.0 */
/* What the readers of detection sets share. */
#ifndef DATA_DETECTION_INTERNAL_H
#define DATA_DETECTION_INTERNAL_H

#include "data/detection/detection.h"

/* Both find their files below root, or say LT_EIO. */
lt_status detection_coco_open(lt_arena *arena, const char *root, const char *split, detection_set *out);
lt_status detection_yolo_open(lt_arena *arena, const char *root, const char *split, detection_set *out);

/* detection_coco_list - root's annotations of a split, in the arena, and what the split is called there; NULL: none */
const char *detection_coco_list(lt_arena *arena, const char *root, const char *split, const char **name);

/* detection_yaml - root itself, or root/data.yaml; NULL: neither */
const char *detection_yaml(lt_arena *arena, const char *root);

/* detection_fault - count one, and keep the line if it is the first; returns LT_OK or LT_ENOMEM */
lt_status detection_fault(lt_arena *arena, detection_set *s, int64_t *counter, const char *line);

/* detection_parse_coco - what a file of COCO's holds, without looking for its pictures, whose folder is images */
lt_status detection_parse_coco(lt_arena *arena, const char *path, const char *images, detection_set *out);

/* A reader's objects of one image, while they are collected */
typedef struct {
    detection_object *list;
    size_t n, room;
} object_list;

/* detection_parse_labels - the rows of one of YOLO's files of labels, which is changed. Errors: LT_EFORMAT with file,
 * line and value. *twice: rows that stand there twice, and are dropped */
lt_status detection_parse_labels(lt_arena *arena, const char *path, char *text, size_t n, int classes,
                                 object_list *out, int64_t *twice);

#endif
