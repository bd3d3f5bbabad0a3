// What the passes read from buffers: the snapshot (render/snapshot.h) in the form that shaders take.
#ifndef NG_SHARED_SCENE_H
#define NG_SHARED_SCENE_H

#include "types.h"

// The camera of a frame.
struct ng_view_data {
    NG_MAT4(view_projection);          // world to clip, reverse-Z, infinite far
    NG_MAT4(previous_view_projection); // last frame's
    NG_VEC3(right);                    // world directions: pixel ray = forward + x * right + y * down,
    NG_VEC3(down);                     // x and y from -1 to 1
    NG_VEC3(forward);
    NG_VEC3(position);
    NG_FLOAT(exposure);
    NG_VEC2(size); // pixels
};

struct ng_instance_data {
    NG_MAT3X4(matrix); // object to world
    NG_MAT3X4(previous_matrix);
    NG_UINT(material);
    NG_UINT(entity); // index half of the id
    NG_UINT(flags);  // NG_INSTANCE_* of render/snapshot.h
    NG_UINT(light);  // the light whose emitter this is, or ~0
};

struct ng_material_data {
    NG_VEC3(base_color);
    NG_FLOAT(metallic);
    NG_VEC3(emission); // radiance
    NG_FLOAT(roughness);
    NG_FLOAT(normal_scale);
    NG_FLOAT(alpha);
    NG_FLOAT(alpha_cutoff); // 0: not masked
    NG_UINT(flags);         // NG_MATERIAL_*
};

#ifdef GL_core_profile
#define NG_INSTANCE_MIRRORED 2
#endif
#define NG_MATERIAL_DOUBLE_SIDED 1
#define NG_MATERIAL_NORMAL_MAP   2

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
struct ng_light_data {
    NG_VEC3(proxy);
    NG_UINT(view_count);
    NG_VEC3(axis);        // spot: direction of the cone
    NG_FLOAT(cone_scale); // spot: falloff = clamp(cos * scale + offset)^2; other lights: 0 and 1
    NG_FLOAT(cone_offset);
    NG_FLOAT(soft_radius); // what makes a penumbra: radius, metres; orthographic: tan of the half angle
    NG_UINT(orthographic);
    NG_UINT(vpl_kind); // NG_VPL_*
    NG_UINT(vpl_count);
    NG_FLOAT(vpl_radius); // of the disk that one VPL stands for, metres
    NG_FLOAT(face_size);  // texels of the depth map
    NG_UINT(index);       // in the snapshot
};

// A direct VPL as the shaders sum it.
struct ng_vpl_data {
    NG_VEC3(position);
    NG_VEC3(normal); // area: unit; directional: where the light travels; point: zero
    NG_VEC3(weight); // radiance / (pdf * count). Area and point: W/sr; directional and environment: W/m2
};

#define NG_VPL_POINT       0
#define NG_VPL_AREA        1
#define NG_VPL_DIRECTIONAL 2

#endif
