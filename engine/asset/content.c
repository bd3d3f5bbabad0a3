#include "asset/content_internal.h"

#include "base/log.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// An array of a geometry, cage or skeleton: where its pointer and its count are, and how large an element is.
// Arrays of points at rest stand in the order of the points.
struct array {
    size_t pointer, count, size;
    enum ng_content_part part;
};

#define ARRAY(type, member, counter, bytes, part_)                                                           \
    {                                                                                                        \
        .pointer = offsetof(type, member), .count = offsetof(type, counter), .size = (bytes),                \
        .part = (part_)                                                                                      \
    }
#define OF_GEOMETRY(member, counter, bytes, part) ARRAY(struct ng_geometry, member, counter, bytes, part)
#define OF_CAGE(member, counter, bytes, part)     ARRAY(struct ng_cage, member, counter, bytes, part)

static const struct array geometry_arrays[] = {
    OF_GEOMETRY(positions, vertex_count, 12, NG_PART_POINTS),
    OF_GEOMETRY(normals, vertex_count, 12, NG_PART_POINTS),
    OF_GEOMETRY(tangents, vertex_count, 16, NG_PART_POINTS),
    OF_GEOMETRY(rest_positions, vertex_count, 12, NG_PART_REST),
    OF_GEOMETRY(rest_normals, vertex_count, 12, NG_PART_REST),
    OF_GEOMETRY(rest_tangents, vertex_count, 16, NG_PART_REST),
    OF_GEOMETRY(uvs, vertex_count, 8, NG_PART_TOPOLOGY),
    OF_GEOMETRY(uvs1, vertex_count, 8, NG_PART_TOPOLOGY),
    OF_GEOMETRY(colors, vertex_count, 8, NG_PART_TOPOLOGY),
    OF_GEOMETRY(joints, vertex_count, 8, NG_PART_TOPOLOGY),
    OF_GEOMETRY(weights, vertex_count, 16, NG_PART_TOPOLOGY),
    OF_GEOMETRY(joints1, vertex_count, 8, NG_PART_TOPOLOGY),
    OF_GEOMETRY(weights1, vertex_count, 16, NG_PART_TOPOLOGY),
    OF_GEOMETRY(indices, index_count, 4, NG_PART_TOPOLOGY),
    OF_GEOMETRY(target_ends, target_count, 4, NG_PART_TOPOLOGY),
    OF_GEOMETRY(delta_vertices, delta_count, 4, NG_PART_TOPOLOGY),
    OF_GEOMETRY(delta_positions, delta_count, 12, NG_PART_TOPOLOGY),
    OF_GEOMETRY(delta_normals, delta_count, 12, NG_PART_TOPOLOGY),
    OF_GEOMETRY(delta_tangents, delta_count, 12, NG_PART_TOPOLOGY),
};
static const struct array cage_arrays[] = {
    OF_CAGE(positions, vertex_count, 12, NG_PART_POINTS),
    OF_CAGE(rest_positions, vertex_count, 12, NG_PART_REST),
    OF_CAGE(face_sizes, face_count, 4, NG_PART_TOPOLOGY),
    OF_CAGE(face_indices, index_count, 4, NG_PART_TOPOLOGY),
    OF_CAGE(face_uvs, index_count, 8, NG_PART_TOPOLOGY),
    OF_CAGE(crease_edges, crease_count, 8, NG_PART_TOPOLOGY),
    OF_CAGE(crease_sharpness, crease_count, 4, NG_PART_TOPOLOGY),
    OF_CAGE(corners, corner_count, 4, NG_PART_TOPOLOGY),
    OF_CAGE(corner_sharpness, corner_count, 4, NG_PART_TOPOLOGY),
    OF_CAGE(vertex_map, vertex_count, 4, NG_PART_TOPOLOGY),
};
static const struct array skeleton_arrays[] = {
    ARRAY(struct ng_skeleton, joints, joint_count, sizeof(ng_entity), NG_PART_TOPOLOGY),
    ARRAY(struct ng_skeleton, inverse_bind, joint_count, 64, NG_PART_TOPOLOGY),
};

// Images and clips have none.
static const struct array *arrays_of(enum ng_asset_kind kind, size_t *count)
{
    static const struct {
        const struct array *arrays;
        size_t count;
    } all[] = {[NG_ASSET_GEOMETRY] = {geometry_arrays, NG_COUNT(geometry_arrays)},
               [NG_ASSET_CAGE] = {cage_arrays, NG_COUNT(cage_arrays)},
               [NG_ASSET_SKELETON] = {skeleton_arrays, NG_COUNT(skeleton_arrays)},
               [NG_ASSET_CLIP] = {NULL, 0}};
    *count = all[kind].count;
    return all[kind].arrays;
}

static void *pointer_of(const union ng_content *c, const struct array *a)
{
    void *pointer;
    memcpy(&pointer, (const unsigned char *)c + a->pointer, sizeof pointer);
    return pointer;
}

static void set_pointer(union ng_content *c, const struct array *a, void *pointer)
{
    memcpy((unsigned char *)c + a->pointer, &pointer, sizeof pointer);
}

static size_t bytes_of(const union ng_content *c, const struct array *a)
{
    uint32_t count;
    memcpy(&count, (const unsigned char *)c + a->count, sizeof count);
    return count * a->size;
}

// Null stays null.
static bool copy_bytes(const void *from, size_t size, void **to)
{
    *to = from ? malloc(size + 1) : NULL;
    if (*to)
        memcpy(*to, from, size);
    return *to || !from;
}

// ---- clips -----------------------------------------------------------------------------------------------
static size_t times_size(const struct ng_channel *c)
{
    return c->key_count * sizeof(float);
}

static size_t values_size(const struct ng_channel *c)
{
    return times_size(c) * c->width * (c->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1);
}

static void clip_finish(struct ng_clip *clip)
{
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        free(clip->channels[i].times);
        free(clip->channels[i].values);
    }
    free(clip->channels);
}

static size_t clip_size(const struct ng_clip *clip)
{
    size_t size = clip->channel_count * sizeof(struct ng_channel);
    for (uint32_t i = 0; i < clip->channel_count; i++)
        size += times_size(&clip->channels[i]) + values_size(&clip->channels[i]);
    return size;
}

static bool clip_copy(const struct ng_clip *from, struct ng_clip *to)
{
    *to = *from;
    to->channels = calloc(from->channel_count + (size_t)1, sizeof *to->channels);
    bool ok = to->channels;
    to->channel_count = ok ? from->channel_count : 0;
    for (uint32_t i = 0; i < to->channel_count; i++) {
        const struct ng_channel *channel = &from->channels[i];
        struct ng_channel *copy = &to->channels[i];
        void *times, *values;
        ok &= copy_bytes(channel->times, times_size(channel), &times);
        ok &= copy_bytes(channel->values, values_size(channel), &values);
        *copy = *channel;
        copy->times = times;
        copy->values = values;
    }
    return ok;
}

// ---- all kinds -------------------------------------------------------------------------------------------
void ng_content_finish(enum ng_asset_kind kind, union ng_content *c)
{
    size_t count;
    const struct array *arrays = arrays_of(kind, &count);
    for (size_t i = 0; i < count; i++)
        free(pointer_of(c, &arrays[i]));
    if (kind == NG_ASSET_IMAGE)
        free(c->image.pixels);
    if (kind == NG_ASSET_CLIP)
        clip_finish(&c->clip);
    memset(c, 0, sizeof *c);
}

size_t ng_content_size(enum ng_asset_kind kind, const union ng_content *c)
{
    size_t count, size = 0;
    const struct array *arrays = arrays_of(kind, &count);
    for (size_t i = 0; i < count; i++)
        size += pointer_of(c, &arrays[i]) ? bytes_of(c, &arrays[i]) : 0;
    if (kind == NG_ASSET_IMAGE)
        size = c->image.size;
    return kind == NG_ASSET_CLIP ? clip_size(&c->clip) : size;
}

bool ng_content_copy(enum ng_asset_kind kind, const union ng_content *from, union ng_content *to)
{
    size_t count;
    const struct array *arrays = arrays_of(kind, &count);
    bool ok = true;
    *to = *from;
    for (size_t i = 0; i < count; i++) {
        void *copy;
        ok &= copy_bytes(pointer_of(from, &arrays[i]), bytes_of(from, &arrays[i]), &copy);
        set_pointer(to, &arrays[i], copy);
    }
    if (kind == NG_ASSET_IMAGE)
        ok = copy_bytes(from->image.pixels, from->image.size, &to->image.pixels);
    if (kind == NG_ASSET_CLIP)
        ok = clip_copy(&from->clip, &to->clip);
    if (!ok)
        ng_content_finish(kind, to);
    return ok;
}

static bool same_bytes(const void *a, const void *b, size_t size)
{
    return (!a && !b) || (a && b && (size == 0 || memcmp(a, b, size) == 0));
}

static bool clips_equal(const struct ng_clip *a, const struct ng_clip *b)
{
    if (a->channel_count != b->channel_count || !same_bytes(&a->duration, &b->duration, sizeof a->duration))
        return false;
    for (uint32_t i = 0; i < a->channel_count; i++) {
        const struct ng_channel *x = &a->channels[i], *y = &b->channels[i];
        if (!ng_entity_same(x->target, y->target) || x->component != y->component ||
            x->field_offset != y->field_offset || x->width != y->width || x->rotation != y->rotation ||
            x->interpolation != y->interpolation || x->key_count != y->key_count ||
            !same_bytes(x->times, y->times, times_size(x)) ||
            !same_bytes(x->values, y->values, values_size(x)))
            return false;
    }
    return true;
}

static bool images_equal(const struct ng_image *a, const struct ng_image *b)
{
    return a->width == b->width && a->height == b->height && a->levels == b->levels &&
           a->format == b->format && memcmp(&a->sampling, &b->sampling, sizeof a->sampling) == 0 &&
           a->size == b->size && same_bytes(a->pixels, b->pixels, a->size);
}

bool ng_content_equal(enum ng_asset_kind kind, const union ng_content *a, const union ng_content *b)
{
    size_t count;
    const struct array *arrays = arrays_of(kind, &count);
    for (size_t i = 0; i < count; i++)
        if (arrays[i].part != NG_PART_REST &&
            (bytes_of(a, &arrays[i]) != bytes_of(b, &arrays[i]) ||
             !same_bytes(pointer_of(a, &arrays[i]), pointer_of(b, &arrays[i]), bytes_of(a, &arrays[i]))))
            return false;
    if (kind == NG_ASSET_IMAGE)
        return images_equal(&a->image, &b->image);
    return kind != NG_ASSET_CLIP || clips_equal(&a->clip, &b->clip);
}

// The first array of a part; those of a part stand together.
static const struct array *first_of(enum ng_asset_kind kind, enum ng_content_part part, size_t *count)
{
    size_t all;
    const struct array *arrays = arrays_of(kind, &all), *first = arrays;
    while (first->part != part)
        first++;
    for (*count = 0; first + *count < arrays + all && first[*count].part == part;)
        ++*count;
    return first;
}

static bool copy_points(enum ng_asset_kind kind, const union ng_content *from, enum ng_content_part as,
                        union ng_content *to)
{
    size_t count;
    const struct array *points = first_of(kind, NG_PART_POINTS, &count);
    const struct array *target = first_of(kind, as, &count);
    void *copies[3] = {NULL};
    bool ok = true;
    for (size_t i = 0; i < count; i++)
        ok &= copy_bytes(pointer_of(from, &points[i]), bytes_of(from, &points[i]), &copies[i]);
    for (size_t i = 0; i < count; i++)
        if (ok)
            set_pointer(to, &target[i], copies[i]);
        else
            free(copies[i]);
    return ok;
}

static void swap_bytes(void *a, void *b, size_t size)
{
    unsigned char *x = a, *y = b;
    for (size_t i = 0; i < size; i++) {
        unsigned char byte = x[i];
        x[i] = y[i];
        y[i] = byte;
    }
}

void ng_content_swap(enum ng_asset_kind kind, enum ng_content_part part, union ng_content *a,
                     union ng_content *b)
{
    size_t count;
    const struct array *arrays = first_of(kind, part, &count);
    for (size_t i = 0; i < count; i++) {
        void *pointer = pointer_of(a, &arrays[i]);
        set_pointer(a, &arrays[i], pointer_of(b, &arrays[i]));
        set_pointer(b, &arrays[i], pointer);
    }
    if (kind != NG_ASSET_GEOMETRY || part != NG_PART_POINTS)
        return;
    swap_bytes(a->geometry.bounds_min, b->geometry.bounds_min, sizeof a->geometry.bounds_min);
    swap_bytes(a->geometry.bounds_max, b->geometry.bounds_max, sizeof a->geometry.bounds_max);
}

bool ng_content_fork_points(enum ng_asset_kind kind, union ng_content *c, union ng_content *original)
{
    size_t count;
    const struct array *arrays = arrays_of(kind, &count);
    *original = *c;
    for (size_t i = 0; i < count; i++)
        set_pointer(original, &arrays[i], NULL);
    if (!copy_points(kind, c, NG_PART_POINTS, original))
        return false;
    ng_content_swap(kind, NG_PART_POINTS, c, original);
    return true;
}

bool ng_content_make_rest(enum ng_asset_kind kind, union ng_content *c)
{
    return copy_points(kind, c, NG_PART_REST, c);
}

void ng_content_drop(enum ng_asset_kind kind, enum ng_content_part part, union ng_content *c)
{
    size_t count;
    const struct array *arrays = first_of(kind, part, &count);
    for (size_t i = 0; i < count; i++) {
        free(pointer_of(c, &arrays[i]));
        set_pointer(c, &arrays[i], NULL);
    }
}
