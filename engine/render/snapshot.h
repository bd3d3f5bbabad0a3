// A frame of the scene as plain data: the one bridge from the world to the renderers.
//
// render/extract.h makes it; the Vulkan passes and the path tracer read only this. All arrays belong to the
// extractor and stay valid until its next extraction. Nothing in here refers to the world except ids.
// The surfaces of area lights (rectangle, disk, sphere) are instances like all others, with a material that
// carries the light's emission and albedo.
#ifndef NG_RENDER_SNAPSHOT_H
#define NG_RENDER_SNAPSHOT_H

#include "components/material.h"
#include "light/light.h"
#include "scene/entity.h"

#include <stddef.h>
#include <stdint.h>

#define NG_NONE UINT32_MAX

// Triangles in memory. Static ones are in object space and have another revision where their points were
// edited; dynamic ones change every frame that they deform: morphed ones in object space, those that joints
// move in world space.
struct ng_snapshot_mesh {
    uint64_t key; // identity of the buffers: the same key and revision mean the same content
    uint64_t revision;
    bool dynamic; // Of one key, vertices alone are rewritten when the revision changes: topology is kept.
    uint32_t vertex_count, index_count;
    const float *positions;          // [vertex_count][3]
    const float *previous_positions; // dynamic only: last frame's, for motion; else null
    // Dynamic: before targets and joints move them, in object space; else before any of them was edited, or
    // null where none was. They follow from the scene, not from who draws it: the same for all revisions of a
    // key, or null.
    const float *rest_positions;
    const float *normals;  // [vertex_count][3]
    const float *tangents; // [vertex_count][4]
    const float *uvs;      // [vertex_count][2]
    const float *uvs1;     // [vertex_count][2], or null: `uvs` stand in for it
    const uint16_t
        *colors; // [vertex_count][4], 65,535 is 1: factors of base colour and alpha; or null: white
    const uint32_t *indices; // [index_count]
    float bounds_min[3], bounds_max[3];
};

enum {
    NG_INSTANCE_DOUBLE_SIDED = 1,
    NG_INSTANCE_MIRRORED = 2, // negative determinant: front faces are clockwise
    NG_INSTANCE_MASKED = 4,   // holes: its material's alpha is a mask, or blends
    NG_INSTANCE_MOVED = 8,    // its version differs from the last extraction's, or it is new
    NG_INSTANCE_LAMP = 16,    // the surface of a light that reflects nothing and is small in the scene
};

// The surface of a lamp (NG_INSTANCE_LAMP), with both its sides, is at most this part of the sphere around
// the scene: as many of the rays that leave a point of it meet the lamp, in the mean. A method may let such
// rays pass, so that what does not see the lamp need not follow it.
#define NG_LAMP_MOST_SHARE (1.0f / 400)

struct ng_snapshot_instance {
    ng_entity entity;
    uint32_t mesh, material; // indices into the snapshot
    uint32_t light;          // index of the light whose emitter this is, or NG_NONE
    uint32_t light_triangle; // of a mesh light's triangles, the first that is of this instance
    uint32_t flags;
    uint64_t version; // changes when placement, geometry or reflection (not emission) do: what a cached
                      // view compares
    float matrix[12]; // 3x4 row-major, object to world; identity where joints move the mesh
    float previous_matrix[12];          // last frame's
    float bounds_min[3], bounds_max[3]; // world space
};

struct ng_snapshot_image {
    uint64_t key, revision; // as for meshes; of one key, another revision may have another size and format
    const struct ng_image *image;
};

struct ng_snapshot_texture {
    uint32_t image;       // index of a snapshot image, or NG_NONE
    uint32_t uv_set;      // 1: it uses `uvs1`
    bool transformed;     // else `coordinates` is the identity
    float coordinates[6]; // 2x3 row-major: the mesh's texture coordinates to the image's
};

// Of a material without textures.
#define NG_SNAPSHOT_NO_TEXTURE                                                                               \
    {                                                                                                        \
        .image = NG_NONE                                                                                     \
    }
#define NG_SNAPSHOT_NO_TEXTURES                                                                              \
    {                                                                                                        \
        NG_SNAPSHOT_NO_TEXTURE, NG_SNAPSHOT_NO_TEXTURE, NG_SNAPSHOT_NO_TEXTURE, NG_SNAPSHOT_NO_TEXTURE,      \
            NG_SNAPSHOT_NO_TEXTURE, NG_SNAPSHOT_NO_TEXTURE                                                   \
    }

// Texture coordinates of a mesh on one of its material's images.
static inline void ng_snapshot_texture_uv(const struct ng_snapshot_texture *texture, const float uv[2],
                                          float out[2])
{
    const float *c = texture->coordinates, u = uv[0], v = uv[1];
    out[0] = texture->transformed ? c[0] * u + c[1] * v + c[2] : u;
    out[1] = texture->transformed ? c[3] * u + c[4] * v + c[5] : v;
}

struct ng_snapshot_material {
    ng_entity entity;
    float base_color[3], metallic, roughness;
    float emission[3]; // radiance, W/(sr m2): what the surface shows and, for emitters, emits
    float normal_scale, alpha, alpha_cutoff;
    // F0 of the dielectric part: specular * min(specular_color, 1), each times its texture.
    float specular, specular_color[3];
    enum ng_alpha_mode alpha_mode; // never NG_ALPHA_BLEND where nothing is behind: that is opaque
    bool double_sided, unlit;      // unlit: `emission` is the base colour, nothing is reflected
    struct ng_snapshot_texture textures[NG_TEXTURE_COUNT];
};

struct ng_snapshot_camera {
    ng_entity entity;                  // null: it is none of the world's
    float view[16], previous_view[16]; // world to camera, column-major: orthonormal, perhaps mirrored
    float position[3];
    float fov_y, near_plane, exposure;
    uint32_t subpixel; // which of the pictures that are averaged (render/subpixel.h); 0: a picture of its own
    bool orthographic; // sees `height` metres from top to bottom, whatever the distance; else by fov_y
    float height;
    bool auto_exposure;  // exposure is a factor on what the light meter finds
    float background[3]; // shown where nothing is seen, as components/camera.h has it; black with an
                         // environment
};

struct ng_snapshot_light {
    ng_entity entity;
    char name[NG_TEXT_SIZE];
    struct ng_light_source source; // light/light.h: type and everything its functions need, prepared
    uint32_t image;                // of the environment's map in the snapshot's images, or NG_NONE
    uint32_t place;                // index of the first light whose surface coincides with this one's
    bool lamp;                     // its surface is one (NG_INSTANCE_LAMP)
    bool flat;                     // it shines to where front . (p, 1) > 0 alone: see ng_lamp_is_beside
    float front[4];
    float power;           // Phi of conventions, W
    uint64_t version;      // of the source: the same version means the same light
    uint64_t unit_version; // the same, of ng_light_unit: whatever its brightness
};

struct ng_snapshot {
    double time; // seconds
    uint64_t frame;
    struct ng_snapshot_camera camera;
    float scene_center[3], scene_radius;
    uint32_t mesh_count, instance_count, image_count, material_count, light_count;
    struct ng_snapshot_mesh *meshes;
    struct ng_snapshot_instance *instances;
    struct ng_snapshot_image *images;
    struct ng_snapshot_material *materials;
    struct ng_snapshot_light *lights;
    // How far apart surfaces of lights may be that do not hide one another, metres; 0: none are close.
    float place_size;
    uint32_t environment;      // index of the light that is visible behind everything, or NG_NONE
    uint64_t geometry_version; // changes when any instance's version does, or one appears or vanishes
    uint64_t surface_version;  // the same of all instances but lamps; it may change more often
    uint64_t emission_version; // changes when an instance that is no light emits in another way
};

// Whether some light's surface is a lamp.
static inline bool ng_snapshot_has_lamps(const struct ng_snapshot *s)
{
    bool any = false;
    for (uint32_t i = 0; i < s->light_count; i++)
        any |= s->lights[i].lamp;
    return any;
}

// Whether some material is unlit.
static inline bool ng_snapshot_has_unlit(const struct ng_snapshot *s)
{
    bool any = false;
    for (uint32_t i = 0; i < s->material_count; i++)
        any |= s->materials[i].unlit;
    return any;
}

// Whether a lamp is nowhere in front of a light: lamps in a row on a ceiling do not see one another, though
// they hang a little higher and lower. The plane stands off the emitter by NG_LAMP_ROW of the scene's radius.
#define NG_LAMP_ROW 1e-3f
static inline bool ng_lamp_is_beside(const struct ng_snapshot_instance *lamp,
                                     const struct ng_snapshot_light *light)
{
    float most = light->front[3];
    for (int k = 0; k < 3; k++)
        most += light->front[k] * (light->front[k] > 0 ? lamp->bounds_max[k] : lamp->bounds_min[k]);
    return lamp->flags & NG_INSTANCE_LAMP && light->flat && most <= 0;
}

#endif
