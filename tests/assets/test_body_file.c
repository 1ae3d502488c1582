/* SPDX-License-Identifier: Apache-2.0 */
/* SMPL-X's arrays out of a .npz, with everything about them that can be wrong; left hands of MANO. */
#include "assets/body_file.h"
#include "assets/hand_file.h"
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"

#include <math.h>

enum { V = BODY_VERTICES, F = BODY_FACES, J = BODY_JOINTS, KEYS = 11 };

/* A body of the right shapes: zeros, but for what is checked. */
static void list_arrays(int directions, lt_named_array list[KEYS])
{
    static const char *const names[KEYS] = {
        "v_template", "shapedirs", "posedirs", "J_regressor", "weights", "f", "kintree_table", "hands_componentsl",
        "hands_componentsr", "hands_meanl", "hands_meanr",
    };
    const int64_t shapes[KEYS][3] = {
        { V, 3 }, { V, 3, directions }, { V, 3, BODY_FEATURES }, { J, V }, { V, J }, { F, 3 }, { 2, J }, { 45, 45 },
        { 45, 45 }, { 45 }, { 45 },
    };
    static const int ranks[KEYS] = { 2, 3, 3, 2, 2, 2, 2, 2, 2, 1, 1 };

    for (int i = 0; i < KEYS; i++) {
        lt_array a = lt_array_make(LT_ELEM_F4, ranks[i], shapes[i], NULL);

        a.data = calloc(lt_array_count(&a), sizeof(float));
        list[i] = (lt_named_array){ names[i], a };
    }
    for (int v = 0; v < V; v++)
        ((float *)list[4].array.data)[v * J] = 1;
    ((float *)list[0].array.data)[4] = 0.5f;
    ((float *)list[1].array.data)[directions - 1] = 0.25f;
    ((float *)list[5].array.data)[3 * F - 1] = V - 1;
    ((float *)list[6].array.data)[0] = 4294967296.0f;               /* the root: an unsigned -1 */
    for (int j = 1; j < J; j++)
        ((float *)list[6].array.data)[j] = (float)(j / 2);
    ((float *)list[10].array.data)[44] = 3;
}

static void free_arrays(lt_named_array list[KEYS])
{
    for (int i = 0; i < KEYS; i++)
        free(list[i].array.data);
}

START_TEST(body)
{
    const int directions = _i ? 400 : 20;
    lt_arena *arena = lt_arena_new();
    lt_named_array list[KEYS];
    body_model *m;

    list_arrays(directions, list);
    check_ok(lt_npz_write(in_folder("b.npz"), list, KEYS, true));
    check_ok(body_file_read(arena, in_folder("b.npz"), &m));
    ck_assert_int_eq(m->shapes, _i ? 300 : 10);
    ck_assert_int_eq(m->expressions, _i ? 100 : 10);
    ck_assert(m->v_template[1][1] == 0.5f && m->shapedirs[directions - 1] == 0.25f);
    ck_assert(m->faces[F - 1][2] == V - 1 && m->parent[0] == -1 && m->parent[54] == 27 && m->hand_mean[1][44] == 3);
    free_arrays(list);
    lt_arena_free(arena);
}
END_TEST

START_TEST(wrong)
{
    static const struct {
        int key;
        size_t at;
        float value;
        const char *reason;
    } cases[] = {
        { 0, 7, INFINITY, "\"v_template\": element 7 is not finite" },
        { 4, 0, 0.5f, "\"weights\": row 0 sums to 0.5, want 1" },
        { 5, 0, V, "\"f\": vertex 10475 in triangle 0, want 0 to 10474" },
        { 6, 3, 3, "\"kintree_table\": joint 3 hangs on 3, want one before it" },
    };
    lt_arena *arena = lt_arena_new();
    lt_named_array list[KEYS];
    body_model *m;

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        list_arrays(20, list);
        ((float *)list[cases[i].key].array.data)[cases[i].at] = cases[i].value;
        check_ok(lt_npz_write(in_folder("b.npz"), list, KEYS, true));
        check_error(body_file_read(arena, in_folder("b.npz"), &m), LT_EFORMAT, cases[i].reason);
        free_arrays(list);
    }
    list_arrays(50, list);
    check_ok(lt_npz_write(in_folder("b.npz"), list, KEYS, true));
    check_error(body_file_read(arena, in_folder("b.npz"), &m), LT_EFORMAT, "50 directions, want 20");
    check_ok(lt_npz_write(in_folder("b.npz"), list + 1, 1, true));
    check_error(body_file_read(arena, in_folder("b.npz"), &m), LT_EFORMAT, "50 directions");
    list[1].name = "shapes";
    check_ok(lt_npz_write(in_folder("b.npz"), list, KEYS, true));
    check_error(body_file_read(arena, in_folder("b.npz"), &m), LT_EFORMAT, "no array \"shapedirs\"");
    check_error(body_file_read(arena, in_folder("none.npz"), &m), LT_EIO, "No such file");
    free_arrays(list);
    lt_arena_free(arena);
}
END_TEST

/* The rule of the three conventions: data.md 3.3 */
START_TEST(left_shape)
{
    lt_hand_model *right = calloc(1, sizeof(*right)), *left = calloc(1, sizeof(*left));

    right->shapedirs[5][0][1] = 2;
    right->shapedirs[5][1][1] = 3;
    memcpy(left, right, sizeof(*left));
    left->left = true;
    ck_assert(hand_left_is_flipped(left, right));
    hand_left_shape(left, HAND_LEFT_AS_IS);
    ck_assert(left->shapedirs[5][0][1] == 2);
    hand_left_shape(left, HAND_LEFT_FIX_X);
    ck_assert(left->shapedirs[5][0][1] == -2 && left->shapedirs[5][1][1] == 3);
    ck_assert(!hand_left_is_flipped(left, right));
    hand_left_shape(left, HAND_LEFT_NEGATE_ALL);
    ck_assert(left->shapedirs[5][0][1] == 2 && left->shapedirs[5][1][1] == -3);
    ck_assert(!hand_left_is_flipped(right, right));
    free(right);
    free(left);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, body, 0, 2);
    tcase_add_test(tc, wrong);
    tcase_add_test(tc, left_shape);
}

int main(void)
{
    return run_suite("body_file", add_tests);
}
