// Writes glTF 2.0 as one binary file (GLB) with this project's extension NG_scene (engine/asset/README.md).
//
// Nodes, meshes, materials and so on are added in any order and named by the index that each call returns.
// The writer is sticky: after the first failure (only memory can fail) every call does nothing, and
// glb_finish says so. Floating-point data are stored on a grid of 2^-20, numbers in the JSON with six
// decimals: the same sources give the same bytes on any machine.
#ifndef CONTENT_GLB_H
#define CONTENT_GLB_H

#include "asset/gltf_writer.h"
#include "base/array.h"
#include "base/result.h"
#include "cage.h"
#include "image.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#define GLB_NONE (-1)

struct glb {
    struct ng_gltf_writer w;
};

void glb_init(struct glb *g);
// Moves the finished file into `out` (owned by the caller), or fails with NG_ERROR_MEMORY. Releases `g`.
NG_NODISCARD ng_result glb_finish(struct glb *g, struct bytes *out);

// ---- data ----

// `count` elements of `width` floats. `bounds` adds min and max, which positions and key times must have.
int glb_floats(struct glb *g, const float *values, size_t count, unsigned width, bool bounds);
// As above, from doubles: the way shapes are made.
int glb_doubles(struct glb *g, const double *values, size_t count, unsigned width, bool bounds);
// Scalars of the smallest of 8, 16 and 32 bits that holds them all; width 2 or 4 makes VEC2 or VEC4.
int glb_integers(struct glb *g, const uint32_t *values, size_t count, unsigned width);
// Values from 0 to 1 as normalised unsigned 8 or 16 bits (`bits`).
int glb_normalized(struct glb *g, const double *values, size_t count, unsigned width, unsigned bits);
// An accessor over the 3-vectors of `base` in which `count` elements are replaced; `bounds`: its min and max.
int glb_sparse(struct glb *g, int base, const uint32_t *at, const double *values, size_t count,
               const double bounds[6]);

// ---- materials ----

enum glb_wrap { GLB_REPEAT, GLB_CLAMP };

// The PNG that `make` writes, embedded, as a texture with trilinear filtering.
int glb_texture(struct glb *g, const char *name, ng_result (*make)(struct bytes *png), enum glb_wrap wrap);

// Zero is black, smooth, opaque, one-sided. Textures: index + 1, 0 for none.
struct glb_material {
    const char *name;
    double base_color[3];
    double metallic, roughness;
    double emissive[3];  // any radiance: the writer splits it into colour and KHR_materials_emissive_strength
    double alpha_cutoff; // above 0: a mask
    bool double_sided;
    int base_color_texture, metallic_roughness_texture, normal_texture, emissive_texture;
};

int glb_add_material(struct glb *g, const struct glb_material *m);

// ---- meshes ----

// Accessors are index + 1, 0 for none.
struct glb_mesh {
    const char *name;
    int positions, normals, uvs, joints, weights, indices;
    int material;            // index
    const struct cage *cage; // the primitive's subdivision cage, or null
    int cage_positions;      // of its points; 0: they are the mesh's vertices
    unsigned level;          // of its refinement
    const char *boundary;    // "edge_only" or "edge_and_corner"; null: the default
};

int glb_add_mesh(struct glb *g, const struct glb_mesh *m);
// The cage as a mesh: its triangles, with smooth normals, are the fallback. Level 0: only these. Where
// texture coordinates of a point differ, the fallback has a vertex for each.
int glb_cage_mesh(struct glb *g, const char *name, const struct cage *c, int material, unsigned level);
// As above, with a boundary rule (struct glb_mesh).
int glb_cage_mesh_bounded(struct glb *g, const char *name, const struct cage *c, int material, unsigned level,
                          const char *boundary);

// ---- nodes ----

// Zero: at the origin, unrotated, unscaled, without parent and content. mesh, camera, light, skin: index + 1.
struct glb_node {
    const char *name;
    int parent; // index + 1
    double translation[3];
    double rotation[4]; // quaternion; zero: none
    double scale[3];    // zero: 1
    int mesh, camera, light, skin;
};

int glb_add_node(struct glb *g, const struct glb_node *n);
// An entry for one of the engine's components in a list of nodes, materials, scenes or animations: fill in
// its fields.
cJSON *glb_component(struct glb *g, enum ng_gltf_list list, int index, const char *name);
// Sets a number, a list of numbers, or a switch of a JSON object. Null objects are ignored.
void glb_set(struct glb *g, cJSON *object, const char *key, double value);
void glb_set_list(struct glb *g, cJSON *object, const char *key, const double *values, int count);
void glb_set_text(struct glb *g, cJSON *object, const char *key, const char *value);
// A reference to an entity: `kind` is "node" or "material".
void glb_set_entity(struct glb *g, cJSON *object, const char *key, const char *kind, int index);
void glb_set_bool(struct glb *g, cJSON *object, const char *key, bool value);
// An image field: a texture of this file, or a picture beside it.
void glb_set_texture(struct glb *g, cJSON *object, const char *key, int texture);
void glb_set_picture(struct glb *g, cJSON *object, const char *key, const char *uri);

int glb_add_camera(struct glb *g, double fov_y, double near_plane);

// KHR_lights_punctual. `type` is "point", "spot" or "directional"; angles (radians) for spots.
int glb_add_light(struct glb *g, const char *name, const char *type, const double color[3], double intensity,
                  double inner_angle, double outer_angle);

// `inverse_bind`: accessor of 4x4 matrices.
int glb_add_skin(struct glb *g, const char *name, const int *joints, int count, int inverse_bind);

// ---- animations ----

int glb_add_animation(struct glb *g, const char *name);

// Keys of one node's "translation", "rotation" or "scale"; with `component`, of that component's field `path`
// (`width` floats). `interpolation`: "STEP", "LINEAR" or "CUBICSPLINE" (in-tangent, value, out-tangent a
// key).
struct glb_channel {
    int node;
    const char *component, *path, *interpolation;
    unsigned width; // 0: 4 for "rotation", else 3
    const double *times, *values;
    size_t keys;
};

void glb_add_channel(struct glb *g, int animation, const struct glb_channel *c);

#endif
