/* SPDX-License-Identifier: Apache-2.0 */
/* Hand models on disk: both forms read to the same numbers; a wrong array is named. */
#include "assets/hand_file.h"
#include "libtensor/base/rng.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/pickle/pickle.h"
#include "tests/suite.h"

enum { V = LT_HAND_VERTICES, F = LT_HAND_FACES, J = LT_HAND_JOINTS, P = LT_HAND_PCA, KEYS = 8 };

/* Numbers of no meaning, in a model that is well formed. */
static lt_hand_model *make_model(void)
{
    lt_hand_model *m = calloc(1, sizeof(*m));
    lt_rng rng = lt_rng_make(7, 0);

    for (size_t i = 0; i < V * 3; i++)
        (&m->v_template[0][0])[i] = 0.02f * (float)lt_rng_normal(&rng);
    for (size_t i = 0; i < V * 3 * 10; i++)
        (&m->shapedirs[0][0][0])[i] = (float)lt_rng_normal(&rng);
    for (size_t i = 0; i < V * 3 * 135; i++)
        (&m->posedirs[0][0][0])[i] = (float)i;
    for (int v = 0; v < V; v++) {
        m->weights[v][v % J] = 0.75f;
        m->weights[v][(v + 1) % J] = 0.25f;
    }
    for (int i = 0; i < F * 3; i++)
        m->faces[i / 3][i % 3] = (int32_t)lt_rng_below(&rng, V);
    for (int i = 0; i < P; i++)
        m->hands_components[i][i] = m->hands_mean[i] = (float)i;
    m->J_regressor[0][0] = 1;
    m->v_template[0][0] = 0.1f;                         /* the wrist */
    m->v_template[lt_hand_tips_ho3d[2]][0] = -0.1f;     /* the middle finger: a right hand */
    return m;
}

static void list_arrays(const lt_hand_model *m, lt_named_array list[KEYS])
{
    const lt_named_array all[KEYS] = {
        { "v_template", lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ V, 3 }, m->v_template) },
        { "shapedirs", lt_array_make(LT_ELEM_F4, 3, (int64_t[]){ V, 3, 10 }, m->shapedirs) },
        { "posedirs", lt_array_make(LT_ELEM_F4, 3, (int64_t[]){ V, 3, 135 }, m->posedirs) },
        { "J_regressor", lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ J, V }, m->J_regressor) },
        { "weights", lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ V, J }, m->weights) },
        { "f", lt_array_make(LT_ELEM_U4, 2, (int64_t[]){ F, 3 }, m->faces) },
        { "hands_mean", lt_array_make(LT_ELEM_F4, 1, (int64_t[]){ P }, m->hands_mean) },
        { "hands_components", lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ P, P }, m->hands_components) },
    };

    memcpy(list, all, sizeof(all));
}

START_TEST(npz_form)
{
    lt_hand_model *m = make_model(), *back;
    lt_arena *arena = lt_arena_new();

    m->synthetic = _i & 1;
    m->left = _i & 2;
    if (m->left)
        m->v_template[lt_hand_tips_ho3d[2]][0] = 0.3f;
    check_ok(hand_file_write(in_folder("hand.npz"), m));
    check_ok(hand_file_read(arena, in_folder("hand.npz"), &back));
    ck_assert_mem_eq(back, m, sizeof(*m));
    lt_arena_free(arena);
    free(m);
}
END_TEST

START_TEST(pickle_form)
{
    lt_hand_model *m = make_model(), *back;
    lt_arena *arena = lt_arena_new();
    lt_named_array list[KEYS];
    lt_pwrite dict[KEYS];

    list_arrays(m, list);
    for (size_t i = 0; i < KEYS; i++)
        dict[i] = (lt_pwrite){ .key = list[i].name, .kind = LT_PW_ARRAY, .array = list[i].array };
    check_ok(lt_pickle_write_dict(in_folder("hand.pkl"), dict, KEYS));
    check_ok(hand_file_read(arena, in_folder("hand.pkl"), &back));
    ck_assert_mem_eq(back, m, sizeof(*m));
    lt_arena_free(arena);
    free(m);
}
END_TEST

/* Write the model with one array exchanged, and expect this line. */
static void check_wrong(const lt_hand_model *m, size_t which, lt_array wrong, const char *reason)
{
    lt_arena *arena = lt_arena_new();
    lt_named_array list[KEYS];
    lt_hand_model *back;

    list_arrays(m, list);
    list[which].array = wrong;
    check_ok(lt_npz_write(in_folder("wrong.npz"), list, KEYS, false));
    check_error(hand_file_read(arena, in_folder("wrong.npz"), &back), LT_EFORMAT, reason);
    lt_arena_free(arena);
}

START_TEST(wrong_arrays)
{
    lt_hand_model *m = make_model(), *other = make_model();
    lt_named_array list[KEYS];
    lt_arena *arena = lt_arena_new();
    lt_hand_model *back;

    list_arrays(other, list);
    list[0].array.shape[0] = 777;
    check_wrong(m, 0, list[0].array, "wrong.npz: \"v_template\": shape (777, 3), want (778, 3)");
    list[1].array.shape[2] = 9;
    check_wrong(m, 1, list[1].array, "\"shapedirs\": 9 directions, want at least 10");
    other->faces[3][1] = V;
    check_wrong(m, 5, list[5].array, "\"f\": vertex 778 in triangle 3");
    other->weights[5][5] = 7;
    check_wrong(m, 4, list[4].array, "\"weights\": row 5 sums to 7.25, want 1");
    other->hands_mean[2] = 1.0f / 0.0f;
    check_wrong(m, 6, list[6].array, "\"hands_mean\": element 2 is not finite");
    list_arrays(m, list);
    check_ok(lt_npz_write(in_folder("less.npz"), list, KEYS - 1, false));
    check_error(hand_file_read(arena, in_folder("less.npz"), &back), LT_EFORMAT, "no array \"hands_components\"");
    put_file(in_folder("none.pkl"), "N.", 2);
    check_error(hand_file_read(arena, in_folder("none.pkl"), &back), LT_EFORMAT, "holds no dict");
    put_file(in_folder("empty.pkl"), "}.", 2);
    check_error(hand_file_read(arena, in_folder("empty.pkl"), &back), LT_EFORMAT, "empty.pkl: no \"v_template\"");
    lt_arena_free(arena);
    free(m);
    free(other);
}
END_TEST

/* The unit that would make a hand of it is named, and the axis that it lies along. */
START_TEST(units_and_axes)
{
    static const struct {
        float factor;
        const char *reason;
    } units[] = {
        { 1000, "in millimetres? then multiply v_template, shapedirs and posedirs by 0.001" },
        { 100, "in centimetres? then multiply" }, { 1 / 0.0254f, "in inches? then multiply" },
        { 10, "spans 2, and a hand some 0.2 metres" }, { 0.001f, "spans 0.0002, and a hand some 0.2 metres" },
    };
    lt_arena *arena = lt_arena_new();
    lt_hand_model *back;

    for (size_t i = 0; i < LT_COUNT(units); i++) {
        lt_hand_model *m = make_model();

        for (int v = 0; v < V; v++)
            for (int d = 0; d < 3; d++)
                m->v_template[v][d] = units[i].factor * (d ? 0 : m->v_template[v][d] > 0 ? 0.1f : -0.1f);
        check_ok(hand_file_write(in_folder("unit.npz"), m));
        check_error(hand_file_read(arena, in_folder("unit.npz"), &back), LT_EFORMAT, units[i].reason);
        free(m);
    }
    for (int axis = 1; axis < 3; axis++) {
        lt_hand_model *m = make_model();

        for (int v = 0; v < V; v++) {
            const float x = m->v_template[v][0];

            m->v_template[v][0] = m->v_template[v][axis];
            m->v_template[v][axis] = x;
        }
        check_ok(hand_file_write(in_folder("axis.npz"), m));
        check_error(hand_file_read(arena, in_folder("axis.npz"), &back), LT_EFORMAT,
                    axis == 1 ? "points along y, and MANO's along x: axes swapped?" : "points along z");
        free(m);
    }
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, npz_form, 0, 4);
    tcase_add_test(tc, pickle_form);
    tcase_add_test(tc, wrong_arrays);
    tcase_add_test(tc, units_and_axes);
}

int main(void)
{
    return run_suite("hand_file", add_tests);
}
