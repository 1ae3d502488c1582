/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/metric.h"

#include <string.h>

static const metric dictionary[] = {
    { "pa_mpjpe_mm", "PA-MPJPE", "mm", false, "joints' mean error after the best similarity, reflections allowed",
      "HO3D's scorer" },
    { "mpjpe_mm", "MPJPE", "mm", false, "joints' mean error, wrist on wrist", "DexYCB's toolkit" },
};

enum { N = sizeof(dictionary) / sizeof(*dictionary) };

const metric *metric_find(const char *key)
{
    for (int i = 0; i < N; i++)
        if (strcmp(dictionary[i].key, key) == 0)
            return &dictionary[i];
    return NULL;
}

const metric *metric_at(int i)
{
    return i < N ? &dictionary[i] : NULL;
}

bool metric_better(const metric *m, double a, double b)
{
    return m->higher ? a > b : a < b;
}
