/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras in the files that calibration programs write, and in those that are none. */
#include "pipeline/calibration/calibration.h"
#include "tests/io/hostile.h"

#define OPENCV "%YAML:1.0\n---\ncalibration_time: \"Tue\"\nimage_width: 640\nimage_height: 480\n" \
    "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n" \
    "   data: [ 6.06e+02, 0., 316., 0., 6.07e+02,\n       232., 0., 0., 1. ]\n" \
    "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n" \
    "   data: [ -2.8e-01, 7.0e-02, 1.0e-03, -2.0e-03, 3.0e-02 ]\navg_reprojection_error: 1.9e-01\n"
#define ROS "image_width: 640\nimage_height: 480\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n" \
    "  data: [606.0, 0.0, 316.0, 0.0, 607.0, 232.0, 0.0, 0.0, 1.0]\ndistortion_model: plumb_bob\n" \
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.28, 0.07, 0.001, -0.002, 0.03]\n" \
    "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [1, 0, 2, 0, 0, 3, 4, 0, 0, 0, 1, 0]\n"

/* Which of the lens and the size there are; fx is 606, fy 607, cx 316, cy 232 in all. */
static const struct { const char *text; bool lens, size; } files[] = {
    { "606 607 316 232\n", false, false }, { "606,607,316,232", false, false },
    { "6.06e+02 0.0 3.16e+02\n0.0 6.07e+02 2.32e+02\n0.0 0.0 1.0\n", false, false },
    { "# K by rows\n[[606.   0. 316.]\n [  0. 607. 232.]\n [  0.   0.   1.]]\n", false, false },
    { "606, 0, 316; 0, 607, 232; 0, 0, 1", false, false },
    { "606 0 0\n0 607 0\n316 232 1\n", false, false },                         /* MATLAB's */
    { "1212 0 632\n0 1214 464\n0 0 2\n", false, false },                       /* a scale means nothing */
    { "606 0 316 0\n0 607 232 0\n0 0 1 0\n", false, false },
    { "606 0 316 0\n0 607 232 0\n0 0 1 0\n0 0 0 1\n", false, false },
    { OPENCV, true, true }, { ROS, true, true },
    { "{\"fx\": 606, \"fy\": 607, \"cx\": 316, \"cy\": 232, \"width\": 640, \"height\": 480}", false, true },
    { "{\"cam_K\": [606, 0, 316, 0, 607, 232, 0, 0, 1], \"depth_scale\": 1.0}", false, false },
    { "{\"0\": {\"cam_K\": [606, 0, 316, 0, 607, 232, 0, 0, 1]},\n\t\"1\": {\"cam_K\": [606,0,316,0,607,232,0,0,1]}}",
      false, false },
    { "{\"K\": [[606, 0, 316], [0, 607, 232], [0, 0, 1]],\n \"dist\": [[-0.28, 0.07, 0.001, -0.002, 0.03]]}", true,
      false },
    { "{\"width\": 640, \"height\": 480, \"intrinsic_matrix\": [606, 0, 0, 0, 607, 0, 316, 232, 1]}", false, true },
    { "{\"fl_x\":606,\"fl_y\":607,\"cx\":316,\"cy\":232,\"w\":640,\"h\":480,\"k1\":-0.28,\"k2\":0.07,\"p1\":0.001,"
      "\"p2\":-0.002,\"k3\":0.03,\"camera_model\":\"OPENCV\"}", true, true },
    { "cam0:\n  camera_model: pinhole\n  intrinsics: [606, 607, 316, 232]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.28, 0.07, 0.001, -0.002, 0.03]\n  resolution: [640, 480]\n", true, true },
    { "color:\n  fx: 606\n  fy: 607\n  ppx: 316\n  ppy: 232\ndepth:\n  fx: 300\n  fy: 300\n  ppx: 100\n  ppy: 100\n",
      false, false },
    { "{\"color\": {\"width\": 640, \"height\": 480, \"intrinsics\": {\"fx\": 606, \"fy\": 607, \"ppx\": 316,"
      " \"ppy\": 232, \"model\": \"distortion.inverse_brown_conrady\", \"coeffs\": [0, 0, 0, 0, 0]}}}", false, true },
    { "cameraMatrix: [[606, 0, 316], [0, 607, 232], [0, 0, 1]]\ndistCoeffs: [-0.28, 0.07, 0.001, -0.002, 0.03]\n", true,
      false },
    { "Camera-Matrix:\n- [606, 0, 316]\n- [0, 607, 232]\n- [0, 0, 1]\n", false, false },
};

static lt_status parse(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    uint8_t *copy = lt_arena_alloc(arena, n + 1);
    calibration c;

    memcpy(copy, bytes, n);
    return calibration_parse(arena, "K.yml", copy, n, &c);
}

START_TEST(read)
{
    static const double lens[5] = { -0.28, 0.07, 0.001, -0.002, 0.03 };
    double found[LT_LENS_COEFFICIENTS];
    calibration c;

    put_file(in_folder("K.yml"), files[_i].text, strlen(files[_i].text));
    check_ok(calibration_read("--K", in_folder("K.yml"), &c));
    ck_assert_double_eq(c.camera.fx, 606);
    ck_assert_double_eq(c.camera.fy, 607);
    ck_assert_double_eq(c.camera.cx, 316);
    ck_assert_double_eq(c.camera.cy, 232);
    ck_assert_int_eq(c.width, files[_i].size ? 640 : 0);
    ck_assert_int_eq(c.height, files[_i].size ? 480 : 0);
    ck_assert(lt_lens_is_none(&c.lens) == !files[_i].lens);
    lt_lens_to_opencv(&c.lens, found);
    for (int i = 0; i < 5 && files[_i].lens; i++)
        ck_assert_double_eq(found[i], lens[i]);
    ck_assert_double_eq(c.skew, 0);
}
END_TEST

START_TEST(options)
{
    calibration c;
    lt_lens lens;

    check_ok(calibration_read("--K", "606,1.5,316,0,607,232,0,0,1", &c));
    ck_assert(c.camera.fy == 607 && c.camera.cx == 316 && c.skew == 1.5);
    check_error(calibration_read("--K", "606,316,232", &c), LT_EUSAGE, "--K 606,316,232: 3 numbers; want fx,fy,cx,cy");
    check_error(calibration_read("--K", "-606,606,316,232", &c), LT_EUSAGE, "must be at least 1 pixel");
    check_error(calibration_read("--K", "none.yml", &c), LT_EUSAGE, "--K none.yml: no numbers, and no such file");
    check_error(calibration_read("--K", scratch_folder, &c), LT_EIO, scratch_folder);
    check_ok(calibration_parse_lens("--distortion", "-0.28,0.07,0.001,-0.002,0.03", &lens));
    ck_assert(lens.k[0] == -0.28 && lens.p[1] == -0.002 && lens.k[2] == 0.03);
    check_error(calibration_parse_lens("--distortion", "1,2,3", &lens), LT_EUSAGE, "--distortion 1,2,3: 3 coefficie");
    check_error(calibration_parse_lens("--distortion", "a", &lens), LT_EUSAGE, "--distortion a: want k1,k2,p1,p2");
}
END_TEST

START_TEST(wrong)
{
    static const struct { const char *text, *reason; } cases[] = {
        { "", "K.yml: an empty file, want a camera's numbers" }, { "# none\n", "K.yml: 0 numbers" },
        { "606 607 316 232 0", "K.yml: 5 numbers" }, { "hello", "K.yml: want fx,fy,cx,cy" },
        { "606 0 316\n0 607 232\n0.1 0 1\n", "no camera matrix" }, { "606 nan 316 232", "K.yml: want" },
        { "606 0 316 9\n0 607 232 0\n0 0 1 0\n", "12 numbers, a projection" },
        { "<?xml version=\"1.0\"?>\n<opencv_storage>", "K.yml: XML, want JSON or YAML" },
        { "a: 1\nb: [1, 2]\n", "K.yml: no camera; want fx, fy, cx and cy" }, { "{\"fx\": 606, ", "K.yml:" },
        { "cam0:\n  intrinsics: [606, 607, 316, 232]\ncam1:\n  intrinsics: [600, 600, 316, 232]\n",
          "K.yml:2: several cameras, another in line 4" },
        { "K: [606, 0, 316, 0, 607, 232, 0, 0, 1]\ndistortion_model: equidistant\nD: [0.1, 0, 0, 0]\n",
          "K.yml:2: a lens of the model equidistant" },
        { "K: [606, 0, 316, 0, 607, 232, 0, 0, 1]\nD: [0.1, 0, 0]\n", "K.yml:1: 3 coefficients" },
        { "fx: 0.8\nfy: 0.8\ncx: 0.5\ncy: 0.5\n", "K.yml:1: focal lengths must be at least 1 pixel" },
        { "\x89PNG\r\n\x1a\n", "K.yml: a PNG image, want a camera's numbers" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(parse, cases[i].text, strlen(cases[i].text), cases[i].reason);
    check_refused(parse, "1\0 2 3 4", 8, "K.yml: not a camera's numbers, JSON or YAML");
}
END_TEST

START_TEST(damaged)
{
    for (size_t i = 0; i < LT_COUNT(files); i++) {
        check_flipped(parse, (const uint8_t *)files[i].text, strlen(files[i].text), 500);
        for (size_t n = 0; n < strlen(files[i].text); n++)
            attempt(parse, (const uint8_t *)files[i].text, n);
    }
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_unchecked_fixture(t, make_scratch_folder, remove_scratch_folder);
    tcase_set_timeout(t, 60);
    tcase_add_loop_test(t, read, 0, LT_COUNT(files));
    tcase_add_test(t, options);
    tcase_add_test(t, wrong);
    tcase_add_test(t, damaged);
}

int main(void)
{
    return run_suite("calibration", add_tests);
}
