// The materials that all furniture shares.
#ifndef CONTENT_LOOK_H
#define CONTENT_LOOK_H

#include "../glb.h"

enum look {
    LOOK_OAK,
    LOOK_WALNUT,
    LOOK_WHITE,    // satin lacquer
    LOOK_CHARCOAL, // the same, dark
    LOOK_SAGE,     // the same, green
    LOOK_BLACK_METAL,
    LOOK_BRASS,
    LOOK_STEEL,
    LOOK_MIRROR,
    LOOK_PLASTIC,
    LOOK_GLASS, // black: screens, hobs
    LOOK_CERAMIC,
    LOOK_STONEWARE, // rough, glazed in a warm grey
    LOOK_TERRACOTTA,
    LOOK_MARBLE,
    LOOK_PAPER,
    LOOK_SOIL,
    LOOK_BARK,
    LOOK_ORANGE, // peel
    LOOK_GREY_CLOTH,
    LOOK_SAND_CLOTH,
    LOOK_BLUE_CLOTH,
    LOOK_RUST_CLOTH,
    LOOK_LINEN, // white bedding
    LOOK_VEIL,  // curtains, seen from both sides
    LOOK_COGNAC_LEATHER,
    LOOK_BLACK_LEATHER,
    LOOK_WICKER,
    LOOK_RUG,
    LOOK_ROUND_RUG,
    LOOK_SPINES,
    LOOK_PRINT_SUN,
    LOOK_PRINT_ARCHES,
    LOOK_PRINT_LEAVES,
    LOOK_CLOCK,
    LOOK_MONSTERA,
    LOOK_FIDDLE_LEAF,
    LOOK_FROND,
    LOOK_SHADE, // these two glow
    LOOK_LANTERN,
    LOOK_PLASTER, // from here on the room's
    LOOK_CEILING,
    LOOK_PARQUET,
    LOOK_COUNT
};

// Metres that one picture covers along u and v: texture coordinates in metres are divided by them. 1: they
// are coordinates of the picture.
void look_tile(enum look look, double out[2]);
// Whether it has pictures at all.
bool look_tiled(enum look look);
const char *look_name(enum look look);

// The materials and textures that a file has so far.
struct looks {
    int materials[LOOK_COUNT]; // index + 1
    struct {
        ng_result (*make)(struct bytes *out);
        int texture;
    } textures[64];
    int texture_count;
};

// The index of the look's material, which is added when it is first asked for.
int look_material(struct looks *looks, struct glb *g, enum look look);
// The index of a picture's texture, likewise.
int look_texture(struct looks *looks, struct glb *g, ng_result (*make)(struct bytes *out));

#endif
