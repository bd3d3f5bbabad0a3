// Buffer views compressed by meshoptimizer: EXT_meshopt_compression, and KHR_meshopt_compression as far as it
// is the same. The decoders are safe with any bytes; what comes out is checked as all that files hold.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"

#include <meshoptimizer.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct coded {
    const unsigned char *data;
    size_t size, count, stride;
    const char *mode, *filter;
};

static const struct gltf_value *extension_of(const struct gltf_view *view)
{
    const struct gltf_value *known = ng_gltf_member(view->extensions, "EXT_meshopt_compression");
    return known ? known : ng_gltf_member(view->extensions, "KHR_meshopt_compression");
}

static bool whole(const struct gltf_value *extension, const char *key, size_t *out)
{
    double v = ng_gltf_number(extension, key, 0);
    *out = v >= 0 && v <= UINT32_MAX ? (size_t)v : 0;
    return v >= 0 && v <= UINT32_MAX && v == (double)*out;
}

static ng_result find_coded(const struct gltf_loader *l, const char *where,
                            const struct gltf_value *extension, struct coded *out)
{
    const struct gltf_document *d = l->doc;
    int index = ng_gltf_index(extension, "buffer", -1);
    size_t offset;
    if (index < 0 || (uint32_t)index >= d->buffer_count || !d->buffers[index].data)
        return ng_gltf_error(l, "%s: EXT_meshopt_compression: buffer %d is not one of %u, or has no bytes",
                             where, index, d->buffer_count);
    const struct gltf_buffer *b = &d->buffers[index];
    if (!whole(extension, "byteOffset", &offset) || !whole(extension, "byteLength", &out->size) ||
        !whole(extension, "count", &out->count) || !whole(extension, "byteStride", &out->stride))
        return ng_gltf_error(l, "%s: EXT_meshopt_compression: a size is not a whole number below 2^32",
                             where);
    if (offset > b->size || out->size > b->size - offset)
        return ng_gltf_error(l,
                             "%s: EXT_meshopt_compression: bytes %zu + %zu run past buffer %d of %zu bytes",
                             where, offset, out->size, index, b->size);
    out->data = b->data + offset;
    out->mode = ng_gltf_text(extension, "mode", "");
    out->filter = ng_gltf_text(extension, "filter", "NONE");
    return NG_OK;
}

// What the decoders ask of their callers, and that so few bytes can hold so much.
static const char *mistake(const struct coded *c)
{
    bool attributes = strcmp(c->mode, "ATTRIBUTES") == 0, triangles = strcmp(c->mode, "TRIANGLES") == 0;
    bool oct = strcmp(c->filter, "OCTAHEDRAL") == 0, quat = strcmp(c->filter, "QUATERNION") == 0;
    if (!attributes && !triangles && strcmp(c->mode, "INDICES") != 0)
        return "the mode is not ATTRIBUTES, TRIANGLES or INDICES";
    if (strcmp(c->filter, "NONE") != 0 &&
        (!attributes || (!oct && !quat && strcmp(c->filter, "EXPONENTIAL") != 0)))
        return "the filter is not NONE, nor one of OCTAHEDRAL, QUATERNION and EXPONENTIAL for attributes";
    if (attributes ? c->stride == 0 || c->stride > 256 || c->stride % 4 != 0
                   : c->stride != 2 && c->stride != 4)
        return "byteStride does not fit the mode";
    if ((oct && c->stride != 4 && c->stride != 8) || (quat && c->stride != 8))
        return "byteStride does not fit the filter";
    if (triangles && c->count % 3 != 0)
        return "count is not a multiple of 3";
    // At least a byte for 64 bytes of vertices, for a triangle, or for an index.
    size_t least = attributes ? c->count * c->stride / 64 : triangles ? c->count / 3 : c->count;
    return c->count == 0 || least > c->size ? "count does not fit byteLength" : NULL;
}

static bool decode(const struct coded *c, unsigned char *out)
{
    if (strcmp(c->mode, "TRIANGLES") == 0)
        return meshopt_decodeIndexBuffer(out, c->count, c->stride, c->data, c->size) == 0;
    if (strcmp(c->mode, "INDICES") == 0)
        return meshopt_decodeIndexSequence(out, c->count, c->stride, c->data, c->size) == 0;
    if (meshopt_decodeVertexBuffer(out, c->count, c->stride, c->data, c->size) != 0)
        return false;
    if (strcmp(c->filter, "OCTAHEDRAL") == 0)
        meshopt_decodeFilterOct(out, c->count, c->stride);
    else if (strcmp(c->filter, "QUATERNION") == 0)
        meshopt_decodeFilterQuat(out, c->count, c->stride);
    else if (strcmp(c->filter, "EXPONENTIAL") == 0)
        meshopt_decodeFilterExp(out, c->count, c->stride);
    return true;
}

static ng_result decode_view(struct gltf_loader *l, uint32_t index, const struct gltf_value *extension)
{
    struct coded c;
    char where[32];
    snprintf(where, sizeof where, "buffer view %u", index);
    NG_TRY(find_coded(l, where, extension, &c));
    const char *why = mistake(&c);
    if (why)
        return ng_gltf_error(l, "%s: EXT_meshopt_compression: %s", where, why);
    NG_TRY(ng_gltf_budget(l, c.count * c.stride, where));
    unsigned char *bytes = malloc(c.count * c.stride);
    if (!bytes)
        return ng_out_of_memory(l->path);
    if (!decode(&c, bytes)) {
        free(bytes);
        return ng_gltf_error(l, "%s: EXT_meshopt_compression: its bytes are damaged", where);
    }
    l->views[index] = (struct gltf_bytes){bytes, c.count * c.stride};
    return NG_OK;
}

ng_result ng_gltf_meshopt(struct gltf_loader *l)
{
    for (uint32_t i = 0; i < l->doc->view_count; i++) {
        const struct gltf_value *extension = extension_of(&l->doc->views[i]);
        struct gltf_part part;
        if (!extension)
            continue;
        ng_gltf_part_begin(&part, "what lies in it is lost");
        NG_TRY(ng_gltf_part_end(&l->faults, &part, decode_view(l, i, extension)));
    }
    return NG_OK;
}
