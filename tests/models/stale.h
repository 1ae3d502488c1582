/* SPDX-License-Identifier: Apache-2.0 */
/* A plan's memory serves one result after another, run after run: no step may read what this run has not written. */
#ifndef TESTS_MODELS_STALE_H
#define TESTS_MODELS_STALE_H

#include "libtensor/graph/plan_internal.h"
#include "models/model.h"

#include <check.h>
#include <math.h>
#include <string.h>

enum { STALE_MOST = 1 << 20 };

/* All that does not stay between runs becomes this number, scratch as well. */
static inline void stale_fill(lt_plan *p, lt_real x)
{
    size_t work = 0;

    for (int i = 0; i < p->g->n_nodes; i++)
        work = p->node[i].work_bytes > work ? p->node[i].work_bytes : work;
    for (size_t i = 0; i < p->memory_bytes / sizeof(x); i++)
        ((lt_real *)(void *)p->memory)[i] = x;
    for (size_t i = 0; i < work / sizeof(x); i++)
        ((lt_real *)p->step[0].call.work)[i] = x;
}

/* All outputs beside each other; returns how many numbers. */
static inline size_t stale_outputs(const lt_plan *p, const model_record *r, lt_real *out)
{
    size_t n = 0;

    for (int i = 0; i < r->outputs.n; i++) {
        const lt_tensor *t = r->outputs.port[i].tensor;

        ck_assert_uint_le(n + (size_t)lt_numel(t), STALE_MOST);
        memcpy(out + n, lt_plan_data(p, t), lt_nbytes(t));
        n += (size_t)lt_numel(t);
    }
    return n;
}

/* fill writes the inputs. Runs over zeros and over NaN have to give the same bits. */
static inline void expect_nothing_stale(lt_plan *p, const model_record *r,
                                        void (*fill)(const model_record *r, const lt_plan *p))
{
    static lt_real clean[STALE_MOST], other[STALE_MOST];
    size_t n;

    stale_fill(p, 0);
    fill(r, p);
    lt_run(p);
    stale_outputs(p, r, clean);
    stale_fill(p, (lt_real)NAN);
    fill(r, p);
    lt_run(p);
    n = stale_outputs(p, r, other);
    ck_assert_msg(memcmp(clean, other, n * sizeof(*clean)) == 0, "what was there before changes the outputs");
}

#endif
