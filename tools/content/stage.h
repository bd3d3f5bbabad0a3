// What the unit scenes share: a floor, a camera, a light to see by, simple shapes with texture coordinates.
#ifndef CONTENT_STAGE_H
#define CONTENT_STAGE_H

#include "glb.h"

// Starts a scene: a camera at (0, 1.5, 5) that looks at (0, 0.7, 0), and a grey floor 8 m square at
// y = 0.
void stage_init(struct glb *g);
// A wall behind, at z = -3.
void stage_add_wall(struct glb *g);
// A square light of 2 m above the floor, for scenes that are not about light.
void stage_add_light(struct glb *g);
// A sphere, a box and a column, which receive and cast shadows.
void stage_add_props(struct glb *g);

// A rough dielectric.
int stage_material(struct glb *g, const char *name, double red, double green, double blue, double roughness);

// Meshes around their origin: returns the mesh.
int stage_sphere(struct glb *g, const char *name, double radius, int material);
int stage_box(struct glb *g, const char *name, double x, double y, double z, int material); // full sizes
// In the XY plane, facing +Z; texture coordinates from 0 to `repeat`.
int stage_plane(struct glb *g, const char *name, double width, double height, double repeat, int material);

// A node with a mesh. Returns the node.
int stage_place(struct glb *g, const char *name, int mesh, double x, double y, double z);

// Any surface of two parameters in [0, 1], seen from outside with u to the right and v up.
struct stage_point {
    struct vec3 position, normal;
};
typedef struct stage_point (*stage_surface)(double u, double v, const void *user);
struct stage_patch {
    stage_surface surface;
    const void *user;
    uint32_t columns, rows;
    double repeat;    // of the texture coordinates; 0: 1
    unsigned uv_bits; // 0: float; 8 or 16: normalised integers (`repeat` at most 1)
};
int stage_patch(struct glb *g, const char *name, const struct stage_patch *p, int material);

#endif
