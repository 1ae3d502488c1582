/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/ycb/ycb.h"

#include <string.h>

enum { P = YCB_ADDS_POSECNN, B = YCB_ADDS_BOP, H = YCB_ADDS_HFL };

/* The table is written in the millimetres and degrees of its source. */
#define MM 1e-3
#define DEG 0.017453292519943295
#define ROW(id, name, x, y, z, diameter, diag, bx, by, bz, sym, adds, yaw, width, depth) \
    { id, name, { (x) * MM, (y) * MM, (z) * MM }, { -(bx) * MM, -(by) * MM, -(bz) * MM }, \
      (diameter) * MM, (diag) * MM, YCB_SYM_##sym, adds, (yaw) * DEG, { (width) * MM, (depth) * MM } }

static const ycb_object table[YCB_COUNT] = {
    ROW(1, "002_master_chef_can", 102.3, 102.4, 140.1, 172.063, 201.1, 1.336, -0.5, 3.5105,
        CYLINDER_Z, B, 0, 102.3, 102.4),
    ROW(2, "003_cracker_box", 71.7, 164.0, 213.5, 269.573, 278.3, 0.5575, 1.7005, 4.805,
        BOX, 0, -0.5, 71.7, 163.5),
    ROW(3, "004_sugar_box", 49.5, 94.0, 176.0, 198.377, 205.4, -0.952, 1.467, 4.3645,
        BOX, 0, -2, 47.8, 93.1),
    ROW(4, "005_tomato_soup_can", 67.9, 67.8, 102.0, 120.543, 139.1, -0.024, -1.527, 8.4035,
        CYLINDER_Z, 0, 0, 67.9, 67.8),
    ROW(5, "006_mustard_bottle", 97.2, 66.6, 191.4, 196.463, 224.4, 1.2995, 2.487, -11.829,
        C2_Z, 0, -25, 95.8, 57.7),
    ROW(6, "007_tuna_fish_can", 85.5, 85.6, 33.5, 89.797, 124.8, -0.1565, 0.115, 4.2625,
        CYLINDER_Z, 0, 0, 85.5, 85.6),
    ROW(7, "008_pudding_box", 137.8, 128.8, 38.8, 142.543, 191.8, 1.1645, -4.2015, 3.119,
        BOX, 0, 27.75, 112.6, 89.5),
    ROW(8, "009_gelatin_box", 89.4, 101.1, 30.1, 114.053, 137.7, 1.446, -0.5915, 3.6085,
        BOX, 0, 13, 73.0, 88.7),
    ROW(9, "010_potted_meat_can", 102.1, 60.3, 83.6, 129.540, 144.0, 2.4195, 0.3075, 8.0715,
        BOX, 0, 2.75, 101.3, 57.0),
    ROW(10, "011_banana", 108.9, 178.4, 36.7, 197.796, 212.0, -18.673, 12.1915, -1.4635,
        NONE, 0, -24.5, 68.4, 196.8),
    ROW(11, "019_pitcher_base", 149.0, 144.8, 242.6, 259.534, 318.7, 5.337, 5.8855, 25.6115,
        NONE, 0, 0, 149.0, 144.8),
    ROW(12, "021_bleach_cleanser", 102.4, 67.7, 250.6, 259.566, 278.8, 4.929, -2.48, -13.292,
        C2_Z, 0, -0.5, 102.1, 67.6),
    ROW(13, "024_bowl", 161.4, 161.1, 55.0, 161.922, 233.1, -0.227, 0.795, -2.9675,
        CONTINUOUS_Z, P | B | H, 0, 161.4, 161.1),
    ROW(14, "025_mug", 117.0, 93.1, 81.4, 124.990, 169.3, -8.4675, -0.6995, -1.6145,
        NONE, B, 34, 117.0, 93.1),
    ROW(15, "035_power_drill", 184.2, 187.4, 57.3, 226.170, 268.4, 9.071, 20.936, -2.119,
        NONE, 0, 1.25, 184.0, 186.7),
    ROW(16, "036_wood_block", 104.0, 103.5, 205.9, 237.299, 252.5, 1.4265, -2.5305, 17.189,
        C4_Z, P | B | H, -12, 90.4, 89.1),
    ROW(17, "037_scissors", 96.1, 201.5, 15.7, 203.973, 223.5, 7.0535, -28.132, 0.042,
        NONE, 0, -30.75, 88.0, 197.1),
    ROW(18, "040_large_marker", 21.0, 120.8, 18.9, 121.365, 124.0, 0.046, -2.104, 0.35,
        CYLINDER_Y, B, 0, 21.0, 120.8),
    ROW(19, "051_large_clamp", 120.0, 171.3, 39.2, 174.746, 212.1, 10.518, -1.964, -0.4745,
        C2, P | B, 8.75, 121.1, 164.8),
    ROW(20, "052_extra_large_clamp", 209.8, 164.4, 36.3, 217.094, 268.4, -0.395, -10.413, 0.162,
        C2, P | B | H, 6.75, 201.6, 165.0),
    ROW(21, "061_foam_brick", 52.6, 77.8, 51.1, 102.903, 106.6, -0.0805, 0.0805, -8.2435,
        C2, P | B | H, -0.75, 51.8, 77.4),
};

const ycb_object *ycb_find(int id)
{
    return id >= 1 && id <= YCB_COUNT ? &table[id - 1] : NULL;
}

const ycb_object *ycb_find_name(const char *name)
{
    for (int i = 0; i < YCB_COUNT; i++)
        if (!strcmp(table[i].name, name))
            return &table[i];
    return NULL;
}
