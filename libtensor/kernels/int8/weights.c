/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/int8/weights.h"

#include "libtensor/base/parallel.h"

#include <math.h>
#include <string.h>

typedef struct {
    const lt_real *w;
    int64_t channels, taps;
    const lt_int8_range *r;
    lt_real *words, *scale, *start;
} weights_job;

static lt_real largest(const lt_real *w, int64_t n)
{
    lt_real most = 0;

    for (int64_t i = 0; i < n; i++) {
        const lt_real size = w[i] < 0 ? -w[i] : w[i];

        most = size > most ? size : most;
    }
    return most;
}

static int8_t nearest(lt_real v)
{
    v = v > -127 ? v : -127;
    return (int8_t)lrint((double)(v < 127 ? v : 127));
}

/* Byte c % 4 of word (c / 4, tap) is channel c; those behind the last channel are 0. */
static void weights_row(void *ctx, int64_t row)
{
    const weights_job *j = ctx;
    const int64_t words = int8_words(j->channels) * j->taps, n = j->channels * j->taps;
    const lt_real *w = j->w + row * n, most = largest(w, n), inverse = most > 0 ? 127 / most : 0;
    int8_t *out = (int8_t *)(j->words + row * words);
    int32_t total = 0;

    memset(out, 0, (size_t)words * sizeof(*j->words));
    for (int64_t c = 0; c < j->channels; c++)
        for (int64_t t = 0; t < j->taps; t++) {
            const int8_t q = nearest(w[c * j->taps + t] * inverse);

            out[(c / INT8_WORD * j->taps + t) * INT8_WORD + c % INT8_WORD] = q;
            total += q;
        }
    total = j->r->has_negative ? -128 * total : 0;
    j->scale[row] = most / 127 * j->r->scale;
    memcpy(j->start + row, &total, sizeof(total));
}

void int8_weights(const lt_real *w, int64_t rows, int64_t channels, int64_t taps, const lt_int8_range *r,
                  lt_real *words, lt_real *scale, lt_real *start)
{
    weights_job j = { w, channels, taps, r, words, scale, start };

    lt_parallel_for(rows, weights_row, &j);
}
