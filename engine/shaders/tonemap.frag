// What a display shows, in sRGB bytes: a layer of a picture, two of them beside a divider, or their difference.
// Radiance goes through the project's one tone map.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/display.h"
#include "shared/tonemap.h"

// Of the two sides: the layer, and what a ratio divides it by.
layout(set = 0, binding = 1) uniform sampler2D left_map;
layout(set = 0, binding = 2) uniform sampler2D left_divisor_map;
layout(set = 0, binding = 3) uniform sampler2D right_map;
layout(set = 0, binding = 4) uniform sampler2D right_divisor_map;
layout(set = 0, binding = 5, scalar) readonly buffer Shown { ng_display_data display; };
layout(set = 0, binding = 6, scalar) readonly buffer Exposure { float exposure; };
layout(set = 0, binding = 7) uniform sampler2D position_map; // w: 0 where there is no surface, -1 where one is shown as it is;
                                                             // or shares

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_color;

// A map may be a single black texel, where there is nothing to show.
vec4 fetch(sampler2D map)
{
    return texelFetch(map, min(ivec2(gl_FragCoord.xy), textureSize(map, 0) - 1), 0);
}

// Between the texels of a map whose texels are cells of the picture.
vec4 fetch_mean(sampler2D map)
{
    const vec2 last = vec2(textureSize(map, 0) - 1);
    const vec2 at = clamp(gl_FragCoord.xy / display.cell - 0.5, vec2(0), last);
    const ivec2 near = ivec2(at), far = min(near + 1, ivec2(last));
    const vec4 above = mix(texelFetch(map, near, 0), texelFetch(map, ivec2(far.x, near.y), 0), fract(at.x));
    const vec4 below = mix(texelFetch(map, ivec2(near.x, far.y), 0), texelFetch(map, far, 0), fract(at.x));
    return mix(above, below, fract(at.y));
}

// Of a pixel: the part in which nothing is seen, and that of what is unlit.
vec2 shares()
{
    const vec4 texel = fetch(position_map);
    return display.averaged != 0 ? texel.xy : vec2(texel.w == 0 ? 1 : 0, texel.w < 0 ? 1 : 0);
}

// What is shown of a texel, before it is encoded: radiance is exposed.
vec3 value_of(uint encoding, vec4 texel, vec4 divisor)
{
    switch (encoding) {
    case NG_SHOWN_RADIANCE:
        return max(texel.rgb * exposure, vec3(0));
    case NG_SHOWN_BEAUTY: // what is unlit is a colour of the display already
        return max(texel.rgb * mix(exposure, 1, shares().y), vec3(0));
    case NG_SHOWN_RATIO:
        return mix(vec3(1), texel.rgb / max(divisor.rgb, vec3(1e-30)), greaterThan(divisor.rgb, vec3(0)));
    case NG_SHOWN_DIRECTION:
        return texel.rgb * 0.5 + 0.5;
    case NG_SHOWN_W:
        return texel.www;
    default:
        return texel.rgb;
    }
}

vec3 encode(uint encoding, vec3 x)
{
    if (encoding == NG_SHOWN_DIRECTION)
        return x;
    const bool beauty = encoding == NG_SHOWN_BEAUTY, radiance = encoding == NG_SHOWN_RADIANCE || beauty;
    const vec2 share = beauty ? shares() : vec2(0);
    const float peak = max(x.r, max(x.g, x.b)), toe = min(x.r, min(x.g, x.b));
    for (int i = 0; i < 3; i++) {
        const float mapped = radiance ? ng_tonemap(x[i], peak, toe) : x[i];
        x[i] = ng_srgb_encode(mix(mapped, x[i], share.y) + share.x * display.background[i]);
    }
    return x;
}

vec3 difference(vec3 left, vec3 right)
{
    const float dark = 0.02; // about a tenth of middle grey: below it errors count less
    float error = dot((left - right) / (abs(right) + dark), vec3(1.0 / 3.0));
    vec3 color = error > 0 ? vec3(1, 0.5, 0.1) : vec3(0.15, 0.5, 1);
    return color * sqrt(min(abs(error) / NG_DIFFERENCE_FULL, 1)); // the root shows small errors too
}

void main()
{
    float from_divider = gl_FragCoord.x - display.divider;
    bool both = display.comparison == NG_COMPARE_DIFFERENCE;
    bool right_side = display.comparison == NG_COMPARE_SPLIT && from_divider > 0;
    vec3 left = vec3(0), right = vec3(0);
    if (both && display.cell > 1) {
        left = value_of(display.encoding, fetch_mean(left_map), fetch_mean(left_divisor_map));
        right = value_of(display.other_encoding, fetch_mean(right_map), fetch_mean(right_divisor_map));
    } else if (both || !right_side) {
        left = value_of(display.encoding, fetch(left_map), fetch(left_divisor_map));
    }
    if ((both && display.cell <= 1) || right_side)
        right = value_of(display.other_encoding, fetch(right_map), fetch(right_divisor_map));
    out_color.rgb = both         ? difference(left, right)
                    : right_side ? encode(display.other_encoding, right)
                                 : encode(display.encoding, left);
    if (display.comparison == NG_COMPARE_SPLIT && abs(from_divider) < 1)
        out_color.rgb = vec3(1);
    out_color.a = 1;
}
