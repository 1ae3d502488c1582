/* SPDX-License-Identifier: Apache-2.0 */
/* The 65 nodes of a body: joints, and vertices where there is none. */
#include "assets/body/body.h"

#include <string.h>

#define VERTEX(v) (BODY_JOINTS + (v))
#define DIGIT(first, tip) first, (first) + 1, (first) + 2, VERTEX(tip)

const int body_node[BODY_NODES] = {
    0, 1, 2, 4, 5, 7, 8, 12, 16, 17, 18, 19, 20, 21,
    VERTEX(5770), VERTEX(5780), VERTEX(8846), VERTEX(8463), VERTEX(8474), VERTEX(8635),         /* toes, heel */
    VERTEX(6), VERTEX(616), VERTEX(9448), VERTEX(9929), VERTEX(9120),                           /* ears, eyes, nose */
    DIGIT(37, 5361), DIGIT(25, 4933), DIGIT(28, 5058), DIGIT(34, 5169), DIGIT(31, 5286),
    DIGIT(52, 8079), DIGIT(40, 7669), DIGIT(43, 7794), DIGIT(49, 7905), DIGIT(46, 8022),
};

void body_nodes(const double *vertices, const double *joints, double out[BODY_NODES][3])
{
    for (int i = 0; i < BODY_NODES; i++) {
        const int n = body_node[i];

        memcpy(out[i], n < BODY_JOINTS ? joints + 3 * n : vertices + 3 * (n - BODY_JOINTS), sizeof(out[i]));
    }
}
