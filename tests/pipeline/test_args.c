/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes, cameras and object names as people type them. */
#include "pipeline/calibration/calibration.h"
#include "pipeline/predict.h"
#include "tests/suite.h"

#include <string.h>

START_TEST(boxes)
{
    static const char *const bad[] = {
        "", "1", "1,2,3", "1,2,3,", "1,2,3,4,5", "1,2,3,4x", "a,2,3,4", "1;2;3;4", "30,2,3,4", "1,9,3,4",
        "1,2,1,4", "nan,2,3,4", "1,2,inf,4", "1,2,1e9,4", ",,,", "1,,3,4",
    };
    crop_box b = { 0 };

    ck_assert_int_eq(predict_parse_box("--hand-box", "10,20.5,110,220", &b), LT_OK);
    ck_assert_float_eq(b.x0, 10);
    ck_assert_float_eq(b.y0, 20.5f);
    ck_assert_float_eq(b.x1, 110);
    ck_assert_float_eq(b.y1, 220);
    ck_assert_int_eq(predict_parse_box("--hand-box", "-5,-6,7,8", &b), LT_OK);
    for (size_t i = 0; i < LT_COUNT(bad); i++) {
        ck_assert_int_eq(predict_parse_box("--hand-box", bad[i], &b), LT_EUSAGE);
        ck_assert(strstr(lt_last_error(), "--hand-box"));
        ck_assert_float_eq(b.x0, -5);
    }
}
END_TEST

START_TEST(cameras)
{
    calibration c;

    ck_assert_int_eq(calibration_read("--K", "614.6,614.1,320,240", &c), LT_OK);
    ck_assert_double_eq(c.camera.fx, 614.6);
    ck_assert_double_eq(c.camera.fy, 614.1);
    ck_assert_double_eq(c.camera.cx, 320);
    ck_assert_double_eq(c.camera.cy, 240);
    ck_assert_int_eq(calibration_read("--K", "0.96,1.28,0.5,0.5", &c), LT_EUSAGE);
    ck_assert_str_eq(lt_last_error(), "--K 0.96,1.28,0.5,0.5: focal lengths must be at least 1 pixel; the order is "
                                      "fx,fy,cx,cy");
    ck_assert_int_eq(calibration_read("--K", "614,614,320", &c), LT_EUSAGE);
}
END_TEST

START_TEST(formats)
{
    predict_format f;

    ck_assert_int_eq(predict_parse_format("--mesh", "obj", &f), LT_OK);
    ck_assert_int_eq(f, PREDICT_OBJ);
    ck_assert_int_eq(predict_parse_format("--mesh", "glb", &f), LT_OK);
    ck_assert_int_eq(f, PREDICT_GLB);
    ck_assert_int_eq(predict_parse_format("--mesh", "GLB", &f), LT_EUSAGE);
    ck_assert_str_eq(lt_last_error(), "--mesh GLB: want obj, ply or glb");
}
END_TEST

START_TEST(objects)
{
    static const char *const same[] = { "006_mustard_bottle", "syn_006_mustard_bottle", "mustard_bottle" };
    const ycb_object *o;

    for (size_t i = 0; i < LT_COUNT(same); i++) {
        ck_assert_int_eq(predict_find_object(same[i], &o), LT_OK);
        ck_assert_str_eq(o->name, "006_mustard_bottle");
    }
    ck_assert_int_eq(predict_find_object("mustrad_bottle", &o), LT_EUSAGE);
    ck_assert(strstr(lt_last_error(), "did you mean \"mustard_bottle\"?"));
    ck_assert_int_eq(predict_find_object("spaceship", &o), LT_EUSAGE);
    ck_assert(strstr(lt_last_error(), "cracker_box"));
    ck_assert(strstr(lt_last_error(), "foam_brick"));
    ck_assert_int_eq(predict_find_object("", &o), LT_EUSAGE);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, boxes);
    tcase_add_test(t, cameras);
    tcase_add_test(t, formats);
    tcase_add_test(t, objects);
}

int main(void)
{
    return run_suite("predict_args", add_tests);
}
