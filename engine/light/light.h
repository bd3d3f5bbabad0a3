// Lights as plain mathematics: power, sampling, direct VPLs, proxy and shadow views, one file a light type.
//
// Everything about a light type is NAME.c in this folder plus its component in engine/components; the build
// finds both. To add a light type, copy spot.c (delta) or disk.c (area) and its component.
//
// Units (engine/README.md): point and spot W/sr, directional W/m2, area and environment W/(sr m2), power W.
// All positions and directions here are in world space. Functions are pure and thread-safe.
#ifndef NG_LIGHT_LIGHT_H
#define NG_LIGHT_LIGHT_H

#include "base/result.h"
#include "scene/component.h"

struct ng_image; // asset/assets.h

#define NG_LIGHT_PARAMS_SIZE 64

// A light of a frame. `params` is a copy of the component, whatever its type.
struct ng_light_source {
    const struct ng_light_type *type;
    _Alignas(8) unsigned char params[NG_LIGHT_PARAMS_SIZE];
    float matrix[16]; // placement, column-major
    float scene_center[3], scene_radius;
    // Textured emission or environment map; a mesh light's emissive texture. Null: none.
    const struct ng_image *image;
    // Mesh lights: the emitter in world space and its material.
    uint32_t triangle_count;
    const float *triangles;    // [triangle_count][3][3]
    const float *triangle_uvs; // [triangle_count][3][2]
    float emission[3];         // material's radiance before the texture
    bool double_sided;
    // Importance distribution built by type->prepare (tables of texels, triangle areas); owned by the source.
    void *distribution;
};

// A sample of a light's emission: a direct VPL (paper 4.1), or a point that a path connects to.
struct ng_light_sample {
    float position[3]; // delta-direction and environment lights: scene centre - direction * 2 radii
    float normal[3];   // of the emitter, the side that emits; directional: travel direction; point: zero
    float radiance[3]; // area, environment: L; point, spot: intensity (W/sr); directional: irradiance
    float pdf;         // density of the sample by area (m^-2), solid angle (environment, sr^-1), or 1 (delta)
};

enum ng_light_views { NG_VIEWS_CUBE, NG_VIEWS_SINGLE_PERSPECTIVE, NG_VIEWS_SINGLE_ORTHOGRAPHIC };

struct ng_light_proxy {
    float position[3];
    float direction[3]; // look direction of single views
    float up[3];
    enum ng_light_views views;
    float fov;    // single perspective: full angle, radians
    float extent; // single orthographic: half width, metres
};

#endif
