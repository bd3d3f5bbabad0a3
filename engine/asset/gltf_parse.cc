// tinygltf behind a plain C document.
//
// gltf_scan.cc has checked the JSON by then. tinygltf drops some of what it cannot read while only noting it
// in a message, so any message that it leaves is an error. Images are not decoded here: their bytes or names
// are kept.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <fstream> // tiny_gltf.h forgets it without a file system
#include <tiny_gltf.h>

#include "asset/gltf_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"

#include <algorithm>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>

namespace
{

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

// The JSON of either kind of file. The chunks of a GLB are checked here: so that the message can say what is
// wrong, and as tinygltf forgets the second chunk's own header when it compares its length with the file's.
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
    size_t end = (size_t)20 + u32_at(data, 12);
    if (size - end >= 8 && u32_at(data, end) > size - end - 8) {
        ng_log_error("%s: GLB chunk 1 is %u bytes long, which run past the file", path, u32_at(data, end));
        return false;
    }
    *out = {reinterpret_cast<const char *>(data) + 20, u32_at(data, 12)};
    return true;
}

// tinygltf's file access. The file's name arrives as JoinPath("", decoded uri). A buffer is added to the
// model once it was read, so their number is the index of the one that is being read.
struct Files {
    const char *document;
    const tinygltf::Model *model;
    const ng_gltf_params *params;
    uint64_t left; // bytes that all buffers together may still have
    uint64_t *hash;
    ng_result result;
};

bool read_file(std::vector<unsigned char> *out, std::string *, const std::string &name, void *user)
{
    Files *files = static_cast<Files *>(user);
    size_t index = files->model->buffers.size();
    char path[4096], shown[4096];
    const char *why = nullptr;
    files->result = NG_ERROR_FORMAT;
    bool good = ng_gltf_file_path(files->document, name.c_str(), path, sizeof path, &why);
    if (name.find('\0') != std::string::npos) {
        good = false;
        why = "holds the character %00";
    }
    if (!good) {
        ng_log_error("%s: buffer %zu: \"%.60s\" %s", files->document, index, name.c_str(), why);
        return false;
    }
    if (files->params->file)
        files->params->file(files->params->user, path);
    if (files->left == 0) {
        ng_log_error("%s: buffer %zu: the limit of bytes of all buffers is used up", files->document, index);
        files->result = NG_ERROR_MEMORY;
        return false;
    }
    std::snprintf(shown, sizeof shown, "%.3500s: buffer %zu: %.500s", files->document, index, path);
    void *data = nullptr;
    size_t size = 0;
    files->result = ng_file_read_named(shown, path, files->left, &data, &size);
    if (files->result != NG_OK)
        return false;
    std::unique_ptr<void, decltype(&std::free)> owner(data, std::free);
    const unsigned char *bytes = static_cast<const unsigned char *>(data);
    *files->hash = ng_hash_bytes(*files->hash, bytes, size);
    out->assign(bytes, bytes + size);
    files->left -= size;
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

// tinygltf calls an inverse bind matrix accessor required; glTF 2.0 does not. It also repeats data: URIs in
// full.
std::string remaining_error(const std::string &all)
{
    static const std::string harmless = "'inverseBindMatrices' property is missing in Skin.\n";
    constexpr size_t shown = 60;
    size_t begin = 0;
    while (all.compare(begin, harmless.size(), harmless) == 0)
        begin += harmless.size();
    std::string text = all.substr(begin, std::min(all.find('\n', begin), all.size()) - begin);
    size_t data = text.find("data:"), end = text.find(' ', data);
    if (data != std::string::npos && std::min(end, text.size()) - data > shown)
        text.replace(data + shown, std::min(end, text.size()) - data - shown, "...");
    return text;
}

// tinygltf reads these in this order, and adds an item to the model once it was read.
std::string where_it_stopped(const tinygltf::Model &model, const gltf_counts &counts)
{
    const struct {
        const char *what;
        size_t read, count;
    } parts[] = {{"buffer", model.buffers.size(), counts.buffers},
                 {"buffer view", model.bufferViews.size(), counts.views},
                 {"accessor", model.accessors.size(), counts.accessors}};
    for (const auto &part : parts)
        if (part.read < part.count)
            return part.what + (" " + std::to_string(part.read) + ": ");
    return "";
}

ng_result parse_model(const char *path, const unsigned char *data, size_t size, const gltf_counts &counts,
                      const ng_gltf_params &params, tinygltf::Model *model, uint64_t *hash)
{
    *hash = ng_hash_bytes(0, data, size);
    Files files = {path, model, &params, params.max_file_size, hash, NG_OK};
    tinygltf::TinyGLTF parser;
    parser.SetFsCallbacks({file_exists, same_path, read_file, nullptr, &files});
    parser.SetImageLoader(keep_image, nullptr);
    parser.SetStoreOriginalJSONForExtrasAndExtensions(true);
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
    ng_log_error("%s: %s%.300s", path, where_it_stopped(*model, counts).c_str(),
                 error.empty() ? "not a glTF document" : error.c_str());
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

    const char *text(const std::string &from)
    {
        char *copy = array<char>(from.size() + 1);
        std::memcpy(copy, from.c_str(), from.size() + 1);
        return copy;
    }
    void value(const nlohmann::json &from, const char *key, gltf_value *to)
    {
        to->key = key;
        if (from.is_boolean()) {
            to->kind = GLTF_BOOL;
            to->boolean = from.get<bool>();
        } else if (from.is_number()) {
            to->kind = GLTF_NUMBER;
            to->number = from.get<double>();
        } else if (from.is_string()) {
            to->kind = GLTF_STRING;
            to->string = text(from.get_ref<const std::string &>());
        } else {
            to->kind = from.is_array() ? GLTF_ARRAY : GLTF_OBJECT;
            gltf_value *items = array<gltf_value>(from.size());
            for (auto item = from.begin(); item != from.end(); ++item)
                value(*item, from.is_array() ? nullptr : text(item.key()), &items[to->count++]);
            to->items = items;
        }
    }
    // From the text of the extensions: tinygltf's own values leave out empty objects, such as "light_mesh":
    // {}.
    const gltf_value *extension(const std::string &extensions)
    {
        if (extensions.empty())
            return nullptr;
        const auto parsed = nlohmann::json::parse(extensions);
        auto found = parsed.find("NG_scene");
        if (found == parsed.end())
            return nullptr;
        gltf_value *v = array<gltf_value>(1);
        value(*found, nullptr, v);
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
        out.extension = extension(p.extensions_json_string);
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
        out.extension = extension(n.extensions_json_string);
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
        out.extension = extension(m.extensions_json_string);
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
        out.extension = extension(a.extensions_json_string);
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
            return gltf_skin{s.name.c_str(), s.inverseBindMatrices, s.skeleton, s.joints.data(),
                             (uint32_t)s.joints.size()};
        });
        d->animations = map<gltf_animation>(m.animations, &d->animation_count,
                                            [this](const tinygltf::Animation &a) { return animation(a); });
        d->scenes = map<gltf_scene>(m.scenes, &d->scene_count, [this](const tinygltf::Scene &s) {
            return gltf_scene{s.name.c_str(), s.nodes.data(), (uint32_t)s.nodes.size(),
                              extension(s.extensions_json_string)};
        });
        d->required = map<const char *>(m.extensionsRequired, &d->required_count,
                                        [](const std::string &name) { return name.c_str(); });
    }
};

ng_result parse_bytes(const char *path, const unsigned char *data, size_t size, const ng_gltf_params &params,
                      gltf_document *doc)
{
    Span text;
    gltf_counts counts = {};
    if (!find_json(path, data, size, &text))
        return NG_ERROR_FORMAT;
    NG_TRY(ng_gltf_scan(path, text.begin, text.size, &counts));
    auto *model = new tinygltf::Model;
    doc->model = model;
    NG_TRY(parse_model(path, data, size, counts, params, model, &doc->hash));
    Converter{&doc->arena}.document(*model, doc);
    return NG_OK;
}

} // namespace

ng_result ng_gltf_parse(const char *path, const struct ng_gltf_params *params, struct gltf_document **out)
{
    *out = nullptr;
    void *data = nullptr;
    size_t size = 0;
    NG_TRY(ng_file_read(path, std::min<uint64_t>(params->max_file_size, UINT32_MAX), &data, &size));
    gltf_document *doc = static_cast<gltf_document *>(std::calloc(1, sizeof *doc));
    ng_result result = NG_ERROR_MEMORY;
    try {
        if (!doc)
            throw std::bad_alloc();
        result = parse_bytes(path, static_cast<const unsigned char *>(data), size, *params, doc);
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
