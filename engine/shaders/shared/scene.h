// What the passes read from buffers: the snapshot (render/snapshot.h) in the form that shaders take.
#ifndef NG_SHARED_SCENE_H
#define NG_SHARED_SCENE_H

#include "types.h"

// Side of the small maps (position, normal, flux) of a light, texels.
#define NG_RSM_SIZE 64

// Where a product of large factors ends: below infinity, so that sums stay numbers.
#define NG_RADIANCE_MAX 1e38f

// The camera of a frame.
struct ng_view_data {
    NG_MAT4(view_projection);          // world to clip, reverse-Z; perspective: infinite far
    NG_MAT4(previous_view_projection); // last frame's
    NG_VEC3(right);                    // render/camera.h: rays through pixels
    NG_VEC3(down);
    NG_VEC3(forward);
    NG_VEC3(position);
    NG_FLOAT(near_plane);
    NG_FLOAT(range); // orthographic: depth of the slab that is seen, metres; perspective: 0
    NG_VEC2(size);   // pixels
    NG_VEC2(shift);  // of rays from the middles of pixels, in halves of the picture (render/subpixel.h)
};

struct ng_instance_data {
    NG_MAT3X4(matrix); // object to world
    NG_MAT3X4(previous_matrix);
    NG_UINT(material);
    NG_UINT(entity);   // index half of the id
    NG_UINT(flags);    // NG_INSTANCE_* of render/snapshot.h
    NG_UINT(subpixel); // of the camera: what blends covers another part of the pixels in each picture
};

// The textures of a material, in the order of their bindings in set 1 (enum ng_material_texture).
#define NG_SLOT_BASE_COLOR         0
#define NG_SLOT_METALLIC_ROUGHNESS 1
#define NG_SLOT_NORMAL             2
#define NG_SLOT_EMISSIVE           3
#define NG_SLOT_SPECULAR           4
#define NG_SLOT_SPECULAR_COLOR     5
#define NG_MATERIAL_TEXTURES       6

struct ng_material_data {
    NG_VEC3(base_color);
    NG_FLOAT(metallic);
    NG_VEC3(emission); // radiance
    NG_FLOAT(roughness);
    NG_FLOAT(normal_scale);
    NG_FLOAT(alpha);
    NG_FLOAT(alpha_cutoff); // of a mask
    NG_UINT(flags);         // NG_MATERIAL_*
    NG_VEC3(specular_color);
    NG_FLOAT(specular); // F0 of the dielectric part: specular * min(specular_color, 1), times textures
    // Of each texture two rows (a, b, c): its coordinates are a u + b v + c. Only with NG_MATERIAL_MOVES_UV.
    NG_VEC3_ARRAY(uv_rows, 2 * NG_MATERIAL_TEXTURES);
};

#ifdef GL_core_profile
#define NG_INSTANCE_MIRRORED 2
#define NG_INSTANCE_LAMP     16
#endif
#define NG_MATERIAL_DOUBLE_SIDED  1
#define NG_MATERIAL_NORMAL_MAP    2
#define NG_MATERIAL_SPECULAR_MAPS 4
#define NG_MATERIAL_MOVES_UV      8
#define NG_MATERIAL_UNLIT         16
#define NG_MATERIAL_MASK          32
#define NG_MATERIAL_BLEND         64
// Shifted by a texture's slot: it uses the second set of texture coordinates.
#define NG_MATERIAL_SECOND_UVS    256

// One direction in which a light looks at the scene: a cube face, a cone, or an orthographic slab.
// A point p maps to the picture by q = p - origin: x = dot(q, axis_x) / w, y = dot(q, axis_y) / w, with
// w = dot(q, axis_z) * tangent (perspective) or w = tangent (orthographic); x and y run from -1 to 1.
struct ng_light_view_data {
    NG_MAT4(view_projection); // world to clip, reverse-Z
    NG_VEC3(axis_x);          // picture right
    NG_FLOAT(tangent);        // perspective: tan of half the field of view; orthographic: half width, metres
    NG_VEC3(axis_y);          // picture down
    NG_FLOAT(depth_range);    // perspective: near plane, metres; orthographic: depth of the slab, metres
    NG_VEC3(axis_z);          // look direction
    NG_VEC3(origin);          // eye; orthographic: centre of the near plane
};

// What the passes need to know of a light, whatever its type.
//
// Its frame has the axes look, right and up; coordinates in it are relative to the proxy. Perspective views
// are the faces of a cube in that frame, of which each is a layer of the depth map or missing; a spot has the
// first alone. The picture of the face along axis k (0 look, 1 right, 2 up) has axis k+1 to its right and
// axis k+2 upwards; the opposite face is turned by half a turn about axis k+2.
struct ng_light_data {
    NG_VEC3(proxy);
    NG_UINT(layers); // four bits a face (+look, +right, +up, -look, -right, -up): 0 none, else layer + 1
    NG_VEC3(look);
    NG_FLOAT(tangent); // perspective: tan of half the field of view
    NG_VEC3(right);
    NG_FLOAT(depth_range); // perspective: near plane, metres; orthographic: depth of the slab, metres
    NG_VEC3(up);
    NG_FLOAT(face_size); // texels of the depth map
    // Orthographic views, finest first: centre along right and up, half width, start of the slab along look;
    // metres, relative to the proxy.
    NG_VEC4_ARRAY(windows, 4);
    NG_UINT(window_count); // 0: perspective
    // What makes penumbrae: the radius of an emitter with the same second moment, metres, and the direction
    // in which it is flat, in the light's frame, of length 0 (a ball) to 1 (a disk). At infinity: the tangent
    // of the half angle.
    NG_FLOAT(soft_radius);
    NG_VEC3(soft_normal);
    NG_FLOAT(cone_scale); // spot: falloff = clamp(cos * scale + offset)^2; other lights: 0 and 1
    NG_FLOAT(cone_offset);
    NG_UINT(vpl_kind); // NG_VPL_*
    NG_UINT(vpl_count);
    NG_FLOAT(vpl_radius); // of the disk that one VPL stands for, metres
    NG_UINT(index);       // in the snapshot
    NG_UINT(facet_kind);  // NG_FACETS_*
    NG_UINT(facet_count); // that are the emitter together; 0: it has no surface
};

// A direct VPL as the shaders sum it.
struct ng_vpl_data {
    NG_VEC3(position);
    NG_VEC3(normal);   // area: unit; directional: where the light travels; point: zero
    NG_VEC3(weight);   // radiance / (pdf * count). Area and point: W/sr; directional and environment: W/m2
    NG_FLOAT(density); // pdf * count: of an environment, VPLs a steradian
};

// A part of an emitter, for receivers so near that its VPLs show one by one.
struct ng_facet_data {
    NG_VEC3_ARRAY(corners, 3); // of a triangle; counter-clockwise is the side that shines
    NG_VEC3(radiance);
};

#define NG_FACETS_ONE_SIDED 0 // triangles
#define NG_FACETS_TWO_SIDED 1
#define NG_FACETS_BALL      2 // one facet: its centre, and (radius, 0, 0)
#define NG_FACETS_PATCHES   3 // centre, normal, and (area, 0, 0): of samples

#define NG_VPL_POINT       0
#define NG_VPL_AREA        1
#define NG_VPL_DIRECTIONAL 2

#endif
