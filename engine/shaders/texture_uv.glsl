// Where a texture of a material is looked up: by which coordinates of the mesh, and how they are moved. Asked in the
// vertex stage: beyond a triangle's edge the
// fragment stage finds derivatives in lanes that read no buffers on some drivers.
layout(set = 0, binding = 2, scalar) readonly buffer Materials { ng_material_data materials[]; };

vec2 texture_uv(uint material, uint slot)
{
    uint flags = materials[material].flags;
    vec2 uv = (flags & NG_MATERIAL_SECOND_UVS << slot) != 0 ? in_uv1 : in_uv;
    if ((flags & NG_MATERIAL_MOVES_UV) == 0)
        return uv;
    vec3 p = vec3(uv, 1);
    return vec2(dot(materials[material].uv_rows[2 * slot], p), dot(materials[material].uv_rows[2 * slot + 1], p));
}
