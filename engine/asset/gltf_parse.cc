// tinygltf behind a plain C document.
//
// tinygltf builds its JSON tree by recursion, turns large integers into small ones, and drops some of what it
// cannot read while only noting it in a message. So the JSON is first scanned by an event parser that
// bounds depth, number of values and size of integers, and any message that tinygltf leaves is an error.
// Images are not decoded here: their bytes or names are kept.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <fstream> // tiny_gltf.h forgets it without a file system
#include <tiny_gltf.h>

extern "C" {
#include "asset/gltf_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
}

#include <climits>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>

namespace
{

constexpr unsigned max_depth = 64;
constexpr size_t max_values = 4u << 20;
constexpr uint64_t max_json = 512u << 20;
constexpr uint64_t max_integer = UINT32_MAX;

// Bounds what the recursive parser will be given; "extras" may hold anything and is only bounded in depth.
struct Scan : nlohmann::json_sax<nlohmann::json> {
    std::string error;
    unsigned depth = 0, extras_depth = 0;
    size_t values = 0;

    bool fail(std::string why)
    {
        error = std::move(why);
        return false;
    }
    bool count()
    {
        return ++values <= max_values || fail("JSON of more than " + std::to_string(max_values) + " values");
    }
    bool open()
    {
        return ++depth <= max_depth
                   ? count()
                   : fail("JSON nested deeper than " + std::to_string(max_depth) + " levels");
    }
    bool close()
    {
        if (--depth < extras_depth)
            extras_depth = 0;
        return true;
    }
    bool number(bool fits, const std::string &text)
    {
        return (fits || extras_depth) ? count() : fail("the integer " + text + " is out of range");
    }
    bool null() override
    {
        return count();
    }
    bool boolean(bool) override
    {
        return count();
    }
    bool number_integer(number_integer_t v) override
    {
        return number(v >= INT32_MIN, std::to_string(v));
    }
    bool number_unsigned(number_unsigned_t v) override
    {
        return number(v <= max_integer, std::to_string(v));
    }
    bool number_float(number_float_t v, const string_t &text) override
    {
        return number(std::isfinite(v), text);
    }
    bool string(string_t &) override
    {
        return count();
    }
    bool binary(binary_t &) override
    {
        return count();
    }
    bool start_object(std::size_t) override
    {
        return open();
    }
    bool end_object() override
    {
        return close();
    }
    bool start_array(std::size_t) override
    {
        return open();
    }
    bool end_array() override
    {
        return close();
    }
    bool key(string_t &name) override
    {
        if (!extras_depth && name == "extras")
            extras_depth = depth;
        else if (extras_depth == depth)
            extras_depth = 0;
        return true;
    }
    bool parse_error(std::size_t position, const std::string &, const nlohmann::detail::exception &e) override
    {
        const char *reason = std::strstr(e.what(), "parse error");
        return fail("malformed JSON at byte " + std::to_string(position) + ": " +
                    (reason ? reason : e.what()));
    }
};

struct Span {
    const char *begin;
    size_t size;
};

bool is_binary(const unsigned char *data, size_t size)
{
    return size >= 4 && std::memcmp(data, "glTF", 4) == 0;
}

uint32_t u32_at(const unsigned char *data, size_t at)
{
    return data[at] | data[at + 1] << 8 | data[at + 2] << 16 | (uint32_t)data[at + 3] << 24;
}

// The JSON of either kind of file. The header of a GLB is checked here so that the message can say what is
// wrong; tinygltf checks the second chunk.
bool find_json(const char *path, const unsigned char *data, size_t size, Span *out)
{
    *out = {reinterpret_cast<const char *>(data), size};
    if (!is_binary(data, size))
        return true;
    if (size < 20) {
        ng_log_error("%s: GLB of %zu bytes is shorter than its header", path, size);
        return false;
    }
    if (u32_at(data, 4) != 2) {
        ng_log_error("%s: GLB version %u is not 2", path, u32_at(data, 4));
        return false;
    }
    if (u32_at(data, 8) != size) {
        ng_log_error("%s: GLB header says %u bytes, the file has %zu (truncated?)", path, u32_at(data, 8),
                     size);
        return false;
    }
    if (u32_at(data, 16) != 0x4e4f534a || u32_at(data, 12) > size - 20) {
        ng_log_error("%s: GLB chunk 0 is not JSON or its length of %u runs past the file", path,
                     u32_at(data, 12));
        return false;
    }
    *out = {reinterpret_cast<const char *>(data) + 20, u32_at(data, 12)};
    return true;
}

bool scan_json(const char *path, const Span &text)
{
    if (text.size > max_json) {
        ng_log_error("%s: JSON of %zu bytes, more than the limit of %llu", path, text.size,
                     (unsigned long long)max_json);
        return false;
    }
    Scan scan;
    if (nlohmann::json::sax_parse(text.begin, text.begin + text.size, &scan))
        return true;
    ng_log_error("%s: %s", path, scan.error.c_str());
    return false;
}

// tinygltf's file access. The file's name arrives as JoinPath("", decoded uri).
struct Files {
    const char *document;
    uint64_t max_size;
    uint64_t *hash;
    ng_result result;
};

bool read_file(std::vector<unsigned char> *out, std::string *, const std::string &name, void *user)
{
    Files *files = static_cast<Files *>(user);
    char path[4096];
    const char *why = nullptr;
    if (!ng_gltf_file_path(files->document, name.c_str(), path, sizeof path, &why)) {
        ng_log_error("%s: buffer \"%.200s\": %s", files->document, name.c_str(), why);
        files->result = NG_ERROR_FORMAT;
        return false;
    }
    void *data = nullptr;
    size_t size = 0;
    files->result = ng_file_read(path, files->max_size, &data, &size);
    if (files->result != NG_OK)
        return false;
    std::unique_ptr<void, decltype(&std::free)> owner(data, std::free);
    const unsigned char *bytes = static_cast<const unsigned char *>(data);
    *files->hash = ng_hash_bytes(*files->hash, bytes, size);
    out->assign(bytes, bytes + size);
    return true;
}

bool file_exists(const std::string &, void *)
{
    return true; // read_file says what is wrong
}

std::string same_path(const std::string &path, void *)
{
    return path;
}

// Keeps the bytes of a data: URI. Those of a buffer view are not looked at: nothing about it was checked yet.
bool keep_image(tinygltf::Image *image, int, std::string *, std::string *, int, int,
                const unsigned char *bytes, int size, void *)
{
    if (image->bufferView < 0)
        image->image.assign(bytes, bytes + size);
    return true;
}

// tinygltf calls an inverse bind matrix accessor required; glTF 2.0 does not.
std::string remaining_error(std::string text)
{
    static const std::string harmless = "'inverseBindMatrices' property is missing in Skin.\n";
    for (size_t at; (at = text.find(harmless)) != std::string::npos;)
        text.erase(at, harmless.size());
    return text.substr(0, text.find('\n'));
}

ng_result parse_model(const char *path, const unsigned char *data, size_t size, uint64_t max_file_size,
                      tinygltf::Model *model, uint64_t *hash)
{
    *hash = ng_hash_bytes(0, data, size);
    Files files = {path, max_file_size, hash, NG_OK};
    tinygltf::TinyGLTF parser;
    parser.SetFsCallbacks({file_exists, same_path, read_file, nullptr, &files});
    parser.SetImageLoader(keep_image, nullptr);
    std::string error, warning;
    bool ok =
        is_binary(data, size)
            ? parser.LoadBinaryFromMemory(model, &error, &warning, data, (unsigned)size, "")
            : parser.LoadASCIIFromString(model, &error, &warning, (const char *)data, (unsigned)size, "");
    if (files.result != NG_OK)
        return files.result;
    error = remaining_error(error);
    if (ok && error.empty())
        return NG_OK;
    ng_log_error("%s: %s", path, error.empty() ? "not a glTF document" : error.c_str());
    return NG_ERROR_FORMAT;
}

// Copies of the model's parts in the document's arena; strings, numbers and bytes are borrowed from the
// model.
struct Converter {
    struct ng_arena *arena;

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

    void value(const tinygltf::Value &from, const char *key, gltf_value *to)
    {
        to->key = key;
        if (from.IsBool()) {
            to->kind = GLTF_BOOL;
            to->boolean = from.Get<bool>();
        } else if (from.IsNumber()) {
            to->kind = GLTF_NUMBER;
            to->number = from.GetNumberAsDouble();
        } else if (from.IsString()) {
            to->kind = GLTF_STRING;
            to->string = from.Get<std::string>().c_str();
        } else if (from.IsArray()) {
            const auto &list = from.Get<tinygltf::Value::Array>();
            to->kind = GLTF_ARRAY;
            gltf_value *items = array<gltf_value>(list.size());
            for (const auto &item : list)
                value(item, nullptr, &items[to->count++]);
            to->items = items;
        } else {
            const auto &members = from.Get<tinygltf::Value::Object>();
            to->kind = GLTF_OBJECT;
            gltf_value *items = array<gltf_value>(members.size());
            for (const auto &member : members)
                value(member.second, member.first.c_str(), &items[to->count++]);
            to->items = items;
        }
    }
    const gltf_value *extension(const tinygltf::ExtensionMap &map)
    {
        auto found = map.find("NG_scene");
        if (found == map.end())
            return nullptr;
        gltf_value *v = array<gltf_value>(1);
        value(found->second, nullptr, v);
        return v;
    }
    static gltf_numbers numbers(const std::vector<double> &from)
    {
        return {from.data(), (uint32_t)from.size()};
    }
    gltf_primitive primitive(const tinygltf::Primitive &p)
    {
        gltf_attribute *attributes = array<gltf_attribute>(p.attributes.size());
        gltf_primitive out = {};
        out.attributes = attributes;
        for (const auto &a : p.attributes)
            attributes[out.attribute_count++] = {a.first.c_str(), a.second};
        out.target_count = (uint32_t)p.targets.size();
        out.indices = p.indices;
        out.material = p.material;
        out.mode = p.mode;
        out.extension = extension(p.extensions);
        return out;
    }
    gltf_node node(const tinygltf::Node &n)
    {
        gltf_node out = {};
        out.name = n.name.c_str();
        out.mesh = n.mesh;
        out.skin = n.skin;
        out.camera = n.camera;
        out.light = -1;
        auto light = n.extensions.find("KHR_lights_punctual");
        if (light != n.extensions.end() && light->second.Has("light"))
            out.light =
                light->second.Get("light").IsInt() ? light->second.Get("light").GetNumberAsInt() : INT_MAX;
        out.matrix = numbers(n.matrix);
        out.translation = numbers(n.translation);
        out.rotation = numbers(n.rotation);
        out.scale = numbers(n.scale);
        out.children = n.children.data();
        out.child_count = (uint32_t)n.children.size();
        out.extension = extension(n.extensions);
        return out;
    }
    gltf_material material(const tinygltf::Material &m)
    {
        const tinygltf::PbrMetallicRoughness &pbr = m.pbrMetallicRoughness;
        gltf_material out = {};
        out.name = m.name.c_str();
        out.alpha_mode = m.alphaMode.c_str();
        out.base_color = numbers(pbr.baseColorFactor);
        out.emissive = numbers(m.emissiveFactor);
        out.metallic = pbr.metallicFactor;
        out.roughness = pbr.roughnessFactor;
        out.alpha_cutoff = m.alphaCutoff;
        out.normal_scale = m.normalTexture.scale;
        out.emissive_strength = 1;
        auto strength = m.extensions.find("KHR_materials_emissive_strength");
        if (strength != m.extensions.end() && strength->second.Has("emissiveStrength"))
            out.emissive_strength = strength->second.Get("emissiveStrength").GetNumberAsDouble();
        out.double_sided = m.doubleSided;
        out.base_color_texture = {pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord};
        out.metallic_roughness_texture = {pbr.metallicRoughnessTexture.index,
                                          pbr.metallicRoughnessTexture.texCoord};
        out.normal_texture = {m.normalTexture.index, m.normalTexture.texCoord};
        out.emissive_texture = {m.emissiveTexture.index, m.emissiveTexture.texCoord};
        out.extension = extension(m.extensions);
        return out;
    }
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
        if (out.sparse) {
            out.sparse_count = a.sparse.count;
            out.sparse_index_type = a.sparse.indices.componentType;
            out.sparse_index_view = a.sparse.indices.bufferView;
            out.sparse_index_offset = a.sparse.indices.byteOffset;
            out.sparse_value_view = a.sparse.values.bufferView;
            out.sparse_value_offset = a.sparse.values.byteOffset;
        }
        return out;
    }
    gltf_animation animation(const tinygltf::Animation &a)
    {
        gltf_animation out = {};
        out.name = a.name.c_str();
        out.channels =
            map<gltf_channel>(a.channels, &out.channel_count, [](const tinygltf::AnimationChannel &c) {
                return gltf_channel{c.sampler, c.target_node, c.target_path.c_str()};
            });
        out.samplers =
            map<gltf_keys>(a.samplers, &out.sampler_count, [](const tinygltf::AnimationSampler &s) {
                return gltf_keys{s.input, s.output, s.interpolation.c_str()};
            });
        out.extension = extension(a.extensions);
        return out;
    }

    void document(const tinygltf::Model &m, gltf_document *d)
    {
        d->scene = m.defaultScene;
        d->buffers = map<gltf_buffer>(m.buffers, &d->buffer_count, [](const tinygltf::Buffer &b) {
            return gltf_buffer{b.data.data(), b.data.size()};
        });
        d->views = map<gltf_view>(m.bufferViews, &d->view_count, [](const tinygltf::BufferView &v) {
            return gltf_view{v.buffer, v.byteOffset, v.byteLength, v.byteStride};
        });
        d->accessors = map<gltf_accessor>(m.accessors, &d->accessor_count, accessor);
        d->meshes = map<gltf_mesh>(m.meshes, &d->mesh_count, [this](const tinygltf::Mesh &mesh) {
            gltf_mesh out = {mesh.name.c_str(), nullptr, 0};
            out.primitives =
                map<gltf_primitive>(mesh.primitives, &out.primitive_count,
                                    [this](const tinygltf::Primitive &p) { return primitive(p); });
            return out;
        });
        d->nodes =
            map<gltf_node>(m.nodes, &d->node_count, [this](const tinygltf::Node &n) { return node(n); });
        d->materials = map<gltf_material>(m.materials, &d->material_count,
                                          [this](const tinygltf::Material &mat) { return material(mat); });
        d->textures = map<gltf_texture>(m.textures, &d->texture_count, [](const tinygltf::Texture &t) {
            return gltf_texture{t.source, t.sampler};
        });
        d->samplers = map<gltf_sampler>(m.samplers, &d->sampler_count, [](const tinygltf::Sampler &s) {
            return gltf_sampler{s.wrapS, s.wrapT};
        });
        d->images = map<gltf_image>(m.images, &d->image_count, [](const tinygltf::Image &i) {
            return gltf_image{i.name.c_str(), i.uri.c_str(), i.bufferView, i.image.data(), i.image.size()};
        });
        d->cameras = map<gltf_camera>(m.cameras, &d->camera_count, [](const tinygltf::Camera &c) {
            return gltf_camera{c.type == "perspective", c.perspective.yfov, c.perspective.znear};
        });
        d->lights = map<gltf_light>(m.lights, &d->light_count, [](const tinygltf::Light &l) {
            return gltf_light{l.name.c_str(), l.type.c_str(),        numbers(l.color),
                              l.intensity,    l.spot.innerConeAngle, l.spot.outerConeAngle};
        });
        d->skins = map<gltf_skin>(m.skins, &d->skin_count, [](const tinygltf::Skin &s) {
            return gltf_skin{s.name.c_str(), s.inverseBindMatrices, s.joints.data(),
                             (uint32_t)s.joints.size()};
        });
        d->animations = map<gltf_animation>(m.animations, &d->animation_count,
                                            [this](const tinygltf::Animation &a) { return animation(a); });
        d->scenes = map<gltf_scene>(m.scenes, &d->scene_count, [this](const tinygltf::Scene &s) {
            return gltf_scene{s.name.c_str(), s.nodes.data(), (uint32_t)s.nodes.size(),
                              extension(s.extensions)};
        });
        d->required = map<const char *>(m.extensionsRequired, &d->required_count,
                                        [](const std::string &name) { return name.c_str(); });
    }
};

ng_result parse_bytes(const char *path, const unsigned char *data, size_t size, uint64_t max_file_size,
                      gltf_document *doc)
{
    Span text;
    if (!find_json(path, data, size, &text) || !scan_json(path, text))
        return NG_ERROR_FORMAT;
    auto *model = new tinygltf::Model;
    doc->model = model;
    NG_TRY(parse_model(path, data, size, max_file_size, model, &doc->hash));
    Converter{&doc->arena}.document(*model, doc);
    return NG_OK;
}

} // namespace

ng_result ng_gltf_parse(const char *path, uint64_t max_file_size, struct gltf_document **out)
{
    *out = nullptr;
    void *data = nullptr;
    size_t size = 0;
    NG_TRY(ng_file_read(path, max_file_size < UINT32_MAX ? max_file_size : UINT32_MAX, &data, &size));
    gltf_document *doc = static_cast<gltf_document *>(std::calloc(1, sizeof *doc));
    ng_result result = NG_ERROR_MEMORY;
    try {
        if (!doc)
            throw std::bad_alloc();
        result = parse_bytes(path, static_cast<const unsigned char *>(data), size, max_file_size, doc);
    } catch (const std::bad_alloc &) {
        ng_log_error("%s: out of memory while parsing", path);
    } catch (const std::exception &e) {
        ng_log_error("%s: %s", path, e.what());
        result = NG_ERROR_FORMAT;
    }
    std::free(data);
    if (result != NG_OK)
        ng_gltf_document_destroy(&doc);
    *out = doc;
    return result;
}

void ng_gltf_document_destroy(struct gltf_document **doc)
{
    if (!*doc)
        return;
    delete static_cast<tinygltf::Model *>((*doc)->model);
    ng_arena_finish(&(*doc)->arena);
    std::free(*doc);
    *doc = nullptr;
}
