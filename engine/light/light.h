// Lights as plain mathematics: power, sampling, direct VPLs, proxy and shadow views, one file a light type.
//
// Everything about a light type is types/NAME.c in this folder plus its component light_NAME in
// engine/components; the build finds both. To add a light type, copy types/spot.c (a delta light) or
// types/disk.c (an area light) and their components.
//
// Units (engine/README.md): point and spot W/sr, directional W/m2, area and environment W/(sr m2), power W.
// Colours are linear Rec. 709; where one number is wanted it is the mean of the three (ng_light_mean).
// All positions and directions here are in world space. Functions are pure and thread-safe; only
// ng_light_prepare and ng_light_finish write to a source.
//
// A light that emits nothing, has no surface, or whose numbers are not finite is "dark": power 0, samples
// with zero radiance and pdf 0, never a NaN.
#ifndef NG_LIGHT_LIGHT_H
#define NG_LIGHT_LIGHT_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/component.h"

#include <math.h>
#include <stdalign.h>

NG_EXTERN_C_BEGIN

#define NG_LIGHT_PARAMS_SIZE 64
#define NG_PI                3.14159265358979323846f

// Texels that a light emits: RGBA, row 0 at the top, borrowed. Lookups are bilinear, but for nearest ones.
enum ng_light_wrap { NG_LIGHT_WRAP_CLAMP, NG_LIGHT_WRAP_REPEAT, NG_LIGHT_WRAP_MIRROR };
enum ng_light_texel { NG_LIGHT_TEXEL_UNORM8, NG_LIGHT_TEXEL_SRGB8, NG_LIGHT_TEXEL_FLOAT32 };

struct ng_light_image {
    uint32_t width, height; // 0: no image, white
    enum ng_light_texel format;
    enum ng_light_wrap wrap_u, wrap_v;
    bool nearest;
    const void *pixels; // [height][width][4]
};

struct ng_light_type;
struct ng_light_tables; // importance distribution, light_internal.h

// A light of a frame. `params` is a copy of the component, whatever its type. Zero it, fill it, prepare it.
struct ng_light_source {
    const struct ng_light_type *type;
    alignas(8) unsigned char params[NG_LIGHT_PARAMS_SIZE];
    float matrix[16]; // placement, column-major
    float scene_center[3], scene_radius;
    struct ng_light_image image; // rectangle's texture, environment's map, or the mesh's emissive texture
    // Mesh lights only: the emitter in world space and its material.
    uint32_t triangle_count;
    const float *triangles;    // [triangle_count][3][3], counter-clockwise is the emitting side
    const float *triangle_uvs; // [triangle_count][3][2], or null
    bool mirrored;             // clockwise is the emitting side
    float emission[3];         // material's radiance before the texture
    bool double_sided;         // emits from both sides; power counts both
    // Made by ng_light_prepare, freed by ng_light_finish. Copies of the source share them.
    struct ng_light_tables *tables;
};

// A point of a light that was chosen by its importance: a direct VPL (paper 4.1), or what a path connects to.
struct ng_light_sample {
    float position[3]; // directional and environment: scene centre - travel direction * 2 radii
    float normal[3];   // area: the side that emits; directional, environment: travel direction; spot: axis;
                       // point: zero
    float radiance[3]; // area, environment: L; point, spot (on its axis): intensity (W/sr); directional:
                       // irradiance
    float pdf;         // by area (m^-2), by solid angle (environment, sr^-1), 1 for delta lights; 0: dark
    float power[3];    // W: its mean over samples is the light's power, so a VPL of n carries power / n
};

// What a sample gives to a receiver. Outgoing radiance of the receiver is estimated by
// brdf * max(0, dot(n, direction)) * irradiance; "irradiance" is that of a surface facing `direction`.
struct ng_light_incident {
    float direction[3]; // unit, from the receiver to the light
    float distance;     // metres, where an occluder must be nearer; INFINITY for directional, environment
    float irradiance[3];
    float pdf; // of this direction by solid angle, for multiple importance sampling; 0 for delta lights
};

// Where a ray met an emitter, to weigh a path that found it by chance.
struct ng_light_hit {
    float position[3];
    float direction[3];   // unit, from the receiver towards the emitter
    float distance;       // from the receiver; environment: any
    uint32_t triangle;    // mesh lights
    float barycentric[2]; // mesh lights: weights of the triangle's vertices 1 and 2
};

enum ng_light_views { NG_VIEWS_CUBE, NG_VIEWS_SINGLE_PERSPECTIVE, NG_VIEWS_SINGLE_ORTHOGRAPHIC };

// Where the light's surroundings are observed from (its reflective shadow map).
struct ng_light_proxy {
    float position[3];
    float direction[3]; // look direction of single views; of cubes (whose faces follow the world's axes) the
                        // main direction of emission
    float up[3];        // unit, perpendicular to direction
    enum ng_light_views views;
    float fov;    // single perspective: full angle, radians
    float extent; // single orthographic: half width, metres
};

// The surface that an area light shows: one of three unit shapes under a matrix, or its own mesh.
//   rectangle: the XY square of side 1 around the origin, facing -Z    disk: radius 1, the same way
//   sphere: radius 1
enum ng_light_shape {
    NG_LIGHT_SHAPE_RECTANGLE,
    NG_LIGHT_SHAPE_DISK,
    NG_LIGHT_SHAPE_SPHERE,
    NG_LIGHT_SHAPE_MESH,
};

struct ng_light_surface {
    enum ng_light_shape shape;
    float matrix[16];  // shape to world, column-major; mesh: not used
    float albedo[3];   // mesh: its own material's
    float radiance[3]; // before the texture; zero if the light is off
};

// One light type. The functions take any numbers; those that return false, with `out` in any state, say that
// the light is dark there. Call them through the ng_light_* functions below, which make that zero.
struct ng_light_type {
    const char *name;       // "point"; the component is "light_point"
    ng_component component; // its id
    bool delta;             // no extent: never met by a ray
    bool infinite;          // directional, environment: no place in the scene

    // Fills s->tables (allocated by the caller); null for types that need none.
    ng_result (*prepare)(struct ng_light_source *s);
    // Phi of conventions (engine/README.md), a channel each.
    bool (*power)(const struct ng_light_source *s, float rgb[3]);
    // u in [0, 1)^2.
    bool (*sample)(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out);
    // The sample that `sample` would give at a hit, normal on the side that was hit; null for delta lights.
    bool (*at_hit)(const struct ng_light_source *s, const struct ng_light_hit *hit,
                   struct ng_light_sample *out);
    // Turns the light on and makes the number that scales its power (radiance, intensity, ...) 1.
    void (*unit)(struct ng_light_source *s);
    // The part of the sample's radiance or intensity that leaves in a unit direction; null: 1 in front of the
    // normal, 0 behind (area lights).
    float (*profile)(const struct ng_light_source *s, const struct ng_light_sample *sample,
                     const float toward[3]);
    // The same for shaders, as clamp(cosine to the proxy's direction * scale + offset, 0, 1)^2. Null: 1.
    void (*cone)(const struct ng_light_source *s, float *scale, float *offset);
    bool (*proxy)(const struct ng_light_source *s, struct ng_light_proxy *out);
    // What can be seen of an area light; null: nothing.
    void (*surface)(const struct ng_light_source *s, struct ng_light_surface *out);
    // The image that the component refers to; null: none, or the mesh's emissive texture.
    ng_asset (*image)(const struct ng_light_source *s);
    bool emissive_mesh; // the entity's mesh is the emitter: triangles and emission have to be given
};

// All types in alphabetical order; null at the end.
extern const struct ng_light_type *const ng_light_types[];
// The type whose component this is, or null.
const struct ng_light_type *ng_light_type_of(ng_component component);

// Builds or rebuilds the importance distribution; call after any change of image, triangles or emission
// (other changes do not need it). Memory is reused. On error (memory, logged) the light is dark.
NG_NODISCARD ng_result ng_light_prepare(struct ng_light_source *s);
// Frees the tables; accepts a zero source.
void ng_light_finish(struct ng_light_source *s);

// How far off a surface that shines its samples and proxies stand, so that what coincides with it does not
// hide them: as little as the rounding of rays allows, since a lamp may lie closely behind something. Metres.
static inline float ng_light_skin(float scene_radius, float x, float y, float z)
{
    float far = fabsf(x);
    far = fabsf(y) > far ? fabsf(y) : far;
    far = fabsf(z) > far ? fabsf(z) : far;
    float skin = 1e-5f * scene_radius < 5e-5f ? 1e-5f * scene_radius : 5e-5f;
    return skin > 1e-6f * far ? skin : 1e-6f * far;
}

// A light that differs from `s` in brightness alone: on, and of brightness 1. So what is computed of it and
// divided by its power does not depend, to the last bit, on how bright `s` is or whether it is on. Shares the
// tables of `s`, is never finished and lives no longer.
void ng_light_unit(const struct ng_light_source *s, struct ng_light_source *out);

// The mean of the three channels: the scalar of colours throughout this folder.
float ng_light_mean(const float rgb[3]);
// Power by channel; zero if dark.
void ng_light_power_rgb(const struct ng_light_source *s, float rgb[3]);
// Phi: the mean of the channels' powers; 0 if dark.
float ng_light_power(const struct ng_light_source *s);

void ng_light_sample_at(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out);
void ng_light_incident_at(const struct ng_light_source *s, const struct ng_light_sample *sample,
                          const float receiver[3], struct ng_light_incident *out);
// The sample that would have been taken there, on the side that was hit. False: the light has no surface
// there.
bool ng_light_sample_of_hit(const struct ng_light_source *s, const struct ng_light_hit *hit,
                            struct ng_light_sample *out);
// Solid-angle density with which ng_light_sample_at + ng_light_incident_at would have found this hit.
float ng_light_pdf_at(const struct ng_light_source *s, const struct ng_light_hit *hit);
// Radiance that a ray with this hit sees of the light; zero for delta lights.
void ng_light_seen_at(const struct ng_light_source *s, const struct ng_light_hit *hit, float rgb[3]);
// Profile of a spot light for shaders (struct ng_light_type, cone); scale 0 and offset 1 for other lights.
void ng_light_cone(const struct ng_light_source *s, float *scale, float *offset);
// Where to observe from. Spots wider than 75 degrees (half angle) take a cube. A dark light gives a cube at
// its placement. The light does not know other objects: the proxy may lie inside a solid.
void ng_light_proxy_of(const struct ng_light_source *s, struct ng_light_proxy *out);

// Direct VPLs: the first `count` points of one fixed low-discrepancy set (Sobol' 1967, dimensions 1 and 2),
// the same for all lights and frames, mapped through the light's importance distribution. An unchanged light
// gives the same bytes.
void ng_light_vpls(const struct ng_light_source *s, uint32_t count, struct ng_light_sample *out);
// Point i of that set, in (0, 1)^2.
void ng_light_vpl_point(uint32_t i, float u[2]);

// Irradiance of a surface at `position` with unit `normal`, from `count` VPLs, nothing in between.
void ng_light_irradiance(const struct ng_light_source *s, uint32_t count, const float position[3],
                         const float normal[3], float rgb[3]);

NG_EXTERN_C_END

#endif
