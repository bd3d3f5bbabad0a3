#include "draco_maker.h"

#include <draco/compression/expert_encode.h>

#include <cstring>

namespace
{

int add(draco::Mesh *mesh, draco::GeometryAttribute::Type type, draco::DataType data, int components,
        bool normalized, const void *values)
{
    draco::GeometryAttribute attribute;
    size_t stride = (size_t)draco::DataTypeLength(data) * (size_t)components;
    attribute.Init(type, nullptr, (int8_t)components, data, normalized, (int64_t)stride, 0);
    int id = mesh->AddAttribute(attribute, true, mesh->num_points());
    for (draco::AttributeValueIndex i(0); i < mesh->num_points(); ++i)
        mesh->attribute(id)->SetAttributeValue(i, static_cast<const char *>(values) + i.value() * stride);
    return id;
}

} // namespace

size_t draco_make(const struct draco_source *source, unsigned char *out, size_t room)
{
    draco::Mesh mesh;
    mesh.set_num_points(source->vertex_count);
    for (uint32_t i = 0; i < source->index_count; i += 3)
        mesh.AddFace({draco::PointIndex(source->indices[i]), draco::PointIndex(source->indices[i + 1]),
                      draco::PointIndex(source->indices[i + 2])});
    int position =
        add(&mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, false, source->positions);
    add(&mesh, draco::GeometryAttribute::COLOR, draco::DT_UINT8, 4, true, source->colors);
    if (source->metadata) {
        auto metadata = std::make_unique<draco::GeometryMetadata>();
        metadata->AddEntryString("made by", "a test");
        mesh.AddMetadata(std::move(metadata));
    }
    draco::ExpertEncoder encoder(mesh);
    encoder.SetEncodingMethod(source->edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                                  : draco::MESH_SEQUENTIAL_ENCODING);
    if (source->edgebreaker)
        encoder.SetAttributeQuantization(position, 14);
    encoder.SetSpeedOptions(source->edgebreaker ? 0 : 10, source->edgebreaker ? 0 : 10);
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeToBuffer(&buffer).ok() || buffer.size() > room)
        return 0;
    std::memcpy(out, buffer.data(), buffer.size());
    return buffer.size();
}
