// Pieces of furniture catalogues, put into a scene: "FILE.sh3f#NAME@X,Y,Z,TURN".
#ifndef LIGHTFORMER_PLACING_H
#define LIGHTFORMER_PLACING_H

#include "asset/gltf.h"

#include <stdbool.h>

// The piece that a text names, and where it stands; the last "@" counts that numbers follow. Not given: on
// the floor of the origin, or as far above it as the piece belongs; unturned.
struct placing {
    char file[4096];
    const char *piece; // within `text`, copied
    char text[4096];
    float at[3], turn; // metres; degrees to the left, seen from above
    bool given;        // `at` is
};

// False, reported, if the text names no piece of a file that is there.
bool placing_read(const char *text, const char *command, struct placing *out);
// As the last child of `parent`. A line tells who made it and under which license; so
// does its name, where there is room.
NG_NODISCARD ng_result placing_place(const struct placing *placing, struct ng_world *world,
                                     struct ng_assets *assets, ng_entity parent,
                                     const struct ng_gltf_params *params);

#endif
