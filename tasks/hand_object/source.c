/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/source.h"

#include "assets/hand_file.h"
#include "data/contact.h"
#include "data/kind.h"
#include "estimate/feed.h"
#include "synth/stream/stream.h"

#include <math.h>

static bool validates(const train_config *c)
{
    return c->loop.validate_every > 0 || c->loop.validate_steps > 0;
}

static lt_status open_stream(const train_config *c, run_source *s)
{
    const hand_object_config *d = hand_object_config_of(c);

    return synth_stream_open(&(synth_stream_options){
        .seed = (uint64_t)c->loop.seed, .count = d->pictures, .shrink = d->shrink, .near = d->near,
        .keep = c->optim.epochs > 1 ? (size_t)d->keep_mb << 20 : 0 }, &s->train);
}

static lt_status open_datasets(lt_arena *arena, const train_config *c, run_source *s)
{
    const hand_object_config *d = hand_object_config_of(c);
    const bool streams = d->kind == HAND_OBJECT_STREAM;
    dataset_options o = { .root = d->common.dir, .split = "train", .models = d->objects,
                          .setup = hand_object_setup(d), .filter = hand_object_filter(d), .hand = s->hand,
                          .needs = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT };
    lt_hand_model *left = NULL;
    lt_status st;

    if (streams && (st = open_stream(c, s)))
        return st;
    if (streams && (!*d->common.dir || !validates(c)))
        return LT_OK;
    if (!*d->common.dir)
        return lt_error(LT_EUSAGE, "%s: data.dir: no dataset given; name its folder with --data or "
                        "--set data.dir=FOLDER", c->path);
    st = dataset_find_kind(d->common.dir, &o.kind);
    if (!st && *d->hand_left)
        st = hand_file_read(arena, d->hand_left, &left);
    o.left = left ? left : s->hands.left;
    if (!st && !streams)
        st = dataset_open(&o, &s->train);
    if (st || !validates(c))
        return st;
    o.split = dataset_validation_split(o.kind, d->common.dir);      /* without: training samples are held back */
    return o.split ? dataset_open(&o, &s->evaluation) : LT_OK;
}

static hand_object_options train_options_of(const train_config *c)
{
    const hand_object_config *d = hand_object_config_of(c);
    hand_object_options o = hand_object_defaults(d->augment, (uint64_t)c->loop.seed);

    o.centre_jitter = d->centre_jitter;
    o.scale_jitter = d->scale_jitter;
    o.rotation = d->rotation_deg * M_PI / 180;
    o.rotation_chance = d->rotation_chance;
    o.colour = (augment_limits){ d->blur, d->brightness, d->contrast, d->saturation, d->hue };
    o.background = d->background;
    o.bilinear = d->bilinear;
    return o;
}

static lt_status deal(const train_config *c, run_source *s)
{
    const int64_t want = validates(c) ? c->loop.validate_samples : 0;

    s->train_count = s->train->count;
    s->check_first = 0;
    s->check_count = s->evaluation ? lt_min_i64(want, s->evaluation->count) : want;
    if (s->evaluation || !want)
        return LT_OK;
    if (want >= s->train->count)
        return lt_error(LT_EINVAL, "%s: train.validate_samples: the data have no evaluation truth, and holding "
                        "back %lld of %lld training samples leaves none; ask for fewer, or none with "
                        "validate_every=0", c->path, (long long)want, (long long)s->train->count);
    s->train_count -= want;
    s->check_first = s->train_count;
    return LT_OK;
}

/* Of the training samples, those with the hand at the object. */
static lt_status keep_contact(lt_arena *arena, const train_config *c, run_source *s)
{
    const hand_object_config *d = hand_object_config_of(c);
    lt_status st;

    if (d->contact_mm <= 0)
        return LT_OK;
    st = contact_select(s->train, s->hand, 0, s->train_count, d->contact_mm / 1e3, arena, &s->train_feed.index,
                        &s->train_feed.count);
    s->train_count = s->train_feed.count;
    if (st == LT_OK && s->train_count == 0)
        return lt_error(LT_EINVAL, "%s: data.contact_mm: no hand comes within %g mm of its object in %s", c->path,
                        d->contact_mm, s->train->root);
    return st;
}

/* That there are masks is seen on the first sample, rather than never: a run would just learn the rooms. A sample
 * that cannot be read is the loader's affair. */
static lt_status check_segments(lt_arena *arena, const train_config *c, const run_source *s)
{
    const hand_object_config *d = hand_object_config_of(c);
    dataset_sample first;

    if (!d->augment || d->background <= 0)
        return LT_OK;
    if (dataset_read(s->train, 0, SAMPLE_SEGMENTS, arena, &first) || (first.flags & SAMPLE_SEGMENTS))
        return LT_OK;
    return lt_error(LT_EINVAL, "%s: data.background: %s has no mask of hand and object, which HO3D keeps in %s/%s/"
                    "SEQUENCE/seg; unpack them there, or leave backgrounds as they are with 0", c->path, first.name,
                    s->train->root, s->train->split);
}

lt_status source_open(lt_arena *arena, const train_config *c, run_source *out)
{
    lt_hand_layer *layer = NULL;
    lt_status st;

    *out = (run_source){ 0 };
    st = hands_open(arena, hand_object_config_of(c)->hand, &out->hands);
    out->hand = out->hands.right;
    if (st == LT_OK)
        st = open_datasets(arena, c, out);
    if (st == LT_OK)
        st = dataset_check_tips(out->train, out->hand, &out->tips_rms_mm);
    if (st == LT_OK)
        st = lt_hand_layer_new(arena, out->hand, out->train->tips, &layer);
    if (st == LT_OK)
        st = deal(c, out);
    if (st == LT_OK)
        st = check_segments(arena, c, out);
    if (st)
        return st;
    out->layer = layer;
    out->train_feed = (hand_object_feed){ .data = out->train, .options = train_options_of(c) };
    out->check_feed = (hand_object_feed){ .data = out->evaluation ? out->evaluation : out->train,
                                          .options = hand_object_defaults(false, (uint64_t)c->loop.seed) };
    out->check_feed.options.bilinear = hand_object_config_of(c)->bilinear;
    return keep_contact(arena, c, out);
}

void source_close(run_source *s)
{
    dataset_free(s->train);
    dataset_free(s->evaluation);
    s->train = s->evaluation = NULL;
}

void source_sizes(run_source *s, const model *m)
{
    feed_options(m, &s->train_feed.options);
    feed_options(m, &s->check_feed.options);
}

loader_source source_loader(const run_source *s)
{
    loader_source l = hand_object_source(&s->train_feed);

    l.count = s->train_count;
    l.ordered = s->train->kind == &synth_stream_kind;
    return l;
}

/* ---- a loader's view of the validation samples: they need not begin at the dataset's first --------------- */

static const char *check_name(const void *ctx, int64_t index)
{
    const run_source *s = ctx;

    return dataset_name(s->check_feed.data, s->check_first + index);
}

static void *check_batch_new(const void *ctx, int capacity)
{
    const run_source *s = ctx;

    return hand_object_batch_new(capacity, s->check_feed.options.size, s->check_feed.options.cells);
}

static lt_status check_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch, int slot)
{
    const run_source *s = ctx;

    return hand_object_source(&s->check_feed).fill(&s->check_feed, epoch, s->check_first + index, scratch, batch,
                                                   slot);
}

loader_source source_checker(const run_source *s)
{
    loader_source l = hand_object_source(&s->check_feed);

    l.ctx = s;
    l.count = s->check_count;
    l.name = check_name;
    l.batch_new = check_batch_new;
    l.fill = check_fill;
    return l;
}
