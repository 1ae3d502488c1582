/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Holds every kernel against plain loops and against generic C, on each instruction set that this CPU
 * has. `checkasm --bench` times them instead.
 */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

enum { GUARD = 64 };            /* words on each side; keeps the alignment of the array */
static const uint32_t guard_word = 0x7fc0dead;

static int failures;
static const char *stage = "";

static void fail(const char *name, const char *fmt, ...) LT_PRINTF(2, 3);
static void fail(const char *name, const char *fmt, ...)
{
    va_list args;

    if (++failures > 20)
        return;
    printf("FAIL %s: %s: ", stage, name);
    va_start(args, fmt);
    vprintf(fmt, args);
    va_end(args);
    printf("\n");
}

/* ---- arrays ----------------------------------------------------------------------------------------- */

static void set_words(float *a, size_t n)
{
    for (size_t i = 0; i < n; i++)
        memcpy(a + i, &guard_word, sizeof(guard_word));
}

static bool words_hold(const float *a, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (memcmp(a + i, &guard_word, sizeof(guard_word)) != 0)
            return false;
    return true;
}

/* The first guard word's place is taken by the size. */
float *guarded_array(size_t n)
{
    float *base = lt_alloc((n + 2 * GUARD) * sizeof(float));

    if (!base) {
        printf("no memory\n");
        exit(99);
    }
    set_words(base, n + 2 * GUARD);
    memcpy(base, &n, sizeof(n));
    return base + GUARD;
}

void free_array(float *a)
{
    size_t n;

    memcpy(&n, a - GUARD, sizeof(n));
    if (!words_hold(a - GUARD + 2, GUARD - 2) || !words_hold(a + n, GUARD))
        fail("guard words", "written over around an array of %zu", n);
    lt_release(a - GUARD);
}

float *random_array(size_t n, uint64_t stream)
{
    float *a = guarded_array(n);
    lt_rng r = lt_rng_make(20, stream);

    for (size_t i = 0; i < n; i++)
        a[i] = (float)lt_rng_range(&r, -1, 1);
    return a;
}

float *zero_array(size_t n)
{
    float *a = guarded_array(n);

    memset(a, 0, n * sizeof(float));
    return a;
}

/* ---- comparing ---------------------------------------------------------------------------------------- */

static bool same_bits(float a, float b)
{
    return memcmp(&a, &b, sizeof(a)) == 0 || (a != a && b != b);
}

void expect_bits(const float *got, const float *want, size_t n, const char *fmt, ...)
{
    char name[256];
    va_list args;

    va_start(args, fmt);
    vsnprintf(name, sizeof(name), fmt, args);
    va_end(args);
    for (size_t i = 0; i < n; i++)
        if (!same_bits(got[i], want[i])) {
            fail(name, "[%zu of %zu] is %.9g, want %.9g", i, n, (double)got[i], (double)want[i]);
            return;
        }
}

void expect_near(double got, double want, double bound, const char *what, const char *name, size_t i)
{
    if (!(fabs(got - want) <= bound))
        fail(what, "%s: [%zu] is %.9g, want %.9g within %.2g", name, i, got, want, bound);
}

typedef struct { uint64_t name, bits; } record;
static record records[4096];
static size_t n_records;

static uint64_t hash(const void *data, size_t bytes)
{
    const unsigned char *p = data;
    uint64_t h = 14695981039346656037u;

    for (size_t i = 0; i < bytes; i++)
        h = (h ^ p[i]) * 1099511628211u;
    return h;
}

void same_as_before(const float *got, size_t n, const char *fmt, ...)
{
    char name[256];
    va_list args;

    va_start(args, fmt);
    vsnprintf(name, sizeof(name), fmt, args);
    va_end(args);
    const record r = { hash(name, strlen(name)), hash(got, n * sizeof(float)) };

    for (size_t i = 0; i < n_records; i++)
        if (records[i].name == r.name) {
            if (records[i].bits != r.bits)
                fail(name, "other bits than the first time");
            return;
        }
    if (n_records < LT_COUNT(records))
        records[n_records++] = r;
}

/* ---- all instruction sets --------------------------------------------------------------------------------- */

static void check_products(bool plainly)
{
    check_gemms(plainly);
    check_convs(plainly);
    check_blocks(plainly);
    check_int8(plainly);
}

static void check_products_on_tiles(bool plainly)
{
    check_convs_on_tiles(plainly);
    check_blocks(plainly);
    check_tiles(plainly);
}

static void check_threads(const char *isa, void (*check)(bool plainly))
{
    char name[64];

    for (int threads = 1; threads <= 4; threads++) {
        snprintf(name, sizeof(name), "%s, %d threads", isa, threads);
        stage = name;
        lt_set_threads(threads);
        check(threads == 1);
    }
    stage = "";
}

/* The same products of bytes where the CPU could do them faster. */
static void check_without_vnni(lt_kernels *k)
{
    if (!lt_cpu_has_vnni(k->isa))
        return;
    lt_kernels_without_vnni(k);
    stage = "without VNNI";
    check_int8(true);
    printf("%-8s checked without VNNI\n", lt_isa_name(k->isa));
}

static void check_all_others(lt_kernels *k, const lt_kernels *generic)
{
    check_entries(k, generic);
    check_samples(k, generic);
    check_points(k, generic);
    check_skin(k, generic);
    check_splat(k, generic);
    check_accuracy(k);
    check_threads(lt_isa_name(k->isa), check_products);
    check_without_vnni(k);
}

static void check_isa(lt_isa isa, const lt_kernels *generic)
{
    static lt_kernels k;

    if (lt_kernels_get(isa, &k)) {
        printf("%-8s not run: %s\n", lt_isa_name(isa), lt_last_error());
        return;
    }
    lt_kernels_use(&k);
    stage = lt_isa_name(isa);
    check_attention(&k, generic);
    if (isa == LT_ISA_AMX)          /* whose other entries are those of AVX-512 */
        check_threads(lt_isa_name(isa), check_products_on_tiles);
    else
        check_all_others(&k, generic);
    printf("%-8s checked\n", lt_isa_name(isa));
    lt_kernels_use(NULL);
}

int main(int argc, char **argv)
{
    static lt_kernels generic;

    if (lt_kernels_init()) {
        printf("%s\n", lt_last_error());
        return 1;
    }
    if (argc > 1 && strcmp(argv[1], "--bench") == 0) {
        bench();
        return 0;
    }
    lt_kernels_get(LT_ISA_GENERIC, &generic);
    for (int isa = LT_ISA_GENERIC; isa <= LT_ISA_AMX; isa++)
        check_isa((lt_isa)isa, &generic);
    printf("%d failures\n", failures);
    return failures != 0;
}
