/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/cpu.h"

#include <stdio.h>
#include <string.h>
#ifdef __linux__
#include <sys/syscall.h>
#include <unistd.h>
#endif

static const char *const names[] = {
    [LT_ISA_GENERIC] = "generic", [LT_ISA_AVX2] = "avx2", [LT_ISA_AVX512] = "avx512",
    [LT_ISA_AMX] = "amx",
};

#if defined(__x86_64__) || defined(__i386__)
#include <cpuid.h>

/* Register sets that the operating system saves: bits 1, 2 for SSE and AVX, 5, 6, 7 for AVX-512, 17, 18 for AMX. */
static bool os_saves(unsigned mask)
{
    unsigned a, b, c, d;

    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE))
        return false;
    __asm__ volatile("xgetbv" : "=a"(a), "=d"(d) : "c"(0));
    return (a & mask) == mask;
}

static unsigned leaf7_ebx(unsigned *ecx)
{
    unsigned a, b, c, d;

    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return *ecx = 0;
    *ecx = c;
    return b;
}

static bool has_avx2(void)
{
    const unsigned want = bit_FMA | bit_AVX | bit_F16C;
    unsigned a, b, c, d, ecx;

    return os_saves(0x6) && __get_cpuid(1, &a, &b, &c, &d) && (c & want) == want
        && (leaf7_ebx(&ecx) & bit_AVX2);
}

static bool has_avx512(void)
{
    const unsigned want = bit_AVX512F | bit_AVX512BW | bit_AVX512DQ | bit_AVX512VL;
    unsigned ecx;

    return has_avx2() && os_saves(0xe6) && (leaf7_ebx(&ecx) & want) == want;
}

#if defined(__linux__) && defined(__x86_64__)
/* Tiles are 8 KB of state for each thread, which Linux saves for processes that asked for it. Bits 17, 18 of XCR0;
 * bits 22, 24 of EDX in leaf 7: bfloat16 and tiles */
static bool has_amx(void)
{
    enum { ARCH_REQ_XCOMP_PERM = 0x1023, XFEATURE_XTILEDATA = 18 };
    const unsigned want = 1u << 22 | 1u << 24;
    unsigned a, b, c, d;

    return has_avx512() && os_saves(0x600e6) && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (d & want) == want
           && syscall(SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) == 0;
}
#else
static bool has_amx(void) { return false; }
#endif

lt_isa lt_cpu_best_isa(void)
{
    return has_amx() ? LT_ISA_AMX : has_avx512() ? LT_ISA_AVX512 : has_avx2() ? LT_ISA_AVX2 : LT_ISA_GENERIC;
}

/* AVX-VNNI: bit 4 of EAX in the second part of leaf 7 */
static bool has_avx_vnni(void)
{
    unsigned a, b, c, d;

    return has_avx2() && __get_cpuid_count(7, 0, &a, &b, &c, &d) && a >= 1 && __get_cpuid_count(7, 1, &a, &b, &c, &d)
           && (a & 1u << 4);
}

bool lt_cpu_has_vnni(lt_isa isa)
{
    unsigned ecx;

    leaf7_ebx(&ecx);
    return isa >= LT_ISA_AVX512 ? has_avx512() && (ecx & bit_AVX512VNNI) : isa == LT_ISA_AVX2 && has_avx_vnni();
}

const char *lt_cpu_model(void)
{
    static char model[49];
    unsigned regs[12];

    if (model[0])
        return model;
    for (unsigned i = 0; i < 3; i++)
        if (!__get_cpuid(0x80000002u + i, &regs[4 * i], &regs[4 * i + 1], &regs[4 * i + 2],
                         &regs[4 * i + 3]))
            return "unknown";
    memcpy(model, regs, sizeof(regs));
    return model;
}

#else

lt_isa lt_cpu_best_isa(void) { return LT_ISA_GENERIC; }
bool lt_cpu_has_vnni(lt_isa isa) { (void)isa; return false; }
const char *lt_cpu_model(void) { return "unknown"; }

#endif

#ifdef __SSE__

enum { FLUSH_TO_ZERO = 0x8000, DENORMALS_ARE_ZERO = 0x0040 };

unsigned lt_flush_denormals(void)
{
    const unsigned mode = __builtin_ia32_stmxcsr();

    __builtin_ia32_ldmxcsr(mode | FLUSH_TO_ZERO | DENORMALS_ARE_ZERO);
    return mode;
}

void lt_restore_denormals(unsigned mode)
{
    __builtin_ia32_ldmxcsr(mode);
}

#else

unsigned lt_flush_denormals(void) { return 0; }
void lt_restore_denormals(unsigned mode) { (void)mode; }

#endif

const char *lt_isa_name(lt_isa isa)
{
    return names[isa];
}

lt_status lt_isa_parse(const char *name, lt_isa *out)
{
    for (size_t i = 0; i < LT_COUNT(names); i++)
        if (strcmp(name, names[i]) == 0) {
            *out = (lt_isa)i;
            return LT_OK;
        }
    return lt_error(LT_EINVAL, "no such instruction set \"%s\"; want generic, avx2, avx512 or amx", name);
}
