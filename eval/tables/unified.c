/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of the paper on the unified RGB-D estimator, as printed: Tables 4, 5, 6 and 8. */
#include "eval/tables/tables.h"

#define ALL_2 { 1, 1 }
#define ALL_4 { 1, 1, 1, 1 }

static const eval_column unified_4_columns[] = {
    { "pa_mpjpe_mm", "PA-MPJPE", 2, NULL }, { "pa_mpvpe_mm", "PA-MPVPE", 2, NULL }, { "f5_percent", "F@5", 1, NULL },
    { "f15_percent", "F@15", 1, NULL },
};
static const eval_row unified_4_rows[] = {
    { "Hasson et al.", "[16]", "", { 11.40, 11.40, 42.8, 93.2 }, ALL_4 },
    { "Hasson et al.", "[51]", "", { 11.00, 11.20, 46.4, 93.9 }, ALL_4 },
    { "Hampali et al.", "[48]", "", { 10.70, 10.60, 50.6, 94.2 }, ALL_4 },
    { "Liu et al.", "[35]", "", { 10.10, 9.70, 53.2, 95.2 }, ALL_4 },
    { "HFL-Net", "[52]", "", { 8.90, 8.70, 57.5, 96.5 }, ALL_4 },
    { "Unified", "", "", { 8.76, 8.68, 58.5, 96.9 }, ALL_4 },
};

static const eval_column unified_5_columns[] = {
    { "mpjpe_mm", "MPJPE", 2, NULL }, { "pa_mpjpe_mm", "PA-MPJPE", 2, NULL },
};
static const eval_row unified_5_rows[] = {
    { "Hasson et al.", "[16]", "RGB", { 17.60 }, { 1 } },
    { "Hasson et al.", "[51]", "RGB", { 18.80 }, { 1 } },
    { "Tse et al.", "[36]", "RGB", { 15.30 }, { 1 } },
    { "Liu et al.", "[35]", "RGB", { 15.27, 6.58 }, ALL_2 },
    { "Zhao et al.", "[37]", "RGB", { 12.70 }, { 1 } },
    { "Lin et al.", "[52]", "RGB", { 12.56, 5.47 }, ALL_2 },
    { "Hoang et al.", "[53]", "RGB-D", { 12.15, 4.54 }, ALL_2 },
    { "Unified", "", "RGB-D", { 11.70, 4.48 }, ALL_2 },
};

static const eval_column unified_6_columns[] = {
    { "adds_auc", "AUC", 2, NULL }, { "adds_below_2cm", "ADD-S<2cm", 2, NULL },
};
static const eval_row unified_6_rows[] = {
    { "Hasson et al.", "[16]", "", { 0.69, 0.65 }, ALL_2 },
    { "Hasson et al.", "[51]", "", { 0.75, 0.71 }, ALL_2 },
    { "Chen et al.", "[38]", "", { 0.72, 0.74 }, ALL_2 },
    { "Chen et al.", "[54]", "", { 0.75, 0.77 }, ALL_2 },
    { "Hoang et al.", "[53]", "", { 0.84, 0.82 }, ALL_2 },
    { "Unified", "", "", { 0.86, 0.83 }, ALL_2 },
};

static const eval_column unified_8_columns[] = {
    { "mpjpe_mm", "MPJPE", 2, NULL }, { "pa_mpjpe_mm", "PA-MPJPE", 2, NULL },
    { "adds_below_2cm", "ADD-S<2cm", 2, NULL }, { "adds_auc", "AUC", 2, NULL },
};
static const eval_row unified_8_rows[] = {
    { "without depth and fusion", "", "no_depth", { 12.60, 4.80, 0.77, 0.76 }, ALL_4 },
    { "without adaptive fusion", "", "no_aaf", { 12.20, 4.54, 0.79, 0.83 }, ALL_4 },
    { "without cross-attention", "", "no_cross_attention", { 12.10, 4.50, 0.76, 0.83 }, ALL_4 },
    { "Unified", "", "full", { 11.70, 4.48, 0.83, 0.86 }, ALL_4 },
};

const eval_table eval_unified_tables[] = {
    {
        .id = "unified-4", .title = "Unified RGB-D estimator, Table 4: hand pose",
        .data = "HO3D",
        .column = unified_4_columns, .n_columns = LT_COUNT(unified_4_columns),
        .row = unified_4_rows, .n_rows = LT_COUNT(unified_4_rows),
    },
    {
        .id = "unified-5", .title = "Unified RGB-D estimator, Table 5: hand pose",
        .data = "DexYCB", .note = "input",
        .column = unified_5_columns, .n_columns = LT_COUNT(unified_5_columns),
        .row = unified_5_rows, .n_rows = LT_COUNT(unified_5_rows),
    },
    {
        .id = "unified-6", .title = "Unified RGB-D estimator, Table 6: object pose",
        .data = "DexYCB",
        .remark = "AUC of ADD-S, 0 to 0.1 m, in the manner of the YCB-Video toolbox",
        .column = unified_6_columns, .n_columns = LT_COUNT(unified_6_columns),
        .row = unified_6_rows, .n_rows = LT_COUNT(unified_6_rows),
    },
    {
        .id = "unified-8", .title = "Unified RGB-D estimator, Table 8: ablation", .cite = "Unified, Table 8",
        .data = "DexYCB", .note = "option",
        .column = unified_8_columns, .n_columns = LT_COUNT(unified_8_columns),
        .row = unified_8_rows, .n_rows = LT_COUNT(unified_8_rows),
        .ablation = true,
    },
};
const int eval_n_unified_tables = LT_COUNT(eval_unified_tables);
