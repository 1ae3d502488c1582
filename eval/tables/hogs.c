/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of the paper on HOGS, as printed: reconstruction, rendering and pose, Tables 2 to
 * 9. */
#include "eval/tables/tables.h"

#define ALL_3 { 1, 1, 1 }
#define ALL_6 { 1, 1, 1, 1, 1, 1 }

static const eval_column hogs_2_columns[] = {
    { "cd_h_cm2", "CD_h", 3, NULL }, { "f_h_1mm", "F_h@1", 3, NULL }, { "f_h_5mm", "F_h@5", 3, NULL },
    { "cd_o_cm2", "CD_o", 2, NULL }, { "f_o_5mm", "F_o@5", 3, NULL }, { "f_o_10mm", "F_o@10", 3, NULL },
};
static const eval_row hogs_2_rows[] = {
    { "Hasson et al.", "", "3D", { 0.537, 0.115, 0.647, 1.94, 0.383, 0.642 }, ALL_6 },
    { "Grasping Field", "", "3D", { 0.364, 0.154, 0.764, 2.06, 0.392, 0.660 }, ALL_6 },
    { "AlignSDF", "", "3D", { 0.358, 0.162, 0.767, 1.83, 0.410, 0.679 }, ALL_6 },
    { "gSDF", "", "3D", { 0.302, 0.177, 0.801, 1.55, 0.437, 0.709 }, ALL_6 },
    { "HORT", "", "3D", { 0, 0, 0, 0, 0.630, 0.850 }, { 0, 0, 0, 0, 1, 1 } },
    { "MOHO", "", "2D", { 0, 0, 0, 0, 0.600, 0.810 }, { 0, 0, 0, 0, 1, 1 } },
    { "GOF, adapted", "", "2D", { 0, 0, 0, 0.68, 0.610, 0.834 }, { 0, 0, 0, 1, 1, 1 } },
    { "HOGS", "", "2D", { 0.481, 0.133, 0.732, 0.24, 0.785, 0.918 }, ALL_6 },
};

static const char *const hogs_2_variants[] = {
    NULL, NULL, NULL, NULL, NULL, NULL, "minimum rule", "full",
};

static const eval_column hogs_3_columns[] = {
    { "cd_o_vertices_cm2", "CD_o", 1, NULL }, { "f_o_10mm_percent", "F_o@10", 1, NULL },
    { "cd_pose_cm2", "CD_pose", 1, NULL },
};
static const eval_row hogs_3_rows[] = {
    { "iHOI", "", "", { 3.8, 75.8, 41.7 }, ALL_3 },
    { "DiffHOI", "", "", { 4.3, 68.8, 43.8 }, ALL_3 },
    { "HOLD", "", "", { 0.4, 96.5, 11.3 }, ALL_3 },
    { "HOGS", "", "", { 0.7, 96.2, 2.7 }, ALL_3 },
};

static const char *const hogs_3_variants[] = { NULL, NULL, NULL, "full" };

static const eval_column hogs_4_columns[] = {
    { "psnr_db", "PSNR", 2, NULL }, { "ssim", "SSIM", 4, NULL }, { "lpips_raw01", "LPIPS", 2, NULL },
};
static const eval_row hogs_4_rows[] = {
    { "GOF, adapted", "", "", { 29.58, 0.9686, 31.69 }, ALL_3 },
    { "3DGS-Avatar, adapted", "", "", { 29.71, 0.9690, 30.52 }, ALL_3 },
    { "HOGS", "", "", { 31.12, 0.9728, 26.83 }, ALL_3 },
};

/* With our rasteriser GOF's images are those of HOGS without V-PM. */
static const char *const hogs_4_variants[] = { "no-vpm", "avatar", "full" };

static const eval_column hogs_5_columns[] = {
    { "oce_mm", "OCE", 1, NULL }, { "mce_mm", "MCE", 1, NULL }, { "adds_mm", "ADD-S", 1, NULL },
};
static const eval_row hogs_5_rows[] = {
    { "AlignSDF", "", "", { 27.0 }, { 1 } },
    { "Wang et al.", "", "", { 27.3, 32.6, 15.9 }, ALL_3 },
    { "Lin et al.", "", "", { 39.8, 45.7, 31.9 }, ALL_3 },
    { "gSDF", "", "", { 19.1 }, { 1 } },
    { "HOISDF", "", "", { 18.4, 27.4, 13.3 }, ALL_3 },
    { "HOGS", "", "", { 18.1, 26.1, 12.0 }, ALL_3 },
};
static const char *const hogs_5_variants[] = {
    NULL, NULL, NULL, NULL, "initial poses", "full",
};

static const eval_column hogs_6_columns[] = {
    { "psnr_db", "PSNR", 2, NULL }, { "ssim", "SSIM", 4, NULL }, { "lpips_raw01", "LPIPS", 2, NULL },
};
static const eval_row hogs_6_rows[] = {
    { "3DGS-Avatar", "", "no", { 29.71, 0.9690, 30.52 }, ALL_3 },
    { "3DGS-Avatar, jitter", "", "yes", { 29.48, 0.9689, 32.02 }, ALL_3 },
    { "HOGS without V-PM", "", "no", { 29.57, 0.9687, 31.75 }, ALL_3 },
    { "HOGS without V-PM, jitter", "", "yes", { 29.32, 0.9685, 33.44 }, ALL_3 },
    { "HOGS", "", "no", { 31.12, 0.9728, 26.83 }, ALL_3 },
    { "HOGS, jitter", "", "yes", { 31.00, 0.9727, 27.57 }, ALL_3 },
};
static const char *const hogs_6_variants[] = {
    "avatar", "avatar-cj", "no-vpm", "no-vpm-cj", "full", "full-cj",
};

static const eval_column hogs_7_columns[] = {
    { "psnr_db", "PSNR", 2, NULL }, { "ssim", "SSIM", 4, NULL }, { "lpips_raw01", "LPIPS", 2, NULL },
    { "oce_mm", "OCE", 2, NULL }, { "mce_mm", "MCE", 2, NULL }, { "adds_mm", "ADD-S", 2, NULL },
};
static const eval_row hogs_7_rows[] = {
    { "full", "", "0", { 31.12, 0.9728, 26.83, 17.83, 25.95, 11.87 }, ALL_6 },
    { "no contact", "", "1", { 31.09, 0.9727, 26.93, 18.10, 26.13, 11.97 }, ALL_6 },
    { "no pretrained 3D backbone", "", "2", { 31.09, 0.9726, 26.96, 18.11, 26.40, 11.88 }, ALL_6 },
    { "no G-PM", "", "3", { 31.17, 0.9721, 27.39, 18.45, 27.37, 13.31 }, ALL_6 },
    { "no adaptive appearance", "", "4", { 29.92, 0.9700, 29.95 }, { 1, 1, 1 } },
    { "no V-PM", "", "5", { 29.57, 0.9687, 31.75 }, { 1, 1, 1 } },
};
static const char *const hogs_7_variants[] = {
    "full", "no-contact", "gpm-random", "no-gpm", "no-color", "no-vpm",
};

static const eval_column hogs_8_columns[] = {
    { "psnr_db", "PSNR", 2, NULL }, { "ssim", "SSIM", 4, NULL }, { "lpips_raw01", "LPIPS", 2, NULL },
};
static const eval_row hogs_8_rows[] = {
    { "none", "", "0", { 29.57, 0.9687, 31.75 }, ALL_3 },
    { "F, G", "", "1", { 30.49, 0.9703, 29.66 }, ALL_3 },
    { "F, F(pi)", "", "2", { 30.52, 0.9704, 29.50 }, ALL_3 },
    { "F(pi), G", "", "3", { 31.08, 0.9725, 27.31 }, ALL_3 },
    { "F, F(pi), G", "", "4", { 31.12, 0.9728, 26.83 }, ALL_3 },
};
static const char *const hogs_8_variants[] = {
    "no-vpm", "vpm-fg", "vpm-fp", "vpm-pg", "full",
};

static const eval_column hogs_9_columns[] = {
    { "cd_o_cm2", "CD_o", 2, NULL }, { "f_o_5mm", "F_o@5", 3, NULL }, { "f_o_10mm", "F_o@10", 3, NULL },
};
static const eval_row hogs_9_rows[] = {
    { "Hasson et al.", "", "", { 1.94, 0.383, 0.642 }, ALL_3 },
    { "Grasping Field", "", "", { 2.06, 0.392, 0.660 }, ALL_3 },
    { "AlignSDF", "", "", { 1.83, 0.410, 0.679 }, ALL_3 },
    { "gSDF", "", "", { 1.55, 0.437, 0.709 }, ALL_3 },
    { "HOGS, no rotation", "", "", { 1.51, 0.497, 0.730 }, ALL_3 },
    { "HOGS", "", "", { 0.24, 0.785, 0.918 }, ALL_3 },
};

static const char *const hogs_9_variants[] = { NULL, NULL, NULL, NULL, "no rotation", "full" };

const eval_table eval_hogs_tables[] = {
    {
        .id = "hogs-2", .title = "HOGS, Table 2: reconstruction, 6 fps", .cite = "HOGS, Table 2",
        .data = "DexYCB", .note = "supervision",
        .column = hogs_2_columns, .n_columns = LT_COUNT(hogs_2_columns),
        .row = hogs_2_rows, .variant = hogs_2_variants, .n_rows = LT_COUNT(hogs_2_rows),
    },
    {
        .id = "hogs-3", .title = "HOGS, Table 3: held object",
        .data = "HO3D",
        .column = hogs_3_columns, .n_columns = LT_COUNT(hogs_3_columns),
        .row = hogs_3_rows, .variant = hogs_3_variants, .n_rows = LT_COUNT(hogs_3_rows),
    },
    {
        .id = "hogs-4", .title = "HOGS, Table 4: rendering", .cite = "HOGS, Table 4",
        .data = "DexYCB",
        .column = hogs_4_columns, .n_columns = LT_COUNT(hogs_4_columns),
        .row = hogs_4_rows, .variant = hogs_4_variants, .n_rows = LT_COUNT(hogs_4_rows),
    },
    {
        .id = "hogs-5", .title = "HOGS, Table 5: object pose", .cite = "HOGS, Table 5",
        .data = "DexYCB",
        .remark = "the HOGS row equals row 1 of Table 7 after rounding, not row 0",
        .column = hogs_5_columns, .n_columns = LT_COUNT(hogs_5_columns),
        .row = hogs_5_rows, .variant = hogs_5_variants, .n_rows = LT_COUNT(hogs_5_rows),
    },
    {
        .id = "hogs-6", .title = "HOGS, Table 6: colour jitter", .cite = "HOGS, Table 6",
        .data = "DexYCB", .note = "jitter",
        .column = hogs_6_columns, .n_columns = LT_COUNT(hogs_6_columns),
        .row = hogs_6_rows, .variant = hogs_6_variants, .n_rows = LT_COUNT(hogs_6_rows),
        .ablation = true,
    },
    {
        .id = "hogs-7", .title = "HOGS, Table 7: module ablation", .cite = "HOGS, Table 7",
        .data = "DexYCB", .note = "ID",
        .column = hogs_7_columns, .n_columns = LT_COUNT(hogs_7_columns),
        .row = hogs_7_rows, .variant = hogs_7_variants, .n_rows = LT_COUNT(hogs_7_rows),
        .ablation = true,
    },
    {
        .id = "hogs-8", .title = "HOGS, Table 8: inputs of V-PM", .cite = "HOGS, Table 8",
        .data = "DexYCB", .note = "ID",
        .column = hogs_8_columns, .n_columns = LT_COUNT(hogs_8_columns),
        .row = hogs_8_rows, .variant = hogs_8_variants, .n_rows = LT_COUNT(hogs_8_rows),
        .ablation = true,
    },
    {
        .id = "hogs-9", .title = "HOGS, Table 9: object alignment",
        .data = "DexYCB",
        .column = hogs_9_columns, .n_columns = LT_COUNT(hogs_9_columns),
        .row = hogs_9_rows, .variant = hogs_9_variants, .n_rows = LT_COUNT(hogs_9_rows),
        .ablation = true,
    },
};
const int eval_n_hogs_tables = LT_COUNT(eval_hogs_tables);
