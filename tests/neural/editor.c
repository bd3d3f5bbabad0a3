#include "editor.h"

#include "test.h"

#include "asset/geometry.h"
#include "components/components.h"
#include "scene/history.h"

#include <math.h>

#define MAX_WHOLE    2  // of whole numbers, which are levels of subdivision
#define MAX_ENTITIES 40 // no more are created
#define MAX_FIELDS   64 // of a component

static uint32_t below(struct editor *e, uint32_t n)
{
    return ng_rng_below(&e->rng, n);
}

static bool one_in(struct editor *e, uint32_t n)
{
    return below(e, n) == 0;
}

// ---- Numbers ---------------------------------------------------------------------------------------------

static float extreme(struct editor *e, float low, float high)
{
    const float values[] = {low, high, 0, 1, -1, 1e-6f, 1e3f};
    return fminf(fmaxf(values[below(e, NG_COUNT(values))], low), high);
}

// Mostly near what it is, so that something is left to be seen.
static float number(struct editor *e, const struct ng_field *f, float now)
{
    bool bounded = f->min != 0 || f->max != 0;
    float low = bounded ? f->min : -1e4f, high = bounded ? f->max : 1e4f;
    if (one_in(e, 3))
        return extreme(e, low, high);
    float change = ng_rng_range(&e->rng, -0.3f, 0.3f);
    return fminf(fmaxf(now + change * fmaxf(fabsf(now), 1), low), high);
}

// All channels, or one of them.
static void numbers(struct editor *e, const struct ng_field *f, float *values, uint32_t count)
{
    uint32_t alone = below(e, 2 * count);
    for (uint32_t i = 0; i < count; i++)
        if (alone >= count || alone == i)
            values[i] = number(e, f, values[i]);
}

static void rotation(struct editor *e, float q[4])
{
    float length = 0, size = one_in(e, 2) ? 1.0f : 0.1f; // any, or a little
    for (int i = 0; i < 4; i++)
        q[i] += ng_rng_range(&e->rng, -size, size);
    for (int i = 0; i < 4; i++)
        length += q[i] * q[i];
    for (int i = 0; i < 4; i++)
        q[i] = length > 1e-4f ? q[i] / sqrtf(length) : (float)(i == 3);
}

// ---- Entities and assets ---------------------------------------------------------------------------------

// Any living entity that has a component; null if there is none.
static ng_entity any_with(struct editor *e, uint64_t components)
{
    const ng_entity root = {0};
    ng_entity found = root;
    uint32_t count = 0;
    for (ng_entity i = ng_world_first_child(e->world, root); !ng_entity_is_null(i);
         i = ng_world_next_below(e->world, root, i))
        if ((ng_world_components(e->world, i) & components) == components && one_in(e, ++count))
            found = i;
    return found;
}

// With any component that an edit may speak of: what is derived follows from others.
static ng_component any_component(struct editor *e)
{
    ng_component c;
    do
        c = below(e, ng_world_component_count(e->world));
    while (ng_world_component(e->world, c)->flags & NG_COMPONENT_DERIVED);
    return c;
}

static ng_asset any_asset(struct editor *e, enum ng_asset_kind kind)
{
    ng_asset found = {0};
    uint32_t count = 0;
    for (ng_asset i = {0}; (i = ng_assets_next(e->assets, kind, i)).id;)
        if (one_in(e, ++count))
            found = i;
    return found;
}

static enum ng_asset_kind kind_of(const struct editor *e, ng_asset id)
{
    for (enum ng_asset_kind kind = NG_ASSET_GEOMETRY; kind <= NG_ASSET_CLIP; kind++)
        for (ng_asset i = {0}; (i = ng_assets_next(e->assets, kind, i)).id;)
            if (i.id == id.id)
                return kind;
    return NG_ASSET_IMAGE; // fields that are mostly empty hold textures
}

static ng_asset another_asset(struct editor *e, ng_asset now)
{
    if (one_in(e, 8))
        return (ng_asset){0};
    return any_asset(e, one_in(e, 16) ? 1 + below(e, NG_ASSET_CLIP) : kind_of(e, now));
}

static ng_entity another_entity(struct editor *e, ng_entity now)
{
    if (one_in(e, 8))
        return (ng_entity){0};
    return any_with(e, one_in(e, 8) ? 0 : ng_world_components(e->world, now));
}

// ---- Edits -----------------------------------------------------------------------------------------------

static const char *name_of(const struct editor *e, ng_component c)
{
    return ng_world_component(e->world, c)->name;
}

static void change(struct editor *e, const struct ng_field *f, unsigned char *value)
{
    uint32_t whole;
    switch (f->type) {
    case NG_FIELD_BOOL:
        *value = !*value;
        break;
    case NG_FIELD_I32:
    case NG_FIELD_U32:
        whole = below(e, (f->max > 0 && f->max < MAX_WHOLE ? (uint32_t)f->max : MAX_WHOLE) + 1);
        memcpy(value, &whole, sizeof whole);
        break;
    case NG_FIELD_ENUM:
        for (whole = 0; f->choices[whole];)
            whole++;
        whole = below(e, whole);
        memcpy(value, &whole, sizeof whole);
        break;
    case NG_FIELD_TEXT:
        snprintf((char *)value, NG_TEXT_SIZE, "%s%u", one_in(e, 2) ? "name" : "", below(e, 4));
        break;
    case NG_FIELD_QUAT:
        rotation(e, (float *)(void *)value);
        break;
    case NG_FIELD_ENTITY:
        *(ng_entity *)(void *)value = another_entity(e, *(ng_entity *)(void *)value);
        break;
    case NG_FIELD_ASSET:
        *(ng_asset *)(void *)value = another_asset(e, *(ng_asset *)(void *)value);
        break;
    default:
        numbers(e, f, (float *)(void *)value, ng_field_size(f->type) / sizeof(float));
    }
}

// Any field that an edit may speak of, of any component: a component is chosen as often as it has fields.
static const struct ng_field *any_field(struct editor *e, ng_component *component)
{
    for (;;) {
        *component = any_component(e);
        const struct ng_component_desc *desc = ng_world_component(e->world, *component);
        uint32_t field = below(e, MAX_FIELDS);
        assert_true(desc->field_count <= MAX_FIELDS);
        if (field < desc->field_count)
            return &desc->fields[field];
    }
}

static void edit_field(struct editor *e)
{
    ng_component c;
    const struct ng_field *f = any_field(e, &c);
    ng_entity on = any_with(e, 1ull << c);
    if (ng_entity_is_null(on))
        return;
    unsigned char *value = (unsigned char *)ng_world_edit(e->world, on, c) + f->offset;
    change(e, f, value);
    assert_true(ng_field_check(f, value, NULL));
    snprintf(e->what, sizeof e->what, "entity %u's %s.%s", ng_entity_index(on), name_of(e, c), f->name);
}

static void add_component(struct editor *e)
{
    ng_component c = any_component(e);
    ng_entity on = any_with(e, 0), model = any_with(e, 1ull << c);
    const void *value = one_in(e, 4) ? NULL : ng_world_get(e->world, model, c);
    unsigned char copy[1024];
    uint32_t size = ng_world_component(e->world, c)->size;
    assert_true(size <= sizeof copy);
    if (c == NG_SCENE_SCALE || ng_entity_is_null(on))
        return;
    if (value) // adding may move what it points to
        memcpy(copy, value, size);
    assert_int_equal(ng_world_add(e->world, on, c, value ? copy : NULL), NG_OK);
    snprintf(e->what, sizeof e->what, "entity %u with %s", ng_entity_index(on), name_of(e, c));
}

// The scene's scale stays: it is what the scene was when it was made (components/scene_scale.h).
static void remove_component(struct editor *e)
{
    ng_component c = any_component(e);
    ng_entity on = any_with(e, 1ull << c);
    if (c == NG_SCENE_SCALE || ng_entity_is_null(on))
        return;
    assert_int_equal(ng_world_remove(e->world, on, c), NG_OK);
    snprintf(e->what, sizeof e->what, "entity %u without %s", ng_entity_index(on), name_of(e, c));
}

static void duplicate_entity(struct editor *e)
{
    ng_entity model = any_with(e, 0);
    if (ng_world_entity_count(e->world) >= MAX_ENTITIES || ng_world_has(e->world, model, NG_SCENE_SCALE))
        return;
    ng_entity twin = ng_entity_create(e->world);
    for (ng_component c = 0; c < ng_world_component_count(e->world); c++)
        if (ng_world_has(e->world, model, c)) {
            unsigned char copy[1024];
            memcpy(copy, ng_world_get(e->world, model, c), ng_world_component(e->world, c)->size);
            assert_int_equal(ng_world_add(e->world, twin, c, copy), NG_OK);
        }
    snprintf(e->what, sizeof e->what, "entity %u as a copy of %u", ng_entity_index(twin),
             ng_entity_index(model));
}

static void destroy_entity(struct editor *e)
{
    ng_entity on = any_with(e, 0);
    for (ng_entity i = on; !ng_entity_is_null(i); i = ng_world_next_below(e->world, on, i))
        if (ng_world_has(e->world, i, NG_SCENE_SCALE))
            return;
    if (ng_entity_is_null(on))
        return;
    snprintf(e->what, sizeof e->what, "no entity %u", ng_entity_index(on));
    assert_int_equal(ng_entity_destroy(e->world, on), NG_OK);
}

static void move_below(struct editor *e)
{
    ng_entity on = any_with(e, 0), parent = one_in(e, 4) ? (ng_entity){0} : any_with(e, 0);
    for (ng_entity i = parent; !ng_entity_is_null(i); i = ng_world_parent(e->world, i))
        if (ng_entity_same(i, on))
            return;
    if (ng_entity_is_null(on))
        return;
    assert_int_equal(ng_world_set_parent(e->world, on, parent, (ng_entity){0}), NG_OK);
    snprintf(e->what, sizeof e->what, "entity %u below %u", ng_entity_index(on), ng_entity_index(parent));
}

static struct ng_image noise(struct editor *e, uint32_t side)
{
    static const enum ng_pixel_format formats[] = {NG_PIXEL_RGBA8_SRGB, NG_PIXEL_RGBA8};
    struct ng_image image = {.width = side,
                             .height = side,
                             .levels = 1,
                             .format = formats[below(e, 2)],
                             .sampling.wrap_u = below(e, 3),
                             .sampling.wrap_v = below(e, 3),
                             .sampling.magnify = below(e, 2),
                             .sampling.minify = below(e, 2),
                             .sampling.mips = below(e, 3),
                             .size = (size_t)side * side * 4};
    unsigned char *pixels = malloc(image.size);
    assert_non_null(pixels);
    for (size_t i = 0; i < image.size; i++)
        pixels[i] = (unsigned char)below(e, 256);
    image.pixels = pixels;
    return image;
}

static void *copy_of(const void *data, size_t size)
{
    void *copy = malloc(size + 1);
    assert_non_null(copy);
    if (data)
        memcpy(copy, data, size);
    return copy;
}

// A pyramid over a square, of one size or another.
static const float pyramid[15] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, 0, 1, 0};

static float *pyramid_points(struct editor *e)
{
    float *points = copy_of(pyramid, sizeof pyramid), size = ng_rng_range(&e->rng, 0.2f, 1);
    for (size_t i = 0; i < NG_COUNT(pyramid); i++)
        points[i] *= size;
    return points;
}

static struct ng_geometry new_geometry(struct editor *e)
{
    static const uint32_t indices[12] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0};
    struct ng_geometry g = {.vertex_count = 5,
                            .index_count = 12,
                            .positions = pyramid_points(e),
                            .indices = copy_of(indices, sizeof indices)};
    assert_int_equal(ng_geometry_complete(&g), NG_OK);
    return g;
}

static struct ng_cage new_cage(struct editor *e)
{
    static const uint32_t sizes[5] = {4, 3, 3, 3, 3};
    static const uint32_t indices[16] = {0, 1, 2, 3, 0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0};
    return (struct ng_cage){.vertex_count = 5,
                            .face_count = 5,
                            .index_count = 16,
                            .positions = pyramid_points(e),
                            .face_sizes = copy_of(sizes, sizeof sizes),
                            .face_indices = copy_of(indices, sizeof indices)};
}

// Moves the first field of three numbers that the model's channels drive.
static struct ng_clip new_clip(struct editor *e, const struct ng_clip *model)
{
    struct ng_clip clip = {.channels = copy_of(NULL, sizeof *clip.channels)};
    if (!model || !model->channel_count)
        return clip;
    const float time = 0;
    struct ng_channel channel = model->channels[below(e, model->channel_count)];
    float value[12] = {0};
    for (uint32_t i = 0; i < channel.width; i++)
        value[i] = value[4 + i] = ng_rng_range(&e->rng, 0.1f, 1);
    channel.key_count = 1;
    channel.interpolation = NG_INTERPOLATION_STEP;
    channel.times = copy_of(&time, sizeof time);
    channel.values = copy_of(value, channel.width * sizeof(float));
    clip.channels[0] = channel;
    clip.channel_count = 1;
    return clip;
}

// The joints of another, in another order; or none.
static struct ng_skeleton new_skeleton(struct editor *e, const struct ng_skeleton *model)
{
    struct ng_skeleton skeleton = model ? *model : (struct ng_skeleton){0};
    skeleton.joints = copy_of(skeleton.joints, skeleton.joint_count * sizeof *skeleton.joints);
    skeleton.inverse_bind = copy_of(skeleton.inverse_bind, skeleton.joint_count * 16 * sizeof(float));
    for (uint32_t i = skeleton.joint_count; i > 1; i--) {
        uint32_t k = below(e, i);
        ng_entity joint = skeleton.joints[i - 1];
        skeleton.joints[i - 1] = skeleton.joints[k];
        skeleton.joints[k] = joint;
    }
    return skeleton;
}

static void add_image(struct editor *e)
{
    struct ng_image image = noise(e, 4);
    ng_asset id;
    assert_int_equal(ng_assets_take_image(e->assets, "noise", &image, &id), NG_OK);
    snprintf(e->what, sizeof e->what, "a new image");
}

// A new one, of any kind.
static void add_asset(struct editor *e)
{
    ng_asset id;
    struct ng_geometry g;
    struct ng_cage cage;
    struct ng_clip clip;
    struct ng_skeleton skeleton;
    switch (below(e, 5)) {
    case 0:
        g = new_geometry(e);
        assert_int_equal(ng_assets_take_geometry(e->assets, "pyramid", &g, &id), NG_OK);
        break;
    case 1:
        cage = new_cage(e);
        assert_int_equal(ng_assets_take_cage(e->assets, "pyramid", &cage, &id), NG_OK);
        break;
    case 2:
        clip = new_clip(e, ng_assets_clip(e->assets, any_asset(e, NG_ASSET_CLIP)));
        assert_int_equal(ng_assets_take_clip(e->assets, "clip", &clip, &id), NG_OK);
        break;
    case 4:
        skeleton = new_skeleton(e, ng_assets_skeleton(e->assets, any_asset(e, NG_ASSET_SKELETON)));
        assert_int_equal(ng_assets_take_skeleton(e->assets, "skeleton", &skeleton, &id), NG_OK);
        break;
    default:
        add_image(e);
        return;
    }
    snprintf(e->what, sizeof e->what, "a new asset %u", id.id);
}

static void edit_points(struct editor *e)
{
    ng_asset id = any_asset(e, one_in(e, 2) ? NG_ASSET_CAGE : NG_ASSET_GEOMETRY);
    const struct ng_cage *cage = ng_assets_cage(e->assets, id);
    const struct ng_geometry *g = ng_assets_geometry(e->assets, id);
    uint32_t count = cage ? cage->vertex_count : g ? g->vertex_count : 0;
    if (!count)
        return;
    float *points = ng_assets_edit_points(e->assets, id);
    float size = one_in(e, 4) ? 1.0f : 0.1f;
    uint32_t first = below(e, count), moved = one_in(e, 4) ? count : 1;
    for (uint32_t i = 0; i < moved; i++)
        for (size_t k = 0; k < 3; k++)
            points[(first + i) % count * 3 + k] += ng_rng_range(&e->rng, -size, size);
    assert_int_equal(ng_assets_changed(e->assets, id), NG_OK);
    snprintf(e->what, sizeof e->what, "%u points of asset %u from %u", moved, id.id, first);
}

static void edit_texels(struct editor *e)
{
    ng_asset id = any_asset(e, NG_ASSET_IMAGE);
    const struct ng_image *image = ng_assets_image(e->assets, id);
    if (!image)
        return;
    void *texels = ng_assets_edit_texels(e->assets, id);
    for (uint32_t i = 0; i < image->width; i++) {
        uint32_t at = i * 4 + below(e, 3), value = below(e, 256);
        if (image->format == NG_PIXEL_RGBA32F)
            ((float *)texels)[at] = (float)value / 64;
        else
            ((unsigned char *)texels)[at] = (unsigned char)value;
    }
    assert_int_equal(ng_assets_changed(e->assets, id), NG_OK);
    snprintf(e->what, sizeof e->what, "texels of image %u", id.id);
}

static void edit_keys(struct editor *e)
{
    ng_asset id = any_asset(e, NG_ASSET_CLIP);
    if (!id.id)
        return;
    struct ng_clip *clip = ng_assets_edit_clip(e->assets, id);
    if (clip->channel_count && !clip->channels[0].rotation)
        clip->channels[0].values[0] += ng_rng_range(&e->rng, -0.2f, 0.2f);
    assert_int_equal(ng_assets_changed(e->assets, id), NG_OK);
    snprintf(e->what, sizeof e->what, "keys of clip %u", id.id);
}

static void replace_asset(struct editor *e)
{
    static const enum ng_asset_kind kinds[] = {NG_ASSET_GEOMETRY, NG_ASSET_CAGE, NG_ASSET_IMAGE,
                                               NG_ASSET_CLIP};
    enum ng_asset_kind kind = kinds[below(e, NG_COUNT(kinds))];
    ng_asset id = any_asset(e, kind);
    ng_result r = NG_OK;
    if (!id.id)
        return;
    if (kind == NG_ASSET_GEOMETRY) {
        struct ng_geometry g = new_geometry(e);
        r = ng_assets_replace_geometry(e->assets, id, &g);
    } else if (kind == NG_ASSET_CAGE) {
        struct ng_cage cage = new_cage(e);
        r = ng_assets_replace_cage(e->assets, id, &cage);
    } else if (kind == NG_ASSET_IMAGE) {
        struct ng_image image = noise(e, 1 + below(e, 6));
        r = ng_assets_replace_image(e->assets, id, &image);
    } else {
        struct ng_clip clip = new_clip(e, ng_assets_clip(e->assets, id));
        r = ng_assets_replace_clip(e->assets, id, &clip);
    }
    assert_int_equal(r, NG_OK);
    snprintf(e->what, sizeof e->what, "other content of asset %u, of kind %d", id.id, (int)kind);
}

static void remove_asset(struct editor *e)
{
    enum ng_asset_kind kind = one_in(e, 2) ? NG_ASSET_IMAGE : 1 + below(e, NG_ASSET_CLIP);
    ng_asset id = any_asset(e, kind);
    if (id.id && (kind == NG_ASSET_IMAGE || one_in(e, 3))) {
        assert_true(ng_assets_remove(e->assets, id));
        snprintf(e->what, sizeof e->what, "no asset %u, of kind %d", id.id, (int)kind);
    }
}

static void take_back(struct editor *e)
{
    if (ng_world_undo(e->world) == NG_OK)
        snprintf(e->what, sizeof e->what, "undo");
}

static void do_again(struct editor *e)
{
    if (ng_world_redo(e->world) == NG_OK)
        snprintf(e->what, sizeof e->what, "redo");
}

static const struct edit {
    void (*make)(struct editor *e);
    uint32_t weight;
    bool recorded; // a transaction of its own
} edits[] = {
    {edit_field, 24, true},      {add_component, 4, true},  {remove_component, 4, true},
    {duplicate_entity, 2, true}, {destroy_entity, 3, true}, {move_below, 2, true},
    {add_asset, 2, true},        {edit_points, 5, true},    {edit_texels, 3, true},
    {edit_keys, 1, true},        {replace_asset, 2, true},  {remove_asset, 2, true},
    {edit_points, 1, false},     {replace_asset, 1, false}, {remove_asset, 1, false},
    {take_back, 12, false},      {do_again, 4, false},
};

static const struct edit *any_edit(struct editor *e)
{
    uint32_t sum = 0, i = 0;
    for (size_t k = 0; k < NG_COUNT(edits); k++)
        sum += edits[k].weight;
    for (sum = below(e, sum); sum >= edits[i].weight; i++)
        sum -= edits[i].weight;
    return &edits[i];
}

void editor_edit(struct editor *e)
{
    for (e->what[0] = 0; !e->what[0];) {
        const struct edit *edit = any_edit(e);
        if (edit->recorded)
            assert_int_equal(ng_world_begin(e->world, "edit"), NG_OK);
        edit->make(e);
        if (edit->recorded)
            assert_int_equal(ng_world_commit(e->world), NG_OK);
    }
}

void editor_begin(struct editor *e, struct ng_world *world, struct ng_assets *assets, uint64_t seed)
{
    *e = (struct editor){.world = world, .assets = assets, .rng = ng_rng_make(seed, 1)};
    for (int i = 0; i < 2; i++)
        add_image(e);
}
