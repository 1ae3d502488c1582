/* SPDX-License-Identifier: Apache-2.0 */
#include "train/ranks/join.h"

#include "libtensor/io/module.h"
#include "train/ranks/mpi_module.h"

#include <stdio.h>
#include <stdlib.h>

static const ranks_mpi_module *mpi;     /* NULL: alone */

static lt_status send_to(void *ctx, int to, const void *data, size_t bytes)
{
    (void)ctx;
    return mpi->send(to, data, bytes) ? lt_error(LT_EIO, "MPI: nothing can be sent to rank %d", to) : LT_OK;
}

static lt_status receive_from(void *ctx, int from, void *data, size_t bytes)
{
    (void)ctx;
    return mpi->receive(from, data, bytes) ? lt_error(LT_EIO, "MPI: nothing comes from rank %d", from) : LT_OK;
}

/* MPI ends this process too: what is wrong is said here. */
static void fail(void *ctx)
{
    fprintf(stderr, "palmar: [rank %d] %s\n", ((const train_ranks *)ctx)->rank, lt_last_error());
    fflush(NULL);
    mpi->fail();
}

/* How many processes were started together: Open MPI's and MPICH's starters say so, Slurm beside a PMI of either. */
static int started(void)
{
    static const char *const names[] = { "OMPI_COMM_WORLD_SIZE", "PMI_SIZE" };
    const char *tasks = getenv("SLURM_NTASKS");

    for (size_t i = 0; i < LT_COUNT(names); i++)
        if (getenv(names[i]))
            return atoi(getenv(names[i]));
    return tasks && (getenv("PMIX_RANK") || getenv("PMI_RANK")) ? atoi(tasks) : 1;
}

lt_status ranks_join(const train_ranks **out)
{
    static train_ranks all = { .size = 1, .send = send_to, .receive = receive_from, .fail = fail, .ctx = &all };
    const int n = started();
    char error[256];

    *out = NULL;
    if (n <= 1)
        return LT_OK;
    mpi = lt_module_symbol(RANKS_MPI_MODULE, RANKS_MPI_SYMBOL);
    if (!mpi)
        return lt_error(LT_EINVAL, "%d processes were started together, and MPI is not there: build palmar with it "
                        "(libopenmpi-dev or libmpich-dev), start one process, or one for each run" LT_MODULE_HINT, n);
    if (mpi->join(&all.rank, &all.size, error)) {
        mpi = NULL;
        return lt_error(LT_EINVAL, "MPI: %s", error);
    }
    if (all.size > TRAIN_RANKS_MAX)
        return lt_error(LT_EINVAL, "%d processes, and %d can train together", all.size, TRAIN_RANKS_MAX);
    *out = all.size > 1 ? &all : NULL;
    return LT_OK;
}

void ranks_leave(void)
{
    if (mpi)
        mpi->leave();
    mpi = NULL;
}
