/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/metric.h"

#include <string.h>

#define HO3D "HO3D's eval.py"
#define TOOLKIT "DexYCB's toolkit, hpe_eval.py"
#define HFL "HFL-Net, utils/metric.py"
#define HOISDF "HOISDF"
#define YCB_VIDEO "PoseCNN; YCB-Video toolbox"
#define SHAPE "HOGS, Table 2, as gSDF"
#define HELD "HOGS, Table 3, as HOLD"
#define IMAGE "HOGS, Table 4"
#define TOUCH "HOGS, section 4; Hasson et al. 2019"
#define COCO "pycocotools, cocoeval.py"
#define PALMAR "palmar"

static const metric dictionary[] = {
    /* hands */
    { "pa_mpjpe_mm", "PA-MPJPE", "mm", false, "joints' mean error after the best similarity, reflections allowed",
      "HO3D's scorer" },
    { "mpjpe_mm", "MPJPE", "mm", false, "joints' mean error, root on root: a hand's wrist, a body's pelvis",
      "DexYCB's toolkit" },
    { "pa_mpvpe_mm", "PA-MPVPE", "mm", false, "vertices' mean error after the best similarity, reflections allowed",
      HO3D },
    { "f5_percent", "F@5", "%", true, "F-score of vertices at 5 mm, after the best similarity", HO3D },
    { "f15_percent", "F@15", "%", true, "F-score of vertices at 15 mm, after the best similarity", HO3D },
    { "rigid_pa_mpjpe_mm", "PA-MPJPE, rigid", "mm", false,
      "joints' mean error after the best similarity without reflections", HFL },
    { "absolute_mpjpe_mm", "MPJPE, absolute", "mm", false, "joints' mean error in the camera's frame", TOOLKIT },
    { "absolute_auc", "AUC, absolute", "", true, "share of joints within 0 to 50 mm, in the camera's frame", TOOLKIT },
    { "relative_auc", "AUC, relative", "", true, "share of joints within 0 to 50 mm, wrist on wrist", TOOLKIT },
    { "pa_auc", "AUC, PA", "", true, "share of joints within 0 to 50 mm, as for PA-MPJPE", TOOLKIT },
    { "rigid_pa_auc", "AUC, rigid PA", "", true, "share of joints within 0 to 50 mm, as for rigid PA-MPJPE", HFL },

    /* hands: the lines of HO3D's scores.txt */
    { "xyz_mean3d", "joints", "cm", false, "joints' mean error in the camera's frame", HO3D },
    { "xyz_auc3d", "joints' AUC", "", true, "share of joints within 0 to 50 mm, in the camera's frame", HO3D },
    { "xyz_procrustes_al_mean3d", "joints, PA", "cm", false, "PA-MPJPE in cm", HO3D },
    { "xyz_procrustes_al_auc3d", "joints' AUC, PA", "", true, "share of joints within 0 to 50 mm, as for PA-MPJPE",
      HO3D },
    { "xyz_scale_trans_al_mean3d", "joints, scaled", "cm", false,
      "joints' mean error, wrist on wrist and one bone as long as the true one", HO3D },
    { "xyz_scale_trans_al_auc3d", "joints' AUC, scaled", "", true,
      "share of joints within 0 to 50 mm, wrist on wrist and one bone as long as the true one", HO3D },
    { "mesh_mean3d", "vertices", "cm", false, "vertices' mean error in the camera's frame", HO3D },
    { "mesh_auc3d", "vertices' AUC", "", true, "share of vertices within 0 to 50 mm, in the camera's frame", HO3D },
    { "mesh_al_mean3d", "vertices, PA", "cm", false, "PA-MPVPE in cm", HO3D },
    { "mesh_al_auc3d", "vertices' AUC, PA", "", true, "share of vertices within 0 to 50 mm, as for PA-MPVPE", HO3D },
    { "f_score_5", "F at 5 mm", "", true, "F-score of vertices at 5 mm, in the camera's frame", HO3D },
    { "f_al_score_5", "F at 5 mm, PA", "", true, "F@5 as a share", HO3D },
    { "f_score_15", "F at 15 mm", "", true, "F-score of vertices at 15 mm, in the camera's frame", HO3D },
    { "f_al_score_15", "F at 15 mm, PA", "", true, "F@15 as a share", HO3D },

    /* objects */
    { "add01_percent", "ADD-0.1D", "%", true,
      "poses whose model points are on average within a tenth of the diameter; on DexYCB symmetric objects by ADD-S",
      "Hinterstoisser et al. 2012; " HFL },
    { "add01_class_mean_percent", "ADD-0.1D, mean of classes", "%", true,
      "ADD-0.1D of each class, and their plain mean", HFL },
    { "rep5_percent", "REP-5", "%", true,
      "poses whose model points project on average within 5 pixels: of the crop, on DexYCB of the image", HFL },
    { "add_mm", "ADD", "mm", false, "mean distance of the same model point under both poses",
      "Hinterstoisser et al. 2012; HOISDF's MME" },
    { "adds_mm", "ADD-S", "mm", false, "mean distance of an estimated model point to the nearest true one", HOISDF },
    { "oce_mm", "OCE", "mm", false, "distance of the objects' centres", HOISDF },
    { "mce_mm", "MCE", "mm", false, "mean distance of the corners of the boxes along the camera's axes", HOISDF },
    { "adds_below_2cm", "ADD-S<2cm", "", true,
      "share of poses whose true model points are on average within 2 cm of the nearest estimated one", YCB_VIDEO },
    { "adds_auc", "AUC of ADD-S", "", true, "area under that share from 0 to 0.1 m", YCB_VIDEO },
    { "no_object_pose_percent", "without a pose", "%", false, "samples whose object no pose was found of", PALMAR },
    { "object_rotation_deg", "rotation", "deg", false, "angle between the object's rotations", "BOP toolkit, re" },

    /* objects: BOP's average recalls */
    { "bop_vsd", "AR of VSD", "", true, "average recall by the visible surface's discrepancy", "BOP challenge 2019" },
    { "bop_mssd", "AR of MSSD", "", true, "average recall by the largest distance of a model point",
      "BOP challenge 2019" },
    { "bop_mspd", "AR of MSPD", "", true, "average recall by the largest distance of a projected model point",
      "BOP challenge 2019" },
    { "bop_ar", "AR", "", true, "mean of the three average recalls", "BOP challenge 2019" },

    /* detections */
    { "map50_95_box", "mAP", "", true, "mean over IoU 0.50 to 0.95 and classes of the average precision of boxes",
      COCO },
    { "map50_box", "mAP50", "", true, "mean over classes of the average precision of boxes at IoU 0.50", COCO },
    { "map50_95_mask", "mAP, masks", "", true, "mAP with the masks' IoU", COCO },
    { "map50_mask", "mAP50, masks", "", true, "mAP50 with the masks' IoU", COCO },
    { "ap50_hand", "AP50, hands", "", true, "average precision of hands' boxes at IoU 0.50", COCO },
    { "ap50_small", "AP50, small", "", true, "mAP50 of objects below 32^2 pixels of a picture of 640", COCO },
    { "ap50_medium", "AP50, medium", "", true, "mAP50 of objects of 32^2 to 96^2 pixels", COCO },
    { "ap50_large", "AP50, large", "", true, "mAP50 of objects above 96^2 pixels", COCO },

    /* trackers */
    { "hota", "HOTA", "", true, "mean over IoU 0.05 to 0.95 of the geometric mean of DetA and AssA",
      "Luiten et al. 2021; TrackEval" },
    { "deta", "DetA", "", true, "found boxes over all that are found, missed or false, mean over IoU 0.05 to 0.95",
      "TrackEval" },
    { "assa", "AssA", "", true, "of each found box, frames that its two identities share over those that either is in, "
      "mean likewise", "TrackEval" },
    { "mota", "MOTA", "", true, "1 - (missed + false + switches) / boxes, at IoU 0.5",
      "Bernardin and Stiefelhagen 2008; TrackEval" },
    { "idf1", "IDF1", "", true, "F1 of boxes under the best pairing of identities, at IoU 0.5",
      "Ristani et al. 2016; TrackEval" },
    { "switches", "switches", "", false, "how often somebody is taken for another than last, at IoU 0.5",
      "TrackEval's IDSW" },
    { "switches_unlike", "switches, unlike", "", false,
      "how often an id goes over to somebody who is not the twin of who had it, at IoU 0.5", "ours" },

    /* the model */
    { "seconds_per_image", "time", "s", false, "median time of one image, from its crop to poses", "HOCAT, Table 5" },
    { "images_per_second", "FPS", "", true, "one over the time of one image", "HOCAT, Table 5" },
    { "parameters_mb", "parameters", "MB", false, "4 bytes a parameter over 2^20", "HOCAT, Table 5" },

    /* reconstruction and rendering */
    { "cd_h_cm2", "CD_h", "cm^2", false, "squared distances between the hands' surfaces, both ways",
      SHAPE },
    { "f_h_1mm", "F_h@1", "", true, "F-score of the hand's surface at 1 mm", SHAPE },
    { "f_h_5mm", "F_h@5", "", true, "F-score of the hand's surface at 5 mm", SHAPE },
    { "cd_o_cm2", "CD_o", "cm^2", false, "squared distances between the objects' surfaces, both ways",
      SHAPE },
    { "cd_o_norot_cm2", "CD_o, no rotation", "cm^2", false, "the same after translation and scale alone", "AlignSDF" },
    { "f_o_5mm", "F_o@5", "", true, "F-score of the object's surface at 5 mm", SHAPE },
    { "f_o_10mm", "F_o@10", "", true, "F-score of the object's surface at 10 mm", SHAPE },
    { "cd_o_vertices_cm2", "CD_o", "cm^2", false, "squared distances between the objects' vertices, both ways",
      HELD },
    { "f_o_10mm_percent", "F_o@10", "%", true, "F-score of the object's vertices at 10 mm", HELD },
    { "cd_pose_cm2", "CD_pose", "cm^2", false, "of the object's surface where the hand's root is the origin",
      HELD },
    { "psnr_db", "PSNR", "dB", true, "peak signal over noise of the rendered image", IMAGE },
    { "ssim", "SSIM", "", true, "structural similarity of the rendered image", IMAGE },
    { "psnr_fg_db", "PSNR, foreground", "dB", true, "PSNR of the pixels of hand and object alone", PALMAR },
    { "lpips_raw01", "LPIPS", "x1000", false,
      "perceptual distance of the rendered image, its values fed to the network as they are, in [0, 1]", IMAGE },
    { "lpips_sym", "LPIPS, in [-1, 1]", "x1000", false,
      "perceptual distance of the rendered image, its values mapped to [-1, 1] as the metric's authors do",
      "Zhang et al. 2018" },
    { "penetration_mm", "penetration", "mm", false, "how deep the hand is in the object under the scored pose, at most",
      TOUCH },
    { "intersection_cm3", "intersection", "cm^3", false, "volume that the hand and the object share", TOUCH },
    { "contact_share", "contact", "", true, "share of frames in which the hand touches the object", TOUCH },
};

enum { N = sizeof(dictionary) / sizeof(*dictionary) };

const metric *metric_find(const char *key)
{
    for (int i = 0; i < N; i++)
        if (strcmp(dictionary[i].key, key) == 0)
            return &dictionary[i];
    return NULL;
}

const metric *metric_at(int i)
{
    return i >= 0 && i < N ? &dictionary[i] : NULL;
}

bool metric_better(const metric *m, double a, double b)
{
    return m->higher ? a > b : a < b;
}
