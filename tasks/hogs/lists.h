/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is known of each set's Gaussians and changes with them, now and then: neighbours, the hand's vertex that each is
 * nearest to, what is inside an object and which of its Gaussians are at its surface. Made anew every thousand
 * iterations of the cpu profile's length, and whenever rows have moved.
 */
#ifndef TASKS_HOGS_LISTS_H
#define TASKS_HOGS_LISTS_H

#include "libtensor/io/array/array.h"
#include "models/hogs/hogs.h"
#include "tasks/hogs/rig.h"

typedef struct {
    int64_t rows;                   /* of all sets, as the Gaussians have them */
    int hands, objects;
    int32_t (*near)[HOGS_NEIGHBOURS];       /* (rows) numbers within the set; -1: none */
    int32_t *vertex;                /* (rows) of a hand's; -1 elsewhere */
    occupancy *grid;                /* (objects) */
    int32_t (*surface)[HOGS_SURFACE_POINTS];        /* (objects) Gaussians within the set, repeated until full */
    lt_real *saved[4];              /* as a checkpoint has them */
} hogs_lists;

/* hogs_lists_make - of the model's Gaussians as they are; rig (hands). *l is empty or from before; LT_ENOMEM. */
lt_status hogs_lists_make(hogs_lists *l, const hogs *m, const hogs_rig *rig);
void hogs_lists_free(hogs_lists *l);

/* hogs_lists_save - arrays for a checkpoint, "task.near" ..; how many, 0 without memory. hogs_lists_load - back, for a
 * model whose rows are those of the file. Errors: LT_EINVAL for a file that lacks them; LT_ENOMEM. */
int hogs_lists_save(hogs_lists *l, lt_named_array *out, int room);
lt_status hogs_lists_load(hogs_lists *l, const hogs *m, const char *path, const lt_named_array *entry, size_t n);

#endif
