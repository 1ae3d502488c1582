/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/tasks/blobs/blobs.h"

#include "libtensor/base/rng.h"
#include "libtensor/graph/rows.h"
#include "libtensor/ops/ops.h"
#include "tests/tasks/blobs/draw.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SETS = 3, SEEN = 2, TRUE_BLOBS = 5, STEP = 4, MOST = 12 };
enum { COARSE_UNTIL = 50, FINE_UNTIL = 120, ADAPT_EVERY = 20 };
enum { TRAINED = 30, CHECKED = 6 };

/* ---- the model: rows set * capacity ... of one parameter are a set's, the first count[set] of them in use ---- */

typedef struct { int first_blobs; } blobs_config;

typedef struct {
    blobs_config config;
    lt_param *centre, *gain;
} blobs;

static const lt_config_key model_keys[] = {
    { .name = "first_blobs", .offset = offsetof(blobs_config, first_blobs), .type = LT_CONFIG_INT, .fallback = "2",
      .lo = 1, .hi = STEP, .doc = "blobs of a set at first" },
    { .name = NULL },
};

static const char *const variants[] = { "full", NULL };

static void build(model *self, const lt_hand_layer *hand)
{
    blobs *m = self->self;

    (void)hand;
    self->variant = variants[0];
    m->centre = lt_params_add_rows(self->params, "blobs", "centre", LT_SHAPE(SETS * STEP, 2));
    m->gain = lt_params_add(self->params, "blobs", "gain", LT_WEIGHT, LT_SHAPE(1));
}

static void init(const model *self, uint64_t seed)
{
    const blobs *m = self->self;
    lt_rng rng = lt_rng_make(seed, 1);

    for (int64_t i = 0; i < lt_param_numel(m->centre); i++)
        m->centre->data[i] = (lt_real)lt_rng_range(&rng, 0.2, 0.8);
    *m->gain->data = (lt_real)0.5;
}

static const model_class blobs_class = {
    .name = "blobs", .size = sizeof(blobs), .paper = "none", .task = "blobs", .variants = variants, .keys = model_keys,
    .build = build, .init = init,
};

/* ---- the data: sets of blobs that do not move, and pictures of two sets with noise ---- */

typedef struct {
    train_data_config common;
    double noise;
} blobs_data;

static const lt_config_key data_keys[] = {
    TRAIN_DIR_KEY(blobs_data),
    TRAIN_LOADER_KEYS(blobs_data),
    { .name = "noise", .offset = offsetof(blobs_data, noise), .type = LT_CONFIG_NUMBER, .fallback = "0.02", .lo = 0,
      .hi = 1, .doc = "of the pictures" },
    { .name = NULL },
};

typedef struct {
    int count, capacity;
    int64_t *index;
    bool *there;
    lt_real (*picture)[DRAW_PIXELS];
} batch;

struct task_run {
    const train_config *config;
    model *model;
    char name[TRAINED][16];
    int count[SETS], capacity;
    lt_row_array slope;                 /* of each row, summed since the last adaptation */
    lt_real *seen;                      /* of a shard: the length of each row's gradient */
    lt_real counts[SETS + 1];           /* count and capacity, as a checkpoint has them */
    lt_optim_group group[2];
};

static const blobs *blobs_of(const task_run *r)
{
    return r->model->self;
}

static lt_real true_blob(int set, int i, int d)
{
    lt_rng rng = lt_rng_make(99, (uint64_t)((set * TRUE_BLOBS + i) * 2 + d));

    return (lt_real)lt_rng_range(&rng, 0.1, 0.9);
}

static int set_of(int64_t sample, int slot)
{
    return (int)((sample + slot) % SETS);
}

static void *batch_new(const void *ctx, int capacity)
{
    batch *b = calloc(1, sizeof(*b));

    (void)ctx;
    if (!b)
        return NULL;
    b->index = calloc((size_t)capacity, sizeof(*b->index));
    b->there = calloc((size_t)capacity, sizeof(*b->there));
    b->picture = calloc((size_t)capacity, sizeof(*b->picture));
    return b;
}

static void batch_free(void *batch_)
{
    batch *b = batch_;

    if (!b)
        return;
    free(b->index);
    free(b->there);
    free(b->picture);
    free(b);
}

static void batch_start(void *b, int count)
{
    ((batch *)b)->count = count;
}

static lt_status batch_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch_, int slot)
{
    const task_run *r = ctx;
    batch *b = batch_;
    lt_rng rng = lt_rng_make(7, epoch << 32 | (uint64_t)index);

    (void)scratch;
    b->index[slot] = index;
    b->there[slot] = true;
    for (int i = 0; i < DRAW_PIXELS; i++)
        b->picture[slot][i] = (lt_real)(((const blobs_data *)r->config->data)->noise * lt_rng_range(&rng, -1, 1));
    for (int k = 0; k < SEEN; k++)
        for (int i = 0; i < TRUE_BLOBS; i++) {
            const int set = set_of(index, k);
            const lt_real c[2] = { true_blob(set, i, 0), true_blob(set, i, 1) };

            draw_add(c, 1, 1, b->picture[slot]);
        }
    return LT_OK;
}

static void batch_skip(void *b, int slot, int64_t index)
{
    ((batch *)b)->index[slot] = index;
    ((batch *)b)->there[slot] = false;
}

static const char *sample_name(const void *ctx, int64_t index)
{
    return ((const task_run *)ctx)->name[index];
}

static loader_source source_of(const task_run *r, int64_t count)
{
    return (loader_source){ .ctx = r, .count = count, .name = sample_name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = batch_start, .fill = batch_fill, .skip = batch_skip };
}

static loader_source run_samples(const task_run *r)
{
    return source_of(r, TRAINED);
}

static loader_source run_checked(const task_run *r)
{
    return source_of(r, CHECKED);
}

static const char *run_sample_name(const task_run *r, const void *batch_, int i)
{
    const batch *b = batch_;

    return i < b->count ? sample_name(r, b->index[i]) : NULL;
}

/* ---- opening -------------------------------------------------------------------------------------------- */

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory");
    for (int i = 0; i < TRAINED; i++)
        snprintf(r->name[i], sizeof(r->name[i]), "sample %d", i);
    r->config = c;
    r->capacity = STEP;
    r->slope = (lt_row_array){ .width = 1, .keeps = false };
    r->seen = lt_arena_array(arena, SETS * MOST, sizeof(*r->seen));
    return r->seen ? LT_OK : lt_error(LT_ENOMEM, "no memory");
}

static void run_close(task_run *r)
{
    if (r->model)
        lt_param_detach(blobs_of(r)->centre, &r->slope);
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    static const char *const centres[] = { "blobs.centre", NULL }, *const gains[] = { "blobs.gain", NULL };
    lt_status st = train_config_model(c, NULL, set, out);

    if (st == LT_OK)
        st = lt_param_attach(((blobs *)out->self)->centre, &r->slope);
    if (st)
        return st;
    r->model = out;
    for (int s = 0; s < SETS; s++)
        r->count[s] = blobs_of(r)->config.first_blobs;
    r->group[0] = (lt_optim_group){ .name = "centres", .prefix = centres, .kind = LT_ADAM,
                                    .schedule = { .kind = LT_CONSTANT_LR, .lr = 0.01 } };
    r->group[1] = (lt_optim_group){ .name = "gain", .prefix = gains, .kind = LT_ADAM,
                                    .schedule = { .kind = LT_CONSTANT_LR, .lr = 0.02 } };
    return LT_OK;
}

static void run_describe(const task_run *r, train_progress *p)
{
    (void)r;
    progress_note(p, "data         blobs, %d to train on", TRAINED);
}

static void run_facts(const task_run *r, cJSON *env)
{
    (void)r;
    cJSON_AddStringToObject(env, "data", "blobs");
}

static size_t run_sample_bytes(const task_run *r)
{
    (void)r;
    return DRAW_PIXELS * sizeof(lt_real);
}

/* ---- phases and graphs ---------------------------------------------------------------------------------- */

static task_phase run_phase(const task_run *r, int64_t step)
{
    task_phase p = { .name = "coarse", .batch = 4, .shards = 4, .until = COARSE_UNTIL, .groups = 1 };

    if (step >= COARSE_UNTIL)
        p = (task_phase){ .name = "fine", .batch = 9, .shards = 3, .until = FINE_UNTIL, .groups = 3 };
    p.shape = (uint64_t)r->capacity;
    return p;
}

static const lt_optim_group *run_groups(const task_run *r, int *n, lt_optim_average *average)
{
    (void)average;
    *n = 2;
    return r->group;
}

static lt_tensor *integer(model_record *rec, const char *name)
{
    lt_tensor *t = lt_input(rec->g, name, LT_I32, 1, (int64_t[]){ 1 });

    model_port_add(&rec->inputs, name, t);
    return t;
}

static lt_status record(const void *ctx, model_record *rec)
{
    const task_run *r = ctx;
    lt_params *set = r->model->params;
    lt_tensor *centre = lt_use(rec->g, blobs_of(r)->centre), *gain = lt_use(rec->g, blobs_of(r)->gain), *loss = NULL;

    for (int b = 0; b < rec->batch; b++) {
        lt_tensor *picture = model_input(rec, lt_name(set, "picture%d", b), LT_SHAPE(DRAW_PIXELS)), *off = picture;
        lt_tensor *weight = model_input(rec, lt_name(set, "weight%d", b), LT_SHAPE(1));

        for (int k = 0; k < SEEN; k++) {
            lt_tensor *first = integer(rec, lt_name(set, "first%d_%d", b, k));
            lt_tensor *n = integer(rec, lt_name(set, "count%d_%d", b, k));

            off = lt_sub(off, draw(lt_rows(centre, first, r->capacity), n, gain));
        }
        off = lt_mul(lt_sum(lt_mul(off, off)), weight);
        loss = loss ? lt_add(loss, off) : off;
    }
    rec->loss = lt_output(lt_scale(lt_sum(loss), 1.0 / rec->batch), "picture");
    model_port_add(&rec->losses, "picture", rec->loss);
    return LT_OK;
}

static void *input(const lt_plan *p, const model_record *rec, const char *name, int b, int k)
{
    char text[32];

    snprintf(text, sizeof(text), k < 0 ? "%s%d" : "%s%d_%d", name, b, k);
    return lt_plan_data(p, model_port_find(&rec->inputs, text));
}

static double feed(const void *ctx, const lt_plan *p, const model_record *rec, const void *batch_, int first, int part,
                   int n)
{
    const task_run *r = ctx;
    const batch *from = batch_;
    double weight = 0;

    (void)part, (void)n;
    for (int b = 0; b < rec->batch; b++) {
        const int slot = first + b;
        const bool there = slot < from->count && from->there[slot];

        *(lt_real *)input(p, rec, "weight", b, -1) = there;
        weight += there;
        if (!there)
            continue;
        memcpy(input(p, rec, "picture", b, -1), from->picture[slot], sizeof(from->picture[slot]));
        for (int k = 0; k < SEEN; k++) {
            const int set = set_of(from->index[slot], k);

            *(int32_t *)input(p, rec, "first", b, k) = set * r->capacity;
            *(int32_t *)input(p, rec, "count", b, k) = r->count[set];
        }
    }
    return weight;
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    (void)phase;
    return (recipe){ .ctx = r, .record = record, .feed = feed };
}

static double batch_weight(const void *batch_)
{
    const batch *b = batch_;
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += b->there[i];
    return sum;
}

/* ---- growing -------------------------------------------------------------------------------------------- */

static lt_status run_rows(task_run *r, const void *batch_, int64_t step)
{
    const batch *b = batch_;
    lt_status st = LT_OK;

    (void)step;
    for (int i = 0; i < b->count; i++)
        for (int k = 0; k < SEEN && !st; k++) {
            const int set = set_of(b->index[i], k);

            st = lt_param_touch(blobs_of(r)->centre, (int64_t)set * r->capacity, r->count[set]);
        }
    return st;
}

static lt_real *run_observed(const task_run *r, int64_t *n)
{
    *n = SETS * MOST;
    return r->seen;
}

static void run_observe(task_run *r, const compiled *c, const void *batch_, int first)
{
    const lt_param *p = blobs_of(r)->centre;

    (void)c, (void)batch_, (void)first;
    for (int i = 0; i < SETS * MOST; i++) {
        const int64_t row = (int64_t)(i / MOST) * r->capacity + i % MOST;
        const bool moves = i % MOST < r->count[i / MOST] && lt_param_is_touched(p, row);

        r->seen[i] = moves ? (lt_real)hypot(p->grad[2 * row], p->grad[2 * row + 1]) : 0;
    }
}

/* The row in use with the largest slope, or the smallest one */
static int extreme(const task_run *r, int set, int sign)
{
    const lt_real *slope = r->slope.data + (int64_t)set * r->capacity;
    int best = 0;

    for (int i = 1; i < r->count[set]; i++)
        if (sign * slope[i] > sign * slope[best])
            best = i;
    return best;
}

/* Each set gives up the blob that hardly matters, from six on, and doubles the one that is pulled at most. */
static lt_status grow(task_run *r)
{
    lt_row_source from[SETS * MOST];
    int count[SETS], capacity = STEP, n = 0;

    for (int s = 0; s < SETS; s++) {
        count[s] = r->count[s] < MOST ? r->count[s] + 1 - (r->count[s] > TRUE_BLOBS) : r->count[s] - 1;
        capacity = count[s] > capacity ? (count[s] + STEP - 1) / STEP * STEP : capacity;
    }
    capacity = capacity > r->capacity ? capacity : r->capacity;
    for (int s = 0; s < SETS; s++) {
        const int doubled = extreme(r, s, 1), gone = r->count[s] > TRUE_BLOBS ? extreme(r, s, -1) : -1;
        const int64_t base = (int64_t)s * r->capacity;

        for (int i = 0; i < r->count[s]; i++)
            if (i != gone)
                from[n++] = (lt_row_source){ .from = base + i };
        if (r->count[s] < MOST)
            from[n++] = (lt_row_source){ .from = base + doubled, .fresh = true };
        while (n < (s + 1) * capacity)
            from[n++] = (lt_row_source){ .from = -1 };
        r->count[s] = count[s];
    }
    r->capacity = capacity;
    return lt_param_gather(blobs_of(r)->centre, n, from);
}

static lt_status run_adapt(task_run *r, int64_t step, lt_optim *o)
{
    const lt_param *p = blobs_of(r)->centre;
    lt_status st;

    (void)o;
    for (int i = 0; i < SETS * MOST; i++)
        if (i % MOST < r->count[i / MOST])
            r->slope.data[(int64_t)(i / MOST) * r->capacity + i % MOST] += r->seen[i];
    if (step % ADAPT_EVERY)
        return LT_OK;
    st = grow(r);
    for (int64_t i = 0; !st && i < p->shape.dim[0]; i++)
        r->slope.data[i] = 0;
    return st;
}

/* ---- its own state -------------------------------------------------------------------------------------- */

static int run_save(const task_run *r, lt_named_array *out, int room)
{
    lt_real *counts = (lt_real *)r->counts;
    const int64_t rows = blobs_of(r)->centre->shape.dim[0], n = SETS + 1;

    (void)room;
    for (int s = 0; s < SETS; s++)
        counts[s] = (lt_real)r->count[s];
    counts[SETS] = (lt_real)r->capacity;
    out[0] = (lt_named_array){ "task.counts", lt_array_make(LT_ELEM_F4, 1, &n, counts) };
    out[1] = (lt_named_array){ "task.slope", lt_array_make(LT_ELEM_F4, 1, &rows, r->slope.data) };
    return 2;
}

static const lt_array *find(const lt_named_array *entry, size_t n, const char *name, size_t want)
{
    for (size_t i = 0; i < n; i++)
        if (strcmp(entry[i].name, name) == 0)
            return lt_array_count(&entry[i].array) == want ? &entry[i].array : NULL;
    return NULL;
}

static lt_status run_load(task_run *r, const char *path, const lt_named_array *entry, size_t n)
{
    const lt_array *counts = find(entry, n, "task.counts", SETS + 1), *slope;
    int count[SETS], capacity;
    lt_status st;

    if (!counts)
        return lt_error(LT_EINVAL, "%s: has no \"task.counts\" of %d numbers", path, SETS + 1);
    capacity = (int)((const float *)counts->data)[SETS];
    for (int s = 0; s < SETS; s++) {
        count[s] = (int)((const float *)counts->data)[s];
        if (capacity < STEP || capacity > MOST || count[s] < 1 || count[s] > capacity)
            return lt_error(LT_EINVAL, "%s: \"task.counts\" are none", path);
    }
    slope = find(entry, n, "task.slope", (size_t)(SETS * capacity));
    if (!slope)
        return lt_error(LT_EINVAL, "%s: has no \"task.slope\" of %d rows", path, SETS * capacity);
    st = lt_param_resize(blobs_of(r)->centre, SETS * capacity);
    if (st)
        return st;
    memcpy(r->count, count, sizeof(count));
    r->capacity = capacity;
    memcpy(r->slope.data, slope->data, (size_t)(SETS * capacity) * sizeof(float));
    return LT_OK;
}

/* ---- scores --------------------------------------------------------------------------------------------- */

/* Of a sample: what was found, the surest first; hit: nearer than 0.1 to a true blob that nobody has taken. */
typedef struct { float sure, hit; } finding;

static lt_status run_score(task_run *r, const compiled *c, const void *batch_, records *out, bool *no_losses)
{
    const batch *b = batch_;
    const lt_real *centre = blobs_of(r)->centre->data;
    lt_status st = LT_OK;

    (void)c, (void)no_losses;
    for (int s = 0; s < b->count && !st; s++) {
        finding found[MOST];
        bool taken[TRUE_BLOBS] = { false };
        const int set = set_of(b->index[s], 0);

        for (int i = 0; i < r->count[set]; i++) {
            const lt_real *at = centre + 2 * ((int64_t)set * r->capacity + i);
            int hit = -1;

            for (int k = 0; k < TRUE_BLOBS; k++)
                if (!taken[k] && hypot(at[0] - true_blob(set, k, 0), at[1] - true_blob(set, k, 1)) < 0.1)
                    hit = k;
            if (hit >= 0)
                taken[hit] = true;
            found[i] = (finding){ 1 / (1 + (float)i), hit >= 0 };
        }
        st = records_add(out, b->index[s], found, (size_t)r->count[set] * sizeof(*found));
    }
    return st;
}

static int surest_first(const void *a, const void *b)
{
    const finding *x = a, *y = b;

    return x->sure > y->sure ? -1 : x->sure < y->sure;
}

/* Average precision over all findings, ties in the order of samples */
static void run_measure(task_run *r, const records *all, double *out)
{
    finding found[CHECKED * MOST];
    size_t n = 0, bytes;
    double hits = 0, sum = 0;

    (void)r;
    for (int64_t i = 0; i < all->n; i++) {
        const void *record_ = records_at(all, i, &bytes);

        memcpy(found + n, record_, bytes);
        n += bytes / sizeof(*found);
    }
    for (size_t i = 1; i < n; i++)              /* stable */
        for (size_t k = i; k > 0 && surest_first(&found[k], &found[k - 1]) < 0; k--) {
            const finding t = found[k];

            found[k] = found[k - 1];
            found[k - 1] = t;
        }
    for (size_t i = 0; i < n; i++)
        if (found[i].hit > 0) {
            hits++;
            sum += hits / (double)(i + 1);
        }
    out[0] = all->n ? sum / (double)(all->n * TRUE_BLOBS) : NAN;
}

static const char *const metrics[] = { "blobs_ap", NULL };
static const metric own_metrics[] = { { "blobs_ap", "AP", "", true, "average precision of blobs", "tests" }, { 0 } };
static const model_class *const models[] = { &blobs_class, NULL };

const task blobs_task = {
    .name = "blobs", .data_size = sizeof(blobs_data), .data_keys = data_keys, .models = models, .metrics = metrics,
    .own_metrics = own_metrics, .open = run_open, .close = run_close, .build = run_build, .describe = run_describe,
    .facts = run_facts, .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes,
    .recipe = run_recipe, .weight = batch_weight, .sample_name = run_sample_name, .score = run_score,
    .measure = run_measure, .phase = run_phase, .groups = run_groups, .rows = run_rows, .observed = run_observed,
    .observe = run_observe, .adapt = run_adapt, .save = run_save, .load = run_load,
};
