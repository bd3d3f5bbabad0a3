// tinygltf behind the tables of a document.
//
// It reads the texts that gltf_normal.c makes of the values, no file and no picture. Nothing of it stays: the
// tables, and what they name, are in the document's arena.
#define TINYGLTF_IMPLEMENTATION
#include "asset/tinygltf_internal.h"

#include "asset/gltf_internal.h"
#include "base/log.h"

#include <algorithm>
#include <climits>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <vector>

namespace
{

// ---- reading ---------------------------------------------------------------------------------------------
// tinygltf leaves out some of what it cannot read while only noting it, so any note is an error.
bool read_model(const char *path, const gltf_normal &text, tinygltf::Model *model)
{
    std::string error, warning;
    tinygltf::TinyGLTF parser;
    bool ok = text.count <= UINT32_MAX &&
              parser.LoadASCIIFromString(model, &error, &warning, text.items, (unsigned)text.count, "",
                                         tinygltf::REQUIRE_VERSION);
    if (ok && error.empty())
        return true;
    error.resize(std::min(error.find('\n'), error.size()));
    ng_log_error("%s: tinygltf cannot read its JSON (%.300s)", path,
                 error.empty() ? "no reason is given" : error.c_str());
    return false;
}

// The texts of a list, one after the other.
struct Texts : gltf_normal {
    Texts(const gltf_value *root, gltf_list of)
    {
        ng_gltf_normal_begin(this, root, of);
    }
    Texts(const Texts &) = delete;
    Texts &operator=(const Texts &) = delete;
    ~Texts()
    {
        ng_array_finish(this);
    }
    void make_next()
    {
        if (!ng_gltf_normal_next(this))
            throw std::bad_alloc();
    }
};

// ---- tables ----------------------------------------------------------------------------------------------
struct Converter {
    ng_arena *arena;

    template <class T> T *array(size_t count)
    {
        T *items = static_cast<T *>(ng_arena_array(arena, count, sizeof(T)));
        if (!items)
            throw std::bad_alloc();
        return items;
    }
    template <class To, class From, class Fn>
    const To *map(const std::vector<From> &from, uint32_t *count, Fn fn)
    {
        To *items = array<To>(from.size());
        for (size_t i = 0; i < from.size(); i++)
            items[i] = fn(from[i]);
        *count = (uint32_t)from.size();
        return items;
    }
    const char *text(const std::string &from)
    {
        if (from.empty())
            return "";
        const char *copy = ng_arena_string(arena, from.c_str());
        if (!copy)
            throw std::bad_alloc();
        return copy;
    }
    gltf_numbers numbers(const std::vector<double> &from)
    {
        double *items = array<double>(from.size());
        std::copy(from.begin(), from.end(), items);
        return {items, (uint32_t)from.size()};
    }
    const int *indices(const std::vector<int> &from, uint32_t *count)
    {
        return map<int>(from, count, [](int i) { return i; });
    }

    static gltf_view view(const tinygltf::BufferView &v)
    {
        gltf_view out = {};
        out.buffer = v.buffer;
        out.offset = v.byteOffset;
        out.length = v.byteLength;
        out.stride = v.byteStride;
        return out;
    }
    // Counts and offsets of sparse ones are 32 bits without a sign, which tinygltf keeps in an int.
    static gltf_accessor accessor(const tinygltf::Accessor &a)
    {
        gltf_accessor out = {};
        out.view = a.bufferView;
        out.offset = a.byteOffset;
        out.count = a.count;
        out.component_type = a.componentType;
        out.components = (uint32_t)tinygltf::GetNumComponentsInType((uint32_t)a.type);
        out.normalized = a.normalized;
        out.sparse = a.sparse.isSparse;
        out.sparse_index_view = out.sparse_value_view = -1;
        if (!out.sparse)
            return out;
        out.sparse_count = (uint32_t)a.sparse.count;
        out.sparse_index_type = a.sparse.indices.componentType;
        out.sparse_index_view = a.sparse.indices.bufferView;
        out.sparse_index_offset = (uint32_t)a.sparse.indices.byteOffset;
        out.sparse_value_view = a.sparse.values.bufferView;
        out.sparse_value_offset = (uint32_t)a.sparse.values.byteOffset;
        return out;
    }
    gltf_primitive primitive(const tinygltf::Primitive &p)
    {
        gltf_primitive out = {};
        gltf_attribute *attributes = array<gltf_attribute>(p.attributes.size());
        for (const auto &a : p.attributes)
            attributes[out.attribute_count++] = {text(a.first), a.second};
        out.attributes = attributes;
        out.indices = -1;
        out.material = p.material;
        out.mode = p.mode;
        return out;
    }
    gltf_mesh mesh(const tinygltf::Mesh &m)
    {
        gltf_mesh out = {};
        out.name = text(m.name);
        out.weights = numbers(m.weights);
        return out;
    }
    gltf_node node(const tinygltf::Node &n)
    {
        gltf_node out = {};
        out.name = text(n.name);
        out.mesh = n.mesh;
        out.skin = n.skin;
        out.camera = n.camera;
        out.light = -1;
        out.matrix = numbers(n.matrix);
        out.translation = numbers(n.translation);
        out.rotation = numbers(n.rotation);
        out.scale = numbers(n.scale);
        out.weights = numbers(n.weights);
        out.children = indices(n.children, &out.child_count);
        return out;
    }
    template <class Info> static gltf_texture_use texture_use(const Info &info)
    {
        gltf_texture_use out = {};
        out.texture = info.index;
        out.uv_set = info.texCoord;
        return out;
    }
    gltf_material material(const tinygltf::Material &m)
    {
        const tinygltf::PbrMetallicRoughness &pbr = m.pbrMetallicRoughness;
        gltf_material out = {};
        out.name = text(m.name);
        out.alpha_mode = text(m.alphaMode);
        out.base_color = numbers(pbr.baseColorFactor);
        out.emissive = numbers(m.emissiveFactor);
        out.metallic = pbr.metallicFactor;
        out.roughness = pbr.roughnessFactor;
        out.alpha_cutoff = m.alphaCutoff;
        out.normal_scale = m.normalTexture.scale;
        out.double_sided = m.doubleSided;
        out.base_color_texture = texture_use(pbr.baseColorTexture);
        out.metallic_roughness_texture = texture_use(pbr.metallicRoughnessTexture);
        out.normal_texture = texture_use(m.normalTexture);
        out.emissive_texture = texture_use(m.emissiveTexture);
        return out;
    }
    static gltf_texture texture(const tinygltf::Texture &t)
    {
        gltf_texture out = {};
        out.image = t.source;
        out.sampler = t.sampler;
        return out;
    }
    // Filters that are not there are -1.
    static gltf_sampler sampler(const tinygltf::Sampler &s)
    {
        gltf_sampler out = {};
        out.wrap_s = s.wrapS;
        out.wrap_t = s.wrapT;
        out.mag_filter = s.magFilter == -1 ? 0 : s.magFilter;
        out.min_filter = s.minFilter == -1 ? 0 : s.minFilter;
        return out;
    }
    static gltf_camera camera(const tinygltf::Camera &c)
    {
        gltf_camera out = {};
        out.perspective = c.type == "perspective";
        out.orthographic = !out.perspective;
        out.fov_y = c.perspective.yfov;
        out.near_plane = out.perspective ? c.perspective.znear : c.orthographic.znear;
        out.x_mag = c.orthographic.xmag;
        out.y_mag = c.orthographic.ymag;
        return out;
    }
    gltf_light light(const tinygltf::Light &l)
    {
        gltf_light out = {};
        out.name = text(l.name);
        out.type = text(l.type);
        out.color = numbers(l.color);
        out.intensity = l.intensity;
        out.inner_angle = l.spot.innerConeAngle;
        out.outer_angle = l.spot.outerConeAngle;
        return out;
    }
    gltf_skin skin(const tinygltf::Skin &s)
    {
        gltf_skin out = {};
        out.name = text(s.name);
        out.inverse_bind = s.inverseBindMatrices;
        out.skeleton = s.skeleton;
        out.joints = indices(s.joints, &out.joint_count);
        return out;
    }
    gltf_channel channel(const tinygltf::AnimationChannel &c)
    {
        return {c.sampler, c.target_node, text(c.target_path)};
    }
    gltf_keys keys(const tinygltf::AnimationSampler &k)
    {
        return {k.input, k.output, text(k.interpolation)};
    }
    gltf_animation animation(const tinygltf::Animation &a)
    {
        gltf_animation out = {};
        out.name = text(a.name);
        return out;
    }
    gltf_scene scene(const tinygltf::Scene &s)
    {
        gltf_scene out = {};
        out.name = text(s.name);
        out.nodes = indices(s.nodes, &out.node_count);
        return out;
    }
};

// Errors that were logged.
struct Unreadable : std::exception {
};

// One list as a table. `of` finds tinygltf's own of a model.
template <class To, class Of, class Fn>
To *read(const char *path, Converter *c, const gltf_value *root, gltf_list list, Of of, Fn convert,
         uint32_t *count)
{
    const size_t wanted = ng_gltf_list_count(root, list);
    To *items = c->array<To>(wanted);
    Texts text(root, list);
    for (size_t i = 0; i < wanted;) {
        tinygltf::Model model;
        text.make_next();
        if (!read_model(path, text, &model))
            throw Unreadable();
        const auto *from = of(model);
        if (!text.item_count || !from || from->size() != text.item_count) {
            ng_log_error("%s: tinygltf leaves out some of its JSON", path);
            throw Unreadable();
        }
        for (const auto &item : *from)
            items[i++] = convert(item);
    }
    *count = (uint32_t)wanted;
    return items;
}

// Gives each of the items its part of a list over all of them.
template <class Outer, class Inner>
void divide(const gltf_value *outer, const char *within, Outer *owners, const Inner *items,
            const Inner *Outer::*first, uint32_t Outer::*count)
{
    for (uint32_t i = 0; outer && i < outer->count; i++) {
        const gltf_value *list = ng_gltf_array(&outer->items[i], within);
        owners[i].*first = items;
        owners[i].*count = list ? list->count : 0;
        items += owners[i].*count;
    }
}

void read_document(const char *path, gltf_document *d)
{
    const gltf_value *root = d->root;
    Converter c{&d->arena};
    uint32_t unused;
#define ALL(list) [](const tinygltf::Model &m) { return &m.list; }
#define OF_FIRST(list, inner)                                                                                \
    [](const tinygltf::Model &m) { return m.list.empty() ? nullptr : &m.list[0].inner; }
#define READ(type, list, of, convert, count)                                                                 \
    read<type>(                                                                                              \
        path, &c, root, list, of, [&c](const auto &from) { return c.convert(from); }, count)
    d->views = READ(gltf_view, GLTF_VIEWS, ALL(bufferViews), view, &d->view_count);
    d->accessors = READ(gltf_accessor, GLTF_ACCESSORS, ALL(accessors), accessor, &d->accessor_count);
    d->nodes = READ(gltf_node, GLTF_NODES, ALL(nodes), node, &d->node_count);
    d->materials = READ(gltf_material, GLTF_MATERIALS, ALL(materials), material, &d->material_count);
    d->textures = READ(gltf_texture, GLTF_TEXTURES, ALL(textures), texture, &d->texture_count);
    d->samplers = READ(gltf_sampler, GLTF_SAMPLERS, ALL(samplers), sampler, &d->sampler_count);
    d->cameras = READ(gltf_camera, GLTF_CAMERAS, ALL(cameras), camera, &d->camera_count);
    d->lights = READ(gltf_light, GLTF_LIGHTS, ALL(lights), light, &d->light_count);
    d->skins = READ(gltf_skin, GLTF_SKINS, ALL(skins), skin, &d->skin_count);
    d->scenes = READ(gltf_scene, GLTF_SCENES, ALL(scenes), scene, &d->scene_count);

    auto *meshes = READ(gltf_mesh, GLTF_MESHES, ALL(meshes), mesh, &d->mesh_count);
    auto *primitives =
        READ(gltf_primitive, GLTF_PRIMITIVES, OF_FIRST(meshes, primitives), primitive, &unused);
    divide(ng_gltf_array(root, "meshes"), "primitives", meshes, primitives, &gltf_mesh::primitives,
           &gltf_mesh::primitive_count);
    d->meshes = meshes;

    auto *animations = READ(gltf_animation, GLTF_ANIMATIONS, ALL(animations), animation, &d->animation_count);
    auto *channels = READ(gltf_channel, GLTF_CHANNELS, OF_FIRST(animations, channels), channel, &unused);
    auto *keys = READ(gltf_keys, GLTF_KEYS, OF_FIRST(animations, samplers), keys, &unused);
    divide(ng_gltf_array(root, "animations"), "channels", animations, channels, &gltf_animation::channels,
           &gltf_animation::channel_count);
    divide(ng_gltf_array(root, "animations"), "samplers", animations, keys, &gltf_animation::samplers,
           &gltf_animation::sampler_count);
    d->animations = animations;
#undef READ
#undef OF_FIRST
#undef ALL
    d->scene = ng_gltf_index(root, "scene", -1);
}

// What the tables may take: an item, with what is copied of its defaults.
uint64_t memory_needed(const gltf_value *root)
{
    constexpr struct {
        gltf_list list;
        size_t size;
    } tables[] = {{GLTF_VIEWS, sizeof(gltf_view)},       {GLTF_ACCESSORS, sizeof(gltf_accessor)},
                  {GLTF_MESHES, sizeof(gltf_mesh)},      {GLTF_PRIMITIVES, sizeof(gltf_primitive)},
                  {GLTF_NODES, sizeof(gltf_node)},       {GLTF_MATERIALS, sizeof(gltf_material) + 80},
                  {GLTF_TEXTURES, sizeof(gltf_texture)}, {GLTF_SAMPLERS, sizeof(gltf_sampler)},
                  {GLTF_CAMERAS, sizeof(gltf_camera)},   {GLTF_LIGHTS, sizeof(gltf_light) + 32},
                  {GLTF_SKINS, sizeof(gltf_skin)},       {GLTF_ANIMATIONS, sizeof(gltf_animation)},
                  {GLTF_CHANNELS, sizeof(gltf_channel)}, {GLTF_KEYS, sizeof(gltf_keys) + 16},
                  {GLTF_SCENES, sizeof(gltf_scene)}};
    uint64_t need = 0;
    for (const auto &table : tables)
        need += table.size * ng_gltf_list_count(root, table.list);
    return need;
}

} // namespace

ng_result ng_gltf_tables(const char *path, uint64_t limit, gltf_document *doc)
{
    uint64_t need = memory_needed(doc->root);
    if (need > limit) {
        ng_log_error(
            "%s: what its JSON lists needs %llu bytes, more than the %llu that a file of this size may take",
            path, (unsigned long long)need, (unsigned long long)limit);
        return NG_ERROR_MEMORY;
    }
    try {
        read_document(path, doc);
        return NG_OK;
    } catch (const Unreadable &) {
        return NG_ERROR_FORMAT;
    } catch (const std::exception &) {
        return ng_out_of_memory(path);
    }
}
