/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Batches of pictures of persons, and how they come into the model's graph.
 */
#ifndef TASKS_BODY_BATCH_H
#define TASKS_BODY_BATCH_H

#include "data/body/set.h"
#include "estimate/body/graph.h"
#include "tasks/body/config.h"

enum { BODY_OF_BODY = 25, BODY_OF_HANDS = 40 };    /* of the 65 nodes */
enum { BODY_PICTURE_FLOATS = 3 * BODY_PICTURE_HEIGHT * BODY_PICTURE_WIDTH };

/* What the model's losses compare with, under the names of its inputs */
typedef struct {
    float rotation[BODY_ROTATIONS][9], shape[BODY_SHAPES], expression[BODY_EXPRESSIONS];
    float body_place[BODY_OF_BODY][3], hand_place[BODY_OF_HANDS][3];
    float box_centre[BODY_BOXES][2], box_size[BODY_BOXES][2];
    float nodes[BODY_NODES][3], bearing[BODY_NODES][2];
    float body_known[BODY_OF_BODY], hand_known[BODY_OF_HANDS], box_known[BODY_BOXES], node_known[BODY_NODES];
} body_target;

/* A source of pictures: count of them, spread over the set. */
typedef struct {
    const body_set *set;
    int64_t count;
    double scale, shift, rotation_deg, flip, colour;        /* body_data_config's; 0 elsewhere than in training */
    uint64_t seed;
} body_feed;

/* body_feed_index - the number in the set of the feed's i-th picture */
int64_t body_feed_index(const body_feed *f, int64_t i);

typedef struct {
    int count;
    int64_t *index;                 /* in the set */
    float *image;                   /* (capacity, 3, BODY_PICTURE_HEIGHT, BODY_PICTURE_WIDTH) */
    body_target *target;            /* (capacity) */
    float *weight;                  /* (capacity) 0: could not be read */
} body_batch;

/* body_source - feed outlives it; sample i of an epoch is a function of both and of the seed */
loader_source body_source(const body_feed *feed);

/* body_batch_recipe - the graph fed with such batches; with its losses, or without; g outlives it */
recipe body_batch_recipe(const body_graph *g, bool losses);

#endif
