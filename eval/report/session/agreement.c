/* SPDX-License-Identifier: Apache-2.0 */
/* How often what was said is true, of persons whom the truth knows: set by set, and of each onset how late. */
#include "eval/report/session/internal.h"

#include "libtensor/base/order.h"

#include <math.h>
#include <string.h>

static const double SETTLED = 5.0 / 30;         /* seconds: of sets farther than that from a change of the truth */
static const double EARLY = 0.5;                /* seconds: before its onset a word counts as the one meant */

/* A lane's word at a time; where it has none, "none" */
static const char *word_at(const lane *l, double time)
{
    for (int i = l ? l->n - 1 : -1; i >= 0; i--)
        if (l->span[i].from <= time && time <= l->span[i].to)
            return l->span[i].label;
    return "none";
}

static bool is_settled(const lane *l, double time)
{
    for (int i = 0; i < l->n; i++) {
        const lane_span *s = &l->span[i];

        if (fabs(s->from - time) <= SETTLED || fabs(s->to - time) <= SETTLED)
            return false;
    }
    return true;
}

static const lane *said_of(const history *h, const lane *truth)
{
    const lane_kind kind = truth->kind == LANE_TRUE_ACTION ? LANE_ACTION : LANE_INTERACTION;

    for (int i = 0; i < h->n_lanes; i++)
        if (h->lane[i].kind == kind && h->lane[i].id == truth->beside)
            return &h->lane[i];
    return NULL;
}

static void count(agreement *a, const char *word, bool right)
{
    int i = 0;

    while (i < a->n_words && strcmp(a->word[i].word, word) != 0)
        i++;
    if (i == AGREEMENT_WORDS)
        return;
    a->n_words += i == a->n_words;
    a->word[i].word = word;
    a->word[i].all++;
    a->word[i].right += right;
}

static void compare_sets(const history *h, const lane *truth, const lane *said, agreement *a)
{
    for (int64_t k = 0; k < h->n; k++) {
        const char *word = word_at(truth, h->time[k]);
        const bool right = strcmp(word, word_at(said, h->time[k])) == 0;

        a->all++;
        a->right += right;
        count(a, word, right);
        if (is_settled(truth, h->time[k])) {
            a->settled++;
            a->settled_right += right;
        }
    }
}

/* When its word is first said, from shortly before a span of the truth to its end; NaN: never */
static double said_first(const lane *said, const lane_span *s)
{
    for (int i = 0; said && i < said->n; i++)
        if (strcmp(said->span[i].label, s->label) == 0 && said->span[i].to >= s->from - EARLY &&
            said->span[i].from <= s->to)
            return fmax(said->span[i].from, s->from - EARLY);
    return NAN;
}

static lt_status compare_onsets(const lane *truth, const lane *said, agreement *a, lt_arena *arena)
{
    for (int i = 0; i < truth->n; i++) {
        const double first = said_first(said, &truth->span[i]);
        double *all = lt_arena_grow(arena, a->delay, (size_t)a->n_delays, &a->room, sizeof(*all));

        if (!all)
            return lt_error(LT_ENOMEM, "no memory for the page");
        a->delay = all;
        if (isnan(first))
            a->missed++;
        else
            a->delay[a->n_delays++] = first - truth->span[i].from;
    }
    return LT_OK;
}

lt_status agreement_of(const history *h, lane_kind truth, agreement *out)
{
    lt_status st = LT_OK;

    *out = (agreement){ .median_delay = NAN };
    for (int i = 0; i < h->n_lanes && !st; i++) {
        const lane *l = &h->lane[i];

        if (l->kind != truth || !l->beside)
            continue;
        compare_sets(h, l, said_of(h, l), out);
        st = compare_onsets(l, said_of(h, l), out, h->arena);
    }
    if (out->n_delays)
        out->median_delay = lt_median(out->n_delays, out->delay);
    return st;
}

/* ---- the page ---- */

static void put_share(FILE *f, int right, int all)
{
    if (all)
        fprintf(f, "<td class=n>%.1f %%</td><td class=n>%d</td>", 100.0 * right / all, all);
    else
        fputs("<td></td><td class=n>0</td>", f);
}

static void put_row(FILE *f, const char *what, const char *word, int right, int all)
{
    fprintf(f, "<tr><td>%s</td><td>", what);
    html_text(f, word);
    fputs("</td>", f);
    put_share(f, right, all);
    fputs("</tr>\n", f);
}

static void put_agreement(FILE *f, const char *what, const agreement *a)
{
    put_row(f, what, "all", a->right, a->all);
    put_row(f, what, "more than 5 frames from a change", a->settled_right, a->settled);
    for (int i = 0; i < a->n_words; i++)
        put_row(f, what, a->word[i].word, a->word[i].right, a->word[i].all);
}

static void put_delay(FILE *f, const char *what, const agreement *a)
{
    if (!a->n_delays && !a->missed)
        return;
    fprintf(f, "<p>Of %d onsets of an %s %d were told", a->n_delays + a->missed, what, a->n_delays);
    if (a->n_delays)
        fprintf(f, ", half of them within %.0f frames (of 30 a second)", 30 * a->median_delay);
    fputs(".</p>\n", f);
}

lt_status agreement_put(FILE *f, const history *h)
{
    agreement action, state;
    lt_status st = agreement_of(h, LANE_TRUE_ACTION, &action);

    st = st ? st : agreement_of(h, LANE_TRUE_INTERACTION, &state);
    if (st || !(action.all + state.all))
        return st;
    fputs("<h2>Beside the truth</h2>\n<p>Of persons whom it knows, sets in which the word is the true one; of each "
          "true word, how often it was said.</p>\n<div class=wide><table>\n<tr><th></th><th>true word</th><th "
          "class=n>said</th><th class=n>sets</th></tr>\n", f);
    put_agreement(f, "action", &action);
    put_agreement(f, "interaction", &state);
    fputs("</table></div>\n", f);
    put_delay(f, "action", &action);
    put_delay(f, "interaction", &state);
    return LT_OK;
}
