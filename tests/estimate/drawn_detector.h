/* SPDX-License-Identifier: Apache-2.0 */
/* A detector that answers the same everywhere, for tests of what is done with one: weights of the YOLOv8-seg layout. */
#ifndef TESTS_ESTIMATE_DRAWN_DETECTOR_H
#define TESTS_ESTIMATE_DRAWN_DETECTOR_H

#include "estimate/detection/detector.h"
#include "libtensor/io/array/safetensors.h"
#include "tests/models/model_of.h"

/* Of `classes`; cls is found in every cell of 32 pixels, with boxes that all but cover the picture; -1: nothing is. */
static inline void write_detector(const char *path, int classes, int cls)
{
    static lt_named_array list[512];
    char config[64];
    size_t n = 0;
    model m;
    lt_params *set;

    snprintf(config, sizeof(config), "{\"image_size\": 640, \"classes\": %d}", classes);
    set = model_of("csp_seg", config, NULL, &m);
    m.cls->init(&m, 1);
    for (lt_param *p = lt_params_first(set); p; p = p->next) {
        const int64_t count = lt_param_numel(p);
        const char *last = strncmp(p->name, "head.class.", 11) == 0 ? strstr(p->name + 11, ".2.") : NULL;

        for (int64_t i = 0; i < count && last; i++)
            p->data[i] = strcmp(last, ".2.bias") ? 0 : p->name[11] == '2' && i == cls ? 2 : -20;
        list[n++] = (lt_named_array){ p->name, lt_array_make(LT_ELEM_F4, p->shape.rank, p->shape.dim, p->data) };
    }
    check_ok(lt_safetensors_write(path, list, n, NULL, 0));
    lt_params_free(set);
}

#endif
