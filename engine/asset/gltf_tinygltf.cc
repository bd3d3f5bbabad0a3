// tinygltf behind the tables of a document.
//
// It reads the text that gltf_normal.c makes of the values, no file and no picture. Nothing of it stays: the
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

// ---- what tinygltf takes ---------------------------------------------------------------------------------
// A list of the document, and tinygltf's table of it: in the order in which they are read.
struct Part {
    const char *what, *list;
    size_t item_size, read;
};

std::vector<Part> parts_of(const tinygltf::Model &m)
{
    return {{"buffer view", "bufferViews", sizeof m.bufferViews[0], m.bufferViews.size()},
            {"accessor", "accessors", sizeof m.accessors[0], m.accessors.size()},
            {"mesh", "meshes", sizeof m.meshes[0], m.meshes.size()},
            {"node", "nodes", sizeof m.nodes[0], m.nodes.size()},
            {"scene", "scenes", sizeof m.scenes[0], m.scenes.size()},
            {"material", "materials", sizeof m.materials[0], m.materials.size()},
            {"texture", "textures", sizeof m.textures[0], m.textures.size()},
            {"animation", "animations", sizeof m.animations[0], m.animations.size()},
            {"skin", "skins", sizeof m.skins[0], m.skins.size()},
            {"sampler", "samplers", sizeof m.samplers[0], m.samplers.size()},
            {"camera", "cameras", sizeof m.cameras[0], m.cameras.size()}};
}

size_t count_of(const gltf_value *object, const char *list)
{
    const gltf_value *items = ng_gltf_array(object, list);
    return items ? items->count : 0;
}

// The lists that the items of a list have.
size_t count_within(const gltf_value *root, const char *list, const char *inner)
{
    const gltf_value *items = ng_gltf_array(root, list);
    size_t sum = 0;
    for (uint32_t i = 0; items && i < items->count; i++)
        sum += count_of(&items->items[i], inner);
    return sum;
}

// At most: the text, its tree, and the tables. Those that begin empty may be half again as large as they
// grow.
uint64_t memory_needed(const gltf_value *root, const gltf_normal &text)
{
    constexpr uint64_t value = 112; // of the tree, a member of an object
    uint64_t need = text.count + text.value_count * value;
    for (const Part &part : parts_of(tinygltf::Model()))
        need += part.item_size * count_of(root, part.list);
    need += 3 * sizeof(tinygltf::Primitive) * count_within(root, "meshes", "primitives");
    need += 3 * sizeof(tinygltf::AnimationChannel) * count_within(root, "animations", "channels");
    need += 3 * sizeof(tinygltf::AnimationSampler) * count_within(root, "animations", "samplers");
    return need;
}

bool fits(const char *path, const gltf_value *root, const gltf_normal &text, uint64_t limit)
{
    uint64_t need = memory_needed(root, text);
    if (need <= limit && text.count <= UINT32_MAX)
        return true;
    ng_log_error("%s: reading its JSON needs %llu bytes, more than the limit of %llu; raise it "
                 "(--memory-limit)",
                 path, (unsigned long long)need, (unsigned long long)limit);
    return false;
}

// ---- reading ---------------------------------------------------------------------------------------------
// The first item that is missing, for a message.
std::string where_it_stopped(const gltf_value *root, const tinygltf::Model &model)
{
    for (const Part &part : parts_of(model))
        if (part.read < count_of(root, part.list))
            return part.what + (" " + std::to_string(part.read));
    return "its JSON";
}

bool is_complete(const gltf_value *root, const tinygltf::Model &model)
{
    size_t primitives = 0, channels = 0, samplers = 0;
    for (const auto &mesh : model.meshes)
        primitives += mesh.primitives.size();
    for (const auto &animation : model.animations) {
        channels += animation.channels.size();
        samplers += animation.samplers.size();
    }
    const auto parts = parts_of(model);
    return primitives == count_within(root, "meshes", "primitives") &&
           channels == count_within(root, "animations", "channels") &&
           samplers == count_within(root, "animations", "samplers") &&
           std::all_of(parts.begin(), parts.end(),
                       [root](const Part &part) { return part.read == count_of(root, part.list); });
}

// So that tables do not grow: tinygltf keeps their capacity.
void reserve(const gltf_value *root, tinygltf::Model *m)
{
    m->bufferViews.reserve(count_of(root, "bufferViews"));
    m->accessors.reserve(count_of(root, "accessors"));
    m->meshes.reserve(count_of(root, "meshes"));
    m->nodes.reserve(count_of(root, "nodes"));
    m->scenes.reserve(count_of(root, "scenes"));
    m->materials.reserve(count_of(root, "materials"));
    m->textures.reserve(count_of(root, "textures"));
    m->animations.reserve(count_of(root, "animations"));
    m->skins.reserve(count_of(root, "skins"));
    m->samplers.reserve(count_of(root, "samplers"));
    m->cameras.reserve(count_of(root, "cameras"));
}

// tinygltf leaves out some of what it cannot read while only noting it, so any note is an error.
bool read_model(const char *path, const gltf_value *root, const gltf_normal &text, tinygltf::Model *model)
{
    reserve(root, model);
    std::string error, warning;
    tinygltf::TinyGLTF parser;
    bool ok = parser.LoadASCIIFromString(model, &error, &warning, text.items, (unsigned)text.count, "",
                                         tinygltf::REQUIRE_VERSION);
    if (ok && error.empty() && is_complete(root, *model))
        return true;
    error.resize(std::min(error.find('\n'), error.size()));
    ng_log_error("%s: %s: tinygltf cannot read it (%.300s)", path, where_it_stopped(root, *model).c_str(),
                 error.empty() ? "no reason is given" : error.c_str());
    return false;
}

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
        out.target_count = (uint32_t)p.targets.size();
        out.indices = p.indices;
        out.material = p.material;
        out.mode = p.mode;
        return out;
    }
    gltf_mesh mesh(const tinygltf::Mesh &m)
    {
        gltf_mesh out = {};
        out.name = text(m.name);
        out.weights = numbers(m.weights);
        out.primitives = map<gltf_primitive>(m.primitives, &out.primitive_count,
                                             [this](const auto &p) { return primitive(p); });
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
    gltf_animation animation(const tinygltf::Animation &a)
    {
        gltf_animation out = {};
        out.name = text(a.name);
        out.channels = map<gltf_channel>(a.channels, &out.channel_count, [this](const auto &c) {
            return gltf_channel{c.sampler, c.target_node, text(c.target_path)};
        });
        out.samplers = map<gltf_keys>(a.samplers, &out.sampler_count, [this](const auto &s) {
            return gltf_keys{s.input, s.output, text(s.interpolation)};
        });
        return out;
    }
    gltf_scene scene(const tinygltf::Scene &s)
    {
        gltf_scene out = {};
        out.name = text(s.name);
        out.nodes = indices(s.nodes, &out.node_count);
        return out;
    }

    void document(const tinygltf::Model &m, gltf_document *d)
    {
        d->scene = m.defaultScene;
        d->views = map<gltf_view>(m.bufferViews, &d->view_count, view);
        d->accessors = map<gltf_accessor>(m.accessors, &d->accessor_count, accessor);
        d->meshes = map<gltf_mesh>(m.meshes, &d->mesh_count, [this](const auto &x) { return mesh(x); });
        d->nodes = map<gltf_node>(m.nodes, &d->node_count, [this](const auto &x) { return node(x); });
        d->materials = map<gltf_material>(m.materials, &d->material_count,
                                          [this](const auto &x) { return material(x); });
        d->textures = map<gltf_texture>(m.textures, &d->texture_count, texture);
        d->samplers = map<gltf_sampler>(m.samplers, &d->sampler_count, sampler);
        d->cameras = map<gltf_camera>(m.cameras, &d->camera_count, camera);
        d->lights = map<gltf_light>(m.lights, &d->light_count, [this](const auto &x) { return light(x); });
        d->skins = map<gltf_skin>(m.skins, &d->skin_count, [this](const auto &x) { return skin(x); });
        d->animations = map<gltf_animation>(m.animations, &d->animation_count,
                                            [this](const auto &x) { return animation(x); });
        d->scenes = map<gltf_scene>(m.scenes, &d->scene_count, [this](const auto &x) { return scene(x); });
    }
};

ng_result read_tables(const char *path, uint64_t limit, const gltf_normal &text, gltf_document *doc)
{
    if (!fits(path, doc->root, text, limit))
        return NG_ERROR_MEMORY;
    tinygltf::Model model;
    if (!read_model(path, doc->root, text, &model))
        return NG_ERROR_FORMAT;
    Converter{&doc->arena}.document(model, doc);
    return NG_OK;
}

} // namespace

ng_result ng_gltf_tables(const char *path, uint64_t limit, gltf_document *doc)
{
    gltf_normal text;
    if (!ng_gltf_normal(doc->root, &text))
        return ng_out_of_memory(path);
    ng_result r;
    try {
        r = read_tables(path, limit, text, doc);
    } catch (const std::exception &) {
        r = ng_out_of_memory(path);
    }
    ng_array_finish(&text);
    return r;
}
