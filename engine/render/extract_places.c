// Lamps in one place. Of surfaces that coincide, rounding decides which hides which; so lights whose surfaces
// do share a place: none of them is in the way of another, and what is seen there shines as all of them.
#include "base/hash.h"
#include "base/log.h"
#include "render/extract_internal.h"

#include <math.h>

#define SAME_PLACE    1.2e-4f // metres between two surfaces at most: lamps are not that thin
#define MOST_COMPARED 256     // emitters, two by two
#define CELL          1e-3    // metres; wider than SAME_PLACE, so that two cells an axis hold all candidates

// Half widths along these tell shapes apart, however their own axes are turned.
#define DIRECTIONS 7
static const float directions[DIRECTIONS][3] = {
    {1, 0, 0},
    {0, 1, 0},
    {0, 0, 1},
    {0.57735027f, 0.57735027f, 0.57735027f},
    {0.57735027f, 0.57735027f, -0.57735027f},
    {0.57735027f, -0.57735027f, 0.57735027f},
    {-0.57735027f, 0.57735027f, 0.57735027f},
};

// Where the surface of a light is, in metres.
#define FORM 9
struct extent {
    uint64_t kind; // what is of different kinds never coincides
    float center[3], normal[3];
    float form[FORM]; // half widths; of meshes, the half axes of their boxes
};

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float half_width(enum ng_light_shape shape, const float matrix[16], const float direction[3])
{
    float x = dot(matrix, direction), y = dot(matrix + 4, direction), z = dot(matrix + 8, direction);
    switch (shape) {
    case NG_LIGHT_SHAPE_RECTANGLE:
        return 0.5f * (fabsf(x) + fabsf(y));
    case NG_LIGHT_SHAPE_DISK:
        return sqrtf(x * x + y * y);
    default:
        return sqrtf(x * x + y * y + z * z);
    }
}

static void measure_shape(const struct ng_light_slot *slot, struct extent *out)
{
    struct ng_light_surface surface = {0};
    slot->source.type->surface(&slot->source, &surface);
    out->kind = surface.shape;
    memcpy(out->center, surface.matrix + 12, sizeof out->center);
    for (int i = 0; i < DIRECTIONS; i++)
        out->form[i] = half_width(surface.shape, surface.matrix, directions[i]);
    for (int i = 0; i < 3; i++) // the side that shines, of those that have one
        out->normal[i] = surface.shape == NG_LIGHT_SHAPE_SPHERE ? 0 : -surface.matrix[8 + i];
}

// False for a mesh that follows joints: it is nowhere twice.
static bool measure_mesh(const struct ng_extractor *x, const struct ng_light_slot *slot, struct extent *out)
{
    uint32_t index = ng_index_map_get(&x->piece_of, slot->entity.id);
    if (index == UINT32_MAX || x->pieces.items[index].deformed)
        return false;
    const struct ng_snapshot_mesh *mesh = ng_extract_piece_mesh(&x->pieces.items[index]);
    out->kind = (uint64_t)mesh->vertex_count << 32 | mesh->index_count; // copies of a mesh are alike
    for (int i = 0; i < 3; i++) {
        const float *row = x->instances.items[index].matrix + i * 4;
        out->center[i] = row[3];
        for (int k = 0; k < 3; k++) {
            out->center[i] += row[k] * 0.5f * (mesh->bounds_min[k] + mesh->bounds_max[k]);
            out->form[k * 3 + i] = row[k] * 0.5f * (mesh->bounds_max[k] - mesh->bounds_min[k]);
        }
    }
    return true;
}

static bool measure(const struct ng_extractor *x, const struct ng_light_slot *slot, struct extent *out)
{
    const struct ng_light_type *type = slot->source.type;
    *out = (struct extent){0};
    if (type->emissive_mesh)
        return measure_mesh(x, slot, out);
    if (type->surface)
        measure_shape(slot, out);
    return type->surface;
}

static bool coincide(const struct extent *a, const struct extent *b)
{
    bool same = a->kind == b->kind && dot(a->normal, b->normal) >= 0;
    for (int i = 0; i < 3; i++)
        same = same && fabsf(a->center[i] - b->center[i]) <= SAME_PLACE;
    for (int i = 0; i < FORM; i++)
        same = same && fabsf(a->form[i] - b->form[i]) <= SAME_PLACE;
    return same;
}

// Cells divide places and the first sizes alike: lamps of many sizes at one spot are not all in one cell.
#define AXES 6

static double cell_of(const struct extent *e, int axis, float offset)
{
    float at = axis < 3 ? e->center[axis] : e->form[axis - 3];
    return floor(((double)at + (double)offset) / CELL);
}

static uint64_t cell_key(uint64_t kind, const double cell[AXES])
{
    uint64_t hash = ng_hash_combine(ng_hash_bytes(0, cell, AXES * sizeof *cell), kind);
    return hash ? hash : 1;
}

// The first light of the place where this extent is, or NG_NONE. A cell's light stands for all in it.
static uint32_t find_place(const struct ng_extractor *x, const struct extent *e)
{
    double low[AXES], high[AXES];
    uint32_t both = 0, up = 0; // axes along which two cells are looked into, and the second ones of this look
    for (int i = 0; i < AXES; i++) {
        low[i] = cell_of(e, i, -SAME_PLACE);
        high[i] = cell_of(e, i, SAME_PLACE);
        both |= (uint32_t)(high[i] > low[i]) << i;
    }
    do {
        double cell[AXES];
        for (int i = 0; i < AXES; i++)
            cell[i] = up >> i & 1 ? high[i] : low[i];
        uint32_t at = ng_index_map_get(&x->place_of, cell_key(e->kind, cell));
        for (; at != UINT32_MAX; at = x->slots.items[at].next_in_cell) {
            struct extent other;
            if (measure(x, &x->slots.items[at], &other) && coincide(e, &other))
                return at;
        }
        up = (up - both) & both; // the next subset
    } while (up);
    return NG_NONE;
}

static ng_result found_place(struct ng_extractor *x, uint32_t index, const struct extent *e)
{
    double cell[AXES];
    for (int i = 0; i < AXES; i++)
        cell[i] = cell_of(e, i, 0);
    uint64_t key = cell_key(e->kind, cell);
    x->slots.items[index].next_in_cell = ng_index_map_get(&x->place_of, key);
    return ng_index_map_set(&x->place_of, key, index) ? NG_OK : ng_out_of_memory("the frame's scene");
}

static ng_result place_light(struct ng_extractor *x, uint32_t index)
{
    struct ng_light_slot *slot = &x->slots.items[index];
    struct extent extent;
    slot->place = index;
    slot->next_in_place = NG_NONE;
    if (!measure(x, slot, &extent))
        return NG_OK;
    uint32_t first = find_place(x, &extent);
    if (first == NG_NONE)
        return found_place(x, index, &extent);
    slot->place = first;
    slot->next_in_place = x->slots.items[first].next_in_place;
    x->slots.items[first].next_in_place = index;
    return NG_OK;
}

static const struct ng_snapshot_instance *emitter_of(const struct ng_extractor *x,
                                                     const struct ng_light_slot *slot)
{
    uint32_t index = slot->source.type->emissive_mesh ? ng_index_map_get(&x->piece_of, slot->entity.id)
                     : slot->source.type->surface     ? slot->instance
                                                      : NG_NONE;
    return index == NG_NONE ? NULL : &x->instances.items[index];
}

static bool touch(const struct ng_snapshot_instance *a, const struct ng_snapshot_instance *b)
{
    bool apart = false;
    for (int i = 0; i < 3; i++)
        apart = apart || a->bounds_min[i] > b->bounds_max[i] + SAME_PLACE ||
                b->bounds_min[i] > a->bounds_max[i] + SAME_PLACE;
    return !apart;
}

// Whether surfaces of two lights may coincide somewhere, whatever their forms. Of many lights it is taken for
// granted.
static bool may_coincide(const struct ng_extractor *x)
{
    const struct ng_snapshot_instance *emitters[MOST_COMPARED];
    uint32_t count = 0;
    for (size_t i = 0; i < x->slots.count; i++) {
        const struct ng_snapshot_instance *emitter = emitter_of(x, &x->slots.items[i]);
        if (!emitter)
            continue;
        if (count == MOST_COMPARED)
            return true;
        for (uint32_t k = 0; k < count; k++)
            if (touch(emitter, emitters[k]))
                return true;
        emitters[count++] = emitter;
    }
    return false;
}

ng_result ng_extract_place_lights(struct ng_extractor *x)
{
    ng_index_map_clear(&x->place_of);
    x->snapshot.place_size = may_coincide(x) ? SAME_PLACE : 0;
    for (uint32_t i = 0; i < x->slots.count; i++)
        NG_TRY(place_light(x, i));
    for (uint32_t i = 0; i < x->slots.count; i++) {
        struct ng_light_slot *slot = &x->slots.items[i];
        // The first of a place comes before the others, who take what it found.
        uint64_t company = slot->place == i ? 0 : x->slots.items[slot->place].company;
        for (uint32_t k = slot->place == i ? i : NG_NONE; k != NG_NONE; k = x->slots.items[k].next_in_place)
            company = ng_hash_combine(company, x->slots.items[k].entity.id);
        if (company != slot->company) // others are in its way now, or no longer
            slot->version = slot->unit_version = ++x->clock;
        slot->company = company;
        x->light_array.items[i].version = slot->version;
        x->light_array.items[i].unit_version = slot->unit_version;
        x->light_array.items[i].place = slot->place;
    }
    return NG_OK;
}
