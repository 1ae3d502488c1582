/* SPDX-License-Identifier: Apache-2.0 */
#include "models/model.h"

#include <assert.h>
#include <string.h>

lt_status model_create(const model_class *cls, const char *where, const struct cJSON *config,
                       const lt_hand_layer *hand, lt_params *set, model *out)
{
    lt_arena *arena = lt_params_arena(set);
    model m = { .cls = cls, .params = set, .hand = hand, .self = lt_arena_alloc(arena, cls->size) };
    lt_status st = m.self ? lt_config_read(arena, where, config, cls->keys, m.self)
                          : lt_error(LT_ENOMEM, "%s: no memory for the model", where);

    if (st == LT_OK && cls->check)
        st = cls->check(where, m.self);
    if (st)
        return st;
    cls->build(&m, hand);
    *out = m;
    return lt_params_status(set);
}

lt_tensor *model_port_find(const model_ports *ports, const char *name)
{
    for (int i = 0; i < ports->n; i++)
        if (strcmp(ports->port[i].name, name) == 0)
            return ports->port[i].tensor;
    return NULL;
}

void model_port_add(model_ports *ports, const char *name, lt_tensor *t)
{
    assert(ports->n < MODEL_PORTS);
    ports->port[ports->n++] = (model_port){ name, t };
}

lt_tensor *model_input(model_record *r, const char *name, lt_shape shape)
{
    lt_tensor *t = lt_input(r->g, name, LT_F32, shape.rank, shape.dim);

    model_port_add(&r->inputs, name, t);
    return t;
}
