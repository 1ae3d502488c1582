/* SPDX-License-Identifier: Apache-2.0 */
/* What the module has that was built with MPI. It is loaded where more than one process was started. */
#ifndef TRAIN_MPI_MODULE_H
#define TRAIN_MPI_MODULE_H

#include "train/ranks/ranks.h"

#define RANKS_MPI_MODULE "ranks-mpi.so"
#define RANKS_MPI_SYMBOL "ranks_mpi"            /* a ranks_mpi_module */

/* join: find the others; not 0, and why in error. send, receive: not 0 when it failed. fail: ends all processes, this
 * one as well. leave: when all is done. */
typedef struct {
    int (*join)(int *rank, int *size, char error[256]);
    int (*send)(int to, const void *data, size_t bytes);
    int (*receive)(int from, void *data, size_t bytes);
    void (*fail)(void);
    void (*leave)(void);
} ranks_mpi_module;

#endif
