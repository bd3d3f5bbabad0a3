// Draco's decoders are made to look twice: how many triangles there are before these take memory, and how
// large the attributes are before those do. A few bytes can promise any number of either.
#include "asset/draco_internal.h"
#include "asset/gltf.h"

#include <draco/compression/decode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <new>

struct ng_draco {
    draco::Mesh mesh;
};

namespace
{

// Of Draco's tables, a triangle.
constexpr uint64_t triangle_bytes = 256;

ng_result fail(char *why, ng_result result, const char *text)
{
    std::snprintf(why, NG_REASON_SIZE, "%s", text);
    return result;
}

// A decoder of either kind that gives up before its attributes take too much.
template <class Base> class Bounded : public Base
{
  public:
    explicit Bounded(uint64_t most) : limit(most)
    {
    }
    bool too_large = false;

  protected:
    bool DecodeAllAttributes() override
    {
        const draco::PointCloud *cloud = this->point_cloud();
        uint64_t bytes = 0;
        for (int i = 0; i < cloud->num_attributes(); i++) // values, what they are decoded from, and a map
            bytes += uint64_t{cloud->attribute(i)->num_components()} * 16 + 8;
        too_large = bytes != 0 && cloud->num_points() > limit / bytes;
        return !too_large && Base::DecodeAllAttributes();
    }

  private:
    uint64_t limit;
};

bool count_faces(draco::DecoderBuffer buffer, uint32_t *faces, bool *edgebreaker)
{
    draco::DracoHeader header;
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok() ||
        header.encoder_type != draco::TRIANGULAR_MESH)
        return false;
    uint16_t version = DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor);
    buffer.set_bitstream_version(version);
    *edgebreaker = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING;
    if (version != DRACO_BITSTREAM_VERSION(2, 2)) // the one that glTF names
        return false;
    if (header.flags & METADATA_FLAG_MASK) {
        draco::GeometryMetadata metadata;
        if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata))
            return false;
    }
    uint8_t traversal;
    uint32_t vertices;
    if (*edgebreaker && (!buffer.Decode(&traversal) || !draco::DecodeVarint(&vertices, &buffer)))
        return false;
    return draco::DecodeVarint(faces, &buffer);
}

template <class Base>
ng_result decode(const void *data, size_t size, uint64_t limit, char *why, draco::Mesh *mesh)
{
    draco::DecoderBuffer buffer;
    draco::DecoderOptions options;
    Bounded<Base> decoder(limit);
    buffer.Init(static_cast<const char *>(data), size);
    draco::Status status = decoder.Decode(options, &buffer, mesh);
    if (decoder.too_large)
        return fail(why, NG_ERROR_MEMORY, "its attributes take more memory than is allowed" NG_GLTF_RAISE);
    return status.ok() ? NG_OK : fail(why, NG_ERROR_FORMAT, status.error_msg());
}

bool indices_are_good(const draco::Mesh &mesh)
{
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
        for (int k = 0; k < 3; k++)
            if (mesh.face(f)[k].value() >= mesh.num_points())
                return false;
    return true;
}

ng_result decode_checked(const void *data, size_t size, uint64_t limit, char *why, draco::Mesh *mesh)
{
    draco::DecoderBuffer buffer;
    uint32_t faces = 0;
    bool edgebreaker = false;
    buffer.Init(static_cast<const char *>(data), size);
    if (!count_faces(buffer, &faces, &edgebreaker))
        return fail(why, NG_ERROR_FORMAT, "not a mesh of Draco's bitstream 2.2");
    if (faces > limit / triangle_bytes)
        return fail(why, NG_ERROR_MEMORY, "its triangles take more memory than is allowed" NG_GLTF_RAISE);
    ng_result r = edgebreaker ? decode<draco::MeshEdgebreakerDecoder>(data, size, limit, why, mesh)
                              : decode<draco::MeshSequentialDecoder>(data, size, limit, why, mesh);
    if (r == NG_OK && (mesh->num_faces() == 0 || mesh->num_points() == 0 || !indices_are_good(*mesh)))
        return fail(why, NG_ERROR_FORMAT, "it has no triangles, or vertices are missing");
    return r;
}

template <class T>
bool convert(const draco::Mesh &mesh, const draco::PointAttribute &a, uint32_t components, void *out)
{
    T *to = static_cast<T *>(out);
    for (draco::PointIndex i(0); i < mesh.num_points(); ++i, to += components) {
        draco::AttributeValueIndex value = a.mapped_index(i);
        if (value.value() >= a.size() || !a.ConvertValue<T>(value, (int8_t)components, to))
            return false;
    }
    return true;
}

} // namespace

ng_result ng_draco_decode(const void *data, size_t size, uint64_t max_memory, char why[NG_REASON_SIZE],
                          struct ng_draco **out)
{
    *out = nullptr;
    try {
        auto mesh = std::make_unique<ng_draco>();
        NG_TRY(decode_checked(data, size, max_memory, why, &mesh->mesh));
        *out = mesh.release();
        return NG_OK;
    } catch (const std::bad_alloc &) {
        return fail(why, NG_ERROR_MEMORY, "out of memory");
    } catch (const std::exception &e) {
        return fail(why, NG_ERROR_FORMAT, e.what());
    }
}

void ng_draco_destroy(struct ng_draco **mesh)
{
    delete *mesh;
    *mesh = nullptr;
}

uint32_t ng_draco_vertex_count(const struct ng_draco *mesh)
{
    return mesh->mesh.num_points();
}

uint32_t ng_draco_index_count(const struct ng_draco *mesh)
{
    return mesh->mesh.num_faces() * 3;
}

void ng_draco_indices(const struct ng_draco *mesh, uint32_t *out)
{
    for (draco::FaceIndex f(0); f < mesh->mesh.num_faces(); ++f)
        for (int k = 0; k < 3; k++)
            *out++ = mesh->mesh.face(f)[k].value();
}

bool ng_draco_attribute(const struct ng_draco *mesh, uint32_t unique_id, int component_type,
                        uint32_t components, void *out)
{
    const draco::PointAttribute *a = mesh->mesh.GetAttributeByUniqueId(unique_id);
    if (!a || a->num_components() != components)
        return false;
    switch (component_type) {
    case 5120:
        return convert<int8_t>(mesh->mesh, *a, components, out);
    case 5121:
        return convert<uint8_t>(mesh->mesh, *a, components, out);
    case 5122:
        return convert<int16_t>(mesh->mesh, *a, components, out);
    case 5123:
        return convert<uint16_t>(mesh->mesh, *a, components, out);
    case 5125:
        return convert<uint32_t>(mesh->mesh, *a, components, out);
    default:
        return convert<float>(mesh->mesh, *a, components, out);
    }
}
