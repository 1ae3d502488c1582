/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Initial values of parameters. The draws of a parameter depend on the seed and on its name, not on the
 * order in which a model is put together.
 */
#ifndef LT_NN_INIT_H
#define LT_NN_INIT_H

#include "libtensor/graph/param.h"

#ifdef __cplusplus
extern "C" {
#endif

LT_API void lt_init_constant(lt_param *p, double value);
LT_API void lt_init_uniform(lt_param *p, uint64_t seed, double bound);     /* [-bound, bound) */
LT_API void lt_init_normal(lt_param *p, uint64_t seed, double deviation);

/* lt_init_xavier - uniform in +- gain sqrt(6 / (fan in + fan out)). Source: Glorot and Bengio 2010. */
LT_API void lt_init_xavier(lt_param *p, uint64_t seed, double gain);

/* lt_fan_in, lt_fan_out - inputs and outputs of one unit of a weight (O, I, kh, kw) or (O, I) */
LT_API double lt_fan_in(const lt_param *p);
LT_API double lt_fan_out(const lt_param *p);

/**
 * lt_init_default - PyTorch's defaults for every parameter of the set
 *
 * Weights of two dimensions and more, and the biases beside them: uniform in +-1 / sqrt(fan_in). Other
 * weights 1 and biases 0 (norms). running_var 1, running_mean 0. Everything else is left as it is.
 */
LT_API void lt_init_default(lt_params *set, uint64_t seed);

#ifdef __cplusplus
}
#endif
#endif
