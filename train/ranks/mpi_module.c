/* SPDX-License-Identifier: Apache-2.0 */
#include "train/ranks/mpi_module.h"

#include <mpi.h>
#include <stdio.h>

enum { MOST = 1 << 30 };                /* bytes: MPI counts in int */

static int join(int *rank, int *size, char error[256])
{
    int given;

    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &given) != MPI_SUCCESS || given < MPI_THREAD_FUNNELED) {
        snprintf(error, 256, "this MPI does not go along with threads");
        return 1;
    }
    MPI_Comm_rank(MPI_COMM_WORLD, rank);
    MPI_Comm_size(MPI_COMM_WORLD, size);
    return 0;
}

static int send_bytes(int to, const void *data, size_t bytes)
{
    const char *at = data;
    int bad = 0;

    for (; bytes && !bad; bytes -= bytes < MOST ? bytes : MOST, at += MOST)
        bad = MPI_Send(at, bytes < MOST ? (int)bytes : MOST, MPI_BYTE, to, 0, MPI_COMM_WORLD);
    return bad;
}

static int receive_bytes(int from, void *data, size_t bytes)
{
    char *at = data;
    int bad = 0;

    for (; bytes && !bad; bytes -= bytes < MOST ? bytes : MOST, at += MOST)
        bad = MPI_Recv(at, bytes < MOST ? (int)bytes : MOST, MPI_BYTE, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return bad;
}

static void fail(void)
{
    MPI_Abort(MPI_COMM_WORLD, 1);
}

static void leave(void)
{
    MPI_Finalize();
}

extern const ranks_mpi_module ranks_mpi;
LT_API const ranks_mpi_module ranks_mpi = { join, send_bytes, receive_bytes, fail, leave };
