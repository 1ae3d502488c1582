/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/splats/density.h"

#include "libtensor/base/rng.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

static const double SLOPE = 2e-4;               /* of a place on the screen, in units of half an image */
static const double SMALL = 0.01, LARGE = 0.1;  /* of the extent: doubled rather than cut; taken out */
static const double SPLIT = 1.6, RESET_OPACITY = 0.01;
enum { PIECES = 2, ARRAYS = 3 };

static const char *const names[ARRAYS] = { "task.slope", "task.seen", "task.radius" };

lt_status density_new(density *d, const gaussians *g, const density_limits *limits)
{
    lt_status st;

    *d = (density){ .g = g, .slope.width = 1, .seen.width = 1, .radius.width = 1, .limits = *limits };
    st = lt_param_attach(g->centre, &d->slope);
    if (!st)
        st = lt_param_attach(g->centre, &d->seen);
    return st ? st : lt_param_attach(g->centre, &d->radius);
}

void density_free(density *d)
{
    lt_release(d->slope.data);
    lt_release(d->seen.data);
    lt_release(d->radius.data);
    *d = (density){ .g = NULL };
}

void density_add(density *d, int64_t first, int64_t n, const lt_real *slope, const lt_real *radius)
{
    for (int64_t i = 0; i < n; i++) {
        const int64_t row = first + i;

        if (!(radius[i] > 0))
            continue;
        d->slope.data[row] += slope[i];
        d->seen.data[row]++;
        if (radius[i] > d->radius.data[row])
            d->radius.data[row] = radius[i];
    }
}

int64_t density_total(const gaussians *g)
{
    int64_t sum = 0;

    for (int i = 0; i < g->sets; i++)
        sum += gaussians_count(g, i);
    return sum;
}

/* ---- what becomes of a row ------------------------------------------------------------------------------- */

typedef enum { KEEP, CLONE, CUT, PRUNE } fate;

static double opacity_of(const gaussians *g, int64_t row)
{
    return 1 / (1 + exp(-(double)g->opacity->data[row]));
}

static bool is_pulled(const density *d, int64_t row)
{
    return d->seen.data[row] > 0 && (double)d->slope.data[row] / (double)d->seen.data[row] >= SLOPE;
}

static bool is_useless(const density *d, int64_t row, bool sizes)
{
    const gaussians *g = d->g;

    return opacity_of(g, row) < d->limits.least_opacity
        || (sizes && (gaussians_scale(g, row) > LARGE * d->limits.extent
                      || (double)d->radius.data[row] > d->limits.most_pixels));
}

/* sizes: large ones go, too */
static fate fate_of(const density *d, int64_t row, bool sizes)
{
    if (is_useless(d, row, sizes))
        return PRUNE;
    if (!is_pulled(d, row))
        return KEEP;
    return gaussians_scale(d->g, row) <= SMALL * d->limits.extent ? CLONE : CUT;
}

/* ---- rows before and after ------------------------------------------------------------------------------- */

/* The new rows of all sets. cut[i]: row i is a piece of the one that it comes from. */
typedef struct {
    lt_row_source *from;
    bool *cut;
    int64_t *count;                 /* (sets) */
    int64_t capacity, densified, pruned;
} layout;

static void add(layout *l, int set, int64_t from, bool fresh, bool cut)
{
    const int64_t at = set * l->capacity + l->count[set]++;

    l->from[at] = (lt_row_source){ .from = from, .fresh = fresh };
    l->cut[at] = cut;
}

/* Those that stay, then copies and pieces, as many as the cap has room for. A set never loses all of its Gaussians: of
 * those that would go, the one that shows most stays. */
static void lay_out_set(const density *d, int set, bool sizes, layout *l)
{
    const gaussians *g = d->g;
    const int64_t first = gaussians_first(g, set), n = gaussians_count(g, set);
    int64_t room = d->limits.cap, best = first;

    for (int64_t row = first; row < first + n; row++) {
        best = opacity_of(g, row) > opacity_of(g, best) ? row : best;
        if (fate_of(d, row, sizes) == PRUNE) {
            l->pruned++;
            continue;
        }
        room--;
        if (fate_of(d, row, sizes) != CUT)
            add(l, set, row, false, false);
    }
    for (int64_t row = first; row < first + n; row++) {
        const fate f = fate_of(d, row, sizes);

        if (f != CLONE && f != CUT)
            continue;
        if (room > 0) {
            for (int k = 0; k < (f == CUT ? PIECES : 1); k++)
                add(l, set, row, true, f == CUT);
            l->densified++;
            room--;
        } else if (f == CUT) {
            add(l, set, row, false, false);
        }
    }
    if (l->count[set] == 0)
        add(l, set, best, false, false);
}

static int64_t most_rows(const density *d)
{
    int64_t most = 0;

    for (int i = 0; i < d->g->sets; i++)
        most = lt_max_i64(most, lt_min_i64(2 * gaussians_count(d->g, i), d->limits.cap));
    return lt_rows_capacity(lt_max_i64(most, gaussians_capacity(d->g)));
}

/* Sets go on with as many rows as the largest needs, and with no fewer than before: plans stay as they are. */
static void tighten(const density *d, layout *l)
{
    const int sets = d->g->sets;
    int64_t need = gaussians_capacity(d->g), wide = l->capacity;

    for (int i = 0; i < sets; i++)
        need = lt_max_i64(need, lt_rows_capacity(l->count[i]));
    for (int i = 0; i < sets; i++)
        for (int64_t k = 0; k < need; k++) {
            l->from[i * need + k] = k < l->count[i] ? l->from[i * wide + k] : (lt_row_source){ .from = -1 };
            l->cut[i * need + k] = k < l->count[i] && l->cut[i * wide + k];
        }
    l->capacity = need;
}

/* ---- new places of pieces -------------------------------------------------------------------------------- */

/* A piece stands at a sample of the Gaussian that it was cut from, and is smaller. */
static void place_piece(const gaussians *g, int64_t row, lt_rng *rng)
{
    lt_real *centre = g->centre->data + 3 * row, *scale = g->log_scale->data + 3 * row;
    double q[4], R[9], own[3], off[3];

    for (int k = 0; k < 4; k++)
        q[k] = (double)g->quaternion->data[4 * row + k];
    lt_rot_from_quat(q, R);
    for (int k = 0; k < 3; k++)
        own[k] = exp((double)scale[k]) * lt_rng_normal(rng);
    lt_mat3_mulvec(R, own, off);
    for (int k = 0; k < 3; k++) {
        centre[k] += (lt_real)off[k];
        scale[k] -= (lt_real)log(SPLIT);
    }
}

static lt_status apply(density *d, const layout *l, uint64_t seed)
{
    const gaussians *g = d->g;
    lt_param *kind[GAUSSIANS_KINDS];
    const int kinds = gaussians_kinds(g, kind);
    lt_rng rng = lt_rng_make(seed, 0x64656e73);
    lt_status st = LT_OK;

    for (int i = 0; i < kinds && !st; i++)
        st = lt_param_gather(kind[i], l->capacity * g->sets, l->from);
    for (int64_t row = 0; row < l->capacity * g->sets && !st; row++)
        if (l->cut[row])
            place_piece(g, row, &rng);
    for (int i = 0; i < g->sets && !st; i++)
        g->count->data[i] = (lt_real)l->count[i];
    lt_params_changed(g->centre->set);
    return st;
}

static void forget(density *d)
{
    const size_t bytes = (size_t)d->g->centre->shape.dim[0] * sizeof(lt_real);

    memset(d->slope.data, 0, bytes);
    memset(d->seen.data, 0, bytes);
    memset(d->radius.data, 0, bytes);
}

static lt_status densify(density *d, bool sizes, uint64_t seed)
{
    const int sets = d->g->sets;
    layout l = { .capacity = most_rows(d) };
    const size_t rows = (size_t)(l.capacity * sets);
    lt_status st = LT_OK;

    l.from = lt_alloc(rows * sizeof(*l.from));
    l.cut = lt_alloc(rows * sizeof(*l.cut));
    l.count = lt_alloc((size_t)sets * sizeof(*l.count));
    if (!l.from || !l.cut || !l.count)
        st = lt_error(LT_ENOMEM, "no memory to rearrange %zu Gaussians", rows);
    for (int i = 0; i < sets && !st; i++)
        lay_out_set(d, i, sizes, &l);
    if (!st) {
        tighten(d, &l);
        st = apply(d, &l, seed);
    }
    if (!st) {
        d->densified = l.densified;
        d->pruned = l.pruned;
        forget(d);
    }
    lt_release(l.from);
    lt_release(l.cut);
    lt_release(l.count);
    return st;
}

/* ---- opacity reset --------------------------------------------------------------------------------------- */

static void reset(const density *d, lt_optim *o)
{
    const gaussians *g = d->g;
    const lt_real most = (lt_real)log(RESET_OPACITY / (1 - RESET_OPACITY));

    for (int i = 0; i < g->sets; i++)
        for (int64_t k = 0; k < gaussians_count(g, i); k++) {
            lt_real *x = g->opacity->data + gaussians_first(g, i) + k;

            *x = *x > most ? most : *x;
        }
    lt_optim_forget(o, g->opacity, 0, g->opacity->shape.dim[0]);
    lt_params_changed(g->opacity->set);
}

lt_status density_control(density *d, const density_schedule *s, int64_t iteration, uint64_t seed, lt_optim *o,
                          bool *moved)
{
    lt_status st = LT_OK;

    d->densified = d->pruned = 0;
    *moved = iteration >= s->start && iteration <= s->end && iteration % s->every == 0;
    if (*moved)
        st = densify(d, iteration > s->reset, lt_rng_mix(seed, (uint64_t)iteration));
    if (!st && iteration > 0 && iteration <= s->end
        && (iteration % s->reset == 0 || (d->limits.reset_at_start && iteration == s->start)))
        reset(d, o);
    return st;
}

/* ---- in a checkpoint ------------------------------------------------------------------------------------- */

static lt_real *data_of(const density *d, int i)
{
    return i == 0 ? d->slope.data : i == 1 ? d->seen.data : d->radius.data;
}

int density_save(const density *d, lt_named_array *out, int room)
{
    const int64_t rows = d->g->centre->shape.dim[0];

    if (room < ARRAYS)
        return 0;
    for (int i = 0; i < ARRAYS; i++)
        out[i] = (lt_named_array){ names[i], lt_array_make(LT_ELEM_F4, 1, &rows, data_of(d, i)) };
    return ARRAYS;
}

lt_status density_load(density *d, const char *path, const lt_named_array *entry, size_t n)
{
    const size_t rows = (size_t)d->g->centre->shape.dim[0];

    for (int a = 0; a < ARRAYS; a++) {
        const float *from = NULL;

        for (size_t i = 0; i < n; i++)
            if (strcmp(entry[i].name, names[a]) == 0 && entry[i].array.type == LT_ELEM_F4
                && lt_array_count(&entry[i].array) == rows)
                from = entry[i].array.data;
        if (!from)
            return lt_error(LT_EINVAL, "%s: has no \"%s\" of %zu numbers: no checkpoint that training can go on from",
                            path, names[a], rows);
        for (size_t i = 0; i < rows; i++)
            data_of(d, a)[i] = (lt_real)from[i];
    }
    return LT_OK;
}
