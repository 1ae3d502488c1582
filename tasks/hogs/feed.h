/* SPDX-License-Identifier: Apache-2.0 */
/* One frame on its way into a graph, for the files feed*.c alone. */
#ifndef TASKS_HOGS_FEED_H
#define TASKS_HOGS_FEED_H

#include "tasks/hogs/run.h"

typedef struct {
    const hogs_feeder *by;
    const task_run *run;
    const hogs *m;
    const lt_plan *plan;
    const model_record *r;
    const hogs_frame *f;
    int slot, batch;                /* which frame of the graph */
    hogs_placer placer;
    lt_rng rng;
    lt_real *posed[2];              /* (N, 3) of hand, object: in this plan's own input or none */
} feed_job;

/* feed_at - where frame `slot` of an input begins;  feed_whole - one that is not split over frames;  feed_integers -
 * those of one frame, which have its number behind their name where there are several. NULL: the graph has none */
void *feed_at(const feed_job *j, const char *name);
void *feed_whole(const feed_job *j, const char *name);
int32_t *feed_integers(const feed_job *j, const char *name);

/* feed_integer, feed_floats - into an input of one frame, if the graph has it */
void feed_integer(const feed_job *j, const char *name, int64_t value);
void feed_floats(const feed_job *j, const char *name, const float *from, int64_t n);

/* feed_first_row, feed_count - of the set that the frame shows */
int64_t feed_first_row(const hogs_placer *p, bool object);
int64_t feed_count(const hogs_placer *p, bool object);

/* feed_in_crop - column and row of a place of the camera in the crop; false: behind the camera */
bool feed_in_crop(const hogs_frame *f, const double x[3], double out[2]);

/* feed_points - G-PM's;  feed_contact;  feed_avatar;  feed_shake - stage 2 begins further off than the initial poses */
void feed_points(feed_job *j);
void feed_contact(feed_job *j);
void feed_avatar(feed_job *j);
void feed_shake(feed_job *j, hogs_frame *f);

#endif
