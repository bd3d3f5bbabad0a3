// Light without what surfaces make of it: radiance over reflectance, which varies less from pixel to pixel.
#version 460

layout(set = 0, binding = 0) uniform sampler2D direct_map; // single black texels where there is nothing
layout(set = 0, binding = 1) uniform sampler2D indirect_map;
layout(set = 0, binding = 2) uniform sampler2D diffuse_map;
layout(set = 0, binding = 3) uniform sampler2D specular_map;

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_light;

vec3 fetch(sampler2D map, ivec2 pixel)
{
    return texelFetch(map, clamp(pixel, ivec2(0), textureSize(map, 0) - 1), 0).rgb;
}

vec3 light_at(ivec2 pixel)
{
    return (fetch(direct_map, pixel) + fetch(indirect_map, pixel)) / max(fetch(diffuse_map, pixel) + fetch(specular_map, pixel), 0.02);
}

float brightness(vec3 light)
{
    return max(light.r, max(light.g, light.b));
}

// A highlight of one pixel would be a spot as large as that pixel is in the picture, and come and go as things move: no pixel
// is brighter than the brightest of its neighbours.
void main()
{
    const ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(diffuse_map, 0) - 1;
    const vec3 light = light_at(pixel);
    float most = 0;
    for (int i = 0; i < 9; i++) {
        const ivec2 place = pixel + ivec2(i % 3, i / 3) - 1;
        if (i != 4 && all(greaterThanEqual(place, ivec2(0))) && all(lessThanEqual(place, last)))
            most = max(most, brightness(light_at(place)));
    }
    const float bright = brightness(light);
    out_light = vec4(bright > most && last != ivec2(0) ? light * (most / bright) : light, 1);
}
