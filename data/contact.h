/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which samples show a grasp: the hand's surface comes close to the object's.
 */
#ifndef DATA_CONTACT_H
#define DATA_CONTACT_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * contact_select - the samples among n of d, from sample `first` on, whose hand comes within `metres` of their object
 *
 *   hand     poses the annotated hand; its vertices are measured against the object's triangles
 *   index    (*n_out) ascending, in arena memory; samples without a hand pose or an object are not among them
 *
 * Errors: those of reading an annotation, for the first sample that has one.
 */
lt_status contact_select(const dataset *d, const lt_hand_model *hand, int64_t first, int64_t n, double metres,
                         lt_arena *arena, const int64_t **index, int64_t *n_out);

#ifdef __cplusplus
}
#endif
#endif
