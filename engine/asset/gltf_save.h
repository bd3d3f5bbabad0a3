// Entities and assets back into glTF 2.0: what the standard has a place for stands there, the rest in
// NG_scene (README.md).
//
// Saving starts from what the file was, if it was loaded with `keep` (asset/gltf.h): what has not changed
// since stays as it is, with everything that the engine does not follow (unknown extensions, extras, other
// scenes, the bytes of pictures), under its old index. Nothing changed at all: the same bytes. What is new is
// added, what is gone leaves an empty place in its list, so that no index moves. Without an origin all is
// written. Loading the result gives the world and the assets that were saved, bit for bit.
#ifndef NG_ASSET_GLTF_SAVE_H
#define NG_ASSET_GLTF_SAVE_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/entity.h"

NG_EXTERN_C_BEGIN

struct ng_assets;
struct ng_gltf_origin;
struct ng_world;

// Whether a name ends in what a scene is saved as: ".glb" or ".gltf", in capitals too.
bool ng_gltf_save_knows(const char *path);

struct ng_gltf_save_params {
    const struct ng_world *world;
    const struct ng_assets *assets;
    ng_entity root;                      // the scene: what is below it is saved
    const struct ng_gltf_origin *origin; // of the file that `root` was loaded from; null: none
};

// Writes `path`, as base/file.h does: a reader finds the old file
// or the new one. A .glb holds its buffers and pictures; a .gltf has them beside it, under the names that
// they had. Pictures that only NG_scene names are beside both. Files beside are written first, and none is
// ever replaced: one of the same bytes is used, where others have the name, NAME.1.EXT and so on are tried.
// After an error none of them is left.
//
// The world is saved as it stands, except that a field which a playing clip drives keeps the value that the
// file gave it. Logged: NG_ERROR_USAGE (another extension of the name), NG_ERROR_IO, NG_ERROR_MEMORY.
NG_NODISCARD ng_result ng_gltf_save(const char *path, const struct ng_gltf_save_params *params);

NG_EXTERN_C_END

#endif
