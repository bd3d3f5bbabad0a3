// Furniture catalogues of Sweet Home 3D (.sh3f): a zip of OBJ models and pictures, and properties that name,
// credit and size them. Its pieces are scenes ("FILE.sh3f#NAME", asset/gltf.h), or parts of one.
//
// A piece stands on the floor, its box centred on the origin in x and z, its back towards -Z. Source: the
// properties that com.eteks.sweethome3d.io.DefaultFurnitureCatalog documents.
#ifndef NG_ASSET_CATALOGUE_H
#define NG_ASSET_CATALOGUE_H

#include "asset/gltf.h"
#include "base/extern_c.h"

#include <stdbool.h>
#include <stddef.h>

NG_EXTERN_C_BEGIN

// Texts are UTF-8, "" if the catalogue has none.
struct ng_piece {
    const char *id, *name, *category;
    const char *creator, *license; // license: the piece's own, else the catalogue's
    const char *model;             // its OBJ file within the zip
    float size[3];                 // width, height, depth along x, y, z, metres
    float elevation;               // metres above the floor at which it belongs; not applied
    float rotation[9];             // of the model, before its box is scaled; rows
    bool movable, door_or_window;
};

struct ng_catalogue_internal;

// Read only. Everything is valid until the catalogue is destroyed. One thread.
struct ng_catalogue {
    const char *path, *name, *license, *provider, *version;
    const struct ng_piece *pieces;
    uint32_t piece_count;
    struct ng_catalogue_internal *internal;
};

// Whether a file begins as a zip does, which a catalogue is.
bool ng_catalogue_is(const char *path);
// Reads a catalogue into memory, at most `limit` bytes (0: 1 GiB), its models not yet. NG_ERROR_FORMAT: it is
// not a zip, or has no properties of furniture. Pieces without model or size are left out, with one warning.
NG_NODISCARD ng_result ng_catalogue_open(const char *path, uint64_t limit, struct ng_catalogue **out);
void ng_catalogue_destroy(struct ng_catalogue **catalogue);

// A piece by its id, its name, the end of its id after "#", or its number from 1; null if there is none. Of
// several the first, letters of either case.
const struct ng_piece *ng_catalogue_find(const struct ng_catalogue *catalogue, const char *name);

// Loads a piece into a world, its root entity the last child of `parent` (null: a root of the world). What
// ng_gltf_load says holds, but neither a scale of the scene, nor a camera, nor a sky is made. `params` may be
// null.
NG_NODISCARD ng_result ng_catalogue_place(const struct ng_catalogue *catalogue, const struct ng_piece *piece,
                                          struct ng_world *world, struct ng_assets *assets, ng_entity parent,
                                          const struct ng_gltf_params *params, struct ng_gltf_scene *out);

// Tells "FILE#PIECE" apart: false if `path` names a file as it is, or no part of it before a "#" does.
// `piece` points into `path`.
bool ng_catalogue_split(const char *path, char *file, size_t size, const char **piece);

NG_EXTERN_C_END

#endif
