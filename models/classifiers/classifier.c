/* SPDX-License-Identifier: Apache-2.0 */
#include "models/classifiers/classifier.h"

const char *const classifier_variants[] = { "full", NULL };

lt_tensor *classifier_image(model_record *r, int size)
{
    return model_input(r, "image", LT_SHAPE(r->batch, 3, size, size));
}

void classifier_record(const lt_linear_layer *fc, double dropout, lt_tensor *features, bool losses,
                       model_record *r)
{
    lt_tensor *x = lt_global_avg_pool(features);
    lt_tensor *logits = lt_linear_layer_forward(fc, dropout > 0 ? lt_dropout(x, dropout) : x);

    model_port_add(&r->outputs, "logits", lt_output(logits, "logits"));
    if (!losses)
        return;
    r->loss = lt_output(lt_mse_loss(logits, model_input(r, "target", logits->shape), NULL), "loss");
    model_port_add(&r->losses, "loss", r->loss);
}
