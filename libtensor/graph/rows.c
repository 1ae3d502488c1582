/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/rows.h"

#include "libtensor/graph/internal.h"

#include <string.h>

typedef struct {
    lt_row_range *range;            /* ascending, with gaps between them */
    int n;
    size_t room;
} range_list;

struct lt_param_rows {
    lt_row_array data, grad;        /* the parameter's own; grad.data is NULL before it has one */
    lt_row_array *first;            /* these and the attached ones */
    range_list touched, spare;      /* spare: for the list after a gather */
    uint64_t moves;                 /* how often it has got another place in memory */
};

static size_t row_bytes(const lt_row_array *a, int64_t rows)
{
    return (size_t)(rows * a->width) * sizeof(lt_real);
}

static int64_t rows_of(const lt_param *p)
{
    return p->shape.dim[0];
}

static lt_status check_rows(const lt_param *p)
{
    return p->rows ? LT_OK : lt_error(LT_EINVAL, "parameter \"%s\" is not stepped by rows; add it with "
                                      "lt_params_add_rows", p->name);
}

/* ---- arrays ------------------------------------------------------------------------------------------- */

static lt_status attach(lt_param *p, lt_row_array *a)
{
    a->data = lt_alloc(row_bytes(a, rows_of(p)));
    if (!a->data)
        return lt_error(LT_ENOMEM, "parameter \"%s\": no memory for %lld rows", p->name, (long long)rows_of(p));
    a->next = p->rows->first;
    p->rows->first = a;
    return LT_OK;
}

lt_status lt_param_attach(lt_param *p, lt_row_array *a)
{
    const lt_status st = check_rows(p);

    return st ? st : attach(p, a);
}

void lt_param_detach(lt_param *p, lt_row_array *a)
{
    lt_row_array **at = &p->rows->first;

    while (*at && *at != a)
        at = &(*at)->next;
    if (!*at)
        return;
    *at = a->next;
    lt_release(a->data);
    a->data = NULL;
}

lt_status lt_rows_init(lt_param *p)
{
    p->rows = lt_arena_alloc(lt_params_arena(p->set), sizeof(*p->rows));
    if (!p->rows)
        return lt_error(LT_ENOMEM, "parameter \"%s\": no memory for its rows", p->name);
    p->rows->data.width = p->rows->grad.width = lt_param_width(p);
    p->rows->data.keeps = true;
    return LT_OK;
}

lt_status lt_rows_allocate(lt_param *p)
{
    const lt_status st = attach(p, &p->rows->data);

    p->data = p->rows->data.data;
    return st;
}

void lt_rows_fini(lt_param *p)
{
    lt_param_detach(p, &p->rows->data);
    lt_param_detach(p, &p->rows->grad);
}

bool lt_rows_need_grad(lt_param *p)
{
    if (!p->rows->grad.data && attach(p, &p->rows->grad))
        return false;
    p->grad = p->rows->grad.data;
    return true;
}

uint64_t lt_rows_moves(const lt_param *p)
{
    return p->rows ? p->rows->moves : 0;
}

/* ---- the rows of a step ------------------------------------------------------------------------------- */

static void clear(const lt_param *p, lt_real *grad, int64_t first, int64_t end)
{
    const int64_t width = p->rows->data.width;

    if (grad && first < end)
        memset(grad + first * width, 0, (size_t)((end - first) * width) * sizeof(*grad));
}

void lt_rows_clear(const lt_param *p, lt_real *grad)
{
    const range_list *l = &p->rows->touched;

    for (int i = 0; i < l->n; i++)
        clear(p, grad, l->range[i].first, l->range[i].first + l->range[i].n);
}

static int64_t end_of(const lt_row_range *r)
{
    return r->first + r->n;
}

/* The first range that ends at `row` or behind it */
static int find(const range_list *l, int64_t row)
{
    int low = 0, high = l->n;

    while (low < high) {
        const int mid = (low + high) / 2;

        if (end_of(&l->range[mid]) < row)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

static bool make_room(lt_param *p, range_list *l)
{
    lt_row_range *list = lt_arena_grow(lt_params_arena(p->set), l->range, (size_t)l->n, &l->room, sizeof(*list));

    if (list)
        l->range = list;
    return list;
}

static lt_status no_memory_for_ranges(const lt_param *p)
{
    return lt_error(LT_ENOMEM, "parameter \"%s\": no memory for the ranges of a step", p->name);
}

/* Ranges i .. j - 1 and [first, end), which touch each other, become one, and what was in none of them begins at 0. */
static void join(lt_param *p, range_list *l, int i, int j, int64_t first, int64_t end)
{
    int64_t at = first, from = first, to = end;

    for (int k = i; k < j; k++) {
        clear(p, p->grad, at, lt_min_i64(l->range[k].first, end));
        at = lt_max_i64(at, end_of(&l->range[k]));
    }
    clear(p, p->grad, at, end);
    if (i < j) {
        from = lt_min_i64(from, l->range[i].first);
        to = lt_max_i64(to, end_of(&l->range[j - 1]));
    }
    memmove(&l->range[i + 1], &l->range[j], (size_t)(l->n - j) * sizeof(*l->range));
    l->range[i] = (lt_row_range){ from, to - from };
    l->n += 1 - (j - i);
}

lt_status lt_param_touch(lt_param *p, int64_t first, int64_t n)
{
    const lt_status st = check_rows(p);
    range_list *l;
    int i, j;

    if (st)
        return st;
    if (first < 0 || n < 0 || first > rows_of(p) - n)
        return lt_error(LT_EINVAL, "parameter \"%s\" has %lld rows, not %lld from %lld on", p->name,
                        (long long)rows_of(p), (long long)n, (long long)first);
    l = &p->rows->touched;
    if (n == 0)
        return LT_OK;
    if (!make_room(p, l))
        return no_memory_for_ranges(p);
    i = j = find(l, first);
    while (j < l->n && l->range[j].first <= first + n)
        j++;
    join(p, l, i, j, first, first + n);
    return LT_OK;
}

void lt_params_untouch(lt_params *set)
{
    for (lt_param *p = lt_params_first(set); p; p = p->next)
        if (p->rows)
            p->rows->touched.n = 0;
}

const lt_row_range *lt_param_touched(const lt_param *p, int *n)
{
    *n = p->rows ? p->rows->touched.n : 0;
    return p->rows ? p->rows->touched.range : NULL;
}

bool lt_param_is_touched(const lt_param *p, int64_t row)
{
    const range_list *l = p->rows ? &p->rows->touched : NULL;
    const int i = l ? find(l, row + 1) : 0;

    return l && i < l->n && row >= l->range[i].first;
}

/* ---- moving rows -------------------------------------------------------------------------------------- */

static lt_status check_sources(const lt_param *p, int64_t rows, const lt_row_source *from)
{
    lt_shape shape = p->shape;
    char text[LT_SHAPE_TEXT];

    shape.dim[0] = rows;
    if (rows < 1 || !lt_shape_fits_memory(&shape))
        return lt_error(LT_EINVAL, "parameter \"%s\" cannot become %s", p->name, lt_shape_text(&shape, text));
    for (int64_t i = 0; from && i < rows; i++)
        if (from[i].from < -1 || from[i].from >= rows_of(p))
            return lt_error(LT_EINVAL, "parameter \"%s\": row %lld is to be made from row %lld, of %lld", p->name,
                            (long long)i, (long long)from[i].from, (long long)rows_of(p));
    return LT_OK;
}

static int64_t source_of(const lt_param *p, const lt_row_source *from, int64_t i)
{
    return from ? from[i].from : i < rows_of(p) ? i : -1;
}

/* Which of the rows to be are touched. */
static lt_status gather_touched(lt_param *p, int64_t rows, const lt_row_source *from)
{
    range_list *l = &p->rows->spare;

    l->n = 0;
    for (int64_t i = 0; p->rows->touched.n && i < rows; i++) {
        const int64_t was = source_of(p, from, i);

        if (was < 0 || !lt_param_is_touched(p, was))
            continue;
        if (l->n && end_of(&l->range[l->n - 1]) == i) {
            l->range[l->n - 1].n++;
            continue;
        }
        if (!make_room(p, l))
            return no_memory_for_ranges(p);
        l->range[l->n++] = (lt_row_range){ i, 1 };
    }
    return LT_OK;
}

static lt_status allocate(const lt_param *p, int64_t rows)
{
    bool ok = true;

    for (lt_row_array *a = p->rows->first; a; a = a->next) {
        a->moved = ok ? lt_alloc(row_bytes(a, rows)) : NULL;
        ok = a->moved;
    }
    for (lt_row_array *a = p->rows->first; !ok && a; a = a->next)
        lt_release(a->moved);
    return ok ? LT_OK : lt_error(LT_ENOMEM, "parameter \"%s\": no memory for %lld rows", p->name, (long long)rows);
}

static void carry(const lt_param *p, lt_row_array *a, int64_t rows, const lt_row_source *from)
{
    for (int64_t i = 0; i < rows; i++) {
        const int64_t was = source_of(p, from, i);

        if (was >= 0 && (a->keeps || !from || !from[i].fresh))
            memcpy(a->moved + i * a->width, a->data + was * a->width, row_bytes(a, 1));
    }
}

/* Into the memory that plans know, when it is as much as before */
static void settle(const lt_param *p, lt_row_array *a, int64_t rows)
{
    lt_real *old = a->data;

    if (rows == rows_of(p)) {
        memcpy(old, a->moved, row_bytes(a, rows));
        old = a->moved;
    } else {
        a->data = a->moved;
    }
    lt_release(old);
}

lt_status lt_param_gather(lt_param *p, int64_t rows, const lt_row_source *from)
{
    lt_status st = check_rows(p);
    range_list list;

    if (!st)
        st = check_sources(p, rows, from);
    if (!st)
        st = gather_touched(p, rows, from);
    if (!st)
        st = allocate(p, rows);
    if (st)
        return st;
    for (lt_row_array *a = p->rows->first; a; a = a->next) {
        carry(p, a, rows, from);
        settle(p, a, rows);
    }
    list = p->rows->touched;
    p->rows->touched = p->rows->spare;
    p->rows->spare = list;
    if (rows != rows_of(p)) {
        p->rows->moves++;
        lt_params_moved(p->set);
    }
    p->shape.dim[0] = rows;
    p->data = p->rows->data.data;
    p->grad = p->rows->grad.data;
    lt_params_changed(p->set);
    return LT_OK;
}

lt_status lt_param_resize(lt_param *p, int64_t rows)
{
    return lt_param_gather(p, rows, NULL);
}
