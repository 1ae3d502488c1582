/* SPDX-License-Identifier: Apache-2.0 */
/* What fuzzing starts from: the test vectors, which our scripts made, and small files of every kind. */
#include "tests/fuzz/fuzz.h"

#include "tests/estimate/class_names_vectors.h"
#include "tests/io/io_vectors.h"
#include "tests/io/picture_vectors.h"
#include "tests/io/ply_vectors.h"
#include "tests/io/resaved_vectors.h"
#include "tests/io/torch_vectors.h"

#include <string.h>

#define BYTES(target, name) { target, #name, name, sizeof(name) }

static const struct {
    const char *target, *name;
    const uint8_t *bytes;
    size_t n;
} vectors[] = {
    BYTES("pickle", pickle_0), BYTES("pickle", pickle_1), BYTES("pickle", pickle_2), BYTES("pickle", pickle_3),
    BYTES("pickle", pickle_4), BYTES("pickle", pickle_5), BYTES("pickle", pickle_expressions),
    BYTES("pickle", pickle_evil_0), BYTES("pickle", pickle_evil_2), BYTES("pickle", pickle_evil_4),
    BYTES("pickle", pickle_loop), BYTES("pickle", pickle_objects),
    BYTES("pickle", resaved_pickle),
    BYTES("npz", npz_deflated), BYTES("npz", npz_stored), BYTES("npz", resaved_npz),
    BYTES("npy", npy_fortran), BYTES("npy", npy_v2), BYTES("npy", npy_v3), BYTES("npy", npy_complex),
    BYTES("npy", npy_struct),
    BYTES("png", png_gray), BYTES("png", png_deep), BYTES("png", png_bits), BYTES("png", png_rgb),
    BYTES("png", png_palette), BYTES("png", png_gray_alpha), BYTES("png", bmp_rgb),
    BYTES("jpeg", jpeg_gray), BYTES("jpeg", jpeg_cmyk), BYTES("jpeg", jpeg_progressive),
    BYTES("jpeg", jpeg_progressive_rgb),
    BYTES("exif", exif_png), BYTES("exif", exif_webp), BYTES("exif", exif_dslr), BYTES("exif", exif_compact),
    BYTES("film_head", film_turned), BYTES("film_head", film_turned_mkv),
    BYTES("torch", torch_zip), BYTES("torch", torch_stream), BYTES("torch", torch_wrapped),
    BYTES("torch", torch_module), BYTES("torch", torch_module_stream), BYTES("torch", torch_tar),
    BYTES("torch", torch_other_order), BYTES("torch", torch_bomb), BYTES("torch", torch_sparse),
    BYTES("torch", torch_complex), BYTES("torch", torch_script), BYTES("torch", names_by_number),
    BYTES("torch", names_in_order),
    BYTES("ply", ply_ascii), BYTES("ply", ply_little), BYTES("ply", ply_big), BYTES("ply", ply_splats),
    { "rle", "mask", (const uint8_t *)mask_rle, sizeof(mask_rle) - 1 }, BYTES("rle", mask_40x50),
    BYTES("hand_file", npz_deflated), BYTES("hand_file", pickle_expressions), BYTES("hand_file", pickle_4),
    BYTES("hand_file", resaved_npz), BYTES("hand_file", resaved_npy), BYTES("hand_file", torch_zip),
};

#define NINE "0,1,-1,.5,0,0,0,0,0,"
#define TEN "0,1,-1,.5,0,0,0,0,0,0,"
#define TEXT(target, name, text) { target, name, text, sizeof(text) - 1 }

static const struct {
    const char *target, *name, *text;
    size_t n;
} texts[] = {
    TEXT("safetensors", "two", "\x78\0\0\0\0\0\0\0{\"t\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]},"
         "\"__metadata__\":{\"format\":\"pt\"},\"h\":{\"dtype\":\"BF16\",\"shape\":[1,2],\"data_offsets\":[8,12]}}"
         "\0\0\xc0\x3f\0\0\0\xc0\x80\x3f\x20\xc0"),
    TEXT("safetensors", "one", "\x38\0\0\0\0\0\0\0{\"t\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}  "
         "\0\0\xc0\x3f\0\0\0\xc0"),
    TEXT("safetensors", "eight", "\x38\0\0\0\0\0\0\0{\"t\":{\"dtype\":\"F8\",\"shape\":[2],\"data_offsets\":[0,2]}}   "
         "12"),
    /* opset 17; a graph with a constant, an input and a Relu of it */
    TEXT("onnx", "relu", "\x08\x08\x42\4\x0a\0\x10\x11\x3a\x4c\x0a\x0c\x0a\1x\x12\1y\"\4Relu\x12\1g"
         "*\x12\x08\2\x10\1\"\x08\0\0\x80\x3f\0\0\0\x40\x42\1wZ\x13\x0a\1x\x12\x0e\x0a\x0c\x08\1\x12\x08\x0a\2\x08\1"
         "\x0a\2\x08\2" "b\x0f\x0a\1y\x12\x0a\x0a\x08\x08\1\x12\4\x0a\2\x08\1"),
    TEXT("json", "words", "{\"NaN\": [1, NaN, \"NaN, -Infinity\", -2,-Infinity,Infinity, NaN], \"b\": -0.5}"),
    TEXT("json", "kinds", "{\"name\": \"r\\u00e9s\\n\", \"list\": [1, -2.5e3, true, null], \"in\": {\"x\": {}}}"),
    TEXT("yaml", "meta", "# of a sequence\nextrinsics: '20200702_151821'\nmano_calib:\n- 20200514-subject-01\n"
         "mano_sides:\n- right\nnum_frames: 72\nycb_ids: [2, 8, 15]\n"),
    TEXT("yaml", "intrinsics", "color:\n  fx: 613.0\n  fy: 611.9\n  ppx: 3.1e2\n  ppy: 245\n---\nx: !!python/tuple "
         "[1]\n"),
    TEXT("exif", "little", "\xff\xd8\xff\xe1\0\x40" "Exif\0\0II\x2a\0\x08\0\0\0\2\0\x12\1\3\0\1\0\0\0\6\0\0\0"
         "\x69\x87\4\0\1\0\0\0\x26\0\0\0\0\0\0\0\1\0\5\xa4\3\0\1\0\0\0\x1c\0\0\0\0\0\0\0\xff\xda\0\x08\1\1\0\0\x3f\0"),
    TEXT("exif", "big", "\xff\xd8\xff\xe0\0\4JF\xff\xe1\0\x22" "Exif\0\0MM\0\x2a\0\0\0\x08\0\1\xa4\5\0\3\0\0\0\1"
         "\0\x32\0\0\0\0\0\0"),
    TEXT("obj", "square", "# a square\nmtllib box.mtl\no thing\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 1 1 0\r\nv 0 1 \\\n "
         "0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/3/1 4/4/1\nf -4/1/1 -3/2/1 -2/4/-1\n"),
    TEXT("obj", "colours", "v 0 0 0 1 0 0\nv 1 0 0 .5 0 1\nv 1 1 0 1 1 1\nf 1//1 2//1 3//1\nvn 0 0 1\ns off\n"),
    TEXT("mtl", "two", "newmtl other\nmap_Kd no.png\nnewmtl skin\nKd 1 1 1\nmap_Kd -s 1 1 skin.png \r\n"),
    TEXT("bop", "two", "scene_id,im_id,obj_id,score,R,t,time\n3,4,5,0.5,1 0 0 0 1 0 0 0 1,-0.1 2e-1 .75,-1\n"
         "1,72,21,-1,0 -1 0 1 0 0 0 0 1,9 9 9,0.04 \r\n\n"),
    TEXT("bop", "blanks", "\xef\xbb\xbf\n 3 , 4,5, 0.5 ,1  0 0\t0 1 0 0 0 nan , -0.1 2e-1  1e154, -1\r\n"),
    TEXT("hpe", "two", "7,-12.5,3e1,.25,0,1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,"
         "9,0,1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,9\n\n0,0,1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,9,0,"
         "1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,9,0,1,2,3,4,5,6,7,8,9,0,1,2 \r\n"),
    TEXT("points", "pred", "[[[[0.1, -2e-3, 5], [1, 2, 3]], [[0, 0, 0.5], [0.5, 1E2, -7]]],\n"
         " [[[4, 5, 6]], [[7, 8, 9]]]]\n"),
    TEXT("points", "empty", "[[], []]"),
    TEXT("points", "alone", "[[[0.1, -2e-3, 5], [1, 2, 3]], [[0, 0, 0.5], [0.5, NaN, -Infinity]]]"),
    TEXT("points", "other", "[[[[1, 2, 3], [4, 5, 6]]], [[[7, 8, 9], [7, 8, 9], [7, 8, 9]]]]"),
    TEXT("points", "null", "[[[[1, 2, 3], [4, 5, 6]]], null]"),
    TEXT("models_info", "two", "{\"1\": {\"diameter\": 172, "
         "\"symmetries_discrete\": [[1,0,0,0, 0,-1,0,4, 0,0,-1,6, 0,0,0,1]], "
         "\"symmetries_continuous\": [{\"axis\": [0,0,2], \"offset\": [1,2,0]}]}, "
         "\"21\": {\"diameter\": 102.9, \"min_x\": -26}}"),
    TEXT("coco", "three", "{\"images\": [{\"id\": 7, \"file_name\": \"b.png\", \"width\": 4, \"height\": 3}], "
         "\"categories\": [{\"id\": 2, \"name\": \"hand\"}], \"annotations\": [{\"image_id\": 7, \"category_id\": 2, "
         "\"bbox\": [1, 0, 2, 2], \"segmentation\": [[1, 0, 3, 0, 3, 2]]}, {\"image_id\": 7, \"category_id\": 2, "
         "\"bbox\": [0, 0, 4, 3], \"iscrowd\": 1, \"segmentation\": {\"size\": [3, 4], \"counts\": [4, 3, 5]}}, "
         "{\"image_id\": 7, \"category_id\": 2, \"bbox\": [0, 0, 4, 3], \"segmentation\": "
         "{\"size\": [3, 4], \"counts\": \"435\"}}]}"),
    TEXT("labels", "two", "1 0.5 0.5 .4 5e-1\n0 0.1 0.125 0.5 0.125 0.5 0.625 0.1 0.625\r\n"),
    TEXT("results", "two", "[{\"image_id\": 7, \"category_id\": 5, \"bbox\": [1, 0, 2, 2], \"score\": 0.5, "
         "\"segmentation\": {\"size\": [3, 4], \"counts\": \"435\"}}, {\"image_id\": 9, \"category_id\": 1, "
         "\"bbox\": [0, 0, 1, 1], \"score\": 1e-3}]"),
    TEXT("action_labels", "three", "{\"names\": [\"a\", \"b\", 3], \"labels\": [0, 9, 2], \"subject\": [0, 1, 12], "
         "\"classes\": [\"waving\", \"walking\"], \"onset\": [-1, 0, 3], \"frames\": [90, 1, 60]}"),
    TEXT("mot", "truth", "1,3,426,78,39,94,1,1,0.9619\n20, 7, 1.5, -2e1, 53, 127, 0, 12, 0 \r\n\n"),
    TEXT("mot", "old", "\xef\xbb\xbf" "2,1,1,2,3,4,1,-4.5,2,-1\n"),
    TEXT("mot", "detections", "1,-1,1359.1,413.27,120.26,362.77,2.3092,-1,-1,-1\n3,-1,5,6,7,8,.25\n"),
    TEXT("looks", "twins", "person,split,shape,clothes,left_hand,right_hand\n1,train,1,1,1,2\r\n31,train,31,7,61,62\n"),
    TEXT("seqinfo", "sequence", "[Sequence]\nname=a\nimDir=../b/img1\nframeRate=29.97\nseqLength = 300\r\nimWidth=512\n"
         "imHeight=288\nimExt=.png\n"),
    TEXT("recording", "frames", "{\"camera\":0,\"t\":0.25,\"colour\":\"a/1.jpg\",\"depth\":\"a/1.z16\"}\n"
         "{\"camera\":1,\"t\":-4e-3,\"colour\":\"b/1.jpg\"}\n"),
    TEXT("recording", "sets", "{\"frames\":[null,null]}\n{\"frames\":[0,1]}\n"),
    TEXT("recording", "rig", "{\"schema\": \"palmar.recording/1\", \"fps\": 30, \"robot\": [0, 1, 0, 0.5], "
         "\"cameras\": [{\"name\": \"a\", \"role\": \"front\", \"width\": 640, \"height\": 480, \"K\": [606, 607, 316, "
         "232], \"depth_scale\": 0.001, \"R_world_cam\": [1, 0, 0, 0, 1, 0, 0, 0, 1], \"t_world_cam\": [0, 1, 2]}]}"),
    TEXT("session", "set", "{\"schema\": \"palmar.set/1\", \"set\": 3, \"t\": [0.4, null], \"pair_ms\": 5.1, "
         "\"age_ms\": 61.2, \"dropped\": [0, 1], \"stages_ms\": {\"S1\": 20, \"S9\": 0.5}, \"tracks\": [{\"id\": 3, "
         "\"class\": \"hand\", \"camera\": 0, \"track\": 5, \"box\": [1, 2, 3, 4], \"score\": 0.9, \"centre\": null}], "
         "\"objects\": [{\"id\": 4, \"class\": \"025_mug\", \"R\": [1,0,0,0,1,0,0,0,1], \"t\": [0,0,1], \"state\": "
         "\"coast\"}], \"contact\": [{\"hand\": 3, \"object\": 4, \"camera\": 0, \"since\": 0.33}], \"action\": "
         "{\"person\": 1, \"class\": \"waving\", \"p\": 0.8}, \"interaction\": [{\"person\": 1, \"state\": \"hold\", "
         "\"object\": 4, \"side\": \"right\"}]}"),
    TEXT("session", "sum", "{\"summary\": 1, \"captured\": 9, \"taken\": 8, \"dropped\": 1, \"fps\": 2.5, \"age_ms\": "
         "{\"p50\": 60, \"p95\": 90}, \"rss_mb\": {\"first\": 100, \"last\": 101}, \"crc32\": \"0badcafe\"}"),
    TEXT("boxes", "two", "image,hand_x0,hand_y0,hand_x1,hand_y1,object_x0,object_y0,object_x1,object_y1,side\n"
         "a.png,1,2,30,4e1,,,,,left\n\"b, c\",10,20,30,40,-11,12,13,14, \r\n"),
    TEXT("boxes", "order", "\xef\xbb\xbfscore,hand_y1,hand_x1,hand_y0,hand_x0,image\n.9,4,3,2,1,f.mp4#12\n\n"
         ",,,,,f-000013"),
    TEXT("calibration", "matrix", "# K\n[[606., 0, 316], [0, 6.07e+02, 232], [0 0 1]]\n"),
    TEXT("calibration", "opencv", "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
         "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
         "   data: [ 606., 0., 316., 0., 607., 232., 0., 0., 1. ]\n"
         "distortion_coefficients: !!opencv-matrix\n   data: [ -.28, .07, .001, -.002, .03 ]\n"),
    TEXT("calibration", "json", "{\"cam0\": {\"intrinsics\": [606, 607, 316, 232], \"distortion_model\": \"radtan\", "
         "\"resolution\": [640, 480], \"k1\": 0.1}, "
         "\"color\": {\"fx\": 606, \"fy\": 607, \"ppx\": 316, \"ppy\": 232}}"),
    TEXT("poses", "poses", "{\"frames\": {\"A/0\": {\"hand\": {\"side\": \"right\", \"pose\": [" TEN TEN TEN TEN
         "1,2,3,4,5,6,7,-8e-1], \"shape\": [" NINE ".5], \"trans\": [0,0,600]}, \"object\": {\"id\": 5, "
         "\"R\": [0,0,0,1], \"t\": [0,0,600]}, \"score\": 1}}, \"format\": \"palmar.poses/1\", \"unit\": \"mm\", "
         "\"rotation\": \"quaternion-xyzw\", \"hand_pose\": \"pca45\", \"axes\": \"opengl\", "
         "\"flat_hand_mean\": false}"),
    TEXT("poses", "matrix", "{\"format\": \"palmar.poses/1\", \"rotation\": \"matrix\", \"frames\": {"
         "\"A/0\": {\"object\": {\"R\": [0,-1,0,1,0,0,0,0,1], \"t\": [0,0,1]}}}}"),
    TEXT("poses", "frames", "{\"schema\": \"palmar.frame/1\", \"image\": \"a.jpg\", \"hands\": [{\"side\": \"right\", "
         "\"position\": \"solved\", \"trusted\": true, \"agreement_px\": 3, \"joints3d_m\": [[0,0,1]], "
         "\"theta_rad\": [" TEN TEN TEN TEN "1,2,3,4,5,6,7,8], \"beta\": [" NINE ".5]}], "
         "\"objects\": [{\"name\": \"025_mug\", "
         "\"found\": true, \"confidence\": 2, \"R\": [1,0,0,0,1,0,0,0,1], \"t_m\": [0,0,1]}]}\n"
         "{\"schema\": \"palmar.frame/1\", \"image\": \"b.jpg\"}\n"),
    TEXT("poses", "hoisdf", "{\"x/rgb/0.jpg\": {\"mano_pose6d\": [" TEN TEN TEN TEN "1,2,3,4,5,6,7,8], "
         "\"mano_shape\": [[" NINE ".5]], \"obj_rot\": [0,0,1], \"obj_trans\": [[0,0,1]], \"obj_center_cam\": [0,0,1], "
         "\"label_file\": \"y\"}}"),
    TEXT("xyz", "two", "# points\n0.1 -2e-3 5\n\n1 2 3 255 0 0\n"),
};

void fuzz_seeds(fuzz_put_fn *put)
{
    for (size_t i = 0; i < sizeof(vectors) / sizeof(vectors[0]); i++)
        put(vectors[i].target, vectors[i].name, vectors[i].bytes, vectors[i].n);
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); i++)
        put(texts[i].target, texts[i].name, (const uint8_t *)texts[i].text, texts[i].n);
}
