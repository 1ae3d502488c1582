/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What this CPU can do, and which of it we use.
 */
#ifndef LT_BASE_CPU_H
#define LT_BASE_CPU_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LT_ISA_GENERIC,                 /* plain C */
    LT_ISA_AVX2,                    /* AVX2, FMA, F16C */
    LT_ISA_AVX512,                  /* AVX-512 F, BW, DQ, VL as well */
    LT_ISA_AMX,                     /* AMX's tiles of bfloat16 as well */
} lt_isa;

/* lt_cpu_best_isa - the widest that both CPUID and the operating system allow (XGETBV; Linux is asked for AMX) */
LT_API lt_isa lt_cpu_best_isa(void);

/* lt_cpu_has_vnni - 8-bit dot products on top of LT_ISA_AVX512 and more, or of LT_ISA_AVX2 (AVX-VNNI) */
LT_API bool lt_cpu_has_vnni(lt_isa isa);

/* lt_isa_name, lt_isa_parse - "generic", "avx2", "avx512", "amx" */
LT_API const char *lt_isa_name(lt_isa isa);
LT_API lt_status lt_isa_parse(const char *name, lt_isa *out);

/**
 * lt_flush_denormals - make this thread take subnormal numbers for zero, in and out; returns the old mode
 *
 * They cost up to a hundred times an ordinary operation, and near-zero maps and Adam's v are full of
 * them. lt_restore_denormals puts the old mode back. lt_parallel_for does both around every task, so
 * a task has the same bits on any thread. Does nothing but on x86.
 */
LT_API unsigned lt_flush_denormals(void);
LT_API void lt_restore_denormals(unsigned mode);

/* lt_cpu_model - the CPU's own name, "unknown" where there is none to be had */
LT_API const char *lt_cpu_model(void);

#ifdef __cplusplus
}
#endif
#endif
