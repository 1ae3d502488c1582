/* SPDX-License-Identifier: Apache-2.0 */
/*
 * TensorBoard's event files: numbers over steps.
 *
 * Source: tensorflow/tensorflow, core/util/event.proto, core/lib/io/record_writer.cc.
 */
#ifndef LT_IO_EVENTS_H
#define LT_IO_EVENTS_H

#include "libtensor/base/arena.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *tag;                /* "loss/total": what stands before '/' groups the curves */
    double value;
} lt_event_scalar;

/**
 * lt_events_open - begin to write events, after what is there
 *
 *   folder   exists; gets a file events.out.tfevents.TIME.palmar, or more of it within the same second
 *   step     of the last event that counts: TensorBoard forgets those behind it, of a run that was cut back
 *   out      the caller closes it; its error flag tells whether all was written
 *
 * Errors: LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_events_open(lt_arena *arena, const char *folder, int64_t step, FILE **out);

/* lt_events_scalars - n numbers at a step, dated now, and flushed; those that are not finite are left out */
LT_API void lt_events_scalars(FILE *f, int64_t step, const lt_event_scalar *list, int n);

/* lt_crc32c - Castagnoli's CRC of n bytes */
LT_API uint32_t lt_crc32c(const void *bytes, size_t n);

#ifdef __cplusplus
}
#endif
#endif
