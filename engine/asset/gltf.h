// glTF 2.0 and GLB into entities and assets.
//
// Nothing in a file is trusted: every index, offset, count, stride and length is checked before it is used,
// and what a file can make us allocate is bounded by ng_gltf_params. The vendor extension NG_scene
// (README.md) carries what the standard lacks. Source: glTF 2.0 specification, Khronos, 2021.
#ifndef NG_ASSET_GLTF_H
#define NG_ASSET_GLTF_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/entity.h"

NG_EXTERN_C_BEGIN

struct ng_assets;
struct ng_catalogue;
struct ng_piece;
struct ng_world;

// Whether emissive meshes without a light component light the scene.
enum ng_gltf_emitters {
    NG_GLTF_EMITTERS_AUTO, // those of files that say nothing of our own lights (NG_scene)
    NG_GLTF_EMITTERS_ON,
    NG_GLTF_EMITTERS_OFF,
};
// What a file was, kept beside what it became: its document with everything in it that the engine does not
// use, the bytes of its buffers and pictures, and the values that its entities had (gltf_save.h).
struct ng_gltf_origin;
void ng_gltf_origin_destroy(struct ng_gltf_origin **origin);

// Limits on what a file may ask for. Zero members take the default. Messages on the first three end with what
// a user does about them.
#define NG_GLTF_RAISE "; raise it (--memory-limit)"
struct ng_gltf_params {
    uint64_t max_memory;    // bytes of decoded geometry, images, clips, ... in all; half of what is available
    uint64_t max_file_size; // bytes of the document, of a picture, of all buffer files together; max_memory
    uint64_t max_image_memory; // of max_memory, bytes of any one image with its mips; max_memory
    uint32_t max_entities;     // nodes, primitives, materials and clips together; 262,144
    uint32_t max_joints;       // of one skin; 4,096
    uint32_t max_image_side;   // pixels, width or height; 16,384
    bool strict; // a fault refuses the file; else it costs the part that has it, and a warning for each kind
    // What the first picture of a foreign file needs:
    bool default_light; // a file without any light gets a sky, as lamps of a studio would make it
    enum ng_gltf_emitters emissive_lights;
    const char
        *clip; // which clips play, as ng_clips_play has it (anim/clips.h); null: the first of each field
    bool keep; // what saving needs to give back what the engine does not use: see `origin`
    // Called with the path of each file that the document names, unused pictures too. May be null.
    void (*file)(void *user, const char *path);
    void *user;
    // A part of a scene that is there: the root becomes the last child of `parent` (null: a root of the
    // world); no scale, camera or sky are made.
    bool part;
    ng_entity parent;
    // Of an open catalogue this piece is loaded, and the path is for messages alone. Null: the path is read.
    const struct ng_catalogue *catalogue;
    const struct ng_piece *piece;
};

// What was loaded. All entities are descendants of `root`; destroying it removes them.
struct ng_gltf_scene {
    ng_entity root;   // named after the file's scene; holds the scene_scale component
    ng_entity camera; // the first camera of the file, or the default one that frames the scene
    bool camera_made; // the file has none
    bool foreign;     // nothing in the file is of NG_scene
    ng_entity sky;    // the light that was made since the file has none; null: none was made
    uint32_t entity_count, primitive_count, material_count, light_count, clip_count, skin_count;
    uint32_t image_count;
    uint32_t emitter_count;             // of light_count, those made of emissive meshes
    uint64_t triangle_count;            // of the fallback meshes, before subdivision
    float bounds_min[3], bounds_max[3]; // box of what is seen at time 0, metres; zeros: nothing is
    float duration;                     // of the longest clip, seconds; 0: nothing is animated
    uint64_t hash; // of the bytes of every file that was read, wherever they lie: what the scene is
    struct ng_gltf_origin *origin; // with params.keep; the caller's to destroy. Else null
};

// Wavefront OBJ files, and pieces of furniture catalogues ("FILE.sh3f#NAME", asset/catalogue.h), are made
// into glTF first (README.md).
//
// Adds the file's default scene to a world whose components are the engine's (ng_components_register).
//
// Nodes become entities with a name and a transform; primitives get a mesh component (on the node if
// there is one primitive, else on children); materials become entities; each animation becomes a clip and an
// entity with an animation component (which of them play: anim/clips.h). Files named by the document lie in
// its directory or below; absolute paths, "..", network addresses and links that lead elsewhere are refused.
//
// A fault in one part costs that part. When the load has succeeded one warning was logged for each kind of
// fault: the file, where the first is, which rule it breaks, what is done about it, and how many there are.
//
// On failure one line was logged (file, where, which rule), nothing is left behind in either the world or the
// store, and `*out` is zero. NG_ERROR_FORMAT: the file breaks a rule; NG_ERROR_UNSUPPORTED: valid but needs
// something that is not there; NG_ERROR_MEMORY: over a limit of `params` or out of memory;
// NG_ERROR_NOT_FOUND, NG_ERROR_IO: a file could not be read.
NG_NODISCARD ng_result ng_gltf_load(const char *path, struct ng_world *world, struct ng_assets *assets,
                                    const struct ng_gltf_params *params, struct ng_gltf_scene *out);

NG_EXTERN_C_END

#endif
