#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "brdf_probe.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, scalar) readonly buffer Source { brdf_probe_in source[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Target { brdf_probe_out target[]; };
layout(push_constant) uniform Push { uint count; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i < count)
        target[i] = brdf_probe(source[i]);
}
