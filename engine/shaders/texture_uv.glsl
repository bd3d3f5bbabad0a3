// Which texture coordinates a texture of a material uses. Asked in the vertex stage: beyond a triangle's edge the
// fragment stage finds derivatives in lanes that read no buffers on some drivers.
layout(set = 0, binding = 2, scalar) readonly buffer Materials { ng_material_data materials[]; };

vec2 texture_uv(uint material, uint slot)
{
    return (materials[material].flags & NG_MATERIAL_SECOND_UVS << slot) != 0 ? in_uv1 : in_uv;
}
