#include "tinygltf_text.h"

#include "asset/gltf_internal.h"
#include "asset/tinygltf_internal.h"
#include "base/file.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace
{

// ---- lines -----------------------------------------------------------------------------------------------
struct Lines {
    std::string text;

    Lines &word(const std::string &s)
    {
        text += s + " ";
        return *this;
    }
    Lines &number(double v)
    {
        char shown[40];
        std::snprintf(shown, sizeof shown, "%a ", v);
        text += shown;
        return *this;
    }
    template <class T> Lines &numbers(const char *name, const T *items, size_t count)
    {
        word(name);
        for (size_t i = 0; i < count; i++)
            number((double)items[i]);
        return *this;
    }
    template <class T> Lines &numbers(const char *name, const std::vector<T> &items)
    {
        return numbers(name, items.data(), items.size());
    }
    Lines &numbers(const char *name, const gltf_numbers &n)
    {
        return numbers(name, n.items, n.count);
    }
    void end()
    {
        text += "\n";
    }
    char *copy() const
    {
        return strdup(text.c_str());
    }
};

// ---- of the original -------------------------------------------------------------------------------------
bool read_file(std::vector<unsigned char> *out, std::string *, const std::string &path, void *)
{
    void *data;
    size_t size;
    if (ng_file_read(path.c_str(), 0, &data, &size) != NG_OK)
        return false;
    out->assign((unsigned char *)data, (unsigned char *)data + size);
    std::free(data);
    return true;
}

bool file_exists(const std::string &, void *)
{
    return true;
}

std::string same_path(const std::string &path, void *)
{
    return path;
}

bool no_image(tinygltf::Image *, int, std::string *, std::string *, int, int, const unsigned char *, int,
              void *)
{
    return true;
}

bool read_original(const char *path, tinygltf::Model *model)
{
    static const std::string harmless =
        "'inverseBindMatrices' property is missing in Skin.\n"; // it is optional
    std::vector<unsigned char> bytes;
    if (!read_file(&bytes, nullptr, path, nullptr))
        return false;
    std::string error, warning, directory = std::string(path).substr(0, std::string(path).rfind('/'));
    tinygltf::TinyGLTF parser;
    parser.SetFsCallbacks({file_exists, same_path, read_file, nullptr, nullptr});
    parser.SetImageLoader(no_image, nullptr);
    bool binary = bytes.size() > 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
    bool ok = binary ? parser.LoadBinaryFromMemory(model, &error, &warning, bytes.data(),
                                                   (unsigned)bytes.size(), directory)
                     : parser.LoadASCIIFromString(model, &error, &warning, (const char *)bytes.data(),
                                                  (unsigned)bytes.size(), directory);
    while (error.compare(0, harmless.size(), harmless) == 0)
        error.erase(0, harmless.size());
    return ok && error.empty();
}

int light_of(const tinygltf::Node &n)
{
    auto found = n.extensions.find("KHR_lights_punctual");
    return found == n.extensions.end() ? -1 : found->second.Get("light").GetNumberAsInt();
}

template <class Info> void put_texture(Lines *out, const Info &info)
{
    out->number(info.index).number(info.texCoord);
}

void put_nodes(Lines *out, const tinygltf::Model &m)
{
    for (const auto &n : m.nodes) {
        out->word("node").word(n.name).number(n.mesh).number(n.skin).number(n.camera).number(light_of(n));
        out->numbers("matrix", n.matrix)
            .numbers("translation", n.translation)
            .numbers("rotation", n.rotation);
        out->numbers("scale", n.scale).numbers("weights", n.weights).numbers("children", n.children).end();
    }
    for (const auto &s : m.skins)
        out->word("skin")
            .word(s.name)
            .number(s.inverseBindMatrices)
            .number(s.skeleton)
            .numbers("joints", s.joints)
            .end();
    for (const auto &s : m.scenes)
        out->word("scene").word(s.name).numbers("nodes", s.nodes).end();
    out->number(m.defaultScene).end();
}

void put_meshes(Lines *out, const tinygltf::Model &m)
{
    for (const auto &v : m.bufferViews)
        out->word("view")
            .number(v.buffer)
            .number((double)v.byteOffset)
            .number((double)v.byteLength)
            .number((double)v.byteStride)
            .end();
    for (const auto &a : m.accessors) {
        out->word("accessor").number(a.bufferView).number((double)a.byteOffset).number((double)a.count);
        out->number(a.componentType)
            .number(tinygltf::GetNumComponentsInType((uint32_t)a.type))
            .number(a.normalized);
        if (a.sparse.isSparse)
            out->word("sparse")
                .number(a.sparse.count)
                .number(a.sparse.indices.bufferView)
                .number(a.sparse.indices.byteOffset)
                .number(a.sparse.indices.componentType)
                .number(a.sparse.values.bufferView)
                .number(a.sparse.values.byteOffset);
        out->end();
    }
    for (const auto &mesh : m.meshes) {
        out->word("mesh").word(mesh.name).numbers("weights", mesh.weights).end();
        for (const auto &p : mesh.primitives) {
            out->word("primitive").number(p.indices).number(p.material).number(p.mode);
            out->number((double)p.targets.size());
            for (const auto &a : p.attributes)
                out->word(a.first).number(a.second);
            out->end();
        }
    }
}

void put_materials(Lines *out, const tinygltf::Model &m)
{
    for (const auto &x : m.materials) {
        const auto &pbr = x.pbrMetallicRoughness;
        out->word("material").word(x.name).word(x.alphaMode).number(x.alphaCutoff).number(x.doubleSided);
        out->numbers("color", pbr.baseColorFactor).numbers("emissive", x.emissiveFactor);
        out->number(pbr.metallicFactor).number(pbr.roughnessFactor).number(x.normalTexture.scale);
        put_texture(out, pbr.baseColorTexture);
        put_texture(out, pbr.metallicRoughnessTexture);
        put_texture(out, x.normalTexture);
        put_texture(out, x.emissiveTexture);
        out->end();
    }
    for (const auto &t : m.textures)
        out->word("texture").number(t.source).number(t.sampler).end();
    for (const auto &s : m.samplers)
        out->word("sampler")
            .number(s.wrapS)
            .number(s.wrapT)
            .number(std::max(s.magFilter, 0))
            .number(std::max(s.minFilter, 0))
            .end();
    for (const auto &i : m.images)
        out->word("image").word(i.name).end();
}

void put_rest(Lines *out, const tinygltf::Model &m)
{
    for (const auto &c : m.cameras)
        out->word("camera")
            .word(c.type)
            .number(c.perspective.yfov)
            .number(c.type == "perspective" ? c.perspective.znear : c.orthographic.znear)
            .number(c.orthographic.xmag)
            .number(c.orthographic.ymag)
            .end();
    for (const auto &l : m.lights)
        out->word("light")
            .word(l.name)
            .word(l.type)
            .numbers("color", l.color)
            .number(l.intensity)
            .number((float)l.spot.innerConeAngle)
            .number((float)l.spot.outerConeAngle)
            .end();
    for (const auto &a : m.animations) {
        out->word("animation").word(a.name);
        for (const auto &c : a.channels)
            out->word("channel").number(c.sampler).number(c.target_node).word(c.target_path);
        for (const auto &s : a.samplers)
            out->word("keys").number(s.input).number(s.output).word(s.interpolation);
        out->end();
    }
}

// ---- of the document -------------------------------------------------------------------------------------
void put_texture(Lines *out, const gltf_texture_use &use)
{
    out->number(use.texture).number(use.uv_set);
}

void put_nodes(Lines *out, const gltf_document &d)
{
    for (uint32_t i = 0; i < d.node_count; i++) {
        const gltf_node &n = d.nodes[i];
        out->word("node").word(n.name).number(n.mesh).number(n.skin).number(n.camera).number(n.light);
        out->numbers("matrix", n.matrix)
            .numbers("translation", n.translation)
            .numbers("rotation", n.rotation);
        out->numbers("scale", n.scale).numbers("weights", n.weights);
        out->numbers("children", n.children, n.child_count).end();
    }
    for (uint32_t i = 0; i < d.skin_count; i++) {
        const gltf_skin &s = d.skins[i];
        out->word("skin").word(s.name).number(s.inverse_bind).number(s.skeleton);
        out->numbers("joints", s.joints, s.joint_count).end();
    }
    for (uint32_t i = 0; i < d.scene_count; i++)
        out->word("scene")
            .word(d.scenes[i].name)
            .numbers("nodes", d.scenes[i].nodes, d.scenes[i].node_count)
            .end();
    out->number(d.scene).end();
}

void put_meshes(Lines *out, const gltf_document &d)
{
    for (uint32_t i = 0; i < d.view_count; i++)
        out->word("view")
            .number(d.views[i].buffer)
            .number((double)d.views[i].offset)
            .number((double)d.views[i].length)
            .number((double)d.views[i].stride)
            .end();
    for (uint32_t i = 0; i < d.accessor_count; i++) {
        const gltf_accessor &a = d.accessors[i];
        out->word("accessor").number(a.view).number((double)a.offset).number((double)a.count);
        out->number(a.component_type).number(a.components).number(a.normalized);
        if (a.sparse)
            out->word("sparse")
                .number((double)a.sparse_count)
                .number(a.sparse_index_view)
                .number((double)a.sparse_index_offset)
                .number(a.sparse_index_type)
                .number(a.sparse_value_view)
                .number((double)a.sparse_value_offset);
        out->end();
    }
    for (uint32_t i = 0; i < d.mesh_count; i++) {
        const gltf_mesh &mesh = d.meshes[i];
        out->word("mesh").word(mesh.name).numbers("weights", mesh.weights).end();
        for (uint32_t k = 0; k < mesh.primitive_count; k++) {
            const gltf_primitive &p = mesh.primitives[k];
            out->word("primitive").number(p.indices).number(p.material).number(p.mode).number(p.target_count);
            for (uint32_t j = 0; j < p.attribute_count; j++)
                out->word(p.attributes[j].name).number(p.attributes[j].accessor);
            out->end();
        }
    }
}

void put_materials(Lines *out, const gltf_document &d)
{
    for (uint32_t i = 0; i < d.material_count; i++) {
        const gltf_material &x = d.materials[i];
        out->word("material").word(x.name).word(x.alpha_mode).number(x.alpha_cutoff).number(x.double_sided);
        out->numbers("color", x.base_color).numbers("emissive", x.emissive);
        out->number(x.metallic).number(x.roughness).number(x.normal_scale);
        put_texture(out, x.base_color_texture);
        put_texture(out, x.metallic_roughness_texture);
        put_texture(out, x.normal_texture);
        put_texture(out, x.emissive_texture);
        out->end();
    }
    for (uint32_t i = 0; i < d.texture_count; i++)
        out->word("texture").number(d.textures[i].image).number(d.textures[i].sampler).end();
    for (uint32_t i = 0; i < d.sampler_count; i++) {
        const gltf_sampler &s = d.samplers[i];
        out->word("sampler")
            .number(s.wrap_s)
            .number(s.wrap_t)
            .number(s.mag_filter)
            .number(s.min_filter)
            .end();
    }
    for (uint32_t i = 0; i < d.image_count; i++)
        out->word("image").word(d.images[i].name).end();
}

void put_rest(Lines *out, const gltf_document &d)
{
    for (uint32_t i = 0; i < d.camera_count; i++) {
        const gltf_camera &c = d.cameras[i];
        out->word("camera").word(c.perspective ? "perspective" : c.orthographic ? "orthographic" : "none");
        out->number(c.fov_y).number(c.near_plane).number(c.x_mag).number(c.y_mag).end();
    }
    for (uint32_t i = 0; i < d.light_count; i++) {
        const gltf_light &l = d.lights[i];
        out->word("light").word(l.name).word(l.type).numbers("color", l.color).number(l.intensity);
        out->number((float)l.inner_angle).number((float)l.outer_angle).end();
    }
    for (uint32_t i = 0; i < d.animation_count; i++) {
        const gltf_animation &a = d.animations[i];
        out->word("animation").word(a.name);
        for (uint32_t k = 0; k < a.channel_count; k++)
            out->word("channel")
                .number(a.channels[k].sampler)
                .number(a.channels[k].node)
                .word(a.channels[k].path);
        for (uint32_t k = 0; k < a.sampler_count; k++)
            out->word("keys")
                .number(a.samplers[k].input)
                .number(a.samplers[k].output)
                .word(a.samplers[k].interpolation);
        out->end();
    }
}

template <class From> char *text_of(const From &from)
{
    Lines out;
    put_nodes(&out, from);
    put_meshes(&out, from);
    put_materials(&out, from);
    put_rest(&out, from);
    return out.copy();
}

} // namespace

char *tinygltf_text_of_file(const char *path)
{
    tinygltf::Model model;
    return read_original(path, &model) ? text_of(model) : nullptr;
}

char *tinygltf_text_of_document(const gltf_document *doc)
{
    return text_of(*doc);
}
