/* SPDX-License-Identifier: Apache-2.0 */
/* All models, by name. A new one is its header here and its line. */
#include "libtensor/io/text/nearest.h"
#include "models/action/action.h"
#include "models/body/osx.h"
#include "models/classifiers/classifier.h"
#include "models/detect/csp_seg.h"
#include "models/hocat/hocat.h"
#include "models/hogs/gpm_model.h"
#include "models/hogs/hogs.h"
#include "models/model.h"
#include "models/parts/parts.h"
#include "models/points/points.h"
#include "models/reid/reid.h"
#include "models/splats/splats.h"
#include "models/unified/unified.h"

#include <string.h>

const model_class *const model_classes[] = {
    &hocat_class, &unified_class, &hogs_class, &csp_seg_class, &reid_class, &action_class, &osx_class, &resnet50_class,
    &efficientnet_b0_class, &vit_class, &lpips_class, &pointnet2_class, &gpm_class, &points_class, &splats_class,
    NULL,
};

lt_status model_find(const char *name, const model_class **out)
{
    const char *names[16];
    size_t n = 0;

    for (; model_classes[n]; n++) {
        names[n] = model_classes[n]->name;
        if (strcmp(names[n], name) == 0) {
            *out = model_classes[n];
            return LT_OK;
        }
    }
    return lt_unknown_name(name, names, n, "palmar help info names them", "no such model \"%s\"", name);
}
