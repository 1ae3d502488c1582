/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A task that hurts: blobs that learn where to be from pictures of them, and grow. Three sets of blobs in one parameter
 * by rows, two of them in a sample; cloned and pruned every twenty steps; two phases of other batches and other
 * optimiser groups; a state of its own; scored by average precision over records of any length.
 */
#ifndef TESTS_TASKS_BLOBS_H
#define TESTS_TASKS_BLOBS_H

#include "train/task.h"

extern const task blobs_task;

#endif
