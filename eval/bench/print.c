/* SPDX-License-Identifier: Apache-2.0 */
/* What was measured as text and JSON, and the profile by op and by layer. */
#include "eval/bench/internal.h"

#include "libtensor/base/parallel.h"
#include "libtensor/io/text/json.h"

#include <stdlib.h>

static const char *mode(const bench *b)
{
    return b->o.train ? "train" : b->o.int8 || b->o.m->int8 ? "infer int8" : "infer";
}

/* A training step is the forward products, and about twice as many backward. */
static double gflops(const bench *b, const bench_result *r)
{
    return (b->o.train ? 3 : 1) * 2e-6 * (double)r->macs / r->median_ms;
}

void bench_print(const bench *b, const bench_result *r, FILE *f, bool heading)
{
    const int digits = r->median_ms < 10 ? 4 : 2;

    if (heading)
        fprintf(f, "| model | variant | mode | batch | threads | isa | median ms | p5 | p95 | min | runs | "
                "GFLOP/s | FMA peak | peak MB |\n|---|---|---|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    fprintf(f, "| %s | %s | %s | %d | %d | %s | %.*f | %.*f | %.*f | %.*f | %d | %.0f | %.0f .. %.0f | %.0f |\n",
            b->o.m->cls->name, b->o.m->variant, mode(b), b->o.batch, lt_threads(), lt_isa_name(b->o.kernels->isa),
            digits, r->median_ms, digits, r->p5_ms, digits, r->p95_ms, digits, r->min_ms, r->runs, gflops(b, r),
            r->fma_before, r->fma_after, r->peak_rss_mb);
    if (r->post_ms > 0)
        fprintf(f, "\n%s: %.3f ms more\n", r->post, r->post_ms);
}

static void print_number(FILE *f, const char *name, double value)
{
    char text[LT_JSON_NUMBER];

    fprintf(f, ", \"%s\": %s", name, lt_json_number(value, text));
}

void bench_print_json(const bench *b, const bench_result *r, FILE *f)
{
    fprintf(f, "{\"model\": \"%s\", \"variant\": \"%s\", \"mode\": \"%s\", \"isa\": \"%s\", \"cpu\": ",
            b->o.m->cls->name, b->o.m->variant, mode(b), lt_isa_name(b->o.kernels->isa));
    lt_json_print_string(f, lt_cpu_model());
    print_number(f, "batch", b->o.batch);
    print_number(f, "threads", lt_threads());
    print_number(f, "median_ms", r->median_ms);
    print_number(f, "p5_ms", r->p5_ms);
    print_number(f, "p95_ms", r->p95_ms);
    print_number(f, "min_ms", r->min_ms);
    print_number(f, "runs", r->runs);
    print_number(f, "peak_rss_mb", r->peak_rss_mb);
    print_number(f, "plan_mb", (double)r->plan_bytes / 1048576);
    print_number(f, "gmacs", 1e-9 * (double)r->macs);
    print_number(f, "fma_gflops", r->fma_before < r->fma_after ? r->fma_before : r->fma_after);
    print_number(f, "fma_gflops_before", r->fma_before);
    print_number(f, "fma_gflops_after", r->fma_after);
    if (r->post_ms > 0) {
        print_number(f, "post_ms", r->post_ms);
        print_number(f, "with_post_ms", r->median_ms + r->post_ms);
    }
    if (b->draws) {
        print_number(f, "instances", b->instances);
        fprintf(f, ", \"crc32\": \"%08x\"", (unsigned)b->image_crc32);
    }
    fprintf(f, "}\n");
}

void bench_print_ratio(const bench *a, const bench *b, const bench_result r[2], FILE *f, bool json)
{
    const double medians = r[1].median_ms / r[0].median_ms, minima = r[1].min_ms / r[0].min_ms;
    const char *ours = lt_isa_name(a->o.kernels->isa), *other = lt_isa_name(b->o.kernels->isa);

    if (json) {
        fprintf(f, "{\"compare\": \"%s\", \"with\": \"%s\"", ours, other);
        print_number(f, "ratio_of_medians", medians);
        print_number(f, "ratio_of_minima", minima);
        fprintf(f, "}\n");
    } else {
        fprintf(f, "\n%s is %.2f times as fast as %s by the lowest medians of %d alternated rounds, %.2f by the "
                "minima\n", ours, medians, other, BENCH_ROUNDS, minima);
    }
}

void bench_print_layers(const bench *b, FILE *f)
{
    if (b->arena)
        calibration_print(&b->layers, f);
}

/* ---- the profile -------------------------------------------------------------------------------------- */

enum { MAX_GROUPS = 256, SLOWEST = 20, PROFILED = 5 };   /* runs that a profile averages */

typedef struct {
    lt_step_info first;             /* op and phase */
    double seconds;
    int64_t macs;
    int count;
} group;

static group *group_of(group *list, int *n, const lt_step_info *s)
{
    for (int i = 0; i < *n; i++)
        if (list[i].first.op == s->op && list[i].first.phase == s->phase)
            return &list[i];
    if (*n == MAX_GROUPS)
        return &list[MAX_GROUPS - 1];
    list[*n] = (group){ .first = *s };
    return &list[(*n)++];
}

static int slower(double a, double b)
{
    return (a < b) - (a > b);
}

static int slower_group(const void *a, const void *b)
{
    return slower(((const group *)a)->seconds, ((const group *)b)->seconds);
}

static int slower_step(const void *a, const void *b)
{
    return slower(((const lt_step_info *)a)->seconds, ((const lt_step_info *)b)->seconds);
}

static void print_line(FILE *f, const char *name, double seconds, int64_t macs, double total, double peak)
{
    const double rate = seconds > 0 ? 2e-9 * (double)macs / seconds : 0;

    fprintf(f, "  %-52s %9.3f ms %5.1f %%", name, 1e3 * seconds, total > 0 ? 100 * seconds / total : 0);
    if (macs)
        fprintf(f, " %7.1f GFLOP/s %5.1f %% of peak", rate, 100 * rate / peak);
    fputc('\n', f);
}

static void print_groups(FILE *f, const lt_step_info *step, int n, double total, double peak)
{
    static group list[MAX_GROUPS];
    int n_groups = 0;
    char name[128];

    for (int i = 0; i < n; i++) {
        group *g = group_of(list, &n_groups, &step[i]);

        g->seconds += step[i].seconds;
        g->macs += step[i].macs;
        g->count++;
    }
    qsort(list, (size_t)n_groups, sizeof(*list), slower_group);
    for (int i = 0; i < n_groups; i++) {
        snprintf(name, sizeof(name), "%s %s x%d", list[i].first.phase, list[i].first.op, list[i].count);
        print_line(f, name, list[i].seconds, list[i].macs, total, peak);
    }
}

static void print_slowest(FILE *f, lt_step_info *step, int n, double total, double peak)
{
    char name[256], shape[LT_SHAPE_TEXT];

    qsort(step, (size_t)n, sizeof(*step), slower_step);
    for (int i = 0; i < n && i < SLOWEST; i++) {
        snprintf(name, sizeof(name), "%s %s %s %s %s", step[i].phase, step[i].op, step[i].layer,
                 lt_shape_text(&step[i].shape, shape), step[i].algorithm);
        print_line(f, name, step[i].seconds, step[i].macs, total, peak);
    }
}

void bench_profile(bench *b, FILE *f)
{
    const int n = lt_plan_steps(b->plan);
    lt_step_info *step = lt_alloc((size_t)n * sizeof(*step));
    const double peak = lt_fma_peak_gflops(BENCH_PEAK_MS);
    double total = 0;

    if (!step)
        return;
    lt_plan_profile(b->plan, true);
    for (int i = 0; i < PROFILED; i++)
        bench_run_once(b);
    for (int i = 0; i < n; i++) {
        step[i] = lt_plan_step(b->plan, i);
        step[i].seconds /= PROFILED;
        total += step[i].seconds;
    }
    lt_plan_profile(b->plan, false);
    fprintf(f, "by op (%.1f ms in all, FMA peak %.0f GFLOP/s)\n", 1e3 * total, peak);
    print_groups(f, step, n, total, peak);
    fprintf(f, "slowest layers\n");
    print_slowest(f, step, n, total, peak);
    lt_release(step);
}
