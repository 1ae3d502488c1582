/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Binary glTF: a JSON chunk that describes, and a binary chunk with one block for each array, in the order in
 * which the description names them.
 */
#include "libtensor/io/mesh/glb_internal.h"

#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_JSON = 0x4e4f534a, CHUNK_BIN = 0x004e4942 };

/* ---- the description ------------------------------------------------------------------------------ */

cJSON *glb_add_object(cJSON *list)
{
    cJSON *o = cJSON_CreateObject();

    cJSON_AddItemToArray(list, o);
    return o;
}

int glb_add_array(glb_builder *b, uint64_t count, int components, int type, int target)
{
    static const char *const kinds[] = { NULL, "SCALAR", "VEC2", "VEC3", "VEC4" };
    cJSON *view = glb_add_object(b->views), *accessor = glb_add_object(b->accessors);
    const uint64_t bytes = 4 * count * (uint64_t)components;

    cJSON_AddNumberToObject(view, "buffer", 0);
    cJSON_AddNumberToObject(view, "byteOffset", (double)b->bytes);
    cJSON_AddNumberToObject(view, "byteLength", (double)bytes);
    if (target)
        cJSON_AddNumberToObject(view, "target", target);
    cJSON_AddNumberToObject(accessor, "bufferView", cJSON_GetArraySize(b->views) - 1);
    cJSON_AddNumberToObject(accessor, "componentType", type);
    cJSON_AddNumberToObject(accessor, "count", (double)count);
    cJSON_AddStringToObject(accessor, "type", kinds[components]);
    b->bytes += bytes;
    return cJSON_GetArraySize(b->accessors) - 1;
}

static const float ours_to_gltf[3] = { 1, -1, -1 };

/* glTF wants the bounds of positions. */
static void add_bounds(const glb_builder *b, int accessor, const lt_mesh *m)
{
    cJSON *a = cJSON_GetArrayItem(b->accessors, accessor), *min = cJSON_AddArrayToObject(a, "min");
    cJSON *max = cJSON_AddArrayToObject(a, "max");

    for (int k = 0; k < 3; k++) {
        float lo = INFINITY, hi = -INFINITY;

        for (int i = 0; i < m->n_vertices; i++) {
            lo = fminf(lo, ours_to_gltf[k] * m->vertex[i][k]);
            hi = fmaxf(hi, ours_to_gltf[k] * m->vertex[i][k]);
        }
        cJSON_AddItemToArray(min, cJSON_CreateNumber((double)lo));
        cJSON_AddItemToArray(max, cJSON_CreateNumber((double)hi));
    }
}

static void add_material(glb_builder *b, const lt_glb_part *p)
{
    cJSON *material = glb_add_object(cJSON_GetObjectItem(b->root, "materials"));
    cJSON *pbr = cJSON_AddObjectToObject(material, "pbrMetallicRoughness");

    cJSON_AddItemToObject(pbr, "baseColorFactor", cJSON_CreateFloatArray(p->color, 4));
    cJSON_AddNumberToObject(pbr, "metallicFactor", 0);
    cJSON_AddNumberToObject(pbr, "roughnessFactor", 0.8);
    cJSON_AddBoolToObject(material, "doubleSided", true);          /* a hand is open at the wrist */
    if (p->color[3] < 1)
        cJSON_AddStringToObject(material, "alphaMode", "BLEND");
}

static void add_part(glb_builder *b, const lt_glb_part *p, int i)
{
    const lt_mesh *m = p->mesh;
    const uint64_t n = (uint64_t)m->n_vertices;
    cJSON *node = glb_add_object(cJSON_GetObjectItem(b->root, "nodes"));
    cJSON *mesh = glb_add_object(cJSON_GetObjectItem(b->root, "meshes"));
    cJSON *primitive = glb_add_object(cJSON_AddArrayToObject(mesh, "primitives"));
    cJSON *attributes = cJSON_AddObjectToObject(primitive, "attributes");
    const int position = glb_add_array(b, n, 3, GLB_FLOAT, GLB_VERTICES);

    cJSON_AddStringToObject(node, "name", p->name);
    cJSON_AddNumberToObject(node, "mesh", i);
    cJSON_AddStringToObject(mesh, "name", p->name);
    add_bounds(b, position, m);
    cJSON_AddNumberToObject(attributes, "POSITION", position);
    if (m->normal)
        cJSON_AddNumberToObject(attributes, "NORMAL", glb_add_array(b, n, 3, GLB_FLOAT, GLB_VERTICES));
    if (m->uv)
        cJSON_AddNumberToObject(attributes, "TEXCOORD_0", glb_add_array(b, n, 2, GLB_FLOAT, GLB_VERTICES));
    if (m->color)
        cJSON_AddNumberToObject(attributes, "COLOR_0", glb_add_array(b, n, 3, GLB_FLOAT, GLB_VERTICES));
    cJSON_AddNumberToObject(primitive, "indices", glb_add_array(b, 3 * (uint64_t)m->n_faces, 1, GLB_UINT, GLB_INDICES));
    cJSON_AddNumberToObject(primitive, "material", i);
    add_material(b, p);
    if (p->n_keys)
        glb_add_motion(b, p, i);
}

lt_status glb_begin(glb_builder *b)
{
    static const char *const lists[] = { "nodes", "meshes", "materials", "accessors", "bufferViews", "buffers" };
    cJSON *asset, *scene;

    *b = (glb_builder){ .root = cJSON_CreateObject() };
    asset = cJSON_AddObjectToObject(b->root, "asset");
    scene = glb_add_object(cJSON_AddArrayToObject(b->root, "scenes"));
    cJSON_AddStringToObject(asset, "version", "2.0");
    cJSON_AddStringToObject(asset, "generator", "palmar");
    cJSON_AddNumberToObject(b->root, "scene", 0);
    b->nodes = cJSON_AddArrayToObject(scene, "nodes");
    for (size_t i = 0; i < LT_COUNT(lists); i++)
        cJSON_AddArrayToObject(b->root, lists[i]);
    b->views = cJSON_GetObjectItem(b->root, "bufferViews");
    b->accessors = cJSON_GetObjectItem(b->root, "accessors");
    return b->accessors ? LT_OK : LT_ENOMEM;
}

/* The whole description as text, which is the caller's to free; NULL without memory. */
char *glb_text(glb_builder *b)
{
    cJSON_AddNumberToObject(glb_add_object(cJSON_GetObjectItem(b->root, "buffers")), "byteLength", (double)b->bytes);
    return cJSON_PrintUnformatted(b->root);
}

/* ---- the file ------------------------------------------------------------------------------------- */

void glb_put_u32(FILE *f, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        fputc((int)(x >> (8 * i) & 255), f);
}

void glb_put_float(FILE *f, float x)
{
    uint32_t bits;

    memcpy(&bits, &x, sizeof(bits));
    glb_put_u32(f, bits);
}

static void put_turned(FILE *f, const float (*x)[3], int n)
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            glb_put_float(f, ours_to_gltf[k] * x[i][k]);
}

static void put_mesh(FILE *f, const lt_mesh *m)
{
    put_turned(f, (const float (*)[3])m->vertex, m->n_vertices);
    if (m->normal)
        put_turned(f, (const float (*)[3])m->normal, m->n_vertices);
    for (int i = 0; m->uv && i < m->n_vertices; i++) {
        glb_put_float(f, m->uv[i][0]);
        glb_put_float(f, 1 - m->uv[i][1]);
    }
    for (int i = 0; m->color && i < m->n_vertices; i++)
        for (int k = 0; k < 3; k++)
            glb_put_float(f, m->color[i][k]);
    for (int i = 0; i < m->n_faces; i++)
        for (int k = 0; k < 3; k++)
            glb_put_u32(f, (uint32_t)m->face[i][k]);
}

static lt_status check_part(const char *path, const lt_glb_part *p)
{
    const lt_mesh *m = p->mesh;

    if (m->n_vertices < 1 || m->n_faces < 1)
        return lt_error(LT_EINVAL, "%s: \"%s\" has %d vertices and %d triangles", path, p->name, m->n_vertices,
                        m->n_faces);
    for (int i = 0; i < m->n_vertices; i++)
        for (int k = 0; k < 3; k++)
            if (!isfinite(m->vertex[i][k]))
                return lt_error(LT_EINVAL, "%s: vertex %d of \"%s\" is not finite", path, i, p->name);
    for (int i = 0; i < m->n_faces; i++)
        for (int k = 0; k < 3; k++)
            if (m->face[i][k] < 0 || m->face[i][k] >= m->n_vertices)
                return lt_error(LT_EINVAL, "%s: triangle %d of \"%s\" has vertex %d of %d", path, i, p->name,
                                m->face[i][k], m->n_vertices);
    for (int i = 1; i < p->n_keys; i++)
        if (!(p->key[i].seconds > p->key[i - 1].seconds))
            return lt_error(LT_EINVAL, "%s: key %d of \"%s\" is at %g s, the one before at %g s", path, i, p->name,
                            (double)p->key[i].seconds, (double)p->key[i - 1].seconds);
    return LT_OK;
}

lt_status glb_open(const char *path, const char *text, uint64_t binary, lt_atomic_file *f)
{
    const uint64_t length = strlen(text), padded = (length + 3) & ~(uint64_t)3;
    const uint64_t total = 12 + 8 + padded + 8 + binary;        /* binary is words already */
    lt_status st;

    if (total > UINT32_MAX)
        return lt_error(LT_EINVAL, "%s: would have %ju bytes, glTF has at most 2^32", path, (uintmax_t)total);
    st = lt_atomic_open(f, path);
    if (st)
        return st;
    fputs("glTF", f->stream);
    glb_put_u32(f->stream, 2);
    glb_put_u32(f->stream, (uint32_t)total);
    glb_put_u32(f->stream, (uint32_t)padded);
    glb_put_u32(f->stream, CHUNK_JSON);
    fprintf(f->stream, "%s%*s", text, (int)(padded - length), "");
    glb_put_u32(f->stream, (uint32_t)binary);
    glb_put_u32(f->stream, CHUNK_BIN);
    return LT_OK;
}

static lt_status write_file(const char *path, const char *text, uint64_t binary, const lt_glb_part *part, int n)
{
    lt_atomic_file f;
    const lt_status st = glb_open(path, text, binary, &f);

    if (st)
        return st;
    for (int i = 0; i < n; i++) {
        put_mesh(f.stream, part[i].mesh);
        glb_put_motion(f.stream, &part[i]);
    }
    return lt_atomic_commit(&f);
}

lt_status lt_glb_write(const char *path, const lt_glb_part *part, int n)
{
    glb_builder b;
    lt_status st = n > 0 ? LT_OK : lt_error(LT_EINVAL, "%s: no meshes to write", path);
    char *text = NULL;

    for (int i = 0; !st && i < n; i++)
        st = check_part(path, &part[i]);
    if (st)
        return st;
    if (!glb_begin(&b)) {
        for (int i = 0; i < n; i++) {
            add_part(&b, &part[i], i);
            cJSON_AddItemToArray(b.nodes, cJSON_CreateNumber(i));
        }
        text = glb_text(&b);
    }
    st = text ? write_file(path, text, b.bytes, part, n) : lt_error(LT_ENOMEM, "%s: no memory", path);
    cJSON_free(text);
    cJSON_Delete(b.root);
    return st;
}
