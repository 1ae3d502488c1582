/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/optim/optim.h"

#include <math.h>

/* How much of the way from `from` to epochs lies behind: 0 .. 1 */
static double done(const lt_schedule *s, double from, double epoch)
{
    const double share = s->epochs > from ? (epoch - from) / (s->epochs - from) : 1;

    return share < 0 ? 0 : share > 1 ? 1 : share;
}

static double after_warmup(const lt_schedule *s, double epoch)
{
    switch (s->kind) {
    case LT_STEP_LR:
        return s->lr * pow(s->gamma, floor(epoch / s->every));
    case LT_COSINE_LR:
        return s->min_lr + 0.5 * (s->lr - s->min_lr) * (1 + cos(M_PI * done(s, s->warmup, epoch)));
    case LT_LINEAR_LR:
        epoch = s->every ? floor(epoch / s->every) * s->every : epoch;
        return s->lr + (s->min_lr - s->lr) * done(s, 0, epoch);
    case LT_LOG_LINEAR_LR:
        return s->lr * pow(s->min_lr / s->lr, done(s, 0, epoch));
    case LT_CONSTANT_LR:
        break;
    }
    return s->lr;
}

double lt_schedule_lr(const lt_schedule *s, double epoch)
{
    const double lr = after_warmup(s, epoch);

    return epoch < s->warmup ? s->warmup_lr + (lr - s->warmup_lr) * epoch / s->warmup : lr;
}
