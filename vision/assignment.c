/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/assignment.h"

#include <math.h>

/* The shorter side is called rows here: each of them gets a column. */
typedef struct {
    const double *cost;
    ptrdiff_t row, col;             /* strides of the cost */
    int rows, cols;
    double *u, *v;                  /* the duals: cost - u - v >= 0, and 0 for pairs */
    int *col_of, *row_of;           /* -1: free */
    double *shortest;               /* (cols) the length of the shortest path to a column so far */
    int *from;                      /* (cols) the row before it on that path */
    bool *row_done, *col_done;
} problem;

static bool make(problem *p, lt_arena *scratch)
{
    const size_t rows = (size_t)p->rows, cols = (size_t)p->cols;

    p->u = lt_arena_array(scratch, rows, sizeof(*p->u));
    p->v = lt_arena_array(scratch, cols, sizeof(*p->v));
    p->col_of = lt_arena_array(scratch, rows, sizeof(*p->col_of));
    p->row_of = lt_arena_array(scratch, cols, sizeof(*p->row_of));
    p->shortest = lt_arena_array(scratch, cols, sizeof(*p->shortest));
    p->from = lt_arena_array(scratch, cols, sizeof(*p->from));
    p->row_done = lt_arena_array(scratch, rows, sizeof(*p->row_done));
    p->col_done = lt_arena_array(scratch, cols, sizeof(*p->col_done));
    if (!p->u || !p->v || !p->col_of || !p->row_of || !p->shortest || !p->from || !p->row_done || !p->col_done)
        return false;
    for (size_t i = 0; i < rows; i++)
        p->col_of[i] = -1;
    for (size_t j = 0; j < cols; j++)
        p->row_of[j] = -1;
    return true;
}

/* Dijkstra from a free row over reduced costs, to the nearest free column, which is returned with its distance */
static int shortest_path(problem *p, int start, double *distance)
{
    int i = start, sink = -1;
    double so_far = 0;

    for (int k = 0; k < p->rows; k++)
        p->row_done[k] = false;
    for (int j = 0; j < p->cols; j++) {
        p->col_done[j] = false;
        p->shortest[j] = INFINITY;
    }
    while (sink < 0) {
        double least = INFINITY;
        int next = -1;

        p->row_done[i] = true;
        for (int j = 0; j < p->cols; j++) {
            if (p->col_done[j])
                continue;
            const double length = so_far + p->cost[i * p->row + j * p->col] - p->u[i] - p->v[j];

            if (length < p->shortest[j]) {
                p->shortest[j] = length;
                p->from[j] = i;
            }
            if (p->shortest[j] < least || (p->shortest[j] == least && p->row_of[j] < 0)) {
                least = p->shortest[j];
                next = j;
            }
        }
        so_far = least;
        p->col_done[next] = true;
        i = p->row_of[next];
        sink = i < 0 ? next : -1;
    }
    *distance = so_far;
    return sink;
}

static void augment(problem *p, int start)
{
    double distance;
    int j = shortest_path(p, start, &distance);

    p->u[start] += distance;
    for (int i = 0; i < p->rows; i++)
        if (p->row_done[i] && i != start)
            p->u[i] += distance - p->shortest[p->col_of[i]];
    for (int k = 0; k < p->cols; k++)
        if (p->col_done[k])
            p->v[k] -= distance - p->shortest[k];
    for (int i = -1; i != start; ) {            /* flip the path, from its end */
        const int before = p->col_of[i = p->from[j]];

        p->row_of[j] = i;
        p->col_of[i] = j;
        j = before;
    }
}

lt_status assignment_solve(lt_arena *scratch, const double *cost, int rows, int cols, int *column)
{
    const bool turned = rows > cols;
    problem p = { .cost = cost, .row = turned ? 1 : cols, .col = turned ? cols : 1, .rows = turned ? cols : rows,
                  .cols = turned ? rows : cols };

    if (!make(&p, scratch))
        return lt_error(LT_ENOMEM, "no memory to assign %d to %d", rows, cols);
    for (int i = 0; i < p.rows; i++)
        augment(&p, i);
    for (int i = 0; i < rows; i++)
        column[i] = turned ? p.row_of[i] : p.col_of[i];
    return LT_OK;
}
