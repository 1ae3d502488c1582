/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/optim/optim.h"

#include <math.h>

static double after_warmup(const lt_schedule *s, double epoch)
{
    double done;

    switch (s->kind) {
    case LT_STEP_LR:
        return s->lr * pow(s->gamma, floor(epoch / s->every));
    case LT_COSINE_LR:
        done = s->epochs > s->warmup ? (epoch - s->warmup) / (s->epochs - s->warmup) : 1;
        done = done < 0 ? 0 : done > 1 ? 1 : done;
        return s->min_lr + 0.5 * (s->lr - s->min_lr) * (1 + cos(M_PI * done));
    case LT_CONSTANT_LR:
        break;
    }
    return s->lr;
}

double lt_schedule_lr(const lt_schedule *s, double epoch)
{
    const double lr = after_warmup(s, epoch);

    return epoch < s->warmup ? lr * epoch / s->warmup : lr;
}
