/* SPDX-License-Identifier: Apache-2.0 */
/* Running statistics, moved by what batches measured. */
#include "libtensor/graph/internal.h"
#include "libtensor/optim/internal.h"

void optim_update_statistics(lt_params *set, int n)
{
    for (lt_param *p = lt_params_first(set); n > 0 && p; p = p->next) {
        const double batches = (double)n * (p->uses > 0 ? p->uses : 1);

        if (p->kind != LT_STATISTIC || !p->grad || p->frozen)
            continue;
        for (int64_t i = 0; i < lt_param_numel(p); i++) {
            p->data[i] += (lt_real)(p->momentum * (p->grad[i] / batches - p->data[i]));
            p->grad[i] = 0;
        }
    }
}

void lt_statistics_update(lt_params *set, int n)
{
    int in_grad;

    if (!lt_params_take_batches(set, &in_grad))
        return;
    optim_update_statistics(set, n);
    lt_params_changed(set);
}
