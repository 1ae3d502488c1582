/* SPDX-License-Identifier: Apache-2.0 */
/* Which line of a file of boxes is for which image, and which for which frame of a film. */
#include "pipeline/internal.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { MOST_DIGITS = 9, MOST_HANDS = 64 };      /* of a frame's number; of an image */

/* A name that an input goes by: its file's, or that without the ending. */
typedef struct {
    const char *text;
    size_t n;
    int input;
} name_key;

typedef struct {
    const predict_boxes *boxes;
    const predict_list *list;
    name_key *key;                      /* n_keys, in order */
    size_t n_keys;
} matcher;

/* In this order names that differ in capitals alone, as IMG_1.JPG and IMG_1.jpg, stand together. */
static int compare_text(const name_key *a, const name_key *b)
{
    const int order = strncasecmp(a->text, b->text, a->n < b->n ? a->n : b->n);

    return order ? order : a->n < b->n ? -1 : a->n > b->n;
}

static int by_text(const void *a, const void *b)
{
    const name_key *x = a, *y = b;
    const int order = compare_text(x, y);

    return order ? order : x->input - y->input;
}

static lt_status list_names(lt_arena *arena, matcher *m)
{
    m->key = lt_arena_array(arena, 2 * (size_t)m->list->n, sizeof(*m->key));
    if (!m->key)
        return lt_error(LT_ENOMEM, "%s: no memory for the names of %d images", m->boxes->path, m->list->n);
    for (int i = 0; i < m->list->n; i++) {
        const char *path = m->list->input[i].path, *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
        const char *dot = strrchr(name, '.');

        m->key[m->n_keys++] = (name_key){ name, strlen(name), i };
        if (dot && dot != name)
            m->key[m->n_keys++] = (name_key){ name, (size_t)(dot - name), i };
    }
    qsort(m->key, m->n_keys, sizeof(*m->key), by_text);
    return LT_OK;
}

/* ---- whose a line is ------------------------------------------------------------------------------------- */

/* The image, or the film, of this name becomes the row's, unless it has another already. */
static lt_status claim_as(const matcher *m, const char *text, size_t n, bool film, bool exactly, predict_boxes_row *row)
{
    const name_key want = { text, n, 0 };
    size_t lo = 0, hi = m->n_keys;

    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;

        if (compare_text(&m->key[mid], &want) < 0)
            lo = mid + 1;
        else
            hi = mid;
    }
    for (; lo < m->n_keys && !compare_text(&m->key[lo], &want); lo++) {
        const int input = m->key[lo].input;

        if (m->list->input[input].film != film || (exactly && memcmp(m->key[lo].text, text, n) != 0))
            continue;
        if (row->input >= 0 && row->input != input)
            return lt_error(LT_EINVAL, "%s:%lld: %s may be %s or %s; give its ending, or predict one at a time",
                            m->boxes->path, (long long)row->line, row->image, m->list->input[row->input].path,
                            m->list->input[input].path);
        row->input = input;
    }
    return LT_OK;
}

static lt_status claim(const matcher *m, const char *text, size_t n, bool film, predict_boxes_row *row)
{
    const lt_status st = claim_as(m, text, n, film, true, row);

    return st || row->input >= 0 ? st : claim_as(m, text, n, film, false, row);
}

/* "film.mp4#12", "film-000012": *n characters name the film. */
static bool is_frame_name(const char *name, size_t *n, int *frame)
{
    const size_t all = strlen(name);
    size_t digits = 0;

    while (digits < all && isdigit((unsigned char)name[all - digits - 1]))
        digits++;
    if (!digits || digits > MOST_DIGITS || digits + 2 > all)
        return false;
    *n = all - digits - 1;
    *frame = atoi(name + *n + 1);
    return name[*n] == '#' || (name[*n] == '-' && digits >= PREDICT_FRAME_DIGITS);
}

static lt_status find_owner(const matcher *m, predict_boxes_row *row)
{
    lt_status st = claim(m, row->image, strlen(row->image), false, row);
    size_t n;
    int frame;

    if (st || row->input >= 0 || !is_frame_name(row->image, &n, &frame))
        return st;
    st = claim(m, row->image, n, true, row);
    if (!st && row->input >= 0 && frame < 1)
        return lt_error(LT_EINVAL, "%s:%lld: %s: a film's frames are counted from 1", m->boxes->path,
                        (long long)row->line, row->image);
    row->frame = frame;
    return st;
}

/* ---- what an input has ----------------------------------------------------------------------------------- */

static int by_owner(const void *a, const void *b)
{
    const predict_boxes_row *x = a, *y = b;

    if (x->input != y->input)
        return x->input < y->input ? -1 : 1;
    if (x->frame != y->frame && x->input >= 0)
        return x->frame < y->frame ? -1 : 1;
    return x->line < y->line ? -1 : x->line > y->line;
}

static bool same_image(const predict_boxes_row *a, const predict_boxes_row *b)
{
    return a->input == b->input && a->frame == b->frame;
}

/* Several lines for an image are several hands. */
static lt_status check_hands(const predict_boxes *b, const predict_boxes_row *first, const predict_boxes_row *row)
{
    if (row - first >= MOST_HANDS)
        return lt_error(LT_EINVAL, "%s:%lld: more than %d lines for %s", b->path, (long long)row->line, MOST_HANDS,
                        row->image);
    for (; first < row; first++) {
        if (!first->has_hand || !row->has_hand)
            return lt_error(LT_EINVAL, "%s:%lld: %s and %s in line %lld are the same image; several hands want a "
                            "hand's box each", b->path, (long long)row->line, row->image, first->image,
                            (long long)first->line);
        if (memcmp(&first->hand, &row->hand, sizeof(row->hand)) == 0)
            return lt_error(LT_EINVAL, "%s:%lld: %s and %s in line %lld are the same image with the same hand's box; "
                            "want one line for a hand", b->path, (long long)row->line, row->image, first->image,
                            (long long)first->line);
    }
    return LT_OK;
}

static lt_status hand_out(predict_boxes *b, size_t from, predict_list *list)
{
    const predict_boxes_row *first = b->row + from;

    for (size_t i = from; i < b->n; i++) {
        const predict_boxes_row *row = &b->row[i];
        predict_input *in = &list->input[row->input];
        lt_status st;

        if (!same_image(first, row))
            first = row;
        st = check_hands(b, first, row);
        if (st)
            return st;
        if (!in->n_boxes++)
            in->boxes = row;
    }
    return LT_OK;
}

lt_status predict_match_boxes(lt_arena *arena, const predict_options *o, predict_boxes *b, predict_list *list)
{
    matcher m = { .boxes = b, .list = list };
    size_t foreign = 0;
    lt_status st = list_names(arena, &m);

    for (size_t i = 0; i < b->n && !st; i++) {
        st = find_owner(&m, &b->row[i]);
        foreign += b->row[i].input < 0;
    }
    if (st)
        return st;
    qsort(b->row, b->n, sizeof(*b->row), by_owner);
    if (foreign == b->n)
        return lt_error(LT_EINVAL, "%s:%lld: there is no image %s, and none of any other line; the first image is %s",
                        b->path, (long long)b->row[0].line, b->row[0].image, list->input[0].path);
    if (foreign)
        predict_say(o, "%s: %zu of %zu lines are for none of the images, the first of them line %lld for %s", b->path,
                    foreign, b->n, (long long)b->row[0].line, b->row[0].image);
    return hand_out(b, foreign, list);
}

static int by_frame(const void *a, const void *b)
{
    const predict_boxes_row *x = a, *y = b;

    return x->frame < y->frame ? -1 : x->frame > y->frame;
}

const predict_boxes_row *predict_frame_boxes(const predict_input *film, int k, size_t *n)
{
    const predict_boxes_row key = { .frame = k }, *end = film->boxes + film->n_boxes;
    const predict_boxes_row *row = film->n_boxes ? bsearch(&key, film->boxes, film->n_boxes, sizeof(key), by_frame)
                                                 : NULL;

    *n = 0;
    if (!row)
        return NULL;
    while (row > film->boxes && row[-1].frame == k)
        row--;
    while (row + *n < end && row[*n].frame == k)
        ++*n;
    return row;
}
