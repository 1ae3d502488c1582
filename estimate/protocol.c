/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/protocol.h"

#include <string.h>

/* A hand-object model that is used otherwise than the first is a row here. */
static const protocol protocols[] = {
    { "hocat", HAND_OBJECT_BOXES, POSE_OPENCV },            /* HOCAT, 3.4; HFL-Net's and Semi-Hand-Object's code */
    { "unified", HAND_OBJECT_UNION, POSE_REFINED },         /* Bandi and Thomas 2025, sections 3 and 4 */
};

const protocol *protocol_of(const model *m)
{
    for (size_t i = 0; i < LT_COUNT(protocols); i++)
        if (strcmp(protocols[i].model, m->cls->name) == 0)
            return &protocols[i];
    return &protocols[0];
}
