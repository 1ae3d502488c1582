/* SPDX-License-Identifier: Apache-2.0 */
#include <config.h>

#include "libtensor/kernels/isa.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

static lt_kernels chosen;
static pthread_once_t once = PTHREAD_ONCE_INIT;
static lt_status init_status;
static char init_error[256];

const lt_kernels *lt_k = &chosen;

static lt_isa best_isa(void)
{
#if defined(LT_DOUBLE)
    return LT_ISA_GENERIC;
#elif defined(HAVE_AMX)
    return lt_cpu_best_isa();
#elif defined(HAVE_AVX512)
    return lt_cpu_best_isa() > LT_ISA_AVX512 ? LT_ISA_AVX512 : lt_cpu_best_isa();
#elif defined(HAVE_AVX2)
    return lt_cpu_best_isa() == LT_ISA_GENERIC ? LT_ISA_GENERIC : LT_ISA_AVX2;
#else
    return LT_ISA_GENERIC;
#endif
}

/* add_avx2 and the like: all units of one instruction set, and what VNNI does better */
#define ADD_UNITS(name, id)                                                                         \
    static void add_##name(lt_kernels *k)                                                           \
    {                                                                                               \
        lt_##name##_add_elements(k);                                                                \
        lt_##name##_add_attention(k);                                                               \
        lt_##name##_add_products(k);                                                                \
        lt_##name##_add_bytes(k);                                                                   \
        lt_##name##_add_depthwise(k);                                                               \
        lt_##name##_add_winograd(k);                                                                \
        lt_##name##_add_splat(k);                                                                   \
        if (lt_cpu_has_vnni(id))                                                                    \
            lt_##name##_add_vnni(k);                                                                \
        k->isa = id;                                                                                \
    }
ADD_UNITS(generic, LT_ISA_GENERIC)
#if defined(HAVE_AVX2) && !defined(LT_DOUBLE)
ADD_UNITS(avx2, LT_ISA_AVX2)
#endif
#if defined(HAVE_AVX512) && !defined(LT_DOUBLE)
ADD_UNITS(avx512, LT_ISA_AVX512)
#endif

lt_status lt_kernels_get(lt_isa isa, lt_kernels *k)
{
    if (isa > best_isa())
        return lt_error(LT_EINVAL, "no %s kernels: this CPU and this build have %s at best",
                        lt_isa_name(isa), lt_isa_name(best_isa()));
    *k = (lt_kernels){ 0 };
    add_generic(k);
#if defined(HAVE_AVX2) && !defined(LT_DOUBLE)
    if (isa >= LT_ISA_AVX2)
        add_avx2(k);
#endif
#if defined(HAVE_AVX512) && !defined(LT_DOUBLE)
    if (isa >= LT_ISA_AVX512)
        add_avx512(k);
#endif
#if defined(HAVE_AMX) && !defined(LT_DOUBLE)
    if (isa >= LT_ISA_AMX)
        lt_kernels_add_amx(k);
#endif
    return LT_OK;
}

void lt_kernels_without_vnni(lt_kernels *k)
{
    (void)k;
#if defined(HAVE_AVX2) && !defined(LT_DOUBLE)
    if (k->isa == LT_ISA_AVX2)
        lt_avx2_add_bytes(k);
#endif
#if defined(HAVE_AVX512) && !defined(LT_DOUBLE)
    if (k->isa >= LT_ISA_AVX512)
        lt_avx512_add_bytes(k);
#endif
}

/* The double build has generic kernels alone, so there PALMAR_ISA asks for nothing. */
static lt_status choose(void)
{
#ifndef LT_DOUBLE
    const char *name = getenv("PALMAR_ISA");
    lt_isa isa;

    if (name && *name) {
        if (lt_isa_parse(name, &isa) || lt_kernels_get(isa, &chosen))
            return lt_error_prefix(LT_EINVAL, "PALMAR_ISA");
        return LT_OK;
    }
#endif
    return lt_kernels_get(best_isa(), &chosen);
}

static void init(void)
{
    init_status = choose();
    if (init_status)
        snprintf(init_error, sizeof(init_error), "%s", lt_last_error());
}

lt_status lt_kernels_init(void)
{
    pthread_once(&once, init);
    return init_status ? lt_error(init_status, "%s", init_error) : LT_OK;
}

/* So that lt_k is never without a table, even where nobody has called lt_kernels_init. */
__attribute__((constructor)) static void start_generic(void)
{
    add_generic(&chosen);
}

void lt_kernels_use(const lt_kernels *k)
{
    lt_k = k ? k : &chosen;
}
