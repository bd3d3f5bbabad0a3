// Accessors into plain arrays. Every byte that is read lies in a view that was found to lie in its buffer;
// all arithmetic on the file's numbers is in 64 bits after the factors were bounded to 32.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_component_type(int type)
{
    return type >= GLTF_I8 && type <= GLTF_F32;
}

static uint32_t component_size(int type)
{
    return type == GLTF_I8 || type == GLTF_U8 ? 1 : type == GLTF_I16 || type == GLTF_U16 ? 2 : 4;
}

// Elements in memory: `stride` bytes apart.
struct elements {
    const unsigned char *data;
    size_t stride;
    int type;
    uint32_t components;
};

// The bytes of a view, as far as they are there.
static ng_result find_bytes(struct gltf_loader *l, int accessor, int view, const unsigned char **data,
                            size_t *length)
{
    const struct gltf_document *d = l->doc;
    if (view < 0 || (uint32_t)view >= d->view_count)
        return ng_gltf_error(l, "accessor %d: buffer view %d is not one of %u", accessor, view,
                             d->view_count);
    if (l->views[view].data) {
        *data = l->views[view].data;
        *length = l->views[view].size;
        return NG_OK;
    }
    const struct gltf_view *v = &d->views[view];
    if (v->buffer < 0 || (uint32_t)v->buffer >= d->buffer_count)
        return ng_gltf_error(l, "buffer view %d: buffer %d is not one of %u", view, v->buffer,
                             d->buffer_count);
    const struct gltf_buffer *b = &d->buffers[v->buffer];
    if (!b->data && b->lost)
        return ng_gltf_follows(&l->faults);
    if (!b->data)
        return ng_gltf_error(l, "buffer view %d: buffer %d has no bytes", view, v->buffer);
    size_t there = v->offset < b->size ? b->size - v->offset : 0;
    *length = v->length;
    if (*length > there) {
        NG_TRY(ng_gltf_fault(&l->faults, "what lies in the rest is lost",
                             "buffer view %d: bytes %zu + %zu run past buffer %d of %zu bytes", view,
                             v->offset, v->length, v->buffer, b->size));
        *length = there;
    }
    *data = b->data + (there ? v->offset : 0);
    return NG_OK;
}

// Finds `count` elements in a view. stride 0: the elements are tightly packed (sparse parts).
static ng_result locate(struct gltf_loader *l, int accessor, int view, size_t offset, size_t count,
                        bool may_stride, struct elements *e)
{
    const unsigned char *data = NULL;
    size_t length = 0;
    NG_TRY(find_bytes(l, accessor, view, &data, &length));
    const struct gltf_view *v = &l->doc->views[view];
    size_t begin = l->views[view].data ? 0 : v->offset;
    size_t unit = component_size(e->type), size = unit * e->components;
    e->stride = may_stride && v->stride ? v->stride : size;
    if (e->stride < size)
        return ng_gltf_error(l, "buffer view %d: stride %zu does not fit elements of %zu bytes (accessor %d)",
                             view, e->stride, size, accessor);
    // count and stride are under 2^32, so this cannot overflow.
    size_t span = e->stride * (count - 1) + size;
    if (offset > length || span > length - offset)
        return ng_gltf_error(l,
                             "accessor %d: %zu elements from byte %zu run past buffer view %d of %zu bytes",
                             accessor, count, offset, view, length);
    // Nothing is read in place, so this costs nothing but the warning.
    if (e->stride % unit != 0 || (begin + offset) % unit != 0)
        NG_TRY(ng_gltf_fault(
            &l->faults, "it is read all the same",
            "accessor %d: byte offset %zu + %zu or stride %zu is not a multiple of the component size "
            "%zu",
            accessor, begin, offset, e->stride, unit));
    e->data = data + offset;
    return NG_OK;
}

static double component(const struct elements *e, size_t i, uint32_t c, bool normalized)
{
    const unsigned char *p = e->data + i * e->stride + c * component_size(e->type);
    switch (e->type) {
    case GLTF_I8: {
        double v = (int8_t)*p;
        return normalized ? fmax(v / 127, -1) : v;
    }
    case GLTF_U8:
        return normalized ? *p / 255.0 : *p;
    case GLTF_I16: {
        int16_t v;
        memcpy(&v, p, sizeof v);
        return normalized ? fmax(v / 32767.0, -1) : v;
    }
    case GLTF_U16: {
        uint16_t v;
        memcpy(&v, p, sizeof v);
        return normalized ? v / 65535.0 : v;
    }
    case GLTF_I32: {
        int32_t v;
        memcpy(&v, p, sizeof v);
        return v;
    }
    case GLTF_U32: {
        uint32_t v;
        memcpy(&v, p, sizeof v);
        return v;
    }
    default: {
        float v;
        memcpy(&v, p, sizeof v);
        return (double)v;
    }
    }
}

static bool has_type(int type, uint32_t types)
{
    return is_component_type(type) && (types & GLTF_TYPE(type));
}

static const struct gltf_accessor *check(const struct gltf_loader *l, int index, const struct gltf_want *want)
{
    const struct gltf_document *d = l->doc;
    if (index < 0 || (uint32_t)index >= d->accessor_count) {
        ng_gltf_log_error(l, "%s: accessor %d is not one of %u", want->what, index, d->accessor_count);
        return NULL;
    }
    const struct gltf_accessor *a = &d->accessors[index];
    if (!has_type(a->component_type, want->integers ? GLTF_ANY : want->types)) {
        ng_gltf_log_error(l, "accessor %d: component type %d is not allowed for %s", index, a->component_type,
                          want->what);
        return NULL;
    }
    if (a->components == 0) {
        ng_gltf_log_error(l, "accessor %d: its type is none of SCALAR, VEC2, ..., MAT4", index);
        return NULL;
    }
    if (!(want->shapes & 1u << a->components)) {
        ng_gltf_log_error(l, "accessor %d: %u components an element are not allowed for %s", index,
                          a->components, want->what);
        return NULL;
    }
    if (a->count == 0 || a->count > UINT32_MAX / 16) {
        ng_gltf_log_error(l, "accessor %d: count %zu is not in 1 to %u", index, a->count, UINT32_MAX / 16);
        return NULL;
    }
    return a;
}

static bool is_whole(double v)
{
    return v >= 0 && v == floor(v);
}

// One 4-byte number a component: floats, or unsigned integers where the caller asked for them.
union word {
    float f;
    uint32_t u;
};

static ng_result convert(const struct gltf_loader *l, int index, const struct elements *e, size_t from,
                         size_t to, const struct gltf_want *want, union word *out)
{
    bool normalized = l->doc->accessors[index].normalized && !want->integers;
    for (uint32_t c = 0; c < e->components; c++) {
        double v = component(e, from, c, normalized);
        if (want->integers) {
            if (!is_whole(v) && !(want->types & GLTF_ANY_NUMBER))
                return ng_gltf_error(l, "accessor %d: element %zu is %g, not a whole number from 0 (%s)",
                                     index, to, v, want->what);
            out[to * e->components + c].u = is_whole(v) && v < UINT32_MAX ? (uint32_t)v : UINT32_MAX;
            continue;
        }
        if (!isfinite(v) && !(want->types & GLTF_ANY_NUMBER))
            return ng_gltf_error(l, "accessor %d: element %zu is not a finite number (%s)", index, to,
                                 want->what);
        v = isfinite(v) ? v : NAN;
        out[to * e->components + c].f = (float)v;
    }
    return NG_OK;
}

// Whole numbers of a type that may not hold them are what they are.
static ng_result accept_type(struct gltf_loader *l, int accessor, int type, uint32_t types, const char *what)
{
    if (has_type(type, types))
        return NG_OK;
    return ng_gltf_fault(&l->faults, "they are read all the same",
                         "accessor %d: %s of component type %d, not of unsigned integers", accessor, what,
                         type);
}

static ng_result apply_sparse(struct gltf_loader *l, int index, const struct gltf_want *want, union word *out)
{
    const struct gltf_accessor *a = &l->doc->accessors[index];
    int type = a->sparse_index_type;
    if (a->sparse_count < 1 || a->sparse_count > a->count)
        return ng_gltf_error(l, "accessor %d: sparse count %zu is not in 1 to %zu", index, a->sparse_count,
                             a->count);
    if (!is_component_type(type))
        return ng_gltf_error(l, "accessor %d: component type %d is not allowed for sparse indices", index,
                             type);
    size_t count = a->sparse_count;
    struct elements at = {.type = type, .components = 1};
    struct elements values = {.type = a->component_type, .components = a->components};
    NG_TRY(locate(l, index, a->sparse_index_view, a->sparse_index_offset, count, false, &at));
    NG_TRY(locate(l, index, a->sparse_value_view, a->sparse_value_offset, count, false, &values));
    double previous = -1;
    for (size_t i = 0; i < count; i++) {
        double target = component(&at, i, 0, false);
        if (!is_whole(target))
            return ng_gltf_error(l, "accessor %d: sparse index %zu is %g, not a whole number from 0", index,
                                 i, target);
        if (target >= (double)a->count) {
            NG_TRY(ng_gltf_fault(&l->faults, "it is left out",
                                 "accessor %d: sparse index %zu is %.0f: not below %zu", index, i, target,
                                 a->count));
            continue;
        }
        if (target <= previous)
            NG_TRY(ng_gltf_fault(&l->faults, "it is taken all the same",
                                 "accessor %d: sparse index %zu is %.0f: not increasing", index, i, target));
        NG_TRY(convert(l, index, &values, i, (size_t)target, want, out));
        previous = target;
    }
    return accept_type(l, index, type, GLTF_UNSIGNED, "sparse indices");
}

static bool find_stand_in(const struct gltf_loader *l, uint32_t accessor, size_t count, struct elements *e)
{
    e->stride = component_size(e->type) * e->components;
    for (size_t i = 0; i < l->stand_ins.count; i++) {
        const struct gltf_stand_in *item = &l->stand_ins.items[i];
        if (item->accessor == accessor && item->bytes.size == count * e->stride)
            e->data = item->bytes.data;
    }
    return e->data;
}

// `used`: the elements that are wanted, of an accessor that is not sparse; null: all.
static ng_result fill(struct gltf_loader *l, int index, const struct gltf_want *want,
                      const struct gltf_subset *used, union word *out)
{
    const struct gltf_accessor *a = &l->doc->accessors[index];
    struct elements e = {.type = a->component_type, .components = a->components};
    size_t count = used ? used->count : a->count;
    if (!find_stand_in(l, (uint32_t)index, a->count, &e) && a->view >= 0)
        NG_TRY(locate(l, index, a->view, a->offset, a->count, true, &e));
    for (size_t i = 0; e.data && i < count; i++) // else zeros
        NG_TRY(convert(l, index, &e, used ? used->vertices[i] : i, i, want, out));
    return a->sparse ? apply_sparse(l, index, want, out) : NG_OK;
}

// The set of elements that is wanted of an accessor, or null. Sparse ones are few, and read whole.
static const struct gltf_subset *subset_of(const struct gltf_loader *l, const struct gltf_accessor *a)
{
    return l->used && a->count == l->used->of && !a->sparse ? l->used : NULL;
}

static ng_result check_count(const struct gltf_loader *l, int index, const struct gltf_want *want)
{
    const struct gltf_accessor *a = &l->doc->accessors[index];
    bool of_vertices = l->used && want->count == l->used->count;
    uint32_t needed = of_vertices ? l->used->of : want->count;
    if (want->count && a->count != needed)
        return ng_gltf_error(l, "accessor %d: %zu elements where %s needs %u", index, a->count, want->what,
                             needed);
    struct elements e = {.type = a->component_type, .components = a->components};
    bool has_bytes = a->view >= 0 || find_stand_in(l, (uint32_t)index, a->count, &e);
    if (!has_bytes && (a->count > NG_GLTF_MAX_ZEROS || a->count > NG_GLTF_MAX_ZEROS / a->components))
        return ng_gltf_error(
            l, "accessor %d: %zu elements without bytes in the file, more than the limit of %d numbers",
            index, a->count, NG_GLTF_MAX_ZEROS);
    return NG_OK;
}

// Keeps the wanted elements of an array that was read whole.
static void gather(const struct gltf_subset *used, uint32_t components, union word *items)
{
    for (size_t i = 0; i < used->count; i++) // increasing: nothing is overwritten before it is read
        memmove(items + i * components, items + used->vertices[i] * (size_t)components,
                components * sizeof *items);
}

ng_result ng_gltf_read(struct gltf_loader *l, int index, const struct gltf_want *want, void *out_items,
                       uint32_t *count)
{
    void **out = out_items;
    *out = NULL;
    const struct gltf_accessor *a = check(l, index, want);
    if (!a)
        return NG_ERROR_FORMAT;
    NG_TRY(check_count(l, index, want));
    const struct gltf_subset *used = subset_of(l, a);
    bool whole = l->used && a->count == l->used->of && !used;
    size_t words = (used ? used->count : a->count) * a->components;
    char what[64];
    snprintf(what, sizeof what, "accessor %d: %s", index, want->what);
    NG_TRY(ng_gltf_budget(l, words * sizeof(union word), what));
    union word *items = calloc(words + 1, sizeof *items);
    if (!items)
        return ng_out_of_memory(l->path);
    ng_result r = fill(l, index, want, used, items);
    if (r == NG_OK && want->integers)
        r = accept_type(l, index, a->component_type, want->types, want->what);
    if (r != NG_OK) {
        free(items);
        return r;
    }
    if (whole)
        gather(l->used, a->components, items);
    *out = items;
    if (count)
        *count = used || whole ? l->used->count : (uint32_t)a->count;
    return NG_OK;
}

ng_result ng_gltf_view_bytes(struct gltf_loader *l, int view, const unsigned char **data, size_t *size)
{
    const struct gltf_document *d = l->doc;
    if (view < 0 || (uint32_t)view >= d->view_count)
        return ng_gltf_error(l, "buffer view %d is not one of %u", view, d->view_count);
    NG_TRY(find_bytes(l, -1, view, data, size));
    return *size ? NG_OK : ng_gltf_error(l, "buffer view %d: is empty", view);
}
