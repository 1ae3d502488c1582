/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/action/scores.h"

#include "eval/tables/scores_file.h"

#include <cjson/cJSON.h>
#include <math.h>

enum { REACHING = 2, RECEIVING = 6 };

const char *const action_score_keys[] = {
    "accuracy", "accuracy_body_only", "accuracy_stream2_only", "object_recall", "object_recall_body_only",
    "share_3_as_7", NULL,
};

void action_confusion_add(action_confusion *c, int cls, int found)
{
    c->n[cls][found]++;
}

static int64_t windows_of(const action_confusion *c, int cls)
{
    int64_t n = 0;

    for (int i = 0; i < ACTION_CLASSES; i++)
        n += c->n[cls][i];
    return n;
}

static void count(const action_confusion *c, int64_t *right, int64_t *all)
{
    *right = *all = 0;
    for (int i = 0; i < ACTION_CLASSES; i++) {
        *right += c->n[i][i];
        *all += windows_of(c, i);
    }
}

double action_accuracy(const action_confusion *c)
{
    int64_t right, all;

    count(c, &right, &all);
    return all ? (double)right / (double)all : NAN;
}

double action_recall(const action_confusion *c, int cls)
{
    const int64_t n = windows_of(c, cls);

    return n ? (double)c->n[cls][cls] / (double)n : NAN;
}

double action_object_recall(const action_confusion *c)
{
    double sum = 0;

    for (int i = ACTION_WITH_OBJECT; i < ACTION_CLASSES; i++)
        sum += action_recall(c, i);
    return sum / (ACTION_CLASSES - ACTION_WITH_OBJECT);
}

double action_share_3_as_7(const action_confusion *c)
{
    int64_t right, all;

    count(c, &right, &all);
    return all > right ? (double)c->n[REACHING][RECEIVING] / (double)(all - right) : 0;
}

static void add_recall(cJSON *to, const char *key, const action_confusion *c)
{
    cJSON *recall = cJSON_AddObjectToObject(to, key);

    for (int i = 0; i < ACTION_CLASSES; i++)
        cJSON_AddNumberToObject(recall, action_classes[i], action_recall(c, i));
}

struct cJSON *action_scores_json(const action_scores *s)
{
    cJSON *root = cJSON_CreateObject(), *confusion;

    cJSON_AddNumberToObject(root, "accuracy", action_accuracy(&s->both));
    add_recall(root, "recall", &s->both);
    add_recall(root, "recall_body_only", &s->body_only);
    cJSON_AddNumberToObject(root, "object_recall", action_object_recall(&s->both));
    cJSON_AddNumberToObject(root, "object_recall_body_only", action_object_recall(&s->body_only));
    confusion = cJSON_AddArrayToObject(root, "confusion");
    for (int i = 0; i < ACTION_CLASSES; i++) {
        double row[ACTION_CLASSES];

        for (int k = 0; k < ACTION_CLASSES; k++)
            row[k] = (double)s->both.n[i][k];
        cJSON_AddItemToArray(confusion, cJSON_CreateDoubleArray(row, ACTION_CLASSES));
    }
    cJSON_AddNumberToObject(root, "share_3_as_7", action_share_3_as_7(&s->both));
    cJSON_AddNumberToObject(root, "accuracy_body_only", action_accuracy(&s->body_only));
    cJSON_AddNumberToObject(root, "accuracy_stream2_only", action_accuracy(&s->hand_object_only));
    cJSON_AddNumberToObject(root, "accuracy_baseline", s->baseline);
    cJSON_AddStringToObject(root, "split", s->split);
    cJSON_AddBoolToObject(root, "synthetic", s->synthetic);
    if (!isnan(s->difficulty))
        cJSON_AddNumberToObject(root, "difficulty", s->difficulty);
    return root;
}

void action_scores_print(const action_scores *s, FILE *f)
{
    int64_t right, all;

    count(&s->both, &right, &all);
    fprintf(f, "%swindows of actions, split by %s: %lld of %lld right\n", s->synthetic ? "SYNTHETIC, " : "", s->split,
            (long long)right, (long long)all);
    fprintf(f, "accuracy %.4f, body only %.4f, stream 2 only %.4f", action_accuracy(&s->both),
            action_accuracy(&s->body_only), action_accuracy(&s->hand_object_only));
    if (!isnan(s->baseline))
        fprintf(f, ", baseline of speeds %.4f", s->baseline);
    fprintf(f, "; errors that take 3 for 7: %.4f\nclasses with an object: recall %.4f, body only %.4f\n\n%-16s %6s "
            "%6s ",
            action_share_3_as_7(&s->both), action_object_recall(&s->both), action_object_recall(&s->body_only), "class",
            "recall", "body");
    for (int k = 0; k < ACTION_CLASSES; k++)
        fprintf(f, "%6d", k + 1);
    for (int i = 0; i < ACTION_CLASSES; i++) {
        fprintf(f, "\n%2d %-13.13s %6.4f %6.4f ", i + 1, action_classes[i], action_recall(&s->both, i),
                action_recall(&s->body_only, i));
        for (int k = 0; k < ACTION_CLASSES; k++)
            fprintf(f, "%6lld", (long long)s->both.n[i][k]);
    }
    fputc('\n', f);
}

static void put_row(FILE *f, const char *name, const action_confusion *c)
{
    fprintf(f, "| %s | %.4f | %.4f |\n", name, action_accuracy(c), action_object_recall(c));
}

lt_status action_scores_page(const action_scores *s, const char *folder)
{
    lt_atomic_file f;
    const lt_status st = scores_table_open(folder, &f);
    int64_t right, all;

    if (st)
        return st;
    count(&s->both, &right, &all);
    fputs("### Share of windows that are right\n\n| what is seen | all | classes with an object |\n| - | -: | -: |\n",
          f.stream);
    put_row(f.stream, "both streams", &s->both);
    put_row(f.stream, "the body alone", &s->body_only);
    put_row(f.stream, "hand and object alone", &s->hand_object_only);
    if (!isnan(s->baseline))
        fprintf(f.stream, "| baseline of speeds | %.4f | - |\n", s->baseline);
    fputs("\n### By class, and what it is taken for\n\n| class | recall | body alone |", f.stream);
    for (int k = 0; k < ACTION_CLASSES; k++)
        fprintf(f.stream, " %d |", k + 1);
    fputs("\n| - | -: | -: |", f.stream);
    for (int k = 0; k < ACTION_CLASSES; k++)
        fputs(" -: |", f.stream);
    for (int i = 0; i < ACTION_CLASSES; i++) {
        fprintf(f.stream, "\n| %d %s | %.4f | %.4f |", i + 1, action_classes[i], action_recall(&s->both, i),
                action_recall(&s->body_only, i));
        for (int k = 0; k < ACTION_CLASSES; k++)
            fprintf(f.stream, " %lld |", (long long)s->both.n[i][k]);
    }
    fprintf(f.stream, "\n\nProtocol: %s%lld windows, split by %s; errors that take 3 for 7: %.4f\n",
            s->synthetic ? "SYNTHETIC, " : "", (long long)all, s->split, action_share_3_as_7(&s->both));
    return lt_atomic_commit(&f);
}
