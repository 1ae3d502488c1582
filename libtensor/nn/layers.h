/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Layers: parameters with names, and the op that uses them. A layer is a small struct by value; its
 * parameters belong to the set they were registered in. Names are PyTorch's: prefix.weight, prefix.bias.
 */
#ifndef LT_NN_LAYERS_H
#define LT_NN_LAYERS_H

#include "libtensor/graph/param.h"
#include "libtensor/ops/ops.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_param *weight, *bias;        /* (O, C / groups, k, k), (O) or NULL */
    lt_conv_opts opts;
} lt_conv_layer;

/* lt_conv_layer_new - k x k; opts NULL for stride 1 without padding */
LT_API lt_conv_layer lt_conv_layer_new(lt_params *set, const char *prefix, int64_t in, int64_t out, int k,
                                       bool bias, const lt_conv_opts *opts);
LT_API lt_tensor *lt_conv_layer_forward(const lt_conv_layer *m, lt_tensor *x);

/* lt_conv_layer_on_rows - a 1 x 1 convolution without groups, on rows (..., C) -> (..., O): a linear layer */
LT_API lt_tensor *lt_conv_layer_on_rows(const lt_conv_layer *m, lt_tensor *x);

typedef struct {
    lt_param *weight, *bias;        /* (N, K), (N) or NULL */
} lt_linear_layer;

LT_API lt_linear_layer lt_linear_layer_new(lt_params *set, const char *prefix, int64_t in, int64_t out,
                                           bool bias);
LT_API lt_tensor *lt_linear_layer_forward(const lt_linear_layer *m, lt_tensor *x);

typedef struct {
    lt_param *weight, *bias, *running_mean, *running_var;
    double eps;
} lt_batch_norm_layer;

/* lt_batch_norm_layer_new - eps 1e-5, momentum 0.1 */
LT_API lt_batch_norm_layer lt_batch_norm_layer_new(lt_params *set, const char *prefix, int64_t channels);
LT_API lt_tensor *lt_batch_norm_layer_forward(const lt_batch_norm_layer *m, lt_tensor *x);

typedef struct {
    lt_param *weight, *bias;
    double eps;
} lt_layer_norm_layer;

/* lt_layer_norm_layer_new - eps 1e-5 */
LT_API lt_layer_norm_layer lt_layer_norm_layer_new(lt_params *set, const char *prefix, int64_t channels);
LT_API lt_tensor *lt_layer_norm_layer_forward(const lt_layer_norm_layer *m, lt_tensor *x);

/* Multi-head attention with projections: out(attention(q(x), k(context), v(context))), all with biases.
 * Source: Vaswani et al. 2017, section 3.2.2. */
typedef struct {
    lt_linear_layer q, k, v, out;
    int heads;
} lt_attention_layer;

LT_API lt_attention_layer lt_attention_layer_new(lt_params *set, const char *prefix, int64_t channels, int heads);

/* lt_attention_layer_forward - x (B, T, C), context (B, S, C) or NULL: x itself */
LT_API lt_tensor *lt_attention_layer_forward(const lt_attention_layer *m, lt_tensor *x, lt_tensor *context);

/* Squeeze and excitation: x times sigmoid(w2 relu(w1 mean(x))), no biases.
 * Source: Hu et al. 2018, "Squeeze-and-Excitation networks", section 3. */
typedef struct {
    lt_linear_layer fc1, fc2;
} lt_se_layer;

/* lt_se_layer_new - channels / reduction in the middle, at least one: else the set has LT_ESHAPE */
LT_API lt_se_layer lt_se_layer_new(lt_params *set, const char *prefix, int64_t channels, int reduction);
LT_API lt_tensor *lt_se_layer_forward(const lt_se_layer *m, lt_tensor *x);

/* lt_se_layer_gate - what the map is multiplied with: means (B, C) -> (B, C, 1, 1) */
LT_API lt_tensor *lt_se_layer_gate(const lt_se_layer *m, lt_tensor *means);

/* lt_map_to_tokens - (B, C, H, W) -> (B, H W, C): a transformer's rows, one for each position */
LT_API lt_tensor *lt_map_to_tokens(lt_tensor *map);

/* lt_tokens_to_map - (B, H W, C) -> (B, C, H, W) */
LT_API lt_tensor *lt_tokens_to_map(lt_tensor *tokens, int64_t H, int64_t W);

#define lt_conv_layer_forward(...) LT_HERE(lt_conv_layer_forward(__VA_ARGS__))
#define lt_conv_layer_on_rows(...) LT_HERE(lt_conv_layer_on_rows(__VA_ARGS__))
#define lt_linear_layer_forward(...) LT_HERE(lt_linear_layer_forward(__VA_ARGS__))
#define lt_batch_norm_layer_forward(...) LT_HERE(lt_batch_norm_layer_forward(__VA_ARGS__))
#define lt_layer_norm_layer_forward(...) LT_HERE(lt_layer_norm_layer_forward(__VA_ARGS__))
#define lt_attention_layer_forward(...) LT_HERE(lt_attention_layer_forward(__VA_ARGS__))
#define lt_se_layer_forward(...) LT_HERE(lt_se_layer_forward(__VA_ARGS__))
#define lt_se_layer_gate(...) LT_HERE(lt_se_layer_gate(__VA_ARGS__))
#define lt_map_to_tokens(...) LT_HERE(lt_map_to_tokens(__VA_ARGS__))
#define lt_tokens_to_map(...) LT_HERE(lt_tokens_to_map(__VA_ARGS__))

#ifdef __cplusplus
}
#endif
#endif
