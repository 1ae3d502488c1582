/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of parts as glTF's animation of nodes: one animation, with three channels of a part that share its times. */
#include "libtensor/io/mesh/glb_internal.h"

enum { TRANSLATION, ROTATION, SCALE, PATHS };

static const struct { const char *name; int components; } paths[PATHS] = {
    [TRANSLATION] = { "translation", 3 }, [ROTATION] = { "rotation", 4 }, [SCALE] = { "scale", 3 },
};

static cJSON *animation_of(glb_builder *b)
{
    cJSON *all = cJSON_GetObjectItem(b->root, "animations"), *one;

    if (all)
        return cJSON_GetArrayItem(all, 0);
    one = glb_add_object(cJSON_AddArrayToObject(b->root, "animations"));
    cJSON_AddArrayToObject(one, "samplers");
    cJSON_AddArrayToObject(one, "channels");
    return one;
}

static void add_channel(glb_builder *b, int times, int path, uint64_t n, int node)
{
    cJSON *animation = animation_of(b), *samplers = cJSON_GetObjectItem(animation, "samplers");
    cJSON *sampler = glb_add_object(samplers);
    cJSON *channel = glb_add_object(cJSON_GetObjectItem(animation, "channels"));
    cJSON *target = cJSON_AddObjectToObject(channel, "target");

    cJSON_AddNumberToObject(sampler, "input", times);
    cJSON_AddStringToObject(sampler, "interpolation", "STEP");
    cJSON_AddNumberToObject(sampler, "output", glb_add_array(b, n, paths[path].components, GLB_FLOAT, 0));
    cJSON_AddNumberToObject(channel, "sampler", cJSON_GetArraySize(samplers) - 1);
    cJSON_AddNumberToObject(target, "node", node);
    cJSON_AddStringToObject(target, "path", paths[path].name);
}

void glb_add_motion(glb_builder *b, const lt_glb_part *p, int node)
{
    const uint64_t n = (uint64_t)p->n_keys;
    const int times = glb_add_array(b, n, 1, GLB_FLOAT, 0);
    cJSON *a = cJSON_GetArrayItem(b->accessors, times);

    cJSON_AddItemToArray(cJSON_AddArrayToObject(a, "min"), cJSON_CreateNumber((double)p->key[0].seconds));
    cJSON_AddItemToArray(cJSON_AddArrayToObject(a, "max"), cJSON_CreateNumber((double)p->key[n - 1].seconds));
    for (int path = 0; path < PATHS; path++)
        add_channel(b, times, path, n, node);
}

/* With F = diag(1, -1, -1) from our axes to glTF's: F R F, whose quaternion has the signs of F, and F t */
void glb_put_motion(FILE *f, const lt_glb_part *p)
{
    for (int i = 0; i < p->n_keys; i++)
        glb_put_float(f, p->key[i].seconds);
    for (int i = 0; i < p->n_keys; i++) {
        const float *t = p->key[i].translation;

        glb_put_float(f, t[0]);
        glb_put_float(f, -t[1]);
        glb_put_float(f, -t[2]);
    }
    for (int i = 0; i < p->n_keys; i++) {
        const float *q = p->key[i].rotation;

        glb_put_float(f, q[1]);
        glb_put_float(f, -q[2]);
        glb_put_float(f, -q[3]);
        glb_put_float(f, q[0]);
    }
    for (int i = 0; i < 3 * p->n_keys; i++)
        glb_put_float(f, p->key[i / 3].shown ? 1 : 0);
}
