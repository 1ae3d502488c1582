/* SPDX-License-Identifier: Apache-2.0 */
/* The processes that mpirun, mpiexec or srun started together with this one. */
#ifndef TRAIN_RANKS_JOIN_H
#define TRAIN_RANKS_JOIN_H

#include "train/ranks/ranks.h"

/* ranks_join - *out: NULL where this process is alone, else what the module of MPI gives; lives until ranks_leave.
 * Errors: LT_EINVAL where there are others and no module, or MPI's own. */
lt_status ranks_join(const train_ranks **out);
void ranks_leave(void);

#endif
