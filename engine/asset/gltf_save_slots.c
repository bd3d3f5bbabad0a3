// What an edit makes superfluous: accessors, views and their bytes. Their places are given to what is new, so
// that no index moves and a file that is edited again and again does not grow.
#include "asset/gltf_save_internal.h"

#include <cjson/cJSON.h>

#include <stdlib.h>
#include <string.h>

static const cJSON *get(const cJSON *object, const char *key)
{
    return ng_gltf_json_get(object, key);
}

static const cJSON *extension(const cJSON *object, const char *name)
{
    return get(get(object, "extensions"), name);
}

// ---- uses ------------------------------------------------------------------------------------------------

typedef void use_fn(struct gltf_saver *s, int index);

static void each_index(struct gltf_saver *s, const cJSON *members, use_fn *use)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, members)
    {
        if (cJSON_IsNumber(item) && item->valuedouble >= 0 && item->valuedouble < INT32_MAX)
            use(s, (int)item->valuedouble);
    }
}

static void slots_of_primitive(struct gltf_saver *s, const cJSON *primitive, use_fn *use)
{
    const cJSON *target;
    each_index(s, get(primitive, "attributes"), use);
    cJSON_ArrayForEach(target, get(primitive, "targets"))
    {
        each_index(s, target, use);
    }
    each_index(s, get(extension(primitive, "NG_scene"), "cage"), use);
    if (ng_gltf_json_index(primitive, "indices") >= 0)
        use(s, ng_gltf_json_index(primitive, "indices"));
}

static void slots_of_animation(struct gltf_saver *s, const cJSON *animation, use_fn *use)
{
    const cJSON *sampler;
    cJSON_ArrayForEach(sampler, get(animation, "samplers"))
    {
        each_index(s, sampler, use);
    }
}

static void use_accessor(struct gltf_saver *s, int index)
{
    if ((size_t)index < s->accessor_uses.count)
        s->accessor_uses.items[index]++;
}

static void use_view(struct gltf_saver *s, int index)
{
    if (index >= 0 && (size_t)index < s->view_uses.count)
        s->view_uses.items[index]++;
}

// The views of an accessor: its own, and those of its sparse part.
static void each_view(struct gltf_saver *s, const cJSON *accessor, use_fn *use)
{
    const cJSON *sparse = get(accessor, "sparse");
    use(s, ng_gltf_json_index(accessor, "bufferView"));
    use(s, ng_gltf_json_index(get(sparse, "indices"), "bufferView"));
    use(s, ng_gltf_json_index(get(sparse, "values"), "bufferView"));
}

static void count_accessors(struct gltf_saver *s)
{
    for (size_t i = 0; i < s->w.lists[NG_GLTF_MESHES].count; i++) {
        const cJSON *primitive;
        cJSON_ArrayForEach(primitive, get(s->w.lists[NG_GLTF_MESHES].items[i], "primitives"))
        {
            slots_of_primitive(s, primitive, use_accessor);
            use_view(s, ng_gltf_json_index(extension(primitive, "KHR_draco_mesh_compression"), "bufferView"));
        }
    }
    for (size_t i = 0; i < s->w.lists[NG_GLTF_ANIMATIONS].count; i++)
        slots_of_animation(s, s->w.lists[NG_GLTF_ANIMATIONS].items[i], use_accessor);
    for (size_t i = 0; i < s->w.lists[NG_GLTF_SKINS].count; i++) {
        int index = ng_gltf_json_index(s->w.lists[NG_GLTF_SKINS].items[i], "inverseBindMatrices");
        if (index >= 0)
            use_accessor(s, index);
    }
    for (size_t i = 0; i < s->w.lists[NG_GLTF_NODES].count; i++)
        each_index(
            s, get(extension(s->w.lists[NG_GLTF_NODES].items[i], "EXT_mesh_gpu_instancing"), "attributes"),
            use_accessor);
}

// A place that an earlier save left over.
static bool is_left(const cJSON *item, const char *key)
{
    return ng_gltf_json_index(item, key) == 1 && !get(item, "bufferView") && !get(item, "extensions") &&
           !get(item, "extras") && !get(item, "sparse");
}

// Once, before anything is released. False when out of memory.
static bool count_uses(struct gltf_saver *s)
{
    struct ng_gltf_writer *w = &s->w;
    if (s->slots_known)
        return true;
    s->slots_known = true;
    if (!ng_array_resize(&s->accessor_uses, w->lists[NG_GLTF_ACCESSORS].count) ||
        !ng_array_resize(&s->view_uses, w->lists[NG_GLTF_VIEWS].count))
        return false;
    count_accessors(s);
    for (size_t i = 0; i < w->lists[NG_GLTF_ACCESSORS].count; i++)
        each_view(s, w->lists[NG_GLTF_ACCESSORS].items[i], use_view);
    for (size_t i = 0; i < w->lists[NG_GLTF_IMAGES].count; i++)
        use_view(s, ng_gltf_json_index(w->lists[NG_GLTF_IMAGES].items[i], "bufferView"));
    bool ok = true;
    for (size_t i = s->accessor_uses.count; i-- > 0;)
        if (!s->accessor_uses.items[i] && is_left(w->lists[NG_GLTF_ACCESSORS].items[i], "count"))
            ok &= ng_array_push(&w->free_accessors, (int)i);
    for (size_t i = s->view_uses.count; i-- > 0;)
        if (!s->view_uses.items[i] && is_left(w->lists[NG_GLTF_VIEWS].items[i], "byteLength"))
            ok &= ng_array_push(&w->free_views, (int)i);
    return ok;
}

// ---- release ---------------------------------------------------------------------------------------------

static void release_view(struct gltf_saver *s, int index)
{
    if (index < 0 || (size_t)index >= s->view_uses.count || !s->view_uses.items[index] ||
        --s->view_uses.items[index])
        return;
    s->released_view = true;
    s->w.failed |= !ng_array_push(&s->w.free_views, index);
}

static void release_accessor(struct gltf_saver *s, int index)
{
    if ((size_t)index >= s->accessor_uses.count || !s->accessor_uses.items[index] ||
        --s->accessor_uses.items[index])
        return;
    each_view(s, ng_gltf_at(&s->w, NG_GLTF_ACCESSORS, index), release_view);
    s->w.failed |= !ng_array_push(&s->w.free_accessors, index);
}

void ng_gltf_release_primitive(struct gltf_saver *s, const cJSON *primitive)
{
    if (count_uses(s))
        slots_of_primitive(s, primitive, release_accessor);
    else
        s->w.failed = true;
}

void ng_gltf_release_animation(struct gltf_saver *s, const cJSON *animation)
{
    if (count_uses(s))
        slots_of_animation(s, animation, release_accessor);
    else
        s->w.failed = true;
}

void ng_gltf_release_view(struct gltf_saver *s, int view)
{
    if (count_uses(s))
        release_view(s, view);
    else
        s->w.failed = true;
}

// ---- what is left ----------------------------------------------------------------------------------------

static cJSON *emptied(struct gltf_saver *s, enum ng_gltf_list list, int index)
{
    cJSON *object = ng_gltf_at(&s->w, list, index);
    while (object && object->child)
        cJSON_Delete(cJSON_DetachItemViaPointer(object, object->child));
    return object;
}

// Places that nothing took hold the least that is valid.
static void leave(struct gltf_saver *s)
{
    for (size_t i = 0; i < s->w.free_accessors.count; i++) {
        cJSON *accessor = emptied(s, NG_GLTF_ACCESSORS, s->w.free_accessors.items[i]);
        ng_gltf_json_number(&s->w, accessor, "componentType", NG_GLTF_U8);
        ng_gltf_json_number(&s->w, accessor, "count", 1);
        ng_gltf_json_text(&s->w, accessor, "type", "SCALAR");
    }
    for (size_t i = 0; i < s->w.free_views.count; i++) {
        cJSON *view = emptied(s, NG_GLTF_VIEWS, s->w.free_views.items[i]);
        ng_gltf_json_number(&s->w, view, "buffer", s->w.buffer);
        ng_gltf_json_number(&s->w, view, "byteLength", 1);
    }
}

// A range of old bytes in the buffer that data are added to.
struct range {
    size_t begin, end, moved; // moved: where it begins from now on
    cJSON *owner;             // of a "byteOffset"
};

struct ranges {
    NG_ARRAY(struct range) list;
};

static void add_range(struct gltf_saver *s, cJSON *owner, struct ranges *old, struct ranges *added)
{
    const cJSON *offset = get(owner, "byteOffset"), *length = get(owner, "byteLength");
    double begin = cJSON_IsNumber(offset) ? offset->valuedouble : 0;
    if (ng_gltf_json_index(owner, "buffer") != s->w.buffer || !cJSON_IsNumber(length) || begin < 0 ||
        length->valuedouble < 0)
        return;
    struct ranges *ranges = begin < (double)s->w.data_offset ? old : added;
    struct range r = {(size_t)begin, (size_t)(begin + length->valuedouble), 0, owner};
    s->w.failed |= !ng_array_push(&ranges->list, r);
}

static int compare_ranges(const void *a, const void *b)
{
    const struct range *x = a, *y = b;
    return (x->begin > y->begin) - (x->begin < y->begin);
}

// Moves ranges together that something still uses; what overlapped overlaps. The size of all.
static size_t move_ranges(struct gltf_saver *s, struct ranges *ranges, const unsigned char *old, size_t size,
                          unsigned char *out)
{
    size_t used = 0, end = 0; // in `out`, and of the run of ranges in `old`
    for (size_t i = 0; i < ranges->list.count; i++) {
        struct range *r = &ranges->list.items[i];
        r->end = r->end < size ? r->end : size;
        if (i == 0 || r->begin > end) {
            used = (used + 3) / 4 * 4 + r->begin % 4;
            end = r->begin;
        }
        r->moved = used - (end - r->begin);
        if (r->end > end) {
            memcpy(out + used, old + end, r->end - end);
            used += r->end - end;
            end = r->end;
        }
        if (r->moved || get(r->owner, "byteOffset"))
            ng_gltf_json_number(&s->w, r->owner, "byteOffset", (double)r->moved);
    }
    return (used + 3) / 4 * 4;
}

// Views of the old bytes, and those that were added after them.
static void find_views(struct gltf_saver *s, struct ranges *old, struct ranges *added)
{
    for (size_t i = 0; i < s->w.lists[NG_GLTF_VIEWS].count; i++) {
        cJSON *view = s->w.lists[NG_GLTF_VIEWS].items[i];
        cJSON *packed = cJSON_GetObjectItemCaseSensitive(get(view, "extensions"), "EXT_meshopt_compression");
        add_range(s, view, old, added);
        if (packed)
            add_range(s, packed, old, added);
    }
    if (old->list.count)
        qsort(old->list.items, old->list.count, sizeof *old->list.items, compare_ranges);
}

const unsigned char *ng_gltf_save_compact(struct gltf_saver *s, const unsigned char *old, size_t *size)
{
    struct ranges kept = {0}, added = {0};
    for (size_t i = 0; i < s->w.free_views.count; i++)
        emptied(s, NG_GLTF_VIEWS, s->w.free_views.items[i]);
    // At worst each range is moved on by three bytes, to keep its alignment.
    unsigned char *out =
        s->released_view && old ? calloc(1, *size + 8 * s->w.lists[NG_GLTF_VIEWS].count + 16) : NULL;
    if (out && ng_array_push(&s->owned, out)) {
        find_views(s, &kept, &added);
        size_t used = move_ranges(s, &kept, old, *size, out);
        for (size_t i = 0; i < added.list.count; i++)
            ng_gltf_json_number(&s->w, added.list.items[i].owner, "byteOffset",
                                (double)(added.list.items[i].begin - s->w.data_offset + used));
        s->w.data_offset = used;
        *size = used;
        old = out;
    } else {
        s->w.failed |= s->released_view && old;
        free(out);
    }
    ng_array_finish(&kept.list);
    ng_array_finish(&added.list);
    leave(s);
    return old;
}
